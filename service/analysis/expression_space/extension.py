"""Takes added to a space that is there, without building it again (expression.md 9.7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.analysis.expression_space.neighbours import nearest
from service.analysis.expression_space.states import distances, state_vectors
from service.motion.skeleton import Array

BLOCK = 500


@dataclass(frozen=True)
class Placed:
    """Frames laid into a space. near: (q, k) old frames nearest to each; apart: (q, k) mm. geodesics: (q, l) to what
    the map was made of (all old frames, or landmarks). uncovered: share of the frames farther than tau from any."""

    near: NDArray[np.int32]
    apart: Array
    geodesics: Array
    uncovered: float


def nearest_frames(old: Array, new: Array, count: int) -> tuple[NDArray[np.int32], Array]:
    """Old frames nearest to each new one and their distances, (q, count), over all pairs of markers.

    old: (n, M, 3), new: (q, M, 3) positions, NaN where missing.
    """
    states = state_vectors(new)
    near = np.empty((len(new), 0), dtype=np.int32)
    apart = np.empty((len(new), 0))
    for start in range(0, len(old), BLOCK):
        block = distances(states, state_vectors(np.asarray(old[start : start + BLOCK], dtype=float)))
        frames = np.broadcast_to(np.arange(start, start + block.shape[1], dtype=np.int32), block.shape)
        near, apart = np.concatenate([near, frames], axis=1), np.concatenate([apart, block], axis=1)
        order = np.argsort(apart, axis=1, kind="stable")[:, :count]
        near, apart = np.take_along_axis(near, order, axis=1), np.take_along_axis(apart, order, axis=1)
    return near, apart


def nearest_reduced(old: Array, new: Array, count: int) -> tuple[NDArray[np.int32], Array]:
    """The same from reduced states, (n, d) and (q, d)."""
    apart, near = nearest(old, new, count)
    return near.astype(np.int32), apart


def place_frames(
    near: NDArray[np.int32], apart: Array, chain: Array, geodesics: NDArray[np.float32], tau: float
) -> Placed:
    """Distances of new frames to what the map was made of: over old neighbours, and along the take's own chain.

    near, apart: (q, k). chain: (q - 1,) mm from each new frame to the next, infinite where a take ends. geodesics:
    (l, n) of what the map was made of.
    """
    found = np.empty((len(near), len(geodesics)))
    for start in range(0, len(near), BLOCK):
        part = slice(start, start + BLOCK)
        over = geodesics[:, near[part]].astype(float) + apart[part]
        found[part] = over.min(axis=2).T
    # A frame may be nearer by way of those before and after it in its take.
    for frame in range(1, len(found)):
        np.minimum(found[frame], found[frame - 1] + chain[frame - 1], out=found[frame])
    for frame in range(len(found) - 2, -1, -1):
        np.minimum(found[frame], found[frame + 1] + chain[frame], out=found[frame])
    return Placed(near, apart, found, float((apart[:, 0] > tau).mean()) if len(apart) else 0.0)
