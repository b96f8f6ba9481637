"""Find the twist of a limb with which its hinge bends correctly.

A rest pose defines the direction of a bone, not its twist, and rigs differ in that. If the bone below rotates freely
this does not matter; a knee that bends about one axis can only follow if that axis is correct.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcml.motion.hub_writer import HubWriter, angles_of
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array, Joint

TOLERATED = 2.0
"""Mean error of a bone's direction, in degrees, above which the limb above is twisted."""
_TRIED, _ROUNDS = 24, 16
_NARROWED = 0.7


def best_twist(error: Callable[[float], float]) -> float:
    """The angle in radians, within half a turn, at which an error is least, 0 where that is good enough.

    error: of an angle, in degrees. All around in steps of 15 degrees, then closer and closer to the best.
    """
    if error(0.0) <= TOLERATED:
        return 0.0
    angles = np.linspace(-np.pi, np.pi, _TRIED, endpoint=False)
    best = float(min(angles, key=lambda angle: (error(float(angle)), abs(angle))))
    least, step = error(best), np.pi / _TRIED
    for _ in range(_ROUNDS):
        for angle in (best - step, best + step):
            found = error(angle)
            if found < least:
                best, least = angle, found
        step *= _NARROWED
    return best


def beyond_limits(joint: Joint, index: int, writer: HubWriter, local: Array) -> Array:
    """(n,) degrees by which local rotations (n, 4) of a joint are outside its limits; 0 if it states none.

    The limits of a file are in the order of its channels, in degrees.
    """
    letters, axes = writer.letters(index), writer.rest.orientations[index]
    found = np.zeros(len(local))
    if not letters or len(joint.limits) != len(joint.channels):
        return found
    angles = np.degrees(angles_of(multiply(multiply(inverse(axes), local), axes), letters))
    angles -= 360 * np.round(angles / 360)
    for place, letter in enumerate(letters):
        words = joint.limits[joint.channels.index(f"R{letter.lower()}")].split()
        try:
            low, high = float(words[0]), float(words[1])
        except (ValueError, IndexError):
            continue
        if low < high:
            found += np.maximum(0.0, np.maximum(low - angles[:, place], angles[:, place] - high))
    return found
