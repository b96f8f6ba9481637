"""A motion that is not stored, as positions for an eye to judge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from service.motion.clip import ClipStream
from service.motion.kinematics import Walker
from service.motion.skeleton import Array
from service.motion.units import reading_of


def positions_of(stream: ClipStream, step: int) -> tuple[NDArray[np.float32], Array]:
    """(n, J + T, 3) of joints, then of ends of chains, in every step-th frame; and (3,) the origin that is taken off:
    where the first joint is in the first frame. In the clip's unit.
    """
    walker = Walker(stream.head.skeleton, reading_of(stream.head))
    found: list[NDArray[np.float32]] = []
    origin: Array = np.zeros(3)
    skipped = 0
    for block in stream.blocks():
        positions, _, tips = walker.poses_with_tips(block)
        points = np.concatenate([positions, tips], axis=1)
        if not found and len(points):
            origin = points[0, 0].copy()
        found.append((points[skipped::step] - origin).astype("<f4"))
        skipped = (skipped - len(points)) % step
    count = len(stream.head.skeleton) + walker.tip_count
    return np.concatenate(found) if found else np.empty((0, count, 3), "<f4"), origin
