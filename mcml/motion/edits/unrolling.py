"""Euler angles without leaps: the same rotations, each angle as near as possible to that of the frame before.

Angles (a, b, c) about three different axes and (a + 180, 180 - b, c + 180) degrees are one rotation, and so are angles
that differ by whole turns. Curves of angles are then continuous, and filters and keys of animation programs work on
them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.motion.clip import FrameBlock
from mcml.motion.conventions.plans import product_order
from mcml.motion.frames import in_columns, remade
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Skeleton
from mcml.motion.units import DEGREES, Reading


def unroll(
    skeleton: Skeleton, block: FrameBlock, joints: Sequence[int] | None = None, reading: Reading = DEGREES
) -> tuple[FrameBlock, int]:
    """(frames of a clip whose angles do not leap, number of samples that have other angles).

    The first frame keeps its angles. joints: all by default. Rotations stay what they are; missing samples stay
    missing, and the next known one follows the last known one.
    """
    columns = skeleton.columns()
    values = in_columns(block, columns).copy()
    place = {column: index for index, column in enumerate(columns)}
    turn = 2 * np.pi / reading.motion_angle
    changed = 0
    for joint in range(len(skeleton)) if joints is None else joints:
        order = product_order(skeleton.joints[joint]) if skeleton.joints[joint].has_axes else ""
        own = [place[joint, CHANNEL_INDEX[f"R{letter.lower()}"]] for letter in order]
        if not own:
            continue
        known = np.flatnonzero(np.isfinite(values[:, own]).all(axis=1))
        before = values[known][:, own]
        after = _unroll_angles(before, turn, has_twin=len(set(order)) == len(order) == 3)
        moved = np.abs(after - before).max(axis=1) > turn / 4 if len(known) else np.zeros(0, dtype=bool)
        changed += int(moved.sum())
        # What did not leap keeps its bits.
        values[known[moved][:, None], own] = after[moved]
    places = np.arange(len(block), dtype=np.intp)
    return remade(block, columns, values, places, block.ids), changed


def _unroll_angles(angles: Array, turn: float, *, has_twin: bool) -> Array:
    """(n, k) angles, each row the nearest of its equivalents to the row before. has_twin: three different axes."""
    ways = [angles]
    if has_twin:
        half = turn / 2
        ways.append(np.stack([angles[:, 0] + half, half - angles[:, 1], angles[:, 2] + half], axis=1))
    unrolled = angles.copy()
    for row in range(1, len(angles)):
        last = unrolled[row - 1]
        nearest = [way[row] - turn * np.rint((way[row] - last) / turn) for way in ways]
        unrolled[row] = min(nearest, key=lambda each: float(np.abs(each - last).sum()))
    return unrolled
