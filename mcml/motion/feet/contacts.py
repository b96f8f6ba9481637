"""Contacts of feet: when a foot is planted, and how far it slides meanwhile.

A contact begins when the foot is low and slow, and ends when it is no longer low or no longer slow; the limits for the
end are wider than those for the start (hysteresis), so that contacts do not flicker (Lee et al., "Interactive control
of avatars animated with human motion data", 2002).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.motion.hub_writer import Flags
from mcml.motion.skeleton import Array
from mcml.numerics.runs import find_true

_LOW, _NOT_LOW = 0.06, 0.12
"""Heights above the lowest the foot gets, in lengths of a leg."""
_SLOW, _NOT_SLOW = 0.35, 0.7
"""Speeds in lengths of a leg a second."""
_SHORTEST = 0.05
"""Shortest contact in seconds."""


def contact_flags(places: Array, frame_time: float, leg: float, up: Array, floor: float | None = None) -> Flags:
    """(n,) true in frames in which a foot is planted.

    places: (n, 3) of one of its joints in the world. frame_time: seconds. leg: its length, in the same unit. up: (3,)
    unit vector. floor: height of the joint when it stands; default the height under which it is in a twentieth of the
    frames.
    """
    flags = np.zeros(len(places), dtype=bool)
    if len(places) < 2 or not leg:
        return flags
    heights = places @ up
    heights = (heights - (standing_height(places, up) if floor is None else floor)) / leg
    speeds = np.linalg.norm(np.gradient(places, axis=0), axis=1) / (frame_time * leg)
    for first, end in standing(heights, speeds, frame_time):
        flags[first:end] = True
    return flags


def standing_height(places: Array, up: Array) -> float:
    """The height under which a joint at positions (n, 3) is in a twentieth of the frames."""
    return float(np.percentile(places @ up, 5))


def standing(heights: Array, speeds: Array, frame_time: float) -> list[tuple[int, int]]:
    """Return (first, end) of the frames, from 0, in which something is planted; the end is the index after the last.

    heights: (n,) above the ground in leg lengths. speeds: (n,) in leg lengths a second. NaN where unknown: no contact
    there. frame_time: seconds.
    """
    stands = hysteresis((heights < _LOW) & (speeds < _SLOW), (heights < _NOT_LOW) & (speeds < _NOT_SLOW))
    shortest = max(2, int(np.ceil(_SHORTEST / frame_time)))
    return [(first, end) for first, end in find_true(stands).tolist() if end - first >= shortest]


def hysteresis(begins: Flags, stays: Flags) -> Flags:
    """(n,) true from where `begins` is until `stays` is no longer, both ways from each beginning.

    >>> hysteresis(np.array([0, 0, 1, 0, 0, 0]) > 0, np.array([0, 1, 1, 1, 0, 1]) > 0).astype(int).tolist()
    [0, 1, 1, 1, 0, 0]
    """
    stands = np.zeros(len(begins), dtype=bool)
    for first, end in find_true(stays | begins):
        stands[first:end] = begins[first:end].any()
    return stands


def sliding(places: Array, stands: Sequence[tuple[int, int]], up: Array) -> float:
    """Return the distance that a foot at positions (n, 3) moves over the ground during contacts.

    stands: (first, last) frames.
    """
    total = 0.0
    for first, last in stands:
        steps = np.diff(places[first : last + 1], axis=0)
        total += float(np.linalg.norm(steps - np.outer(steps @ up, up), axis=1).sum())
    return total
