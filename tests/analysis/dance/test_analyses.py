"""The three analyses as users meet them: parts, labels, invariances, determinism."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.hub import walked
from mcml.motion.rotations import from_euler, inverse, multiply, rotate
from mcml.motion.skeleton import numbers
from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters, GraphParameters
from mcml_service.analysis.dance.analyses import BEATS, DANCE, MOTION_GRAPH
from mcml_service.analysis.dance.figure import lay_back, upright
from mcml_service.analysis.interface import MadeClip, Motion, Parts, silent
from tests import fuzz
from tests.analysis.dance.motions import enlarged, generated, moved

PAIR = [
    generated("groove", "a", bars=8, seed=1)[0],
    generated("step", "b", bars=8, seed=2, tempo=120.0)[0],
]
DANCED = DanceParameters.model_validate({"bpm": 118, "bars": 12, "labels": ["bars", "beats"]})


def made(parts: Parts) -> MadeClip:
    clip = parts["clip"].clip
    assert clip is not None
    return clip


def rows(parts: Parts, name: str) -> list[dict[str, Any]]:
    names = [column["name"] for column in parts[name].data["columns"]]
    return [dict(zip(names, row, strict=True)) for row in parts[name].data["rows"]]


def same(one: Parts, other: Parts, tolerance: float = 0.0) -> None:
    """Equal parts, numbers within a relative tolerance."""
    assert one.keys() == other.keys()
    for name in one:
        alike(one[name].data, other[name].data, tolerance, name)


def alike(one: Any, other: Any, tolerance: float, where: str) -> None:
    if isinstance(one, dict):
        assert one.keys() == other.keys(), where
        for key in one:
            alike(one[key], other[key], tolerance, f"{where}.{key}")
    elif isinstance(one, list):
        assert len(one) == len(other), where
        for place, (a, b) in enumerate(zip(one, other, strict=True)):
            alike(a, b, tolerance, f"{where}[{place}]")
    elif isinstance(one, float) and isinstance(other, float):
        assert one == pytest.approx(other, rel=tolerance, abs=tolerance), where
    else:
        assert one == other, where


@pytest.mark.parametrize(
    ("analysis", "parameters"),
    [(BEATS, BeatsParameters(labels=["bars"])), (MOTION_GRAPH, GraphParameters()), (DANCE, DANCED)],
)
def test_parts_are_announced_plain_and_deterministic(analysis: Any, parameters: Any) -> None:
    told: list[float] = []
    parts = analysis.run(PAIR, parameters, lambda stage, share: told.append(share))
    assert set(parts) <= set(analysis.parts)
    for name, part in parts.items():
        assert part.kind == analysis.parts[name].kind
        orjson.dumps(part.data)
        for array in part.arrays.values():
            assert np.isfinite(array).all()
    assert told == sorted(told)
    assert told[-1] == 1.0
    again = analysis.run(PAIR, parameters, silent)
    same(parts, again)
    if analysis is DANCE:
        assert np.array_equal(made(parts).rotations, made(again).rotations)


@pytest.mark.parametrize(
    ("analysis", "parameters"), [(BEATS, BeatsParameters()), (MOTION_GRAPH, GraphParameters()), (DANCE, DANCED)]
)
def test_the_order_of_clips_changes_nothing(analysis: Any, parameters: Any) -> None:
    one, other = analysis.run(PAIR, parameters, silent), analysis.run(PAIR[::-1], parameters, silent)
    same(one, other)
    if analysis is DANCE:
        assert np.array_equal(made(one).translations, made(other).translations)


@pytest.mark.slow
@fuzz.examples(5)
@given(heading=st.floats(-3, 3), x=st.floats(-500, 500), z=st.floats(-500, 500))
def test_a_rigid_motion_of_a_clip_changes_nothing(heading: float, x: float, z: float) -> None:
    """Each clip may stand elsewhere: beats, distances and path stay; the dance starts where its first bar stands."""
    shifted = [PAIR[0], moved(PAIR[1], heading, np.array([x, 0.0, z]))]
    same(BEATS.run(PAIR, BeatsParameters(), silent), BEATS.run(shifted, BeatsParameters(), silent), 1e-6)
    one, other = DANCE.run(PAIR, DANCED, silent), DANCE.run(shifted, DANCED, silent)
    same({"path": one["path"], "metrics": one["metrics"]}, {"path": other["path"], "metrics": other["metrics"]}, 1e-5)
    heights = made(one).translations[:, 0, 1], made(other).translations[:, 0, 1]
    assert np.allclose(*heights, atol=1e-6)
    assert np.allclose(np.abs(np.sum(made(one).rotations[:, 1:] * made(other).rotations[:, 1:], axis=-1)), 1)


@fuzz.examples(5)
@given(factor=st.sampled_from([0.01, 0.3937, 10.0, 1000.0]))
def test_the_unit_of_length_changes_nothing(factor: float) -> None:
    scaled = [enlarged(motion, factor) for motion in PAIR]
    one, other = DANCE.run(PAIR, DANCED, silent), DANCE.run(scaled, DANCED, silent)
    same({"path": one["path"], "metrics": one["metrics"]}, {"path": other["path"], "metrics": other["metrics"]}, 1e-6)
    assert np.allclose(made(one).translations * factor, made(other).translations, rtol=1e-6, atol=1e-6 * factor)
    found = [
        [row[key] for key in ("b0", "b3", "entry", "leave")]
        for row in rows(BEATS.run(PAIR, BeatsParameters(), silent), "bars")
    ]
    assert found == [
        [row[key] for key in ("b0", "b3", "entry", "leave")]
        for row in rows(BEATS.run(scaled, BeatsParameters(), silent), "bars")
    ]


@pytest.mark.parametrize("up", ["X", "Z"])
def test_an_axis_up_other_than_y_is_turned_and_turned_back(up: str) -> None:
    lying = [lay_back(motion, up) for motion in PAIR]
    assert lying[0].up == up
    height = "XYZ".index(up)
    assert lying[0].walk()[0][..., height] == pytest.approx(PAIR[0].walk()[0][..., 1])
    back = upright(lying[0])
    for joint, original in zip(back.skeleton.joints, PAIR[0].skeleton.joints, strict=True):
        assert numbers(joint.offset).tolist() == numbers(original.offset).tolist()
    assert np.allclose(back.translations, PAIR[0].translations)
    one, other = DANCE.run(PAIR, DANCED, silent), DANCE.run(lying, DANCED, silent)
    same({"path": one["path"], "metrics": one["metrics"]}, {"path": other["path"], "metrics": other["metrics"]}, 1e-6)
    clip = made(other)
    assert (clip.up, clip.skeleton) == (up, lying[0].skeleton)
    positions = walked(clip.skeleton, clip.translations, clip.rotations)[0]
    expected = walked(made(one).skeleton, made(one).translations, made(one).rotations)[0]
    assert np.allclose(positions[..., height], expected[..., 1])


def test_turning_the_axes_turns_all_positions_alike() -> None:
    turn = from_euler(np.array([-np.pi / 2, 0, 0]), "XYZ")
    lying = lay_back(PAIR[1], "Z")
    assert np.allclose(rotate(turn, lying.walk()[0]), PAIR[1].walk()[0])
    bone = multiply(multiply(turn, lying.rotations[5]), inverse(turn))
    assert np.allclose(np.abs(np.sum(bone * PAIR[1].rotations[5], axis=-1)), 1)


def test_labels_of_bars_and_beats() -> None:
    clip = made(DANCE.run(PAIR, DANCED, silent))
    bars = [label for label in clip.labels if label[0].startswith("bar-")]
    assert [name for name, _, _ in bars] == [f"bar-{number}" for number in range(1, 13)]
    assert bars[0][1] == 0
    assert bars[-1][2] == len(clip.rotations) - 1
    assert all(b[1] == a[2] + 1 for a, b in pairwise(bars))
    assert sum(name == "beat" for name, _, _ in clip.labels) == 48
    assert made(DANCE.run(PAIR, DANCED.model_copy(update={"labels": []}), silent)).labels == ()
    parts = BEATS.run(PAIR, BeatsParameters(labels=["bars", "beats"]), silent)
    beats, labels = rows(parts, "beats"), rows(parts, "labels")
    assert [r["first"] for r in labels if r["name"] == "beat" and r["document"] == "a"] == [
        row["frame"] for row in beats if row["document"] == "a"
    ]
    first = rows(parts, "bars")[0]
    assert {"document": "a", "name": "bar-1", "first": first["b0"], "last": first["b3"]} in labels
    assert "labels" not in BEATS.run(PAIR, BeatsParameters(), silent)


def test_a_dry_run_gives_path_and_figures_only() -> None:
    whole = DANCE.run(PAIR, DANCED, silent)
    dry = DANCE.run(PAIR, DANCED.model_copy(update={"dry_run": True}), silent)
    assert set(dry) == {"path", "transitions", "metrics", "warnings"}
    same(dry, {name: whole[name] for name in dry})


def test_the_new_clip_says_where_it_comes_from() -> None:
    clip = made(DANCE.run(PAIR, DANCED, silent))
    said = {name: value for name, value, _ in clip.properties}
    assert said["sources"] == "a@1 b@1"
    assert orjson.loads(said["parameters"])["bpm"] == 118
    assert len(said["path"].split()) == 12
    assert clip.skeleton == PAIR[0].skeleton
    assert clip.frame_time == PAIR[0].frame_time
    fast = made(DANCE.run(PAIR, DANCED.model_copy(update={"fps": 90.0}), silent))
    assert fast.frame_time == 1 / 90
    assert len(fast.rotations) == int(48 * 60 / 118 * 90 + 0.5)


def test_bones_are_those_of_the_first_clip() -> None:
    tall = enlarged(PAIR[1], 1.2)
    parts = DANCE.run([PAIR[0], tall], DANCED, silent)
    clip = made(parts)
    assert "bones differ" in parts["warnings"].data["rows"][0][0]
    lengths = np.linalg.norm(clip.translations[:, 1:], axis=-1)
    assert np.allclose(lengths, lengths[:1])
    metres = [replace(PAIR[0], metres=0.01), replace(enlarged(PAIR[1], 0.01), metres=1.0)]
    assert not DANCE.run(metres, DANCED, silent)["warnings"].data["rows"]


def test_joints_in_another_order_are_put_in_order() -> None:
    motion = PAIR[1]
    joints = motion.skeleton.joints
    order = [
        0,
        *(i for i, j in enumerate(joints) if i and _side(motion, i) == "Right"),
        *(i for i in range(1, len(joints)) if _side(motion, i) != "Right"),
    ]
    place = {old: new for new, old in enumerate(order)}
    turned = replace(
        motion,
        skeleton=replace(
            motion.skeleton,
            joints=tuple(replace(joints[old], parent=place.get(joints[old].parent, -1)) for old in order),
        ),
        rotations=motion.rotations[:, order],
        translations=motion.translations[:, order],
    )
    assert turned.skeleton.names != motion.skeleton.names
    one, other = DANCE.run(PAIR, DANCED, silent), DANCE.run([PAIR[0], turned], DANCED, silent)
    same({"path": one["path"]}, {"path": other["path"]}, 1e-9)
    assert np.allclose(made(one).rotations, made(other).rotations)


def _side(motion: Motion, joint: int) -> str:
    """Right for the right leg, which hangs on the root: moved before the rest, parents stay before their children."""
    while motion.skeleton.joints[joint].parent > 0:
        joint = motion.skeleton.joints[joint].parent
    return "Right" if motion.skeleton.joints[joint].name == "RightUpLeg" else ""


def test_what_a_person_knows_of_a_clip_counts() -> None:
    times = np.arange(1.0, 13.0, 0.5).tolist()
    parameters = BeatsParameters.model_validate(
        {"clips": [{"document": "a", "beats": times}, {"document": "b", "source_bpm": 120, "beats_from": "tracked"}]}
    )
    parts = BEATS.run(PAIR, parameters, silent)
    assert [row["seconds"] for row in rows(parts, "beats") if row["document"] == "a"] == pytest.approx(times)
    clips = {row["document"]: row for row in rows(parts, "clips")}
    assert clips["a"]["bpm"] == pytest.approx(120, rel=0.01)
    assert (clips["b"]["bpm"], clips["b"]["beats_from"]) == (120, "tracked")


def test_natural_pairs_play_on_without_a_blend() -> None:
    graph = MOTION_GRAPH.run(PAIR, GraphParameters(), silent)["graph"]
    nodes = {node["id"]: node for node in graph.data["nodes"]}
    natural = [edge for edge in graph.data["edges"] if edge["natural"]]
    assert len(natural) >= 12
    for edge in natural:
        one, two = nodes[edge["from"]], nodes[edge["to"]]
        assert (one["document"], one["bar"] + 1, edge["distance"]) == (two["document"], two["bar"], 0)


def test_the_thesis_choices_can_be_had() -> None:
    literal = DanceParameters.model_validate(
        {
            "bpm": 118, "bars": 8, "smooth": 0, "difference": "forward", "k2": 1 / 21, "locate": False,
            "interval_tolerance": "window", "lead_in": "third", "beats_from": "detected", "cloud_at": "first beat",
            "threshold": 0.2, "strategy": "random", "warp": "uniform", "placement": "facing", "seed": 3,
        }
    )  # fmt: skip
    clip = made(DANCE.run(PAIR, literal, silent))
    assert np.isfinite(clip.rotations).all()
    other = made(DANCE.run(PAIR, literal.model_copy(update={"seed": 4}), silent))
    assert not np.array_equal(clip.rotations, other.rotations)
