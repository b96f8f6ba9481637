"""Spaces of random small sets under random options keep what every space promises."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from mcml_schemas.analyses.expression import (
    ExpressionParameters,
)
from mcml_schemas.analyses.expression_paths import (
    ExpressionPathWish,
    ExpressionPlayback,
)
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.expression_space.frame_graph import threshold_graph
from mcml_service.analysis.expression_space.geodesics import all_pairs
from mcml_service.analysis.expression_space.planar_map import classical_scaling
from mcml_service.analysis.interface import AnalysisError, silent
from mcml_service.demo.face_takes import face_takes
from tests.analysis.expression.face_motions import motion_of
from tests.analysis.expression.test_threshold import r_of, rows, searched

OPTIONS = st.fixed_dictionaries(
    {
        "method": st.sampled_from(["robust", "paper"]),
        "scale": st.sampled_from(["full", "landmark"]),
        "grouping": st.sampled_from([None, "fcm", "fps"]),
        "links": st.sampled_from([None, "voronoi", "paper"]),
        "on_disconnected": st.sampled_from([None, "bridge", "largest", "error"]),
        "tau_rule": st.sampled_from([None, "published", "best", "unbroken"]),
        "first_level": st.integers(2, 30),
        "tau_count": st.integers(0, 4),
        "smooth_s": st.sampled_from([None, 0.0, 0.1]),
    }
)


@pytest.mark.fuzz
@settings(max_examples=300)
@given(
    st.integers(0, 2**31), st.integers(1, 4), st.sampled_from([0.0, 0.2, 1.0]), st.sampled_from([0.0, 0.05]), OPTIONS
)
def test_any_space_keeps_its_promises(
    seed: int, count: int, noise: float, gaps: float, options: dict[str, Any]
) -> None:
    takes = face_takes(seed, fps=6, every_marker=7, head=True, noise=noise, gaps=gaps)[:count]
    parameters = ExpressionParameters(landmarks=20, **options)
    code, parts = "", None
    try:
        parts = EXPRESSION.run([motion_of(take) for take in takes], parameters, silent)
    except AnalysisError as error:
        code = error.code
    if parts is None:
        assert code in {"disconnected", "too-few-frames"}
        return
    for part in parts.values():
        assert all(np.isfinite(array).all() for array in part.arrays.values())
    space = EXPRESSION.prepare(parts)
    graph = space.ground.graph
    assert graph.components().max() == 0
    for candidates, sizes in zip(space.ground.candidates, space.sizes, strict=True):
        assert len(set(candidates.tolist())) == len(candidates)
        assert sizes.sum() == len(space.take)
    last = len(space.ground.candidates) - 1
    ends = [
        {"document": space.documents[space.take[n]], "frame": int(space.frame[n]) + 1}
        for n in space.ground.candidates[last][[0, -1]].tolist()
    ]
    made = None
    try:
        wish = ExpressionPathWish(level=last, keys=ends, auto_route=True)
        made = EXPRESSION.operations["path"].run(space, wish)
    except AnalysisError as error:
        code = error.code
    if made is None or made.keep is None:
        assert code == "unreachable"
        assert options["links"] == "paper" or options["method"] == "paper"
        return
    child = EXPRESSION.prepare({**parts, **made.keep})
    walk = child.path.walk
    assert all(space.ground.edge(a, b) is not None for a, b in pairwise(walk.frames.tolist()))
    played = EXPRESSION.operations["playback"].run(child, ExpressionPlayback(duration_s=1.0)).clip
    assert played is not None
    assert np.isfinite(played.translations).all()


@pytest.mark.fuzz
@settings(max_examples=40)
@given(st.integers(5, 9), st.floats(5, 11), st.floats(0.0, 0.2), st.integers(0, 2**31))
def test_no_single_take_becomes_a_time_line(count: int, apart: float, shake: float, seed: int) -> None:
    """A sheet that is covered back and forth, with noise of a part of the distance between its rows."""
    points = rows(100, apart * (count - 1), count)
    points = points + np.random.default_rng(seed).normal(size=points.shape) * shake * apart / 2
    trials, _, chosen = searched(points)
    paths = all_pairs(threshold_graph(trials.apart, chosen.tau).matrix)
    plane = classical_scaling(paths, 2).coordinates
    assert r_of(cdist(plane, plane), trials.apart) > 0.9
