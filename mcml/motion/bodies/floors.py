"""The height of the floor of a clip along its up axis: from force plates, from 0 of the laboratory, or from feet."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from mcml.motion.bodies.origins import Origin
from mcml.motion.clip import ClipHead
from mcml.motion.floor_plates import floor_of_plates, kept_plates
from mcml.motion.guesses import landmarks_of
from mcml.motion.skeleton import Array, Convention, Skeleton, once_a_skeleton
from mcml.numerics.ranks import percentile

_LOW = 5.0
"""Percent of the heights of the toes that are below the floor."""
_LOWEST = 1.0
"""The same of a marker, which is on top of the foot or behind it."""
_LEAST, _MOST = -0.02, 0.1
"""Metres of the lowest marker of a foot above the floor: its radius, and the thickness of the sole."""
_STEP = 0.05
"""Metres between plates of one floor, at most."""
_FOOT: Final = re.compile(r"heel|hee\b|toe|mt[1-5]$|foot")


def find_floor(
    head: ClipHead, names: Sequence[str], positions: Array, up: Array, metres: float | None
) -> tuple[float | None, Origin]:
    """Return the height of the floor along up, (3,), in source units, None where unknown.

    names, positions (n, P, 3): of the points of the body, NaN where unknown. metres: of a source unit.
    """
    return (
        _of_plates(head, up, metres)
        or _of_markers(head.skeleton, positions, up, metres)
        or _of_joints(names, positions, up)
        or (None, Origin("unknown", "no foot is known"))
    )


def _of_plates(head: ClipHead, up: Array, metres: float | None) -> tuple[float, Origin] | None:
    plates = kept_plates(head)
    heights = floor_of_plates(plates, up)
    if heights is None:
        return None
    low, high = heights
    if metres is not None and (high - low) * metres <= _STEP:
        return (low + high) / 2, Origin("stated", "the surface of the force plates")
    if low == high:
        return low, Origin("stated", "the surface of the force plates")
    return low, Origin("guessed", "force plates have several heights: the lowest one")


def _of_markers(skeleton: Skeleton, positions: Array, up: Array, metres: float | None) -> tuple[float, Origin] | None:
    lowest = [
        percentile(seen, _LOWEST)
        for marker in _foot_markers(skeleton)
        if len(seen := (heights := positions[:, marker] @ up)[np.isfinite(heights)])
    ]
    if not lowest:
        return None
    low = min(lowest)
    if metres is None:
        return low, Origin("guessed", "the lowest marker of a foot; the unit is unknown, so 0 was not checked")
    above = f"the lowest marker of a foot is {low * metres * 1000:.0f} mm above 0"
    if _LEAST <= low * metres <= _MOST:
        return 0.0, Origin("guessed", f"0 of the file: {above}")
    return low, Origin("guessed", f"the lowest marker of a foot; 0 of the file is not the floor, for {above}")


@once_a_skeleton
def _foot_markers(skeleton: Skeleton) -> tuple[int, ...]:
    """Indices of markers of heels and toes, by their landmarks, else by their names."""
    if any(joint.convention is not Convention.MARKER for joint in skeleton.joints):
        return ()
    known = landmarks_of(skeleton)
    texts = [known.get(index, joint.source_name.lower()) for index, joint in enumerate(skeleton.joints)]
    return tuple(index for index, text in enumerate(texts) if _FOOT.search(text) and not text.endswith("_tracking"))


def _of_joints(names: Sequence[str], positions: Array, up: Array) -> tuple[float, Origin] | None:
    at = {name: index for index, name in enumerate(names)}
    for part in ("toes", "foot"):
        joints = [at[name] for side in ("left", "right") if (name := f"{side}_{part}") in at]
        heights = (positions[:, joints] @ up).ravel()
        heights = heights[np.isfinite(heights)]
        if len(heights):
            word = "toes" if part == "toes" else "feet (no toes are known)"
            return percentile(heights, _LOW), Origin("guessed", f"the {word} are above it nearly always")
    return None
