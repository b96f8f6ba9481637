"""Large spaces by landmarks, and takes added without a rebuild."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mcml_schemas.analyses.expression import (
    ExpressionLevelChoice,
    ExpressionParameters,
)
from mcml_schemas.analyses.expression_paths import (
    ExpressionPathWish,
)
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.expression_space.extension import extend
from mcml_service.analysis.expression_space.geodesics import from_sources
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.space import Space, build
from mcml_service.analysis.interface import AnalysisError, Part, Parts, silent
from tests.analysis.expression.face_motions import motion_from, motions, takes


@cache
def large() -> Space:
    return build(motions(noise=0.1), options_of(scale="landmark", landmarks=100))


@cache
def parts_of(scale: str, left_out: int = 0) -> Parts:
    parameters = ExpressionParameters(scale=scale, landmarks=60, tau_count=3)  # type: ignore[arg-type]
    return EXPRESSION.run(motions(noise=0.1)[left_out:], parameters, silent)


def test_landmarks_reproduce_their_own_places() -> None:
    found = large()
    assert found.reduced is not None
    assert found.geodesics is None
    assert np.allclose(found.coordinates[found.reduced.landmarks], found.scaling.coordinates, atol=0.01)
    assert np.allclose(found.reduced.geodesics, from_sources(found.graph.matrix, found.reduced.landmarks), rtol=1e-6)


def test_the_map_is_nearly_that_of_all_distances() -> None:
    found = large()
    whole = from_sources(found.graph.matrix, None)
    centred = np.eye(len(whole)) - 1 / len(whole)
    values, vectors = np.linalg.eigh(-0.5 * centred @ whole**2 @ centred)
    wanted = vectors[:, ::-1][:, :10] * np.sqrt(values[::-1][:10])
    # Axes of nearly equal eigenvalues turn about each other, so distances are compared and not axes.
    i, j = np.triu_indices(len(whole), 1)
    apart = [np.linalg.norm(places[i] - places[j], axis=1) for places in (found.coordinates, wanted)]
    assert np.corrcoef(*apart)[0, 1] > 0.998


def test_levels_nest_and_links_connect_them() -> None:
    found = large()
    assert found.graph.components().max() == 0
    for level, links in zip(found.levels, found.links, strict=True):
        assert links.components == 1
        assert len(set(level.candidates.tolist())) == len(level.candidates)
    for coarse, fine in zip(found.levels[:-1], found.levels[1:], strict=True):
        assert set(coarse.candidates.tolist()) <= set(fine.candidates.tolist())
    few = build(motions(), options_of(scale="landmark", landmarks=60, most_candidates=100))
    assert [len(level.candidates) for level in few.levels] == [11, 22, 44, 88]


def test_the_scale_follows_the_number_of_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    from mcml_service.analysis.expression_space import space as spaces

    monkeypatch.setattr(spaces, "FULL_FRAMES", 50)
    assert build(motions()[:3], options_of()).reduced is not None
    assert build(motions()[:3], options_of(scale="full", tau_count=0)).reduced is None


def test_gaps_do_not_tear_a_large_space() -> None:
    found = build(motions(noise=0.1, gaps=0.02), options_of(scale="landmark", landmarks=60))
    assert np.isfinite(found.coordinates).all()
    assert np.isnan(found.frames.positions).any()


@pytest.mark.parametrize("scale", ["full", "landmark"])
def test_an_added_take_lies_where_a_rebuild_would_put_its_twin(scale: str) -> None:
    old = parts_of(scale)
    twin = replace(motions(noise=0.1)[3], document="zz")
    new = extend(old, [twin])
    before = old["map"].arrays["coordinates"]
    after = new["map"].arrays["coordinates"]
    assert np.array_equal(after[: len(before)], before)
    own = before[old["map"].arrays["take"] == 3]
    assert len(after) == len(before) + len(own)
    assert np.allclose(after[len(before) :], own, atol=0.02 * np.ptp(before, axis=0).max())
    summary = new["space"].data["summary"]
    assert summary["version"] == 2
    assert summary["added"] == len(own)
    assert summary["stale_share"] == pytest.approx(len(own) / len(after))
    assert summary["uncovered"] == 0.0
    assert old["space"].data["summary"]["version"] == 1
    levels = new["levels"].arrays
    twins = (
        levels["nearest"][:, len(before) :] == levels["nearest"][:, : len(before)][:, old["map"].arrays["take"] == 3]
    )
    assert twins.mean() > 0.9
    assert np.allclose(levels["shares"].sum(axis=2)[:2].max(), 1, atol=0.5)


@pytest.mark.parametrize("scale", ["full", "landmark"])
def test_paths_lead_to_added_frames(scale: str) -> None:
    stranger = motions(noise=0.1)[0]
    space = EXPRESSION.prepare(extend(parts_of(scale, 1), [stranger]))
    frame = space.number(stranger.document, 20)
    walk = space.ground.row(frame)
    assert np.isfinite(walk).all()
    assert np.allclose(space.ground.row(0)[frame], walk[0], rtol=1e-5)
    if scale == "full":
        last = len(space.ground.candidates) - 1
        old = {"document": space.documents[0], "frame": 1}
        keys = [old, {"document": stranger.document, "frame": 20}]
        answer = EXPRESSION.operations["path"].run(space, ExpressionPathWish(level=last, keys=keys, auto_route=True))
        assert answer.value.walk[-1].document == stranger.document
        level = EXPRESSION.operations["level"].run(space, ExpressionLevelChoice(level=last)).value
        assert len(level.candidates) == len(space.take)


def test_a_space_that_has_grown_much_is_stale() -> None:
    old = parts_of("full", 8)
    grown = extend(old, motions(noise=0.1)[:1])
    assert [warning["code"] for warning in grown["space"].data["summary"]["warnings"]] == ["stale"]
    again = extend(grown, motions(noise=0.1)[1:2])
    summary = again["space"].data["summary"]
    assert summary["version"] == 3
    assert [warning["code"] for warning in summary["warnings"]] == ["stale"]
    assert summary["frames"] == sum(len(motion) for motion in [*motions()[:2], *motions()[8:]])
    assert len(again["takes"].data["rows"]) == 4
    stranger = motion_from(takes()[0].still * 1.5, "zz", labels=motions()[0].skeleton.names)
    assert extend(old, [stranger])["space"].data["summary"]["uncovered"] > 0.9


def test_what_cannot_be_added() -> None:
    old = parts_of("full")
    for given, code in (
        (motions()[0], "already-there"),
        (motion_from(takes()[0].still, "zz"), "marker-sets-disjoint"),
    ):
        with pytest.raises(AnalysisError) as error:
            extend(old, [given])
        assert error.value.code == code


def test_a_path_is_no_part_of_a_grown_space() -> None:
    assert "path" not in extend({**parts_of("full"), "path": Part("table")}, [replace(motions()[0], document="zz")])
