"""Every named error and warning of building, and the takes that bring it about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcml.errors import SizeError
from mcml.motion.skeleton import Skeleton
from mcml_service.analysis.expression_space import space as spaces
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.space import build
from mcml_service.analysis.interface import AnalysisError, Motion
from tests.analysis.expression.face_motions import body_motion, motion_from, motions, takes


def code_of(given: list[Motion], method: str = "robust", **options: object) -> AnalysisError:
    with pytest.raises(AnalysisError) as error:
        build(given, options_of(method, **options))  # type: ignore[arg-type]
    assert error.value.what
    assert error.value.remedy
    return error.value


def far_faces() -> list[Motion]:
    """Two takes of faces whose expressions have nothing in common."""
    first, second = takes()[0].still, takes()[1].still.copy()
    second = second * (1.0, 1.4, 1.0)
    return [motion_from(first, "a"), motion_from(second, "b")]


def test_too_few_frames() -> None:
    assert code_of([motion_from(takes()[0].still[:11])]).code == "too-few-frames"
    build([motion_from(takes()[0].still[10:40])], options_of())


def test_marker_sets_without_common_names() -> None:
    still = takes()[0].still
    other = motion_from(still, "b", labels=[f"n{place}" for place in range(still.shape[1])])
    assert code_of([motion_from(still, "a"), other]).code == "marker-sets-disjoint"
    assert code_of([motion_from(still)], markers=("m1", "m2", "m3")).code == "marker-sets-disjoint"


def test_markers_on_one_line() -> None:
    line = np.arange(5.0)[:, None] * (1.0, 2.0, 3.0) + np.sin(np.arange(30.0))[:, None, None]
    assert code_of([motion_from(line)]).code == "collinear-markers"


def test_an_infinite_coordinate() -> None:
    positions = takes()[0].still.copy()
    positions[3, 2, 1] = np.inf
    assert code_of([motion_from(positions)]).code == "not-finite"


def test_a_skeleton_is_no_marker_set() -> None:
    assert code_of([body_motion()]).code == "no-markers"


def test_one_take_among_others_is_named() -> None:
    still = takes()[0].still
    good = [motion_from(still, name) for name in "ab"]
    for stranger, what in (
        (body_motion(), "is a skeleton"),
        (replace(body_motion(), skeleton=Skeleton(()), translations=np.zeros((20, 0, 3))), "has no markers"),
        (
            motion_from(still, "c", labels=[f"n{place}" for place in range(still.shape[1])]),
            "has none of the 25 markers",
        ),
    ):
        error = code_of([*good, stranger])
        assert error.code == ("marker-sets-disjoint" if stranger.name == "c" else "no-markers")
        assert error.what.startswith(f"{stranger.name} ({stranger.document}) {what}")
        assert str(error.remedy).startswith("Leave it out")
        assert error.details["document"] == stranger.document


def test_a_face_that_does_not_move() -> None:
    still = np.repeat(takes()[0].still[:1], 30, axis=0)
    assert code_of([motion_from(still)]).code == "no-variation"
    assert code_of([motion_from(still)], scale="landmark").code == "no-variation"


def test_faces_far_apart() -> None:
    error = code_of(far_faces(), tau_mm=60.0, on_disconnected="error", tau_count=3)
    assert error.code == "disconnected"
    assert len(error.details["components"]) == 2
    assert sum(error.details["components"]) == sum(len(motion) for motion in far_faces())
    assert error.details["connecting_tau_mm"] > 60
    bridged = build(far_faces(), options_of(tau_mm=60.0, tau_count=3))
    assert [code for code, _ in bridged.warnings] == ["bridged"]
    assert bridged.graph.bridge.sum() == 1
    assert bridged.graph.length[bridged.graph.bridge][0] == pytest.approx(bridged.connecting)
    assert [links.components for links in bridged.links] == [1] * len(bridged.links)
    assert any(links.bridge.any() for links in bridged.links)
    largest = build(far_faces(), options_of(tau_mm=60.0, tau_count=3, on_disconnected="largest"))
    assert [code for code, _ in largest.warnings] == ["frames-left-out"]
    assert "b." in largest.warnings[0][1] or "a." in largest.warnings[0][1]
    assert len(set(largest.frames.take.tolist())) == 1
    assert np.isfinite(np.asarray(largest.geodesics)).all()


def test_more_frames_than_floyd_or_anything_can_take(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spaces, "FLOYD_FRAMES", 100)
    assert code_of(motions()[:4], "paper").code == "too-many-frames-for-floyd"
    build(motions()[:4], options_of(tau_count=2))
    monkeypatch.setattr(spaces, "MOST_FRAMES", 100)
    with pytest.raises(SizeError) as error:
        build(motions()[:4], options_of())
    assert error.value.details["code"] == "too-many-frames"


def test_long_gaps_are_bridged_over_the_markers_that_are_there() -> None:
    still = np.concatenate([take.still for take in takes()[:2]])
    half = still.shape[1] // 5
    first, second = still[:40].copy(), still[40:].copy()
    first[:, :half] = np.nan
    found = build([motion_from(first, "a"), motion_from(second, "b")], options_of(gap_s=0.001, tau_count=3))
    assert np.isfinite(np.asarray(found.geodesics)).all()
    assert np.isnan(found.frames.positions).any()
    assert len(found.frames.markers) == still.shape[1]


def test_a_map_that_cannot_keep_the_distances_says_so() -> None:
    rng = np.random.default_rng(0)
    positions = rng.normal(size=(40, 6, 3)) * 50
    found = build([motion_from(positions)], options_of(tau_count=0, smooth_s=0.0, tau_mm=1e4, dimensions=10))
    assert "poor-embedding" not in [code for code, _ in found.warnings]
    circle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    base = rng.normal(size=(6, 3)) * 40
    ring = (
        base
        + np.cos(circle)[:, None, None] * rng.normal(size=(6, 3))
        + np.sin(circle)[:, None, None] * rng.normal(size=(6, 3))
    )
    found = build([motion_from(ring * 1.0)], options_of(tau_count=0, smooth_s=0.0, tau_mm=4.0))
    assert found.scaling.negative > 0.02


def test_an_unknown_threshold_falls_back() -> None:
    rng = np.random.default_rng(1)
    corners = np.concatenate([np.eye(12), np.zeros((12, 6))], axis=1).reshape(12, 6, 3)
    base = rng.normal(size=(6, 3)) * 100
    found = build([motion_from(base + 1e-3 * corners, fps=1)], options_of(smooth_s=0.0))
    assert np.isfinite(found.tau)


def test_a_take_twice_changes_nothing_but_the_count() -> None:
    first = motions()[:3]
    again = [replace(motion, document=f"{motion.document}-again") for motion in first]
    found = build([*first, *again], options_of(tau_count=3))
    once = build(first, options_of(tau_count=3))
    assert len(found.coordinates) == 2 * len(once.coordinates)
    assert np.isfinite(found.coordinates).all()
    twins = {take.document: number for number, take in enumerate(found.frames.takes)}
    for motion in first:
        a = found.coordinates[found.frames.take == twins[motion.document]]
        b = found.coordinates[found.frames.take == twins[f"{motion.document}-again"]]
        assert np.allclose(a, b, atol=1e-5)
