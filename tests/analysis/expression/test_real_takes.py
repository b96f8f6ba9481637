"""Real marker files: faces of bigoMay/AnimFace, bodies and a dance in C3D, gaps included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.units import metres_of
from mcml_schemas.analyses.expression import ExpressionParameters
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.expression_space.frame_graph import threshold_graph
from mcml_service.analysis.expression_space.geodesics import all_pairs
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.planar_map import agreement, classical_scaling, neighbourhoods
from mcml_service.analysis.expression_space.space import Space, build
from mcml_service.analysis.expression_space.states import distances, state_vectors
from mcml_service.analysis.expression_space.takes import frames_of
from mcml_service.analysis.expression_space.threshold import STEPS, choose
from mcml_service.analysis.expression_space.trials import Trials
from mcml_service.analysis.interface import Motion, silent
from tests.analysis.expression.face_motions import motion_from


def read(path: Path, every: int = 1, metres: float | None = None) -> Motion:
    """A marker file as analyses get it, every so many frames."""
    name = path.suffix[1:].lower()
    with path.open("rb") as stream:
        clip = FORMATS[name].read({name: SourceFile(path.name, stream)}, ReadOptions())
        blocks = list(clip.blocks())
    head = clip.head
    columns = {column: place for place, column in enumerate(blocks[0].columns)}
    values = np.concatenate([block.values for block in blocks])
    places = np.array([[columns[marker, axis] for axis in range(3)] for marker in range(len(head.skeleton))])
    positions = values[:, places][::every]
    fps = 1 / (head.seconds_per_frame() or 1 / 60) / every
    return motion_from(positions, path.name, fps, metres or metres_of(head), head.skeleton.names)


def check(found: Space) -> None:
    """What holds of every space."""
    assert np.isfinite(found.coordinates).all()
    assert np.isfinite(np.asarray(found.geodesics)).all()
    assert [links.components for links in found.links] == [1] * len(found.levels)
    assert found.agreements[0].r > 0.8
    assert found.agreements[0].stress < 0.35


def faces(shared: Path, every: int) -> list[Motion]:
    folder = shared / "trc_facial"
    if not folder.is_dir():
        pytest.skip("the facial takes are not here")
    return [read(path, every) for path in sorted(folder.glob("*.trc"))]


@pytest.mark.slow
def test_faces_of_two_takes(shared: Path) -> None:
    given = faces(shared, 4)
    assert [motion.translations.shape[1] for motion in given] == [41, 41]
    found = build(given, options_of())
    check(found)
    assert len(found.frames.take) + len(found.frames.excluded) == sum(len(motion) for motion in given)
    assert len(set(found.frames.take.tolist())) == 2


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1])
def test_a_single_take_is_no_time_line(shared: Path, number: int) -> None:
    """Faces that look alike lie together on its map: r 0.98 with the distances of faces. As a time line it was 0.15."""
    options = options_of()
    frames = frames_of([faces(shared, 1)[number]], options)
    trials = Trials(distances(state_vectors(frames.positions)))
    tried = [trials.try_threshold(tau) for tau in trials.steps(STEPS)]
    chosen = choose(trials, tried, options.tau_rule, len(frames.markers))
    assert tried[0].broken > 0.1
    assert 0.08 < chosen.tau / trials.far < 0.3
    assert chosen.warnings == ()
    plane = classical_scaling(all_pairs(threshold_graph(trials.apart, chosen.tau).matrix), 2).coordinates
    assert agreement(trials.apart, plane).r > 0.97
    assert min(neighbourhoods(trials.apart, plane)) > 0.9


@pytest.mark.slow
def test_the_paper_on_real_faces(shared: Path) -> None:
    parts = EXPRESSION.run(faces(shared, 4), ExpressionParameters(method="paper", tau_count=2), silent)
    summary = parts["space"].data["summary"]
    assert summary["tau_mm"] == pytest.approx(2.3 * summary["markers"])
    assert summary["frames"] > 12


@pytest.mark.parametrize("name", ["body/nick_freeform_001.c3d", "dance/Dance.c3d", "body/HDM_dg_06-03_03_120.c3d"])
def test_bodies_are_marker_sets_too(shared: Path, name: str) -> None:
    path = shared / "c3d" / name
    if not path.is_file():
        pytest.skip("the C3D files are not here")
    motion = read(path, 8 if "nick" in name else 2)
    found = build([motion], options_of(tau_count=3))
    check(found)
    frames = found.frames
    lacking = bool(frames.dropped) or bool(frames.excluded) or bool(np.isnan(frames.positions).any())
    assert lacking == (motion.present is not None)
