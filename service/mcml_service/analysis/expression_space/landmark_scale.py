"""Spaces of up to 100,000 frames: reduced states and distances to landmarks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import FrameGraph
from mcml_service.analysis.expression_space.geodesics import from_sources
from mcml_service.analysis.expression_space.states import state_vectors

BLOCK = 2000
BASIS_FRAMES = 1500
VARIANCE = 0.999
MOST = 16


@dataclass(frozen=True)
class Basis:
    """Principal components of states. mean: (P,) mm. components: (d, P) orthonormal. variance: share they hold."""

    mean: Array
    components: Array
    variance: float

    def reduce(self, positions: Array) -> Array:
        """States of positions (n, M, 3), NaN where missing, as coordinates (n, d). Never n x P at once.

        Pairs of invisible markers are left out of a least-squares fit.
        """
        reduced = np.empty((len(positions), len(self.components)))
        for start in range(0, len(positions), BLOCK):
            states = state_vectors(np.asarray(positions[start : start + BLOCK], dtype=float)) - self.mean
            gone = np.isnan(states)
            part = np.where(gone, 0.0, states) @ self.components.T
            for row in np.flatnonzero(gone.any(axis=1)).tolist():
                hidden = self.components[:, gone[row]]
                part[row] = np.linalg.lstsq(np.eye(len(part[row])) - hidden @ hidden.T, part[row], rcond=1e-9)[0]
            reduced[start : start + BLOCK] = part
        return reduced


def basis_of(positions: Array, seed: int) -> Basis:
    """From 1,500 random frames, as many components as hold 99.9 % of the variance, at most 16.

    positions: (n, M, 3). Frames with missing markers are used only if there are not enough others.
    """
    whole = np.flatnonzero(~np.isnan(positions[..., 0]).any(axis=1))
    random = np.random.default_rng(seed)
    pool = whole if len(whole) >= min(200, len(positions)) else np.arange(len(positions))
    chosen = np.sort(random.choice(pool, min(BASIS_FRAMES, len(pool)), replace=False))
    states = state_vectors(np.asarray(positions[chosen], dtype=float))
    gone = np.isnan(states)
    mean = np.where(gone, 0.0, states).sum(axis=0) / np.maximum((~gone).sum(axis=0), 1)
    states = np.where(gone, 0.0, states - mean)
    values, vectors = np.linalg.eigh(states @ states.T)
    values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    share = np.cumsum(values) / max(float(values.sum()), 1e-300)
    count = min(int(np.searchsorted(share, VARIANCE)) + 1, MOST, int((values > 1e-12 * values[0]).sum()) or 1)
    components = (vectors[:, :count].T @ states) / np.sqrt(np.maximum(values[:count], 1e-300))[:, None]
    sign = np.where(np.take_along_axis(components, np.abs(components).argmax(axis=1)[:, None], 1) < 0, -1.0, 1.0)
    return Basis(mean, components * sign, float(share[count - 1]))


def landmark_geodesics(graph: FrameGraph, landmarks: NDArray[np.int32]) -> NDArray[np.float32]:
    """Shortest distances (l, n) from landmarks to all frames, in single precision, some landmarks at a time."""
    lengths = np.empty((len(landmarks), graph.frames), dtype=np.float32)
    for start in range(0, len(landmarks), 25):
        lengths[start : start + 25] = from_sources(graph.matrix, landmarks[start : start + 25])
    return lengths
