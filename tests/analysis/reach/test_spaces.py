"""Components, motion spaces and attribute spaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.rotations import from_euler
from mcml_service.analysis.reach_blending.attribute_space import attribute_space, duplicates, gaps, same_place
from mcml_service.analysis.reach_blending.motion_spaces import EigenposeSpace, GlobalPoseSpace, TangentSpace, Track
from mcml_service.analysis.reach_blending.principal_components import principal_components
from mcml_service.analysis.reach_blending.quaternion_tracks import (
    align_tracks,
    angle_between,
    continuous,
    mean_rotations,
    second_moments,
)
from mcml_service.analysis.reach_blending.time_normalisation import PAPER_KNOTS, instants, read_rotations, read_values

seeds = st.integers(0, 10_000)


def make_tracks(seed: int = 0, clips: int = 6, joints: int = 4) -> tuple[list[Track], np.ndarray]:
    """Smooth clips of 60 to 80 frames around one posture, and their reference."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(clips):
        frames = int(rng.integers(60, 81))
        wave = np.sin(np.linspace(0, 3, frames))[:, None, None]
        angles = rng.normal(0, 0.3, (1, joints, 3)) + wave * rng.normal(0, 0.5, (1, joints, 3))
        root = rng.normal(0, 2, 3) + wave[:, 0] * rng.normal(0, 5, 3)
        at = instants(PAPER_KNOTS, (8.0, 30.0, frames - 1.0))
        found.append(Track(root, continuous(from_euler(angles, "XYZ")), at))
    reference = mean_rotations(sum(second_moments(track.rotations) for track in found))
    return [Track(t.root, align_tracks(t.rotations, reference), t.at) for t in found], reference


@given(seeds, st.integers(1, 6))
def test_components_are_those_of_the_covariance(seed: int, count: int) -> None:
    data = np.random.default_rng(seed).normal(size=(12, 7)) * np.arange(1, 8)
    found = principal_components(data, count)
    values, vectors = np.linalg.eigh(np.cov(data.T, bias=True))
    assert np.allclose(found.variances, values[::-1])
    assert np.allclose(np.abs(np.sum(found.basis * vectors[:, ::-1].T[:count], axis=1)), 1)
    assert np.allclose(found.basis @ found.basis.T, np.eye(count))
    assert np.allclose(found.coefficients, (data - data.mean(axis=0)) @ found.basis.T)
    largest = np.take_along_axis(found.basis, np.argmax(np.abs(found.basis), axis=1)[:, None], axis=1)
    assert (largest > 0).all()


def test_no_more_components_than_exist() -> None:
    data = np.random.default_rng(0).normal(size=(5, 40))
    found = principal_components(data, 10)
    assert found.basis.shape == (4, 40)
    assert np.allclose(found.mean + found.coefficients @ found.basis, data)
    assert found.cumulative()[-1] == pytest.approx(1)


def test_variance_chooses_the_least_number_that_holds_it() -> None:
    data = np.random.default_rng(0).normal(size=(30, 8)) * np.array([9, 5, 3, 2, 1, 1, 1, 1])
    for share in (0.3, 0.8, 0.95, 1.0):
        found = principal_components(data, 3, share)
        kept = len(found.basis)
        assert found.cumulative()[kept - 1] >= share - 1e-12
        assert kept == 1 or found.cumulative()[kept - 2] < share


def test_tangents_give_the_motion_back() -> None:
    tracks, reference = make_tracks()
    root = np.stack([read_values(track.root, track.at) for track in tracks])
    rotations = np.stack([read_rotations(track.rotations, track.at) for track in tracks])
    space = TangentSpace(reference, 7.0)
    vectors = space.vectors(root, rotations)
    assert vectors.shape == (6, (3 + 3 * 4) * 50)
    back_root, back = space.motions(vectors)
    assert np.allclose(back_root, root)
    assert angle_between(back, rotations).max() < 1e-5
    assert np.array_equal(space.vectors(root, -rotations), vectors)
    blend = space.motions(0.5 * (vectors[:1] + vectors[1:2]))[1]
    assert np.abs(np.linalg.norm(blend, axis=-1) - 1).max() < 1e-12
    assert space.farthest(vectors) == pytest.approx(np.radians(angle_between(rotations, reference)).max(), rel=1e-6)


@pytest.mark.parametrize("sign_align", ["none", "max", "reference"])
def test_enough_eigenposes_give_the_motion_back(sign_align: str) -> None:
    tracks, _ = make_tracks()
    space = EigenposeSpace(4, 19)
    vectors, shares = space.vectors(tracks, sign_align)  # type: ignore[arg-type]
    assert vectors.shape == (6, 19 + 19 * 19 + 19 * 50)
    assert np.allclose(shares[:, -1], 1)
    root, rotations = space.motions(vectors)
    for place, track in enumerate(tracks):
        assert np.allclose(root[place], read_values(track.root, track.at))
        assert angle_between(rotations[place], read_rotations(track.rotations, track.at)).max() < 0.05


def test_a_short_clip_has_fewer_eigenposes_than_asked_for() -> None:
    tracks, _ = make_tracks(clips=1)
    short = Track(tracks[0].root[:8], tracks[0].rotations[:8], instants(PAPER_KNOTS, (2.0, 5.0, 7.0)))
    space = EigenposeSpace(4, 10)
    vectors, shares = space.vectors([short], "max")
    assert shares.shape == (1, 10)
    assert np.allclose(space.motions(vectors)[0][0], read_values(short.root, short.at), atol=1e-8)


def test_means_of_eigenpose_vectors_are_not_means_of_motions() -> None:
    """The published decoder multiplies; the tangent space's does not, nor does it depend on signs of eigenposes."""
    tracks, reference = make_tracks(clips=2)
    space = EigenposeSpace(4, 10)
    vectors, _ = space.vectors(tracks, "max")
    middle_of_roots = space.motions(vectors)[0].mean(axis=0)
    root_of_middle = space.motions(vectors.mean(axis=0, keepdims=True))[0][0]
    assert np.abs(middle_of_roots - root_of_middle).max() > 0.1
    tangent = TangentSpace(reference, 1.0)
    root = np.stack([read_values(track.root, track.at) for track in tracks])
    rotations = np.stack([read_rotations(track.rotations, track.at) for track in tracks])
    rows = tangent.vectors(root, rotations)
    assert np.allclose(tangent.motions(rows.mean(axis=0, keepdims=True))[0][0], root.mean(axis=0))


def test_signs_of_eigenposes_follow_the_first_clip() -> None:
    tracks, _ = make_tracks()
    space = EigenposeSpace(4, 3)
    vectors, _ = space.vectors(tracks, "reference")
    bases = vectors[:, 19 : 19 + 3 * 19].reshape(6, 3, 19)
    assert (np.einsum("nkp,kp->nk", bases, bases[0]) >= 0).all()


def test_global_eigenposes_give_the_motion_back() -> None:
    tracks, _ = make_tracks()
    space, shares = GlobalPoseSpace.of(tracks, 19)
    assert shares[-1] == pytest.approx(1)
    root, rotations = space.motions(space.vectors(tracks))
    for place, track in enumerate(tracks):
        assert np.allclose(root[place], read_values(track.root, track.at))
        assert angle_between(rotations[place], read_rotations(track.rotations, track.at)).max() < 0.05
    frames = np.concatenate([np.concatenate([t.root, t.rotations.reshape(-1, 16)], axis=1) for t in tracks])
    whole = principal_components(frames, 3)
    assert np.abs(np.abs(np.sum(whole.basis * space.basis[:3], axis=1)) - 1).max() < 1e-9


@given(seeds)
def test_rotated_attributes_keep_their_distances(seed: int) -> None:
    attributes = np.random.default_rng(seed).normal(size=(20, 3)) * [20, 8, 40]
    x = attribute_space(attributes, "rotate").coordinates(attributes)
    between = np.linalg.norm(attributes[:, None] - attributes[None], axis=2)
    assert np.allclose(np.linalg.norm(x[:, None] - x[None], axis=2), between)


@given(seeds, st.sampled_from(["zscore", "whiten"]))
def test_scaled_attributes_know_no_units(seed: int, scaling: str) -> None:
    attributes = np.random.default_rng(seed).normal(size=(20, 3)) * [20, 8, 40] + [40, 170, 265]
    space = attribute_space(attributes, scaling)  # type: ignore[arg-type]
    x = space.coordinates(attributes)
    assert np.allclose(x.std(axis=0), 1)
    other = attributes * [1, 0.01, 0.1]
    assert np.allclose(np.abs(attribute_space(other, scaling).coordinates(other)), np.abs(x), atol=1e-6)  # type: ignore[arg-type]
    if scaling == "whiten":
        assert np.allclose(np.cov(x.T, bias=True), np.eye(3), atol=1e-9)
    assert np.allclose(space.attributes(x), attributes)
    assert np.allclose(space.off_plane(attributes), 0)


def test_dependent_attributes_lose_a_direction_and_constant_ones_stay_out() -> None:
    rng = np.random.default_rng(0)
    age = rng.normal(size=20)
    attributes = np.stack([age, 2 * age + 1, np.full(20, 170.0), rng.normal(size=20)], axis=1)
    space = attribute_space(attributes, "whiten")
    assert space.matrix.shape == (4, 2)
    assert space.dropped == 1
    assert space.scale[2] == 0
    assert np.allclose(space.off_plane(attributes), 0)
    assert space.off_plane(attributes[:1] + np.array([1.0, 0, 0, 0]))[0] > 0.1
    assert attribute_space(attributes, "zscore").matrix.shape == (4, 3)


def test_gaps_are_wide_intervals() -> None:
    assert gaps(np.array([20.0, 25, 29, 60, 79])) == [(29.0, 60.0), (60.0, 79.0)]
    assert gaps(np.linspace(0, 1, 20)) == []
    assert gaps(np.array([5.0, 5.0])) == []


@given(seeds)
def test_equal_attributes_are_found_whatever_their_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.integers(0, 3, (15, 2)).astype(float) + rng.uniform(-1, 1, (15, 2)) * 1e-12
    slow: dict[tuple[float, ...], list[int]] = {}
    for row, point in enumerate(np.round(x)):
        slow.setdefault(tuple(point), []).append(row)
    assert duplicates(x) == sorted(rows for rows in slow.values() if len(rows) > 1)
    assert same_place(duplicates(x), 15) == sorted(slow.values())
