"""Distances of faces, against the obvious way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.landmark_scale import basis_of
from mcml_service.analysis.expression_space.states import distances, state_vectors
from tests.analysis.expression.face_motions import takes


def matrices(positions: Array) -> Array:
    """The paper's matrices of all distances, (n, M, M)."""
    apart: Array = np.linalg.norm(positions[:, :, None] - positions[:, None], axis=-1)
    return apart


def naive(a: Array, b: Array) -> float:
    """Over the full matrices, pairs seen in both, scaled to all."""
    gap = matrices(a[None])[0] - matrices(b[None])[0]
    off = ~np.eye(len(a), dtype=bool)
    seen = ~np.isnan(gap) & off
    if seen.sum() < 0.5 * off.sum():
        return np.inf
    return float(np.sqrt((gap[seen] ** 2).sum() * off.sum() / seen.sum()))


def faces(seed: int, frames: int = 9, markers: int = 7, gaps: float = 0.0) -> Array:
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(markers, 3)) * 50 + rng.normal(size=(frames, markers, 3)) * 3
    positions[rng.random((frames, markers)) < gaps] = np.nan
    return positions


@given(st.integers(0, 2**31), st.sampled_from([0.0, 0.1, 0.35]))
def test_distances_are_those_of_the_full_matrices(seed: int, gaps: float) -> None:
    positions = faces(seed, gaps=gaps)
    found = distances(state_vectors(positions))
    wanted = np.array([[naive(a, b) for b in positions] for a in positions])
    np.fill_diagonal(wanted, 0.0)
    assert np.allclose(found, wanted, rtol=1e-9, atol=1e-9)
    others = faces(seed + 1, gaps=gaps)
    found = distances(state_vectors(positions), state_vectors(others))
    assert np.allclose(found, [[naive(a, b) for b in others] for a in positions], rtol=1e-9, atol=1e-9)


def test_230_mm_is_162_6_on_the_plain_upper_triangle() -> None:
    a, b = faces(5, frames=2)
    upper = np.triu_indices(len(a), 1)
    plain = np.linalg.norm(matrices(a[None])[0][upper] - matrices(b[None])[0][upper])
    assert naive(a, b) * 162.6 / 230 == pytest.approx(plain, rel=1e-3)


@given(st.integers(0, 2**31), st.booleans())
def test_rigid_motion_and_reflection_change_nothing(seed: int, mirrored: bool) -> None:
    rng = np.random.default_rng(seed)
    positions = faces(seed)
    turns = Rotation.random(len(positions), rng=rng)
    moved = np.stack([turn.apply(frame) for turn, frame in zip(turns, positions, strict=True)])
    moved += rng.normal(size=(len(positions), 1, 3)) * 500
    if mirrored:
        moved *= (1, -1, 1)
    assert np.allclose(distances(state_vectors(moved)), distances(state_vectors(positions)), atol=1e-8)


def test_equal_and_nearly_equal_frames_keep_their_distance() -> None:
    positions = np.concatenate([takes()[0].still[:5]] * 2)
    positions[5] += np.array([1e-5, 0, 0]) * (np.arange(positions.shape[1]) == 0)[:, None]
    found = distances(state_vectors(positions))
    assert found[1, 6] == 0.0
    assert found[0, 5] == pytest.approx(naive(positions[0], positions[5]), rel=1e-3)
    assert found[0, 5] < 1e-3


def test_reduced_states_keep_distances() -> None:
    positions = np.concatenate([take.still for take in takes()])
    basis = basis_of(positions, 0)
    reduced = basis.reduce(positions)
    assert reduced.shape[1] <= 16
    assert basis.variance >= 0.99
    whole = distances(state_vectors(positions))
    kept: NDArray[np.float64] = np.linalg.norm(reduced[:, None] - reduced[None], axis=2)
    assert (kept <= whole + 1e-6).all()
    assert np.corrcoef(kept.ravel(), whole.ravel())[0, 1] > 0.998
    assert np.allclose(basis.components @ basis.components.T, np.eye(len(basis.components)), atol=1e-9)


def test_a_missing_marker_hardly_moves_a_reduced_state() -> None:
    positions = np.concatenate([take.still for take in takes()])
    basis = basis_of(positions, 0)
    holed = positions.copy()
    rng = np.random.default_rng(0)
    for frame in range(len(holed)):
        holed[frame, rng.integers(0, holed.shape[1], 2)] = np.nan
    moved = np.linalg.norm(basis.reduce(holed) - basis.reduce(positions), axis=1)
    assert np.isfinite(moved).all()
    assert moved.max() < 0.06 * np.ptp(basis.reduce(positions), axis=0).max()
