"""Frames of takes: head motion, gaps, smoothing, units; and the generator's truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.motion.rotations import rotate
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.rigid_motion import align
from mcml_service.analysis.expression_space.states import state_vectors
from mcml_service.analysis.expression_space.takes import fill_gaps, frames_of, smooth
from mcml_service.demo.face_takes import EXPRESSIONS, UNITS, face_markers, face_takes
from tests.analysis.expression.face_motions import motion_from, motion_of, motions, takes


def test_generated_takes_have_the_shape_of_the_papers_set() -> None:
    made = face_takes(1)
    assert len(made) == 10
    assert [take.expression for take in made] == list(EXPRESSIONS)
    assert 2200 <= sum(len(take.still) for take in made) <= 2600
    assert all(take.still.shape[1] == 100 for take in made)
    assert len(set(face_markers()[0])) == 100
    for take in made:
        start, end = take.amounts[0], take.amounts[-1]
        assert np.abs(start).max() < 0.1
        assert np.abs(end).max() < 0.1
        assert take.amounts.max() > 0.6


def test_the_truth_is_in_the_clip() -> None:
    take = face_takes(3, fps=12, head=True)[4]
    block = next(iter(take.clip.blocks()))
    values = block.values.reshape(take.still.shape)
    there = rotate(take.rotations[:, None], take.still) + take.positions[:, None]
    assert np.abs(values - there).max() < 1e-6
    assert take.amounts.shape == (len(values), len(UNITS))
    assert ("expression", "fear", "") in take.clip.head.properties
    assert take.clip.head.fields["calibration_unit"] == "mm"


def test_noise_and_gaps_leave_the_movement_as_it_is() -> None:
    plain, noisy = (face_takes(2, fps=12, noise=noise, gaps=noise / 5)[0] for noise in (0.0, 0.1))
    assert np.array_equal(plain.still, noisy.still)
    block = next(iter(noisy.clip.blocks()))
    assert np.array_equal(np.isnan(block.values[:, ::3]), ~noisy.present)
    assert 0.005 < 1 - noisy.present.mean() < 0.15
    difference = block.values.reshape(noisy.still.shape) - next(iter(plain.clip.blocks())).values.reshape(
        noisy.still.shape
    )
    assert np.nanstd(difference) == pytest.approx(0.1, rel=0.05)


def test_the_same_movement_at_any_rate() -> None:
    slow, fast = face_takes(1, fps=10)[2], face_takes(1, fps=40)[2]
    assert np.allclose(slow.still, fast.still[::4][: len(slow.still)], atol=1e-9)


def test_head_motion_changes_nothing() -> None:
    still = frames_of(motions(), options_of())
    moving = frames_of([motion_of(take) for take in takes(head=True)], options_of())
    assert np.allclose(state_vectors(still.positions), state_vectors(moving.positions), atol=1e-4)
    assert moving.neutral == still.neutral


@given(st.integers(0, 2**31), st.booleans())
def test_a_frame_is_laid_on_the_reference(seed: int, gaps: bool) -> None:
    rng = np.random.default_rng(seed)
    reference = rng.normal(size=(8, 3)) * 40
    turns = Rotation.random(5, rng=rng)
    frames = np.stack([turn.apply(reference) for turn in turns]) + rng.normal(size=(5, 1, 3)) * 100
    if gaps:
        frames[rng.random((5, 8)) < 0.2] = np.nan
    laid = align(frames, reference)
    enough = (~np.isnan(frames[..., 0])).sum(axis=1) >= 4
    wanted = np.broadcast_to(reference, frames.shape)
    here = ~np.isnan(frames) & enough[:, None, None]
    assert np.allclose(laid[here], wanted[here], atol=1e-8)


def test_a_mirrored_face_is_not_turned_inside_out() -> None:
    reference = face_markers()[1]
    laid = align((reference * (-1, 1, 1))[None] + 5.0, reference)[0]
    assert np.allclose(
        np.linalg.norm(laid[0] - laid[1:], axis=1), np.linalg.norm(reference[0] - reference[1:], axis=1), atol=1e-9
    )
    some = [3, 40, 70]
    assert np.linalg.det(laid[some] - laid[95]) * np.linalg.det(reference[some] - reference[95]) < 0


def test_short_gaps_are_filled_by_the_cubic_and_long_ones_stay() -> None:
    time = np.arange(60.0)
    track = np.stack([1 + time - 0.02 * time**2 + 0.0003 * time**3] * 3, axis=1)[:, None].repeat(2, axis=1)
    holed = track.copy()
    holed[10:22, 0] = np.nan
    holed[30:43, 0] = np.nan
    holed[57:, 0] = np.nan
    filled = fill_gaps(holed, 12)
    assert np.allclose(filled[:30, 0], track[:30, 0], atol=1e-9)
    assert np.isnan(filled[30:43, 0]).all()
    assert np.isnan(filled[57:, 0]).all()
    assert np.array_equal(filled[:, 1], track[:, 1])
    assert np.isnan(holed[12, 0]).all()


def test_a_gap_beside_the_end_is_filled_linearly() -> None:
    track = np.arange(6.0)[:, None, None] ** 2 * np.ones((1, 1, 3))
    track[1:3] = np.nan
    assert np.allclose(fill_gaps(track, 5)[:, 0, 0], [0, 3, 6, 9, 16, 25])


def test_smoothing_is_the_gaussian_mean_of_what_is_there() -> None:
    rng = np.random.default_rng(0)
    track = rng.normal(size=(40, 2, 3))
    track[12:17, 0] = np.nan
    found = smooth(track, 2.0)
    for marker in range(2):
        for frame in (0, 5, 11, 17, 39):
            apart = np.arange(40) - frame
            weight = np.exp(-0.5 * (apart / 2.0) ** 2) * (np.abs(apart) <= 8) * ~np.isnan(track[:, marker, 0])
            if np.isnan(track[frame, marker, 0]):
                continue
            mean = np.nansum(weight[:, None] * track[:, marker], axis=0) / weight.sum()
            assert np.allclose(found[frame, marker], mean, atol=1e-12)
    assert np.array_equal(np.isnan(found), np.isnan(track))
    assert smooth(track, 0.0) is track


def test_markers_missing_too_often_and_frames_with_too_few_are_left_out() -> None:
    rng = np.random.default_rng(1)
    face = rng.normal(size=(10, 3)) * 40
    positions = face + 0.1 * np.arange(40)[:, None, None] * rng.normal(size=(10, 3))
    positions[:25, 3] = np.nan
    positions[30:34, 4:8] = np.nan
    frames = frames_of([motion_from(positions)], options_of(gap_s=0.01))
    assert [name for name, _ in frames.dropped] == ["m3"]
    assert [(take, frame) for take, frame, _ in frames.excluded] == [(0, 30), (0, 31), (0, 32), (0, 33)]
    assert frames.positions.shape == (36, 9, 3)
    assert 30 not in frames.frame.tolist()


def test_frames_at_the_origin_count_as_missing() -> None:
    positions = takes()[0].still.copy()
    positions[20:30] = 0.0
    frames = frames_of([motion_from(positions)], options_of(gap_s=0.01))
    assert {frame for _, frame, _ in frames.excluded} == set(range(20, 30))


def test_units_are_millimetres_and_an_unknown_one_is_guessed() -> None:
    known = frames_of(motions(), options_of())
    for factor, metres in ((0.1, 0.01), (0.001, 1.0), (0.1, None), (0.001, None), (1.0, None)):
        changed = [replace(m, translations=m.translations * factor, metres=metres) for m in motions()]
        found = frames_of(changed, options_of())
        assert np.allclose(found.positions, known.positions, atol=1e-6)
        assert [code for code, _ in found.warnings] == (["unit-guessed"] if metres is None else [])


def test_the_order_of_takes_does_not_matter() -> None:
    forth, back = (frames_of(motions()[::step], options_of()) for step in (1, -1))
    assert np.array_equal(forth.positions, back.positions)
    assert forth.takes == back.takes


def test_faces_of_other_size_are_brought_to_the_firsts() -> None:
    plain = motions()
    mixed = [replace(m, translations=m.translations * (1.2 if place % 2 else 1.0)) for place, m in enumerate(plain)]
    found = frames_of(mixed, options_of(normalise_scale=True))
    sizes = [state_vectors(found.positions[found.take == take][:1]).mean() for take in range(len(plain))]
    assert np.ptp(sizes) < 1e-6 * sizes[0]
    assert np.ptp([state_vectors(frames_of(mixed, options_of()).positions[[0, -1]]).mean(axis=1)]) > 1


def test_common_markers_are_used() -> None:
    first, second = motions()[:2]
    fewer = replace(
        second,
        skeleton=replace(second.skeleton, joints=second.skeleton.joints[3:]),
        translations=second.translations[:, 3:],
        rotations=second.rotations[:, 3:],
    )
    frames = frames_of([first, fewer], options_of())
    assert frames.markers == first.skeleton.names[3:]
    assert [why for _, why in frames.dropped] == ["not in every take"] * 3
    chosen = first.skeleton.names[4:12]
    frames = frames_of([first, fewer], options_of(markers=(*chosen, "elsewhere")))
    assert frames.markers == chosen
    assert ("elsewhere", "in no take") in frames.dropped
