"""The data of a scene: stated unit and up axis, times of frames, and moving joints."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError
from mcml.formats.format import need_seconds, note
from mcml.formats.missing_facts import guess_unit, guess_up
from mcml.motion.clip import ClipHead, ClipStream
from mcml.motion.conventions.convert import with_scale_factor
from mcml.motion.conventions.survey import STILL
from mcml.motion.guesses import stated_up
from mcml.motion.hub import HubReader, Rest, walked
from mcml.motion.rotations import multiply
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.skin import Character
from mcml.motion.units import metres_of, reading_of

LARGEST = float(np.finfo(np.float32).max)
_RATE_OF_A_POSE = 120
"""Frames a second of a scene with a single frame, or none, whose rate means nothing."""

_AXES = {"Y": (0.0, 0.0, 0.0), "Z": (-0.5, 0.0, 0.0), "X": (0.0, 0.0, 0.5)}
"""Half turns about X, Y and Z that make an axis point where Y does."""


@dataclass(frozen=True, eq=False)
class Stage:
    """The data of a scene.

    metres: of a unit of length, up: "Y", "-Z" …; as stated, else a guess that a notice names, else None. seconds: of a
    frame. moving, turning: (J,) joints that leave their rest. size: the largest extent of the first frame, or of the
    rest pose. character: whether a body with a skin is asked for: the own figure, or the body itself. faces: the clip
    with blend shapes, which `clip` has not, None without any.
    """

    clip: ClipStream
    rest: Array
    tips: tuple[tuple[int, Array], ...]
    frames: int
    seconds: float
    metres: float | None
    up: str | None
    moving: NDArray[np.bool_]
    turning: NDArray[np.bool_]
    size: float
    character: bool | Character = False
    faces: ClipStream | None = None

    @property
    def shapes(self) -> tuple[str, ...]:
        """The names of blend shapes."""
        skeleton = None if self.faces is None else self.faces.head.skeleton
        return () if skeleton is None else tuple(skeleton.joints[shape].source_name for shape in skeleton.blend_shapes)

    @property
    def skeleton(self) -> Skeleton:
        return self.clip.head.skeleton

    @property
    def title(self) -> str:
        """The name of the clip, if its file states one."""
        said = self.clip.head.fields.get("filename", "") or self.clip.head.fields.get("skeleton_name", "")
        return said.rsplit("/", 1)[-1].rpartition(".")[0] or said or "motion"

    def rest_places(self) -> Array:
        """(J, 3) joints in the rest pose, in the source's unit and axes."""
        places = self.rest.copy()
        for index, joint in enumerate(self.skeleton.joints):
            if joint.parent >= 0:
                places[index] += places[joint.parent]
        return places

    def blocks(self) -> Iterator[tuple[Array, Array]]:
        """Translations (n, J, 3) and rotations (n, J, 4) of the joints in their parents, frame after frame.

        Rotations are continuous: of the two quaternions for each, the one nearer to the previous frame's.
        """
        return ((translations, rotations) for translations, rotations, _ in self.blocks_with_weights())

    def blocks_with_weights(self) -> Iterator[tuple[Array, Array, Array]]:
        """As `blocks`, and the weights (n, S) of the blend shapes; a missing one keeps its last value."""
        clip = self.clip if self.faces is None else self.faces
        skeleton = clip.head.skeleton
        shapes = list(skeleton.blend_shapes)
        joints = [index for index in range(len(skeleton)) if index not in shapes] if shapes else slice(None)
        hub = HubReader(skeleton, reading_of(clip.head))
        last: Array | None = None
        for block in clip.blocks():
            if not len(block):
                continue
            found = hub.read(block)
            rotations = found.rotations[:, joints]
            before = np.concatenate([rotations[:1] if last is None else last[None], rotations[:-1]])
            apart = np.einsum("njk,njk->nj", before, rotations) < 0
            signs = np.where(np.cumsum(apart, axis=0) % 2 == 1, -1.0, 1.0)
            rotations = rotations * signs[:, :, None]
            last = rotations[-1]
            yield found.translations[:, joints], rotations, found.scales[:, shapes]


def look_through(clip: ClipStream, title: str, taken_for: str) -> Stage:
    """Collect the data of a scene in one pass over the frames.

    title: of the format. taken_for: the unit that readers of the format assume. Raises ConversionError for numbers
    beyond single precision. Adds notices for a missing unit or axis.
    """
    clip = with_scale_factor(clip)
    head, notices = clip.head, clip.notices
    metres, up = metres_of(head), stated_up(head)
    skeleton = head.skeleton
    hub = HubReader(skeleton, reading_of(head))
    first: tuple[Array, Array] | None = None
    frames, turning = 0, np.zeros(len(skeleton), dtype=bool)
    low, high = hub.rest.offsets.copy(), hub.rest.offsets.copy()
    for block in clip.blocks():
        if not len(block):
            continue
        found = hub.read(block)
        if first is None:
            first = found.translations[0], found.rotations[0]
        low = np.minimum(low, found.translations.min(axis=0))
        high = np.maximum(high, found.translations.max(axis=0))
        turning |= (np.abs(found.rotations[:, :, :3]) > STILL).any(axis=(0, 2))
        frames += len(block)
    _check_numbers(skeleton, hub.rest, low, high)
    if hub.missing:
        note(notices, "warning", f"{hub.missing} samples are missing; the last value is written")
    rest, reach = _rest(skeleton, hub.rest, low, high, first)
    moving = np.maximum(np.abs(high - rest), np.abs(low - rest)).max(axis=1, initial=0.0) > STILL * (reach or 1.0)
    stage = Stage(
        clip, rest, hub.rest.tips, frames, _seconds(head, frames, title), metres, up, moving, turning, 1.0
    )  # fmt: skip
    places = stage.rest_places() if first is None else walked(skeleton, first[0][None], first[1][None])[0][0]
    size = float(np.ptp(places, axis=0).max()) if len(places) else 0.0
    metres = guess_unit(head, places, notices, taken_for) if metres is None else metres
    up = guess_up(head, places, notices, title) if up is None else up
    return replace(stage, size=size if 0 < size < LARGEST else 1.0, metres=metres, up=up, character=clip.character)


def _rest(
    skeleton: Skeleton, stated: Rest, low: Array, high: Array, first: tuple[Array, Array] | None
) -> tuple[Array, float]:
    """Return the rest positions of joints in their parents, and the longest distance between two.

    Joints without offsets (markers, some rigs) rest at their position in the first frame.
    """
    rest = stated.offsets.copy()
    if first is not None:
        marker = np.array([joint.convention is Convention.MARKER for joint in skeleton.joints], dtype=bool)
        loose = marker | ((skeleton.parents >= 0) & ~rest.any(axis=1) & (low != high).any(axis=1))
        rest[loose] = first[0][loose]
    bones = np.abs(stated.bones).max(initial=0.0)
    return rest, float(max(np.abs(rest).max(initial=0.0), bones))


def _check_numbers(skeleton: Skeleton, rest: Rest, low: Array, high: Array) -> None:
    largest = np.maximum(np.abs(low), np.abs(high)).max(axis=1, initial=0.0)
    for joint, vector in rest.tips:
        largest[joint] = max(largest[joint], float(np.abs(vector).max()))
    # One addition for each joint stays within single precision.
    beyond = ~(largest < LARGEST / (len(skeleton) + 1))
    if beyond.any():
        raise ConversionError(
            f"joint {skeleton.joints[int(np.argmax(beyond))].name!r} is {largest.max():.3g} away from its parent, "
            "which is more than single precision holds",
            remedy="Check the numbers it is made from, or scale them with `unit`.",
        )


def _seconds(head: ClipHead, frames: int, title: str) -> float:
    seconds = need_seconds(head, title) if frames > 1 else head.seconds_per_frame() or 1 / _RATE_OF_A_POSE
    if not math.isfinite(seconds * frames) or seconds * frames > LARGEST:
        raise ConversionError(
            f"the times of the frames are beyond the largest number, at {seconds:g} seconds each",
            remedy="State another frame time first.",
        )
    return seconds


def turn_to_y(up: str | None) -> Array:
    """(4,) the rotation that makes an axis point where Y does."""
    if up is None:
        return np.array([0.0, 0.0, 0.0, 1.0])
    halves = np.array(_AXES[up[-1]]) * math.pi / 2
    turn = np.array([*np.sin(halves), np.cos(halves).prod()])
    if up.startswith("-"):
        turn = multiply(np.array([1.0, 0.0, 0.0, 0.0]), turn)
    return turn
