"""Limits of joints: the angles about its own axes that a joint may have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.hub_writer import HubWriter, angles_of
from mcml.motion.rotation_vectors import angle_between
from mcml.motion.rotations import from_euler, inverse, multiply
from mcml.motion.skeleton import Array, Joint, Skeleton
from mcml.numerics.runs import find_true

Limits = Mapping[int, Array]
"""Joint -> (k, 2) degrees, lowest and highest, about the axes of its rotations, left to right of their product."""
_TOLD = 0.01
"""Degrees beyond a limit from which a frame counts."""
_LOCKED = 1e-5
"""Radians, and cosine of the second of three angles: nearer than this, the other two turn about one axis."""


@dataclass(frozen=True)
class ClampedJoint:
    """A joint of the target that is kept inside its limits.

    spans: (first frame, last frame) from 0. largest: degrees that the joint would be outside.
    """

    joint: int
    spans: tuple[tuple[int, int], ...]
    largest: float


def file_limits(skeleton: Skeleton, writer: HubWriter) -> dict[int, Array]:
    """Return the limits that a file states for its joints, such as `limits` of ASF."""
    found = {index: joint_limits(joint, writer.letters(index)) for index, joint in enumerate(skeleton.joints)}
    return {index: limits for index, limits in found.items() if limits is not None}


def joint_limits(joint: Joint, letters: str) -> Array | None:
    """Return limits (k, 2) in degrees that a file states for a joint; None without any.

    letters: its k axes. A file states limits in the order of the joint's channels; an axis whose limits are no numbers
    has none.
    """
    if not letters or len(joint.limits) != len(joint.channels):
        return None
    limits = np.tile([-np.inf, np.inf], (len(letters), 1))
    for place, letter in enumerate(letters):
        words = joint.limits[joint.channels.index(f"R{letter.lower()}")].split()
        try:
            low, high = float(words[0]), float(words[1])
        except (ValueError, IndexError):
            continue
        if low < high:
            limits[place] = low, high
    return limits if np.isfinite(limits).any() else None


def clamp_joint(limits: Array, index: int, writer: HubWriter, local: Array) -> tuple[Array, Array]:
    """Move local rotations (n, 4) of a joint inside its limits, angle by angle.

    Return the rotations, and by how many degrees (n,) they were outside: the sum over the axes. Rotations inside stay
    as they are, to the bit. Three angles mean the same as three others, of which those are limited that are nearer.
    """
    letters, axes = writer.letters(index), writer.rest.orientations[index]
    own = multiply(multiply(inverse(axes), local), axes)
    angles = np.degrees(angles_of(own, letters))
    best, outside = angles, np.full(len(local), np.inf)
    for choice, holds in _equal_angles(own, angles, letters, limits):
        turned = _nearest_turn(choice, limits)
        clipped = np.clip(turned, limits[:, 0], limits[:, 1])
        away = np.where(holds, np.abs(turned - clipped).sum(axis=1), np.inf)
        nearer = away < outside - 1e-9
        best, outside = np.where(nearer[:, None], clipped, best), np.where(nearer, away, outside)
    if not len(local) or not (outside > 0).any():
        return local, np.where(np.isfinite(outside), outside, 0.0)
    held = multiply(multiply(axes, from_euler(np.radians(best), letters)), inverse(axes))
    return np.where((outside > 0)[:, None], held, local), outside


def _equal_angles(
    rotations: Array, angles: Array, letters: str, limits: Array
) -> Iterator[tuple[Array, NDArray[np.bool_] | bool]]:
    """Yield angles (n, k) in degrees that mean the same rotations (n, 4), and where they do.

    Where the second angle is 90 degrees, the first and the third turn about one axis: the first is limited, and the
    third makes up for it.
    """
    yield angles, True
    if len(letters) < 3:
        return
    both = angles, angles * [1.0, -1.0, 1.0] + 180.0
    yield both[1], True
    for choice in both:
        if not (np.abs(np.cos(np.radians(choice[:, 1]))) < _LOCKED).any():
            continue
        turned = _nearest_turn(choice, limits)
        first = np.clip(turned[:, 0], *limits[0])
        for sign in (1.0, -1.0):
            shifted = np.stack([first, turned[:, 1], turned[:, 2] + sign * (turned[:, 0] - first)], axis=1)
            yield shifted, angle_between(from_euler(np.radians(shifted), letters), rotations) < _LOCKED


def _nearest_turn(angles: Array, limits: Array) -> Array:
    """The same angles (n, k) in degrees, whole turns nearer to the middle of their limits."""
    stated = np.where(np.isfinite(limits).all(axis=1, keepdims=True), limits, 0.0)
    middle = stated.sum(axis=1) / 2
    turned: Array = angles - 360.0 * np.round((angles - middle) / 360.0)
    return turned


def describe_clamped(joint: int, outside: Array) -> ClampedJoint | None:
    """Describe the frames in which a joint is outside by (n,) degrees; None if it never is."""
    if not (outside > _TOLD).any():
        return None
    spans = tuple((first, end - 1) for first, end in find_true(outside > _TOLD).tolist())
    return ClampedJoint(joint, spans, float(outside.max()))
