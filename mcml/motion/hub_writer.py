"""From the hub form to the channels of a skeleton, in its own convention: the inverse of `HubReader`.

With C the rest orientation of a joint, o its rest offset, L and t its rotation and translation in the hub form
(docs/conventions.md): LISTED: angles of L, position t, or t - o where positions add to the offset. FIXED:
M = C^-1 L C, whose angles are about fixed axes; t - s o, in C, for a bone that may move (s: scale of the bone above).
BASE: C^-1 L C, and t - o in the axes of the parent at rest. MARKER: t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.errors import Notice
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.conventions.plans import is_identity, product_order
from mcml.motion.hub import HubReader
from mcml.motion.rotation_vectors import angle_between
from mcml.motion.rotations import from_euler, inverse, multiply, rotate, to_euler
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading
from mcml.numerics.runs import find_true

Flags = NDArray[np.bool_]

_AXIS = {"X": 0, "Y": 1, "Z": 2}
_SCALE = CHANNEL_INDEX["SF"]
_WEIGHT = CHANNEL_INDEX["weight"]
ROUNDING = 1e-9
"""Radians, and fractions of the size of a skeleton: differences up to this are rounding, not losses."""


@dataclass(frozen=True)
class Known:
    """Existing values that need not be computed.

    values: (n, D) in the skeleton's columns. holds: (n, J) where they are valid for a joint: its channels are copied
    bit by bit. near: whether they are a guess elsewhere: the angles of each frame are then the nearest to it; else
    angles continue from the previous frame.
    """

    values: Array
    holds: Flags
    near: bool = False


@dataclass(frozen=True)
class Shortfall:
    """The greatest loss in any frame, because channels are missing. angles: (J,) radians. lengths: (J,)."""

    angles: Array
    lengths: Array

    def worse_of(self, other: Shortfall) -> Shortfall:
        """The larger of each."""
        return Shortfall(np.maximum(self.angles, other.angles), np.maximum(self.lengths, other.lengths))

    def notices(self, skeleton: Skeleton) -> list[Notice]:
        """One line for turns and one for places, empty where all was held."""
        found = []
        for lost, limit, what in (
            (np.degrees(self.angles), 1e-6, "turn by up to {:.3g} degrees more than their channels hold"),
            (self.lengths, ROUNDING * _size(skeleton, self.lengths), "move up to {:.3g} more than their channels hold"),
        ):
            worst = np.flatnonzero(lost > limit)
            if len(worst):
                name = skeleton.joints[int(np.argmax(lost))].name
                found.append(
                    Notice("warning", f"{len(worst)} joints {what.format(float(lost.max()))}, most of all {name!r}")
                )
        return found


def _size(skeleton: Skeleton, lengths: Array) -> float:
    rest = HubReader(skeleton).rest
    return max(1.0, float(np.abs(rest.offsets).max(initial=0.0)), float(np.abs(rest.bones).max(initial=0.0)))


class HubWriter:
    """Hub arrays of consecutive frames to channel values; carries angles from block to block, so that they are
    continuous.
    """

    def __init__(self, skeleton: Skeleton, reading: Reading = DEGREES) -> None:
        self.skeleton = skeleton
        self.columns = skeleton.columns()
        self._reading = reading
        self._reader = HubReader(skeleton, reading)
        self.rest = self._reader.rest
        place = {column: index for index, column in enumerate(self.columns)}
        self._letters = [product_order(joint) if joint.has_axes else "" for joint in skeleton.joints]
        self._turns = [
            [place[index, CHANNEL_INDEX[f"R{letter.lower()}"]] for letter in letters]
            for index, letters in enumerate(self._letters)
        ]
        self._moves = [
            [(axis, place[index, axis]) for axis in range(3) if (index, axis) in place]
            for index in range(len(skeleton))
        ]
        self._scaled = {index: place[index, _SCALE] for index in range(len(skeleton)) if (index, _SCALE) in place}
        self._scaled |= {index: place[index, _WEIGHT] for index in skeleton.blend_shapes if (index, _WEIGHT) in place}
        scaled = set(self._scaled.values())
        self._others = [
            index for index, (_, channel) in enumerate(self.columns) if channel > _SCALE and index not in scaled
        ]
        self._of_joint = [
            [column for column, (joint, _) in enumerate(self.columns) if joint == index]
            for index in range(len(skeleton))
        ]
        self._previous: list[Array | None] = [None] * len(skeleton)
        self.shortfall = Shortfall(np.zeros(len(skeleton)), np.zeros(len(skeleton)))

    def write(
        self, translations: Array, rotations: Array, scales: Array | None = None, known: Known | None = None
    ) -> Array:
        """Return channel values (n, D) in `columns`, finite.

        translations: (n, J, 3), rotations: (n, J, 4), scales: (n, J), 1 where left out: as in `HubBlock`. A channel
        that is not part of motion (`residual`) is 0 unless `known` has it. Losses of joints are added to `shortfall`.
        """
        count = len(translations)
        values = np.zeros((count, len(self.columns)))
        if not count:
            return values
        scales = np.ones((count, len(self.skeleton))) if scales is None else scales
        for index in range(len(self.skeleton)):
            held = known is not None and bool(known.holds[:, index].all())
            if known is not None and held:
                values[:, self._of_joint[index]] = known.values[:, self._of_joint[index]]
            else:
                self._move(index, translations[:, index], scales, values)
                self._scale(index, scales[:, index], values)
                self._turn(index, rotations[:, index], values, known)
            self._carry(index, values)
        if known is not None and self._others:
            values[:, self._others] = known.values[:, self._others]
        self._measure(translations, rotations, scales, values)
        return values

    def letters(self, index: int) -> str:
        """The axes of the product of a joint's rotations, left to right, as far as it has channels for them."""
        return self._letters[index]

    def is_free(self, index: int) -> bool:
        """Whether a joint can take every rotation."""
        return len(self._letters[index]) == 3

    def nearest(self, index: int, rotations: Array) -> Array:
        """Return the rotations (n, 4) nearest to given ones that the channels of a joint can represent."""
        if self.is_free(index):
            return rotations
        axes, letters = self.rest.orientations[index], self._letters[index]
        local = multiply(multiply(inverse(axes), rotations), axes)
        held = from_euler(angles_of(local, letters), letters)
        return multiply(multiply(axes, held), inverse(axes))

    def _carry(self, index: int, values: Array) -> None:
        if self._turns[index]:
            self._previous[index] = values[-1, self._turns[index]] * self._reading.motion_angle

    def _turn(self, index: int, rotation: Array, values: Array, known: Known | None) -> None:
        letters, columns = self._letters[index], self._turns[index]
        held = np.zeros(len(values), dtype=bool) if known is None else known.holds[:, index]
        if known is not None and held.any():
            for column in self._of_joint[index]:
                values[held, column] = known.values[held, column]
        if not letters:
            return
        axes = self.rest.orientations[index]
        if not is_identity(axes):
            rotation = multiply(multiply(inverse(axes), rotation), axes)
        unit = self._reading.motion_angle
        if known is not None and known.near:
            free = np.flatnonzero(~held)
            guess = known.values[np.ix_(free, np.array(columns))] * unit
            values[np.ix_(free, np.array(columns))] = _nearest_angles(rotation[free], letters, guess) / unit
            return
        for start, end in find_true(~held):
            previous = values[start - 1, columns] * unit if start else self._previous[index]
            values[start:end, columns] = angles_of(rotation[start:end], letters, previous) / unit

    def _move(self, index: int, translation: Array, scales: Array, values: Array) -> None:
        if not self._moves[index]:
            return
        joint, rest = self.skeleton.joints[index], self.rest
        offset = np.broadcast_to(rest.offsets[index], translation.shape)
        if joint.convention is Convention.FIXED and joint.parent >= 0:
            offset = offset * scales[:, joint.parent, None]
        if joint.convention is Convention.LISTED and joint.translation != "relative":
            moved = translation
        elif joint.convention is Convention.BASE and joint.parent >= 0:
            moved = rotate(inverse(rest.orientations[joint.parent]), translation - offset)
        elif joint.convention is Convention.FIXED and joint.parent >= 0:
            moved = rotate(inverse(rest.orientations[index]), translation - offset)
        else:
            moved = translation - offset
        for axis, column in self._moves[index]:
            values[:, column] = moved[:, axis]

    def _scale(self, index: int, scale: Array, values: Array) -> None:
        column = self._scaled.get(index)
        if column is None:
            return
        if self.skeleton.joints[index].convention is Convention.FIXED:
            scale = (scale - 1.0) * float(np.linalg.norm(self.rest.bones[index]))
        values[:, column] = scale

    def _measure(self, translations: Array, rotations: Array, scales: Array, values: Array) -> None:
        ids = np.arange(len(values), dtype=np.int64)
        again = self._reader.read(FrameBlock(values, self.columns, (full_shape(self.columns),), ids))
        angles = angle_between(rotations, again.rotations).max(axis=0)
        lengths = np.linalg.norm(translations - again.translations, axis=2).max(axis=0)
        self.shortfall = self.shortfall.worse_of(Shortfall(angles, lengths))


def angles_of(rotation: Array, letters: str, previous: Array | None = None) -> Array:
    """Angles (n, k) in radians about k axes of the product nearest to rotations (n, 4), continuous over the frames.

    letters: up to three different axes, the product's from left to right. previous: (k,) of the frame before.
    With fewer than three, q = Ri(a) Rj(b) is nearest where its scalar product with the rotation is largest: that is
    half of |z1| cos(a/2 + b/2 - arg z1) + |z2| cos(a/2 - b/2 - arg z2), two cosines that are 1 at the same time.
    """
    letters = letters.upper()
    if len(letters) == 3:
        return to_euler(rotation, letters, previous)
    if not letters or not len(rotation):
        return np.zeros((len(rotation), len(letters)))
    w, first = rotation[:, 3], rotation[:, _AXIS[letters[0]]]
    if len(letters) == 1:
        angles = 2 * np.arctan2(first, w)[:, None]
    else:
        i, j = _AXIS[letters[0]], _AXIS[letters[1]]
        second, third = rotation[:, j], rotation[:, 3 - i - j] * (1.0 if (j - i) % 3 == 1 else -1.0)
        total = np.arctan2(first + second, w - third)
        difference = np.arctan2(first - second, w + third)
        angles = np.stack([total + difference, total - difference], axis=-1)
    turns = 2 * np.pi
    if previous is None:
        angles[0] -= turns * np.round(angles[0] / turns)
        return np.unwrap(angles, axis=0)
    unwrapped: Array = np.unwrap(np.vstack([previous, angles]), axis=0)[1:]
    return unwrapped


def _nearest_angles(rotation: Array, letters: str, guess: Array) -> Array:
    """Angles (n, k) of rotations (n, 4), of all that mean the same those nearest to a guess (n, k) frame by frame."""
    angles = angles_of(rotation, letters)
    turns = 2 * np.pi
    angles = angles + turns * np.round((guess - angles) / turns)
    if len(letters) < 3:
        return angles
    other = angles * np.array([1.0, -1.0, 1.0]) + np.pi
    other = other + turns * np.round((guess - other) / turns)
    nearer = np.abs(other - guess).sum(axis=1) < np.abs(angles - guess).sum(axis=1)
    return np.where(nearer[:, None], other, angles)
