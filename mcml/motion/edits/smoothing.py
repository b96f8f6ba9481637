"""Motion made smoother: a Gaussian over the frames.

Translations are weighted means. Rotations are too, on the sphere of quaternions: the mean is where the weighted
rotation vectors to all neighbours add to nothing (the intrinsic mean; Pennec 1998), so no Euler angle leaps.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Edited, Rows, in_columns, present, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import Flags, HubWriter, Known
from mcml.motion.rotation_vectors import from_vector, to_vector
from mcml.motion.rotations import inverse, multiply, slerp
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading

_REACH = 3.0
"""Standard deviations after which a neighbour counts no more."""


def smoothed(
    skeleton: Skeleton,
    block: FrameBlock,
    deviation: float,
    strength: Array,
    joints: Sequence[int] | None = None,
    reading: Reading = DEGREES,
) -> Edited:
    """Frames of a clip smoothed by a Gaussian.

    deviation: its standard deviation in frames. strength: (n,) of `frames.eased`: 0 keeps a frame bit by bit, 1 takes
    the mean. joints: those to smooth, all by default. Missing samples stay missing and count in no mean; near the ends
    of the clip the window shrinks on both sides alike, so that the first and the last frame stay.
    """
    if not (np.isfinite(deviation) and deviation > 0):
        raise ConversionError(f"{deviation} frames are no width of a mean", remedy="Give a positive number.")
    columns = skeleton.columns()
    raw = in_columns(block, columns)
    hub = HubReader(skeleton, reading).read(block)
    chosen = np.arange(len(skeleton)) if joints is None else np.unique(np.array(joints, dtype=np.intp))
    has = present(raw, columns, len(skeleton))[:, chosen]
    moved, turned, scales = hub.translations.copy(), hub.rotations.copy(), hub.scales.copy()
    share = np.broadcast_to(strength[:, None], has.shape)
    mean = smooth_vectors(np.concatenate([moved[:, chosen], scales[:, chosen, None]], axis=2), has, deviation)
    moved[:, chosen] += share[..., None] * (mean[..., :3] - moved[:, chosen])
    scales[:, chosen] += share * (mean[..., 3] - scales[:, chosen])
    turned[:, chosen] = slerp(turned[:, chosen], smooth_rotations(turned[:, chosen], has, deviation), share)
    holds = np.ones((len(block), len(skeleton)), dtype=bool)
    holds[:, chosen] = (strength == 0)[:, None]
    writer = HubWriter(skeleton, reading)
    values = writer.write(moved, turned, scales, Known(hub.values, holds))
    values[np.isnan(raw)] = np.nan
    rows = np.arange(len(block), dtype=np.intp)
    return Edited(remade(block, columns, values, rows, block.ids), writer.shortfall)


def smooth_vectors(vectors: Array, has: Flags, deviation: float) -> Array:
    """Gaussian means (n, J, k) of vectors (n, J, k); has: (n, J) which samples count."""
    total, weights = np.zeros_like(vectors), np.zeros(has.shape)
    for weight, rows in _neighbours(len(vectors), deviation):
        part = weight[:, None] * has[rows]
        # Differences from the middle keep what never changes to the last bit.
        total += part[..., None] * (vectors[rows] - vectors)
        weights += part
    mean: Array = vectors + total / np.where(weights > 0, weights, 1.0)[..., None]
    return mean


def smooth_rotations(rotations: Array, has: Flags, deviation: float) -> Array:
    """Gaussian means (n, J, 4) of unit quaternions (n, J, 4); has: (n, J) which samples count."""
    neighbours = _neighbours(len(rotations), deviation)
    # The mean of the quaternions is already close; one step on the sphere squares the remaining error.
    mean = np.zeros_like(rotations)
    for weight, rows in neighbours:
        part = weight[:, None] * has[rows]
        other = rotations[rows]
        mean += np.where((other * rotations).sum(axis=2) < 0, -part, part)[..., None] * other
    length = np.linalg.norm(mean, axis=2, keepdims=True)
    mean = np.where(length > 0, mean / np.where(length > 0, length, 1.0), rotations)
    back = inverse(mean)
    total, weights = np.zeros((*has.shape, 3)), np.zeros(has.shape)
    for weight, rows in neighbours:
        part = weight[:, None] * has[rows]
        total += part[..., None] * to_vector(multiply(back, rotations[rows]))
        weights += part
    return multiply(mean, from_vector(total / np.where(weights > 0, weights, 1.0)[..., None]))


def _neighbours(frames: int, deviation: float) -> list[tuple[Array, Rows]]:
    """(weights (n,), places (n,)) of the neighbour at each distance; weight 0 where the window has shrunk."""
    places = np.arange(frames)
    room = np.minimum(places, frames - 1 - places)
    reach = min(int(np.ceil(_REACH * deviation)), int(room.max(initial=0)))
    found = []
    for step in range(-reach, reach + 1):
        weight = np.where(abs(step) <= room, np.exp(-0.5 * (step / deviation) ** 2), 0.0)
        found.append((weight, np.clip(places + step, 0, frames - 1)))
    return found
