"""Bones of one clip on the body of another, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Edited, in_columns, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import HubWriter, Known
from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading


def lay_over(
    skeleton: Skeleton,
    base: FrameBlock,
    over: FrameBlock,
    joints: Sequence[int],
    strength: Array,
    reading: Reading = DEGREES,
    first: int = 0,
) -> Edited:
    """Joints of one clip on the body of another, frame by frame: the arms of a wave on the legs of a walk.

    joints: they rotate, and move in their parents, as in `over`; the others as in `base`. strength: (n,) for the frames
    of the base: 0 its own, 1 the other's, bit by bit; in between, interpolated. first: frame of the base, from 0, where
    `over` begins. Before it, and after the end of `over`, the base is unchanged.
    """
    columns = skeleton.columns()
    place = np.arange(len(base)) - first
    rows = np.clip(place, 0, max(len(over) - 1, 0))
    share = np.where((place >= 0) & (place < len(over)), strength, 0.0)
    one, two = (HubReader(skeleton, reading).read(block) for block in (base, over))
    chosen = np.unique(np.array(joints, dtype=np.intp))
    moved, turned, scales = one.translations.copy(), one.rotations.copy(), one.scales.copy()
    part = np.broadcast_to(share[:, None], (len(base), len(chosen)))
    moved[:, chosen] += part[..., None] * (two.translations[rows][:, chosen] - moved[:, chosen])
    scales[:, chosen] += part * (two.scales[rows][:, chosen] - scales[:, chosen])
    turned[:, chosen] = slerp(turned[:, chosen], two.rotations[rows][:, chosen], part)
    values, holds = one.values.copy(), np.ones((len(base), len(skeleton)), dtype=bool)
    holds[:, chosen] = ((share == 0) | (share == 1))[:, None]
    taken = np.array([joint in set(chosen.tolist()) for joint, _ in columns], dtype=bool)
    whole = np.ix_(np.flatnonzero(share == 1), np.flatnonzero(taken))
    values[whole] = two.values[rows][whole]
    writer = HubWriter(skeleton, reading)
    written = writer.write(moved, turned, scales, Known(values, holds))
    gaps, others = np.isnan(in_columns(base, columns)), np.isnan(in_columns(over, columns))[rows]
    gaps = np.where(taken, (gaps & (share < 1)[:, None]) | (others & (share > 0)[:, None]), gaps)
    written[gaps] = np.nan
    return Edited(remade(base, columns, written, np.arange(len(base), dtype=np.intp), base.ids), writer.shortfall)
