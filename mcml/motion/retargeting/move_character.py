"""A clip on the rig of a character: as it is where both have the same joints, else retargeted."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mcml.errors import ConversionError, LimitError, Notice
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.conventions.resizing import turn_up
from mcml.motion.frames import joined
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.solving.marker_skeleton import has_markers, with_skeleton
from mcml.motion.units import reading_of

MOST_POSES = 1_000_000
"""Frames times joints of both, which are in memory together."""
LEAST_MATCHES = 8
"""Joints of both that must be the same: fewer move hardly anything of a body."""
_OF_BODY = (
    "skeleton_name",
    "calibration_unit",
    "global_axis_of_gravity",
    "bone_length_axis",
    "units_angle",
    "units_mass",
    "units_length",
    "scale_factor",
    "euler_rotation_order",
)
"""Fields of a header that define the meaning of the skeleton's numbers."""


@dataclass(frozen=True, eq=False)
class Movement:
    """Frames of a body. up: the axis that points up, "X", "Y" or "Z"."""

    head: ClipHead
    block: FrameBlock
    up: str


@dataclass(frozen=True, eq=False)
class MovedCharacter:
    """head, block: the motion on the rig of the character, in its unit and axes. scale: its lengths in those of the
    clip. notices: of the retargeting."""

    head: ClipHead
    block: FrameBlock
    scale: float
    notices: tuple[Notice, ...]

    def clip(self) -> ClipStream:
        return ClipStream(self.head, lambda: iter([self.block]), len(self.block), list(self.notices))


def move_character(source: Movement, body: Movement, seconds: float) -> MovedCharacter:
    """Return the motion of a clip on the rig of a character.

    body: the character with at least one frame. seconds: of a frame. Markers get a skeleton first. Raises
    ConversionError where too few joints of the two are the same, for markers that show no skeleton and for a character
    of markers; LimitError for more than `MOST_POSES`.
    """
    if has_markers(body.head.skeleton):
        raise ConversionError("Markers have no bones that could carry a body.", remedy="They are shown as points.")
    check_size(len(source.block), len(source.head.skeleton), len(body.head.skeleton))
    notices: list[Notice] = []
    if has_markers(source.head.skeleton):
        solved = with_skeleton(ClipStream(source.head, lambda: iter([source.block]), len(source.block)))
        source, notices = Movement(solved.head, joined(solved.blocks()), source.up), solved.notices
    own, rig = source.head.skeleton, body.head.skeleton
    head = replace(with_body(source.head, body.head), frame_time=source.head.frame_time)
    if own == rig and reading_of(source.head) == reading_of(body.head) and source.up == body.up:
        return MovedCharacter(head, source.block, 1.0, tuple(notices))
    if source.up != body.up:
        clip = ClipStream(source.head, lambda: iter([source.block]), len(source.block))
        turned = turn_up(clip, source.up, body.up)
        source = Movement(turned.head, joined(turned.blocks()), body.up)
        own = source.head.skeleton
    matches = suggest_matches(own, rig)
    if 2 * len(matches) <= min(len(own), len(rig)) or len(matches) < min(LEAST_MATCHES, len(rig)):
        raise ConversionError(
            f"Only {len(matches)} joints of the clip are known in the character, which has {len(rig)}.",
            remedy="Name the joints of both: `mcml names`.",
        )
    made = retarget(
        own, source.block, rig, matches, seconds,
        reading=reading_of(source.head), target_reading=reading_of(body.head), up=body.up, target_block=body.block,
    )  # fmt: skip
    notices += [*made.report.notices(own, rig), *made.shortfall.notices(rig)]
    return MovedCharacter(head, made.block, made.report.scale, tuple(notices))


def check_size(frames: int, joints: int, others: int) -> None:
    """Raises LimitError for more frames than are moved at once, of a clip and a character of so many joints."""
    most = MOST_POSES // max(1, joints + others)
    if frames > most:
        raise LimitError(
            f"A character of {others} joints is moved through at most {most} frames of this clip, which has {frames}.",
            remedy="Take a range of frames: `mcml split ID FIRST-LAST` extracts one.",
        )


def with_body(head: ClipHead, body: ClipHead) -> ClipHead:
    """Return a header with the skeleton of another, and its units, axes and conventions."""
    fields = {name: text for name, text in head.fields.items() if name not in (*_OF_BODY, "num_frames", "num_segments")}
    fields |= {name: text for name, text in body.fields.items() if name in _OF_BODY}
    return replace(head, format=body.format, skeleton=body.skeleton, fields=fields, sources=body.sources)
