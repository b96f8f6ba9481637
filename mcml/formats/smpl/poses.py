"""The poses of a clip on the joints of an SMPL model, with Z up and in metres."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from mcml.formats.format import note
from mcml.formats.scenes.stage import turn_to_y
from mcml.formats.smpl.skeleton import SmplBody, body_of, skeleton_of
from mcml.formats.transfer import match_person, transfer
from mcml.motion.clip import ClipStream
from mcml.motion.guesses import stated_up
from mcml.motion.hub import HubReader
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array
from mcml.motion.units import metres_of, reading_of

_TARGET = 52
"""Joints of SMPL-H, the model of AMASS' first and most used files."""
_CORE = (
    "pelvis", "head", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
"""Joints without which a motion is not a person's."""


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

    Raises ConversionError for clips that lack joints of a person, and for very long ones.
    """
    body = body_of(_TARGET)
    target = skeleton_of(body)
    matches = match_person(clip, target, _CORE, "SMPL")
    return own_poses(transfer(clip, target, matches, seconds, "a general SMPL-H body of 1.70 m"), body)


def _turn_to_z(up: str | None) -> Array:
    """(4,) the rotation that makes an axis point where Z does; none for an unknown axis."""
    return turn_to_y(None) if up is None else multiply(inverse(turn_to_y("Z")), turn_to_y(up))


def _turn_root(places: Array, rotations: Array, turn: Array) -> tuple[Array, Array]:
    rotations = rotations.copy()
    rotations[:, 0] = multiply(turn, rotations[:, 0])
    return rotate(turn, places), rotations
