"""Decide whether the position channels of a BVH replace the OFFSET or add to it, which the file does not state.

For the joints that carry a body the heights of its lowest joint decide: in the rest pose, and in the motion by either
reading. Position channels below them decide by their own values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mcml.errors import Notice
from mcml.motion.carriers import chain
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.hub import HubReader, rest_of, walked
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import Array, Convention, Skeleton, numbers, once_a_skeleton

ABSOLUTE: Final = "absolute"
RELATIVE: Final = "relative"
MOST_FRAMES: Final = 64
"""Frames of a sample that are looked at."""

_APART: Final = 0.25
"""Relative to the body's size: two readings that differ this much in height are clearly different.

A shorter OFFSET is no evidence: SMPL bodies have the pelvis a fifth of their size away from the origin.
"""

_AGREES: Final = 0.15
_AGREES_CLOSELY: Final = 0.03
"""Of the body's size: how far the lowest joint may be from that of the rest pose, where the readings are far apart and
where they are not."""

_AGREES_OF_GAP: Final = 0.1
"""Likewise, of the distance between the two readings, where that is much longer than the body."""

_HANGS: Final = 0.3
"""Relative to the length of the legs: a rest pose that extends down less, as in rigs with all bones along one axis,
is not a standing body, and the legs are treated as stretched.
"""

_SHOWN: Final = 5

_MOST_CARRIERS: Final = 4
"""Joints below each other that may carry a body; each takes a walk through the whole skeleton."""


@dataclass(frozen=True, slots=True)
class TranslationReading:
    """The interpretation of the positions of a joint with an OFFSET, and its evidence.

    mode: "absolute" or "relative". clear: whether one reading agrees with the rest pose, and the other does not.
    up: along which heights are measured, "Y" or "Z", with a minus where the rest pose hangs down; "" for a joint that
        does not carry the body.
    rest: height of the lowest joint in the rest pose, in the file's unit of length; with stretched legs if `stretched`.
    absolute, relative: that of the motion by either reading, the median over the frames.
    """

    joint: int
    mode: str
    clear: bool
    up: str = ""
    rest: float = 0.0
    absolute: float = 0.0
    relative: float = 0.0
    stretched: bool = False


def read_translations(skeleton: Skeleton, sample: Array) -> tuple[TranslationReading, ...]:
    """Return the readings of all joints whose OFFSET and position channels are ambiguous, in any mode.

    skeleton: of the convention LISTED; other conventions are never ambiguous. sample: (n, D) frames of the motion in
    the skeleton's columns, spread over it; NaN where a sample is missing.
    """
    if not _choices(skeleton) or not len(sample):
        return ()
    values = np.nan_to_num(sample[:: -(-len(sample) // MOST_FRAMES)])
    carried = _carriers(skeleton)
    readings: list[TranslationReading] = []
    known = _with_modes(skeleton, tuple((joint, ABSOLUTE) for joint in _choices(skeleton)))
    places = _places(skeleton)
    for joint in _choices(skeleton):
        if joint not in carried:
            readings.append(_by_value(skeleton, joint, places[joint], values))
            continue
        readings.append(_by_height(known, joint, values))
        if readings[-1].mode == RELATIVE:
            known = _with_modes(known, ((joint, RELATIVE),))
    return tuple(readings)


def differing_translations(skeleton: Skeleton, sample: Array) -> tuple[TranslationReading, ...]:
    """Return the readings that differ from the modes of a skeleton's joints; () if none does.

    Arguments as for `read_translations`. A chosen mode cannot be distinguished from a guessed one.
    """
    readings = read_translations(skeleton, sample)
    return tuple(reading for reading in readings if reading.mode != skeleton.joints[reading.joint].translation)


def guess_translation(skeleton: Skeleton, sample: Callable[[], Array], wanted: str, notices: list[Notice]) -> Skeleton:
    """Set each joint's translation mode: as requested, or guessed from the motion, with a notice.

    sample: returns the frames for `read_translations`; called only if a mode is ambiguous.
    """
    if wanted in (ABSOLUTE, RELATIVE):
        moved = [index for index, joint in enumerate(skeleton.joints) if joint.translation]
        return _with_modes(skeleton, tuple((index, wanted) for index in moved))
    if not _choices(skeleton):
        return skeleton
    readings = read_translations(skeleton, sample())
    notices += [_notice(skeleton, reading) for reading in readings if reading.up][:_SHOWN]
    others = [reading.joint for reading in readings if not reading.up and reading.mode == RELATIVE]
    if others:
        names = ", ".join(repr(skeleton.joints[index].source_name) for index in others[:_SHOWN])
        what = (
            f"positions of {names}{' …' if len(others) > _SHOWN else ''} are nearer to 0 than to the OFFSET: "
            "read as added to it. Import with translation=absolute if they replace it"
        )
        notices.append(Notice("guess", what))
    relative = tuple((reading.joint, RELATIVE) for reading in readings if reading.mode == RELATIVE)
    return _with_modes(skeleton, relative) if relative else skeleton


def _notice(skeleton: Skeleton, reading: TranslationReading) -> Notice:
    name = skeleton.joints[reading.joint].source_name
    adds = reading.mode == RELATIVE
    chosen, other = ("are added to", "replace") if adds else ("replace", "are added to")
    sure = "clear" if reading.clear else "uncertain"
    pose = "with its legs stretched below the OFFSET" if reading.stretched else "in the rest pose"
    what = (
        f"positions of {name!r} {chosen} its OFFSET ({sure}): the height of the lowest joint, along {reading.up}, is "
        f"{reading.rest:.4g} {pose}, {reading.absolute:.4g} in the motion if they replace it and "
        f"{reading.relative:.4g} if they are added. Import with translation={ABSOLUTE if adds else RELATIVE} "
        f"if they {other} it"
    )
    return Notice("guess", what)


@once_a_skeleton
def _with_modes(skeleton: Skeleton, modes: tuple[tuple[int, str], ...]) -> Skeleton:
    joints = list(skeleton.joints)
    for index, mode in modes:
        joints[index] = replace(joints[index], translation=mode)
    return replace(skeleton, joints=tuple(joints))


@once_a_skeleton
def _places(skeleton: Skeleton) -> dict[int, list[tuple[int, int]]]:
    """(axis, column) of the position channels of each joint."""
    found: dict[int, list[tuple[int, int]]] = {}
    for place, (joint, axis) in enumerate(skeleton.columns()):
        if axis < 3:
            found.setdefault(joint, []).append((axis, place))
    return found


@once_a_skeleton
def _choices(skeleton: Skeleton) -> tuple[int, ...]:
    """Joints with position channels along an axis in which their OFFSET is not 0."""
    return tuple(
        index
        for index, joint in enumerate(skeleton.joints)
        if joint.convention is Convention.LISTED
        and any(
            numbers(joint.offset)["XYZ".index(channel[1].upper())] for channel in joint.channels if channel[0] == "T"
        )
    )


@once_a_skeleton
def _carriers(skeleton: Skeleton) -> frozenset[int]:
    """The joints that carry a body: each root, and below one that does not branch the first joint that does."""
    return frozenset(joint for root in skeleton.roots for joint in chain(skeleton, root)[:_MOST_CARRIERS])


def _by_height(skeleton: Skeleton, joint: int, values: Array) -> TranslationReading:
    """Absolute, unless the lowest joint agrees with the rest pose's only when the OFFSET is added.

    Positions that are nearer to the OFFSET than to 0 in height replace it in any case.
    """
    body = _body(skeleton, joint)
    absolute, relative = (
        _heights(_with_modes(skeleton, ((joint, mode),)), body, values) for mode in (ABSOLUTE, RELATIVE)
    )
    offset = numbers(skeleton.joints[joint].offset)
    # Both readings have the same poses: they differ by the OFFSET, rotated by the joints above.
    gap = float(np.abs(relative - absolute).max())
    far = gap > _APART * body.size
    told = far or float(np.linalg.norm(offset)) > _APART * body.size
    allowed = max((_AGREES if far else _AGREES_CLOSELY) * body.size, _AGREES_OF_GAP * gap)
    replaces, adds = (float(np.mean(np.abs(heights - body.rest) <= allowed)) >= 0.5 for heights in (absolute, relative))
    places = [place for axis, place in _places(skeleton)[joint] if body.up[axis]]
    height = float(np.abs(values[:, places]).mean()) if places else 0.0
    from_offset = float(np.abs(values[:, places] - offset @ np.abs(body.up)).mean()) if places else 0.0
    mode = RELATIVE if told and adds and not replaces and height < from_offset else ABSOLUTE
    middle = float(np.median(absolute)), float(np.median(relative))
    clear = told and replaces != adds and (mode == RELATIVE) == adds
    return TranslationReading(joint, mode, clear, body.axis, body.rest, *middle, body.stretched)


def _heights(skeleton: Skeleton, body: _Body, values: Array) -> Array:
    """(n,) how high the lowest joint of a body is."""
    columns = skeleton.columns()
    ids = np.arange(1, len(values) + 1, dtype=np.int64)
    hub = HubReader(skeleton).read(FrameBlock(values, columns, (full_shape(columns),), ids))
    positions = walked(skeleton, hub.translations, hub.rotations)[0]
    return np.asarray((positions[:, body.joints] @ body.up).min(axis=1))


@dataclass(frozen=True, eq=False)
class _Body:
    """A joint and all below it. axis: up as a word. up: (3,). size: the largest extent of the rest pose.

    rest: height of its lowest joint in the rest pose, with stretched legs if `stretched`.
    """

    joints: list[int]
    axis: str
    up: Array
    size: float
    rest: float
    stretched: bool


@once_a_skeleton
def _body(skeleton: Skeleton, joint: int) -> _Body:
    """Up is from feet to head in the rest pose, along Y or Z, with which BVH is written.

    Without such names it is the one of these two along which the body is longer, Y where it is as long along both.
    """
    joints = _branch(skeleton, joint)
    positions = _rest_positions(skeleton)
    extent = np.ptp(positions[joints], axis=0)
    axis, sign = (2 if extent[2] > extent[1] else 1), 1.0
    heads, feet = _named(skeleton, joints, ("head",)), _named(skeleton, joints, ("foot", "ankle", "toe"))
    if heads and feet:
        towards = positions[heads].mean(axis=0) - positions[feet].mean(axis=0)
        if towards[1:].any():
            axis = 1 if abs(towards[1]) >= abs(towards[2]) else 2
            sign = float(np.sign(towards[axis]))
    up = np.zeros(3)
    up[axis] = sign
    legs = _longest(skeleton, joint, feet or joints)
    top = float(positions[joint] @ up)
    lowest = float((positions[joints] @ up).min())
    stretched = top - lowest < _HANGS * legs
    rest = top - legs if stretched else lowest
    return _Body(joints, ("-" if sign < 0 else "") + "XYZ"[axis], up, max(float(extent.max()), legs), rest, stretched)


def _longest(skeleton: Skeleton, joint: int, joints: list[int]) -> float:
    """The longest way along the bones from a joint to one of others."""
    ways = {joint: 0.0}
    for index in _branch(skeleton, joint)[1:]:
        bone = float(np.linalg.norm(rest_of(skeleton).offsets[index]))
        ways[index] = ways[skeleton.joints[index].parent] + bone
    return max(ways[index] for index in joints)


def _named(skeleton: Skeleton, joints: list[int], words: tuple[str, ...]) -> list[int]:
    return [index for index in joints if any(word in skeleton.joints[index].source_name.lower() for word in words)]


@once_a_skeleton
def _rest_positions(skeleton: Skeleton) -> Array:
    """(J, 3) of the rest pose, each root at its OFFSET."""
    still = np.broadcast_to(IDENTITY, (1, len(skeleton), 4))
    positions: Array = walked(skeleton, rest_of(skeleton).offsets[None], still)[0][0]
    return positions


def _branch(skeleton: Skeleton, joint: int) -> list[int]:
    """A joint and all below it; subtrees are contiguous."""
    found = [joint]
    inside = {joint}
    for index in range(joint + 1, len(skeleton)):
        if skeleton.joints[index].parent not in inside:
            break
        inside.add(index)
        found.append(index)
    return found


def _by_value(skeleton: Skeleton, joint: int, places: list[tuple[int, int]], values: Array) -> TranslationReading:
    """Absolute, unless the mean is nearer to 0 than to the OFFSET and agrees with it along no axis."""
    offset = numbers(skeleton.joints[joint].offset)[[axis for axis, _ in places]]
    mean = values[:, [place for _, place in places]].mean(axis=0)
    large = np.abs(offset) >= 0.1 * np.linalg.norm(offset)
    agrees = bool((large & (np.abs(mean - offset) < 0.25 * np.abs(offset))).any())
    nearer_to_zero = bool(np.linalg.norm(mean) < np.linalg.norm(mean - offset))
    mode = RELATIVE if nearer_to_zero and not agrees else ABSOLUTE
    return TranslationReading(joint, mode, agrees != nearer_to_zero)
