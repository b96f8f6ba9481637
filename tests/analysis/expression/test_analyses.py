"""The catalogue entry: parts that survive storage, operations, order of takes, head motion."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from mcml_schemas.analyses import expression, expression_paths
from mcml_schemas.analyses.expression import (
    ExpressionCandidateChoice,
    ExpressionLevel,
    ExpressionLevelChoice,
    ExpressionNeighbours,
    ExpressionParameters,
    ExpressionPoints,
    ExpressionStride,
)
from mcml_schemas.analyses.expression_paths import (
    ExpressionMotion,
    ExpressionPath,
    ExpressionPathWish,
    ExpressionPlayback,
    ExpressionRefinement,
)
from mcml_service.analysis.expression_space.analyses import EXPRESSION, options_from
from mcml_service.analysis.expression_space.stored import Stored
from mcml_service.analysis.interface import AnalysisError, Motion, Part, Parts, silent
from tests.analysis.expression.face_motions import motions


@cache
def result(method: str = "robust") -> Parts:
    parameters = ExpressionParameters(method=method)  # type: ignore[arg-type]
    return EXPRESSION.run(motions(noise=0.1, head=True, gaps=0.01), parameters, silent)


def stored(parts: Parts) -> Parts:
    """The parts as a store gives them back."""
    return {
        name: Part(part.kind, json.loads(json.dumps(part.data, allow_nan=False)), dict(part.arrays))
        for name, part in parts.items()
    }


@cache
def ready(method: str = "robust") -> Stored:
    found: Stored = EXPRESSION.prepare(stored(result(method)))
    return found


def ask(name: str, space: Stored, **wish: Any) -> Any:
    operation = EXPRESSION.operations[name]
    answer = operation.run(space, operation.parameters(**wish))
    assert isinstance(answer.value, operation.answer)
    return answer


def keys(space: Stored, count: int = 3) -> list[dict[str, Any]]:
    """Candidates of level 0, each linked to the next, all different."""
    level: ExpressionLevel = ask("level", space, level=0).value
    chosen = [level.links[-1].a, level.links[-1].b]
    for link in level.links:
        ends = {link.a, link.b}
        if len(chosen) < count and chosen[-1] in ends and not (ends - {chosen[-1]}) & set(chosen):
            chosen += ends - {chosen[-1]}
    return [named(level.candidates[place]) for place in chosen]


def named(frame: Any) -> dict[str, Any]:
    return {"document": frame.document, "frame": frame.frame}


def child(answer: Any, method: str = "robust") -> Stored:
    """The result that an answer keeps, with the parts of its parent."""
    found: Stored = EXPRESSION.prepare(stored({**result(method), **answer.keep}))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("method", ["robust", "paper"])
def test_parts_are_those_announced(method: str) -> None:
    parts = result(method)
    assert set(EXPRESSION.parts) - set(parts) == {"path"}
    for name, part in parts.items():
        assert EXPRESSION.parts[name].kind == part.kind
        if part.kind == "table":
            assert all(len(row) == len(part.data["columns"]) for row in part.data["rows"]), name
        for array in part.arrays.values():
            assert np.isfinite(array).all(), name


@pytest.mark.slow
def test_the_summary_says_what_was_built() -> None:
    summary = result()["space"].data["summary"]
    total = sum(len(motion) for motion in motions())
    assert summary["frames"] + summary["frames_excluded"] == total
    assert summary["markers"] == 25
    assert summary["tau_rms_mm"] == pytest.approx(summary["tau_mm"] / 25)
    assert summary["levels"] == len(result()["levels"].data["rows"])
    assert summary["components"] == [summary["frames"]]
    paper = result("paper")["space"].data["summary"]
    assert paper["tau_mm"] == pytest.approx(2.3 * 25)
    assert len(result()["tau"].data["rows"]) == 25
    assert len(result("paper")["tau"].data["rows"]) == 13
    assert 0.8 < summary["trustworthiness"] <= 1
    assert 0.9 < summary["continuity"] <= 1


@pytest.mark.slow
def test_the_speed_of_capture_is_not_that_of_noise() -> None:
    speeds = [
        EXPRESSION.run(
            motions(fps=60, every_marker=9, noise=noise)[:2], ExpressionParameters(method=method, tau_count=0), silent
        )[  # type: ignore[arg-type]
            "space"
        ].data["summary"]["speed_mm_s"]
        for method, noise in (("robust", 0.0), ("robust", 0.2), ("paper", 0.2))
    ]
    assert speeds[1] == pytest.approx(speeds[0], rel=0.15)
    assert speeds[2] == pytest.approx(speeds[1], rel=0.15)


def test_progress_goes_through_the_stages_and_ends_the_work() -> None:
    seen: list[tuple[str, float]] = []
    EXPRESSION.run(motions()[:4], ExpressionParameters(), lambda stage, share: seen.append((stage, share)))
    stages = list(dict.fromkeys(stage for stage, _ in seen))
    assert stages == ["states", "distances", "tau", "graph", "geodesics", "map", "levels", "links", "done"]
    assert all(a <= b for (_, a), (_, b) in pairwise(seen))
    assert seen[-1][1] == 1.0

    class CancelledError(Exception):
        pass

    def stop(stage: str, share: float) -> None:
        if stage == "geodesics":
            raise CancelledError

    with pytest.raises(CancelledError):
        EXPRESSION.run(motions()[:4], ExpressionParameters(), stop)


def test_the_order_of_takes_does_not_matter() -> None:
    forth, back = (EXPRESSION.run(motions()[:5][::step], ExpressionParameters(), silent) for step in (1, -1))
    for name, part in forth.items():
        assert part.data == back[name].data
        for key, array in part.arrays.items():
            assert np.array_equal(array, back[name].arrays[key]), (name, key)


def _moved(motion: Motion, seed: int) -> Motion:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng)
    moved = turn.apply(motion.translations.reshape(-1, 3)).reshape(motion.translations.shape)
    return replace(motion, translations=moved + rng.normal(size=3) * 300)


@cache
def of_six() -> Parts:
    return EXPRESSION.run(motions(noise=0.1)[:6], ExpressionParameters(), silent)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_heads_that_stand_elsewhere_change_nothing(seed: int) -> None:
    moved = [_moved(motion, 10 * seed + place) for place, motion in enumerate(motions(noise=0.1)[:6])]
    a, b = of_six(), EXPRESSION.run(moved, ExpressionParameters(), silent)
    assert np.allclose(a["space"].arrays["geodesics"], b["space"].arrays["geodesics"], rtol=1e-5)
    size = np.abs(a["map"].arrays["coordinates"]).max()
    assert np.allclose(a["map"].arrays["coordinates"], b["map"].arrays["coordinates"], atol=1e-6 * size)
    assert np.array_equal(a["levels"].arrays["candidates"], b["levels"].arrays["candidates"])
    assert np.array_equal(a["links"].arrays["a"], b["links"].arrays["a"])


def test_points_of_the_map() -> None:
    value: ExpressionPoints = ask("points", ready(), stride=7).value
    coordinates = result()["map"].arrays["coordinates"]
    assert value.total == len(coordinates)
    assert np.allclose(np.column_stack([value.x, value.y]), coordinates[::7, :2])
    assert value.frame[0] == 1
    assert [value.takes[take].document for take in value.take] == [
        ready().documents[take] for take in ready().take[::7].tolist()
    ]


def test_a_level_has_candidates_and_links() -> None:
    for number in range(len(ready().ground.candidates)):
        value: ExpressionLevel = ask("level", ready(), level=number, most_links=50).value
        assert [candidate.id for candidate in value.candidates] == list(range(len(value.candidates)))
        assert sum(candidate.size for candidate in value.candidates) == len(ready().take)
        lengths = [link.length_mm for link in value.links]
        assert lengths == sorted(lengths)
        assert len(lengths) == min(50, value.links_total)
        assert value.components == 1
        place = ready().number(value.candidates[0].document, value.candidates[0].frame)
        assert place == ready().ground.candidates[number][0]


def test_neighbours_are_the_links_of_a_candidate() -> None:
    for number in (0, len(ready().ground.candidates) - 1):
        level: ExpressionLevel = ask("level", ready(), level=number, most_links=20_000).value
        chosen = level.candidates[5]
        value: ExpressionNeighbours = ask("neighbours", ready(), level=number, **named(chosen)).value
        assert value.candidate == chosen
        # The last level has more links than an answer may hold.
        if level.links_total <= 20_000:
            wanted = {
                link.b if link.a == 5 else link.a: link.length_mm for link in level.links if 5 in (link.a, link.b)
            }
            assert {one.id: one.length_mm for one in value.neighbours} == pytest.approx(wanted)
        lengths = [one.length_mm for one in value.neighbours]
        assert lengths == sorted(lengths)


def test_a_path_is_made_refined_and_played() -> None:
    space = ready()
    wanted = keys(space)
    made = ask("path", space, level=0, keys=wanted)
    value: ExpressionPath = made.value
    assert [named(key) for key in value.keys] == wanted
    assert value.version == 1
    assert value.walk[0].position_mm == 0
    assert value.walk[-1].position_mm == pytest.approx(value.length_mm)
    assert value.largest_hop_mm <= result()["space"].data["summary"]["tau_mm"] * (1 + 1e-6)
    assert [named(step) for step in value.walk if step.key] == wanted
    first = child(made)
    seen = ask("refine", first, level=3)
    assert seen.keep is None
    assert seen.value.offered
    picked = ask("refine", first, level=3, keys=[named(seen.value.offered[0])])
    assert picked.value.version == 2
    assert len(picked.value.keys) == len(wanted) + 1
    assert picked.value.offered[0].accepted
    second = child(ask("refine", child(picked), level=4, auto=True))
    assert second.path is not None
    assert second.path.version == 3
    played = ask("playback", second, most_samples=5)
    motion: ExpressionMotion = played.value
    clip = played.clip
    assert motion.frames == len(clip.translations)
    assert len(motion.samples) == 5
    assert named(motion.samples[0].frame_a) == wanted[0]
    assert motion.samples[0].alpha == 0
    assert clip.metres == 0.001
    assert clip.up == "Y"
    assert wanted[0]["document"] in clip.description
    for place, key in ((0, wanted[0]), (-1, wanted[-1])):
        captured = space.positions[space.number(*key.values())]
        assert np.isfinite(captured).any()
        assert np.allclose(clip.translations[place][np.isfinite(captured)], captured[np.isfinite(captured)], atol=1e-9)


def test_candidates_are_named_by_their_ids_too() -> None:
    space = ready()
    level: ExpressionLevel = ask("level", space, level=1).value
    link = level.links[0]
    frames = [named(level.candidates[place]) for place in (link.a, link.b)]
    made = ask("path", space, level=1, keys=[link.a, frames[1]])
    assert made.value == ask("path", space, level=1, keys=frames).value
    assert [named(key) for key in made.value.keys] == frames
    other = next(one.id for one in level.candidates if one.id not in (link.a, link.b))
    picked = ask("refine", child(made), level=1, keys=[other], rule="robust").value
    assert named(level.candidates[other]) in [named(key) for key in picked.keys]
    assert ask("neighbours", space, level=1, id=link.a).value == ask("neighbours", space, level=1, **frames[0]).value
    for name, wish in (("path", {"keys": [0, 11]}), ("neighbours", {"id": 11})):
        with pytest.raises(AnalysisError) as error:
            ask(name, space, level=0, **wish)
        assert error.value.code == "not-a-candidate"
        assert "0 to 10" in str(error.value.remedy)
    for wrong in ({}, {"id": 1, **frames[0]}, {"document": "a"}):
        with pytest.raises(ValidationError):
            ExpressionCandidateChoice(level=0, **wrong)


def test_the_papers_path_is_refined_over_the_map() -> None:
    made = ask("path", ready("paper"), level=0, keys=keys(ready("paper"), 2))
    space = child(made, "paper")
    assert space.path is not None
    near = ask("refine", space, level=3).value.offered
    assert near == ask("refine", space, level=3, rule="paper").value.offered
    assert near != ask("refine", space, level=3, rule="robust").value.offered


def test_a_path_keeps_frames_by_take_and_says_what_is_lost() -> None:
    made = ask("path", ready(), level=0, keys=keys(ready(), 4))
    part = made.keep["path"]
    kept = json.loads(json.dumps(part.data))
    kept["path"]["keys"][1] = ["elsewhere", 3]
    space = EXPRESSION.prepare({**result(), "path": Part("table", kept, part.arrays)})
    assert space.path is not None
    assert [code for code, _ in space.path.warnings] == ["keys-lost"]
    assert len(space.path.walk.keys) == 3
    kept["path"]["keys"] = [["elsewhere", 1], kept["path"]["keys"][0]]
    with pytest.raises(AnalysisError) as error:
        EXPRESSION.prepare({**result(), "path": Part("table", kept, part.arrays)})
    assert error.value.code == "keys-lost"


def test_operations_that_do_not_apply() -> None:
    frame = keys(ready())[0]
    off = next(
        {"document": ready().documents[take], "frame": place + 1}
        for number, (take, place) in enumerate(zip(ready().take.tolist(), ready().frame.tolist(), strict=True))
        if number not in ready().ground.candidates[0]
    )
    cases: list[tuple[str, dict[str, Any], str]] = [
        ("level", {"level": 19}, "unknown-level"),
        ("neighbours", {"level": 0, **off}, "not-a-candidate"),
        ("neighbours", {"level": 0, "document": frame["document"], "frame": 10_000}, "unknown-frame"),
        ("path", {"level": 0, "keys": [frame]}, "too-few-keys"),
        ("path", {"level": 0, "keys": [frame, frame]}, "repeated-key"),
        ("path", {"level": 0, "keys": [frame, off]}, "not-a-candidate"),
        ("refine", {"level": 1, "auto": True}, "no-path"),
        ("playback", {}, "no-path"),
    ]
    for name, wish, code in cases:
        with pytest.raises(AnalysisError) as error:
            ask(name, ready(), **wish)
        assert error.value.code == code, name
        assert error.value.remedy


def test_a_missing_link_is_answered_with_frames_of_takes() -> None:
    level: ExpressionLevel = ask("level", ready(), level=0).value
    linked = {(link.a, link.b) for link in level.links}
    a, b = next((a, b) for a in range(11) for b in range(a + 1, 11) if (a, b) not in linked)
    ends = [named(level.candidates[place]) for place in (a, b)]
    with pytest.raises(AnalysisError) as error:
        ask("path", ready(), level=0, keys=ends)
    assert error.value.code == "not-linked"
    way = error.value.details["suggestion"]
    assert [way[0], way[-1]] == ends
    assert (
        ask("path", ready(), level=0, keys=way).value == ask("path", ready(), level=0, keys=ends, auto_route=True).value
    )


def test_methods_are_sets_of_options() -> None:
    robust, paper = (options_from(ExpressionParameters(method=method)) for method in ("robust", "paper"))
    assert (robust.smooth_s, robust.tau_rule, robust.on_disconnected, robust.cluster_dimensions, robust.links) == (
        pytest.approx(1 / 30),
        "unbroken",
        "bridge",
        10,
        "voronoi",
    )
    assert (paper.smooth_s, paper.tau_rule, paper.on_disconnected, paper.cluster_dimensions, paper.links) == (
        0.0,
        "published",
        "largest",
        2,
        "paper",
    )
    mixed = options_from(ExpressionParameters(method="paper", links="voronoi", rho_mm=5.0, markers=["a"]))
    assert (mixed.links, mixed.rho, mixed.markers, mixed.tau_rule) == ("voronoi", 5.0, ("a",), "published")


@pytest.mark.parametrize(
    "wrong",
    [{"method": "best"}, {"tau_mm": 0}, {"tau_mm": float("nan")}, {"first_level": 1}, {"fuzziness": 1.0}, {"hue": 1}],
)
def test_wrong_parameters_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ExpressionParameters(**wrong)


def test_every_field_is_described() -> None:
    found = {**vars(expression), **vars(expression_paths)}
    known = [value for name, value in found.items() if name.startswith("Expression")]
    assert len(known) > 20
    for model in known:
        for name, field in model.model_fields.items():
            assert field.description, (model, name)
        model.model_validate(model.model_config["json_schema_extra"]["examples"][0])
    for wish in (
        ExpressionStride, ExpressionLevelChoice, ExpressionCandidateChoice, ExpressionPathWish, ExpressionRefinement,
        ExpressionPlayback,
    ):  # fmt: skip
        assert wish.model_config["extra"] == "forbid"
