"""Positions of the joints of a body, as integer multiples of a small step: the basis of every quantity of a body.

Forward kinematics with rotation matrices, many frames at once, one component of all frames after the other: with A the
axes of a joint in the world, G those at rest and M the product of its channels' rotations, A = A_parent G_parent^-1 G M
and P = P_parent + A_parent G_parent^-1 t (docs/conventions.md). Joints without children are not rotated.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import FrameBlock
from mcml.motion.conventions.plans import product_order
from mcml.motion.hub import HubReader, rest_of
from mcml.motion.kinematics import unseen
from mcml.motion.layout import Held
from mcml.motion.rotations import inverse, multiply, rotate, to_matrix
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Skeleton, once_a_skeleton
from mcml.motion.units import DEGREES, Reading

Steps = NDArray[np.int32]

UNSEEN = int(np.iinfo(np.int32).min)
"""All three numbers of a joint with an unknown position: a sample is missing, or the position is out of range."""

BLOCK = 2048
"""Frames at a time: the matrices of a chain of joints stay in the processor's cache."""


@dataclass(frozen=True, eq=False)
class _Turn:
    """The transformation of a joint relative to its parent.

    above: (3, 3) G_parent^-1. on: (3, 3) G_parent^-1 G, None for the identity. angles: (axis, place among all angles)
    of the factors of M. turns: whether it has children.
    """

    parent: int
    above: Array | None
    on: Array | None
    angles: tuple[tuple[int, int], ...]
    turns: bool


def world_positions(skeleton: Skeleton, values: Array, reading: Reading = DEGREES) -> Array:
    """Positions (n, J, 3) of the joints in the world, in the source's unit and axes.

    values: (n, D) of the skeleton's columns without gaps (`Held`); frames of several clips may be concatenated. Each
    component of a joint is contiguous in memory.
    """
    found = np.empty((len(skeleton), 3, len(values)))
    for first in range(0, len(values), BLOCK):
        rows = slice(first, first + BLOCK)
        _walk(skeleton, values[rows], reading, found[:, :, rows])
    return found.transpose(2, 0, 1)


def world_directions(
    skeleton: Skeleton, values: Array, fixed: Sequence[tuple[int, Array]], reading: Reading = DEGREES
) -> Array:
    """Where directions that are fixed to joints point in the world, (n, directions, 3).

    fixed: joint, and direction (3,) at rest in the world, such as the line to the left of a thigh. values: as for
    `world_positions`.
    """
    turns, columns = _turns(skeleton, reading)
    orientations = rest_of(skeleton, reading).orientations
    needed: set[int] = set()
    for joint, _ in fixed:
        while joint >= 0 and joint not in needed:
            needed.add(joint)
            joint = skeleton.joints[joint].parent
    own = [(fixed_to, rotate(inverse(orientations[fixed_to]), direction)) for fixed_to, direction in fixed]
    found = np.empty((len(fixed), 3, len(values)))
    places = sorted(place for joint in needed for _, place in turns[joint].angles)
    row_of = {place: row for row, place in enumerate(places)}
    for first in range(0, len(values), BLOCK):
        part = values[first : first + BLOCK]
        angles = np.ascontiguousarray(part.T[[columns[place] for place in places]]) * reading.motion_angle
        sines, cosines = np.sin(angles), np.cos(angles)
        axes: dict[int, _Axes] = {}
        for joint in sorted(needed):
            turn = turns[joint]
            carried = _carry(turn, axes.get(turn.parent), len(part))
            rows = tuple((axis, row_of[place]) for axis, place in turn.angles)
            axes[joint] = _turned(carried, rows, sines, cosines)
        for place, (joint, (x, y, z)) in enumerate(own):
            one, two, three = axes[joint]
            found[place, :, first : first + BLOCK] = x * one + y * two + z * three
    return found.transpose(2, 0, 1)


def _walk(skeleton: Skeleton, values: Array, reading: Reading, found: Array) -> None:
    """Fills in (J, 3, n) positions."""
    turns, columns = _turns(skeleton, reading)
    moved = np.ascontiguousarray(HubReader(skeleton, reading).translations(values).transpose(1, 2, 0))
    angles = np.ascontiguousarray(values.T[columns]) * reading.motion_angle
    sines, cosines = np.sin(angles), np.cos(angles)
    axes: list[_Axes | None] = []
    for index, turn in enumerate(turns):
        carrier = axes[turn.parent] if turn.parent >= 0 else None
        there = moved[index] if turn.above is None else turn.above @ moved[index]
        if carrier is None:
            found[index] = there
        else:
            along = carrier[0] * there[0]
            along += carrier[1] * there[1]
            along += carrier[2] * there[2]
            np.add(found[turn.parent], along, out=found[index])
        if not turn.turns:
            axes.append(None)
            continue
        axes.append(_turned(_carry(turn, carrier, len(values)), turn.angles, sines, cosines))


_Axes: TypeAlias = tuple[Array, ...]
"""The three axes of a joint in the world: (3, n) components of each."""


def _carry(turn: _Turn, carrier: _Axes | None, frames: int) -> _Axes:
    """Axes of a joint before its own rotation: those of its parent, turned as at rest."""
    own = carrier or tuple(np.repeat(np.eye(3)[:, :, None], frames, axis=2))
    if turn.on is None:
        return own
    return tuple(one * own[0] + two * own[1] + three * own[2] for one, two, three in turn.on.T)


def _turned(axes: _Axes, angles: tuple[tuple[int, int], ...], sines: Array, cosines: Array) -> _Axes:
    """Axes after rotations about themselves, one after the other."""
    own = list(axes)
    for axis, place in angles:
        one, two = own[(axis + 1) % 3], own[(axis + 2) % 3]
        sine, cosine = sines[place], cosines[place]
        first = one * cosine
        first += two * sine
        second = two * cosine
        second -= one * sine
        own[(axis + 1) % 3], own[(axis + 2) % 3] = first, second
    return tuple(own)


@once_a_skeleton
def _turns(skeleton: Skeleton, reading: Reading) -> tuple[list[_Turn], list[int]]:
    """Return the transformation of each joint, and the columns of all angles."""
    place = {column: index for index, column in enumerate(skeleton.columns())}
    orientations = rest_of(skeleton, reading).orientations
    parents = {joint.parent for joint in skeleton.joints}
    turns: list[_Turn] = []
    columns: list[int] = []
    for index, joint in enumerate(skeleton.joints):
        angles = []
        for letter in product_order(joint):
            angles.append(("XYZ".index(letter), len(columns)))
            columns.append(place[index, CHANNEL_INDEX[f"R{letter.lower()}"]])
        back = None if joint.parent < 0 else inverse(orientations[joint.parent])
        on = orientations[index] if back is None else multiply(back, orientations[index])
        turns.append(
            _Turn(joint.parent, _matrix(back), _matrix(on), tuple(angles), index in parents),
        )
    return turns, columns


def _matrix(rotation: Array | None) -> Array | None:
    """(3, 3), None where nothing turns."""
    if rotation is None or not rotation[:3].any():
        return None
    return to_matrix(rotation)


@dataclass(frozen=True, eq=False)
class Filled:
    """Frames of a clip without gaps. values: (n, D) of the skeleton's columns, a missing sample as the last one before
    it. unseen: (n, J) where a sample that a joint's place hangs on is missing; None for nowhere."""

    values: Array
    unseen: NDArray[np.bool_] | None = None


def filled(skeleton: Skeleton, blocks: Iterable[FrameBlock]) -> Filled:
    """Consecutive blocks of one clip, from its first frame on."""
    held = Held(skeleton)
    values: list[Array] = [np.empty((0, len(held.columns)))]
    gaps: list[NDArray[np.bool_]] = []
    for block in blocks:
        values.append(held.values(block))
        gaps.append(unseen(skeleton, block) if held.missing else np.zeros((len(block), len(skeleton)), bool))
    return Filled(np.concatenate(values), np.concatenate(gaps) if held.missing else None)


def clip_positions(skeleton: Skeleton, clips: Sequence[Filled], reading: Reading = DEGREES) -> list[Array]:
    """Positions (n, J, 3) in each of some clips of a skeleton; NaN where a joint is not seen."""
    together = world_positions(skeleton, np.concatenate([clip.values for clip in clips]), reading)
    ends = np.cumsum([len(clip.values) for clip in clips])[:-1]
    found = np.split(together, ends)
    for positions, clip in zip(found, clips, strict=True):
        if clip.unseen is not None:
            positions[clip.unseen] = np.nan
    return found


def rounded(positions: Array, step: float) -> Steps:
    """Positions (n, J, 3) as whole numbers of a step, to the nearest, halves to the even one.

    step: in the unit of the positions. UNSEEN where one is not finite, or beyond 2^31 - 1 steps (at 0.1 mm, 214 km).
    """
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = positions / step
        np.rint(scaled, out=scaled)
    # NaN is not below anything either.
    beyond = ~(np.abs(scaled) < -UNSEEN)
    lost = beyond.any()
    if lost:
        scaled[beyond] = 0.0
    steps = scaled.astype(np.int32)
    if lost:
        steps[beyond.any(axis=-1)] = UNSEEN
    return steps
