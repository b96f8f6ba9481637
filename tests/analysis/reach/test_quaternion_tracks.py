"""Logarithms, signs, references and gaps, against SciPy and slow twins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.motion.rotations import from_euler, slerp
from mcml_service.analysis.interface import AnalysisError
from mcml_service.analysis.reach_blending.quaternion_tracks import (
    align_tracks,
    angle_between,
    continuous,
    exp,
    fill_gaps,
    jumps,
    log,
    mean_rotations,
    second_moments,
    unit,
)

seeds = st.integers(0, 10_000)


def tracks(seed: int, frames: int = 40, joints: int = 3) -> np.ndarray:
    """(F, J, 4) smooth tracks, each quaternion with a sign of its own."""
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.normal(0, 0.2, (frames, joints, 3)), axis=0)
    return from_euler(angles, "XYZ") * rng.choice([-1.0, 1.0], (frames, joints, 1))


@given(seeds)
def test_logarithms_are_scipys(seed: int) -> None:
    rotations = Rotation.random(50, random_state=seed)
    assert np.abs(log(rotations.as_quat()) - rotations.as_rotvec()).max() < 1e-12


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 1.0, np.pi - 1e-9])
def test_exponentials_and_logarithms_are_inverse_at_every_size(size: float) -> None:
    vector = size * np.array([0.6, -0.8, 0.0])
    assert np.abs(log(exp(vector)) - vector).max() <= 1e-13 * max(size, 1e-290)
    assert abs(np.linalg.norm(exp(vector)) - 1) < 1e-15


@given(seeds)
def test_opposite_quaternions_have_one_logarithm(seed: int) -> None:
    rotations = Rotation.random(20, random_state=seed).as_quat()
    assert np.array_equal(log(rotations), log(-rotations))
    assert (np.linalg.norm(log(rotations), axis=1) <= np.pi + 1e-12).all()


@given(seeds)
def test_continuous_tracks_never_leave_the_near_side(seed: int) -> None:
    raw = tracks(seed)
    fixed = continuous(raw)
    slow = raw.copy()
    for f in range(1, len(slow)):
        for j in range(slow.shape[1]):
            if slow[f, j] @ slow[f - 1, j] < 0:
                slow[f, j] = -slow[f, j]
    assert np.array_equal(fixed, slow)
    assert (np.sum(fixed[1:] * fixed[:-1], axis=2) >= 0).all()


@given(seeds)
def test_references_are_the_rotations_of_least_squared_chord(seed: int) -> None:
    raw = tracks(seed)
    reference = mean_rotations(second_moments(raw))
    assert np.allclose(np.abs(np.sum(reference * mean_rotations(second_moments(-raw)), axis=1)), 1)
    assert (reference[:, 3] >= 0).all()
    for joint in range(raw.shape[1]):
        mean = Rotation.from_quat(raw[:, joint]).mean().as_quat()
        assert abs(mean @ reference[joint]) > 1 - 1e-9


def test_clips_are_put_on_the_reference_s_side() -> None:
    raw = continuous(tracks(3))
    reference = mean_rotations(second_moments(raw))
    for signs in ((1, 1, 1), (-1, 1, -1)):
        turned = align_tracks(raw * np.array(signs)[:, None], reference)
        assert (np.einsum("fjc,jc->j", turned, reference) >= 0).all()
        assert np.array_equal(turned, align_tracks(raw, reference))


def test_jumps_name_frame_and_joint() -> None:
    still = np.tile([0.0, 0.0, 0.0, 1.0], (5, 2, 1))
    still[3:, 1] = exp(np.array([2.2, 0.0, 0.0]))
    assert jumps(still) == [(3, 1)]
    still[3:, 1] = exp(np.array([2.0, 0.0, 0.0]))
    assert jumps(still) == []


def test_lengths_are_made_one_and_zero_is_refused() -> None:
    rotations = tracks(1) * 1.7
    assert np.abs(np.linalg.norm(unit(rotations), axis=2) - 1).max() < 1e-15
    rotations[7, 1] = 1e-8
    with pytest.raises(AnalysisError) as error:
        unit(rotations)
    assert error.value.code == "zero-quaternion"


def test_short_gaps_are_filled_on_the_arc_and_on_the_line() -> None:
    rotations = continuous(tracks(2))
    values = rotations[:, :, :3].copy()
    missing = np.zeros(rotations.shape[:2], dtype=bool)
    missing[10:15, 1] = True
    broken = rotations.copy()
    broken[missing] = np.nan
    filled = fill_gaps(broken, missing)
    assert np.allclose(filled[12, 1], slerp(rotations[9, 1], rotations[15, 1], np.array(0.5)))
    assert np.array_equal(filled[~missing], rotations[~missing])
    line = fill_gaps(np.where(missing[..., None], np.nan, values), missing)
    assert np.allclose(line[10, 1], values[9, 1] + (values[15, 1] - values[9, 1]) / 6)


@pytest.mark.parametrize("gap", [slice(10, 16), slice(0, 2), slice(38, 40)])
def test_long_gaps_and_gaps_at_the_ends_are_refused(gap: slice) -> None:
    missing = np.zeros((40, 3), dtype=bool)
    missing[gap, 0] = True
    with pytest.raises(AnalysisError) as error:
        fill_gaps(tracks(2), missing)
    assert error.value.code == "missing-samples"


def test_the_printed_euler_formula_is_another_rotation() -> None:
    """Angles about moving X, Y, Z: the product agrees with the closed form; the printed signs mean fixed axes."""
    angles = np.random.default_rng(1).uniform(-np.pi, np.pi, (4000, 3))
    (c1, c2, c3), (s1, s2, s3) = np.cos(angles.T / 2), np.sin(angles.T / 2)
    closed = [
        s1 * c2 * c3 + c1 * s2 * s3,
        c1 * s2 * c3 - s1 * c2 * s3,
        c1 * c2 * s3 + s1 * s2 * c3,
        c1 * c2 * c3 - s1 * s2 * s3,
    ]
    printed = [
        s1 * c2 * c3 - c1 * s2 * s3,
        c1 * s2 * c3 + s1 * c2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
        c1 * c2 * c3 + s1 * s2 * s3,
    ]
    ours = from_euler(angles, "XYZ")
    assert angle_between(ours, np.stack(closed, axis=1)).max() < 1e-5
    fixed = Rotation.from_euler("xyz", angles).as_quat()
    assert angle_between(fixed, np.stack(printed, axis=1)).max() < 1e-5
    assert 100 < angle_between(ours, np.stack(printed, axis=1)).mean() < 120
