"""The poses of a clip on the joints of an SMPL model, with Z up and in metres."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from mcml.errors import ConversionError
from mcml.formats.format import note
from mcml.formats.missing_facts import guess_up
from mcml.formats.scenes.stage import turn_to_y
from mcml.formats.smpl.skeleton import SmplBody, body_of, skeleton_of
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import turn_up
from mcml.motion.frames import joined
from mcml.motion.guesses import stated_up
from mcml.motion.hub import HubReader, walked
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array, Convention
from mcml.motion.units import metres_of, reading_of

_TARGET = 52
"""Joints of SMPL-H, the model of AMASS' first and most used files."""
_CORE = (
    "pelvis", "head", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
"""Joints without which a motion is not a person's."""
_SURE = 0.7
_MOST = 5_000_000
"""Joints, over all frames, that are transferred at once."""
_FRAMES_AT_ONCE = 2048


@dataclass(frozen=True, eq=False)
class Poses:
    """body: joints, in the order of its tree. is_z_up: whether the up axis is known, and thus Z.

    blocks: places of the root (n, 3) in metres, and rotations (n, J, 4) of joints in their parents, of the root in the
    world.
    """

    body: SmplBody
    is_z_up: bool
    blocks: Callable[[], Iterator[tuple[Array, Array]]]


def own_poses(clip: ClipStream, body: SmplBody) -> Poses:
    """Return the poses of a document whose joints are those of a model, unchanged but for unit and up axis."""
    head, skeleton = clip.head, clip.head.skeleton
    metres, up = metres_of(head), stated_up(head)
    if metres is None:
        note(clip.notices, "note", "the document states no unit of length: its numbers were written as metres")
    if up is None:
        note(clip.notices, "note", "the document states no up axis: nothing was turned, and the rate is called `fps`")
    turn = _turn_to_z(up)
    index = {joint.source_name: place for place, joint in enumerate(skeleton.joints)}
    order = [index[name] for name in body.names]
    hub = HubReader(skeleton, reading_of(head))

    def blocks() -> Iterator[tuple[Array, Array]]:
        for block in clip.blocks():
            if len(block):
                pose = hub.read(block)
                yield _turn_root((metres or 1.0) * pose.translations[:, order[0]], pose.rotations[:, order], turn)
        if hub.missing:
            note(clip.notices, "warning", f"{hub.missing} samples are missing; the last value is written")

    return Poses(body, up is not None, blocks)


def transfer_poses(clip: ClipStream, seconds: float) -> Poses:
    """Return the poses of another skeleton, retargeted to a general body of SMPL-H.

    Bones point as they do in the clip; travel is scaled by the length of the legs. Raises ConversionError for clips
    that lack joints of a person, and for very long ones.
    """
    body = body_of(_TARGET)
    target, skeleton = skeleton_of(body), clip.head.skeleton
    if any(joint.convention is Convention.MARKER for joint in skeleton.joints):
        raise ConversionError("SMPL holds joints, and markers have none", remedy="Export them as C3D or TRC.")
    matches = suggest_matches(skeleton, target)
    matched = {body.names[match.target] for match in matches}
    missing = [name for name in _CORE if name not in matched]
    if missing:
        raise ConversionError(
            f"SMPL needs the joints of a person, and the clip lacks {', '.join(missing)}",
            remedy="Give its joints MCML's names with aliases, or choose another format.",
        )
    upright = turn_up(clip, _find_up(clip), "Y")
    block = joined(part for part in upright.blocks() if len(part))
    joints = max(len(skeleton), _TARGET)
    if len(block) * joints > _MOST:
        raise ConversionError(
            f"{len(block)} frames of {joints} joints are more than are transferred at once",
            remedy=f"Export a part, `first` and `last`: no more than {_MOST // joints} frames.",
        )
    result = retarget(
        upright.head.skeleton, block, target, matches, seconds, reading=reading_of(upright.head)
    )  # fmt: skip
    note(
        clip.notices, "warning", "the clip was retargeted to a general SMPL-H body of 1.70 m: its bones point the same"
    )
    for notice in result.report.notices(skeleton, target):
        note(clip.notices, notice.kind, notice.what)
    doubtful = [body.names[match.target] for match in matches if match.confidence < _SURE]
    if doubtful:
        note(clip.notices, "guess", f"joints that stand in for those of SMPL: {', '.join(doubtful)}")
    pose = HubReader(target).read(result.block)
    turn = _turn_to_z("Y")

    def blocks() -> Iterator[tuple[Array, Array]]:
        for first in range(0, len(block), _FRAMES_AT_ONCE):
            rows = slice(first, first + _FRAMES_AT_ONCE)
            yield _turn_root(pose.translations[rows, 0], pose.rotations[rows], turn)

    return Poses(body, True, blocks)


def _find_up(clip: ClipStream) -> str:
    """The up axis that the document states, else a guess with a notice."""
    stated = stated_up(clip.head)
    if stated is not None:
        return stated
    hub = HubReader(clip.head.skeleton, reading_of(clip.head))
    first = next((block for block in clip.blocks() if len(block)), None)
    if first is None:
        return "Y"
    pose = hub.read(first)
    places = walked(clip.head.skeleton, pose.translations[:1], pose.rotations[:1])[0][0]
    return guess_up(clip.head, places, clip.notices, "this export") or "Y"


def _turn_to_z(up: str | None) -> Array:
    """(4,) the rotation that makes an axis point where Z does; none for an unknown axis."""
    return turn_to_y(None) if up is None else multiply(inverse(turn_to_y("Z")), turn_to_y(up))


def _turn_root(places: Array, rotations: Array, turn: Array) -> tuple[Array, Array]:
    rotations = rotations.copy()
    rotations[:, 0] = multiply(turn, rotations[:, 0])
    return rotate(turn, places), rotations
