"""Clips on the general body of a format that prescribes its joints, such as SMPL's or VRM's."""

from __future__ import annotations

from collections.abc import Sequence

from mcml.errors import ConversionError
from mcml.formats.format import note
from mcml.formats.missing_facts import guess_up
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.conventions.convert import turn_up
from mcml.motion.frames import joined
from mcml.motion.guesses import stated_up
from mcml.motion.hub import HubReader, walked
from mcml.motion.lexemes import lexeme
from mcml.motion.retargeting.bone_mapping import Match, suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Convention, Skeleton
from mcml.motion.units import reading_of

_SURE = 0.7
"""Confidence of a match below which it is a guess."""
_MOST = 1_500_000
"""Joints, over all frames, that are transferred at once: 20,000 frames of 52 joints take 490 MiB and 9 seconds."""


def match_person(clip: ClipStream, target: Skeleton, required: Sequence[str], title: str) -> tuple[Match, ...]:
    """Return which joint of a clip is which of a body.

    required: joints of the target, by their names in the format. title: of the format. Raises ConversionError for
    markers, and for clips without a required joint.
    """
    skeleton = clip.head.skeleton
    if any(joint.convention is Convention.MARKER for joint in skeleton.joints):
        raise ConversionError(f"{title} holds joints, and markers have none", remedy="Export them as C3D or TRC.")
    matches = suggest_matches(skeleton, target)
    names = {target.joints[match.target].source_name: match for match in matches}
    missing = [name for name in required if name not in names]
    if missing:
        raise ConversionError(
            f"{title} needs the joints of a person, and the clip lacks {', '.join(missing)}",
            remedy="Give its joints MCML's names with aliases, or choose another format.",
        )
    doubtful = [name for name, match in names.items() if match.confidence < _SURE]
    if doubtful:
        note(clip.notices, "guess", f"joints that stand in for those of {title}: {', '.join(doubtful)}")
    return matches


def transfer(clip: ClipStream, target: Skeleton, matches: Sequence[Match], seconds: float, body: str) -> ClipStream:
    """Return a clip retargeted to a body in metres with Y up.

    Its bones point as they do in the clip, travel is scaled by the length of the legs. body: its name, for the notice.
    Raises ConversionError for very long clips.
    """
    skeleton = clip.head.skeleton
    upright = turn_up(clip, _find_up(clip), "Y")
    joints = max(len(skeleton), len(target))
    parts, frames = list[FrameBlock](), 0
    for part in upright.blocks():
        frames += len(part)
        if frames * joints > _MOST:
            raise ConversionError(
                f"more than {_MOST // joints} frames of {joints} joints cannot be retargeted at once",
                remedy="Export a part: `first` and `last`.",
            )
        if len(part):
            parts.append(part)
    fields = {"dataframe_rate": lexeme(1 / seconds), "calibration_unit": "m", "global_axis_of_gravity": "Y"}
    fields |= {name: text for name, text in clip.head.fields.items() if name in ("filename", "skeleton_name")}
    head = ClipHead(clip.head.format, target, fields)
    if not parts:
        return ClipStream(head, lambda: iter(()), 0, clip.notices)
    result = retarget(
        upright.head.skeleton, joined(parts), target, matches, seconds, reading=reading_of(upright.head)
    )  # fmt: skip
    note(clip.notices, "warning", f"the clip was retargeted to {body}: its bones point the same")
    for notice in result.report.notices(skeleton, target):
        note(clip.notices, notice.kind, notice.what)
    return ClipStream(head, lambda: iter([result.block]), frames, clip.notices)


def _find_up(clip: ClipStream) -> str:
    """The up axis that the document states, else a guess with a notice."""
    stated = stated_up(clip.head)
    first = next((block for block in clip.blocks() if len(block)), None)
    if stated is not None or first is None:
        return stated or "Y"
    pose = HubReader(clip.head.skeleton, reading_of(clip.head)).read(first)
    places = walked(clip.head.skeleton, pose.translations[:1], pose.rotations[:1])[0][0]
    return guess_up(clip.head, places, clip.notices, "this export") or "Y"
