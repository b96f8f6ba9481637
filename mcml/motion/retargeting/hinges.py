"""Find the twist of a limb with which its hinge bends correctly.

A rest pose defines the direction of a bone, not its twist, and rigs differ in that. If the bone below rotates freely
this does not matter; a knee that bends about one axis can only follow if that axis is correct.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

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
