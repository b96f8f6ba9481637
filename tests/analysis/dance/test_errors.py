"""Every named error by its test: what is wrong, and how to mend it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from mcml.motion.skeleton import Convention, Joint, Skeleton
from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters, GraphParameters
from mcml_service.analysis.dance import bar_graph
from mcml_service.analysis.dance.analyses import BEATS, DANCE, MOTION_GRAPH
from mcml_service.analysis.interface import AnalysisError, Motion, Parts, silent
from tests.analysis.dance.motions import generated

PAIR = [
    generated("groove", "a", bars=6, seed=1)[0],
    generated("groove", "b", bars=6, seed=2)[0],
]


def refused(code: str, motions: Sequence[Motion], **parameters: Any) -> AnalysisError:
    with pytest.raises(AnalysisError) as error:
        DANCE.run(motions, DanceParameters.model_validate({"bpm": 112, "bars": 4, **parameters}), silent)
    assert error.value.code == code
    assert error.value.remedy
    return error.value


def still(motion: Motion) -> Motion:
    return replace(
        motion,
        rotations=np.repeat(motion.rotations[:1], len(motion), axis=0),
        translations=np.repeat(motion.translations[:1], len(motion), axis=0),
    )


def slice_of(motion: Motion, first: int, last: int) -> Motion:
    return replace(motion, rotations=motion.rotations[first:last], translations=motion.translations[first:last])


def named(motion: Motion, joint: int, **changes: Any) -> Motion:
    joints = list(motion.skeleton.joints)
    joints[joint] = replace(joints[joint], **changes)
    return replace(motion, skeleton=Skeleton(tuple(joints)))


def test_frame_rate_too_low() -> None:
    refused("frame-rate-too-low", [replace(PAIR[0], frame_time=1 / 9.9)])
    BEATS.run([replace(PAIR[0], frame_time=1 / 10)], BeatsParameters(), silent)


def test_clip_too_short_says_the_shortest() -> None:
    assert refused("clip-too-short", [slice_of(PAIR[0], 0, 40)]).details["shortest"] == 41
    BEATS.run([slice_of(PAIR[0], 0, 41)], BeatsParameters(), silent)


def test_a_number_that_is_none_is_named_with_joint_and_frame() -> None:
    broken = PAIR[0].rotations.copy()
    broken[17:, 4, 1] = np.nan
    error = refused("not-finite", [replace(PAIR[0], rotations=broken)])
    assert (error.details["joint"], error.details["frame"]) == (PAIR[0].skeleton.names[4], 18)
    lost = PAIR[0].translations.copy()
    lost[3, 0, 2] = np.inf
    assert refused("not-finite", [replace(PAIR[0], translations=lost)]).details["frame"] == 4


def test_no_beats_counts_what_was_refused() -> None:
    assert refused("no-beats", [still(PAIR[0])]).details["failures"] == {"F1": 0, "F2": 0, "F3": 0}
    counts = refused("no-beats", PAIR, k3=0.0).details["failures"]
    assert counts["F3"] > 20
    assert refused("no-beats", PAIR, k2=2.0).details["failures"]["F2"] > 20


def test_a_clip_without_beats_is_a_result_of_beats_and_no_hindrance_beside_others() -> None:
    parts = BEATS.run([still(PAIR[0])], BeatsParameters(), silent)
    assert parts["bars"].data["rows"] == []
    DANCE.run([PAIR[0], still(PAIR[1])], DanceParameters(bpm=112, bars=2), silent)


def test_no_bars() -> None:
    error = refused("no-bars", [slice_of(PAIR[0], 0, 110)])
    assert "source_bpm" in (error.remedy or "")


def test_skeletons_differ_names_the_first_joint() -> None:
    other = named(PAIR[1], 3, name="Elsewhere")
    error = refused("skeletons-differ", [PAIR[0], other])
    assert error.details["joint"] == PAIR[0].skeleton.names[3]
    assert "missing" in error.what
    hung = named(PAIR[1], 20, parent=PAIR[1].skeleton.joints[20].parent - 1)
    assert "another joint" in refused("skeletons-differ", [PAIR[0], hung]).what
    more = replace(
        PAIR[1],
        skeleton=Skeleton((*PAIR[1].skeleton.joints, Joint("Tail", 0, "Tail", Convention.LISTED))),
        rotations=np.concatenate([PAIR[1].rotations, PAIR[1].rotations[:, :1]], axis=1),
        translations=np.concatenate([PAIR[1].translations, PAIR[1].translations[:, :1]], axis=1),
    )
    assert refused("skeletons-differ", [PAIR[0], more]).details["joint"] == "Tail"


def markers(motion: Motion) -> Motion:
    positions, _ = motion.walk()
    joints = tuple(
        Joint(joint.name, -1, joint.name, Convention.MARKER, ("Tx", "Ty", "Tz")) for joint in motion.skeleton.joints
    )
    flat = np.zeros((*positions.shape[:2], 4))
    flat[..., 3] = 1
    return replace(motion, skeleton=Skeleton(joints), translations=positions, rotations=flat)


def test_markers_have_beats_but_make_no_dance() -> None:
    parts = BEATS.run([markers(PAIR[0])], BeatsParameters(), silent)
    assert len(parts["bars"].data["rows"]) == 6
    refused("no-skeleton", [markers(PAIR[0])])


def test_no_edges_says_the_threshold_that_would_do() -> None:
    error = refused("no-edges", PAIR, threshold=0.0)
    least = error.details["threshold"]
    assert least > 0
    DANCE.run(PAIR, DanceParameters(bpm=112, bars=4, threshold=least * 1.000001), silent)
    refused("no-edges", PAIR, threshold=least * 0.999)


def test_a_pose_of_calibration_in_front_is_warned_of() -> None:
    posed = PAIR[1].translations.copy()
    posed[0, 0] += np.array([150.0, 0.0, 90.0])
    clips = [PAIR[0], replace(PAIR[1], translations=posed)]
    parts = DANCE.run(clips, DanceParameters(bpm=112, bars=2), silent)
    assert [row[0] for row in parts["warnings"].data["rows"]] == [
        "groove b: the body jumps at frame 1, as after a pose of calibration; cut that off."
    ]
    assert [row[-1] for row in parts["clips"].data["rows"]] == [None, 1]


def test_one_bar_of_a_graph_of_one_is_fine() -> None:
    single = slice_of(PAIR[0], 0, 146)
    parts = DANCE.run([single], DanceParameters(bpm=112, bars=1), silent)
    assert len(parts["path"].data["rows"]) == 1
    assert parts["transitions"].data["rows"] == []
    refused("no-edges", [single], bars=2)
    parts = DANCE.run([single], DanceParameters(bpm=112, bars=3, allow_repeat=True, threshold=2.0), silent)
    assert [row[1] for row in parts["path"].data["rows"]] == [1, 1, 1]


def nodes(**parameters: Any) -> Parts:
    return MOTION_GRAPH.run(PAIR, GraphParameters.model_validate(parameters), silent)


def test_no_path_names_the_first_position_that_cannot_be() -> None:
    kept = [node["id"] for node in nodes()["graph"].data["nodes"] if node["kept"]]
    assert refused("no-path", PAIR, allowed=[{"position": 3, "document": "elsewhere"}]).details["position"] == 3
    edges = {(edge["from"], edge["to"]) for edge in nodes()["graph"].data["edges"]}
    stuck = next((a, b) for a in kept for b in kept if (a, b) not in edges)
    wish = [{"position": 2, "bars": [stuck[1]]}]
    assert refused("no-path", PAIR, start=stuck[0], allowed=wish).details["position"] == 2
    assert refused("no-path", PAIR, start=999).details["position"] == 1


def test_constraints_are_kept() -> None:
    labelled = [replace(PAIR[0], labels=(("chorus", 0, 400),)), PAIR[1]]
    wishes = [{"position": 2, "document": "b"}, {"position": 4, "label": "chorus"}]
    parts = DANCE.run(labelled, DanceParameters.model_validate({"bpm": 112, "bars": 6, "allowed": wishes}), silent)
    rows = parts["path"].data["rows"]
    assert rows[1][2] == "b"
    assert rows[3][2] == "a"
    assert rows[3][5] <= 401
    start = rows[2][1]
    again = DANCE.run(labelled, DanceParameters.model_validate({"bpm": 112, "bars": 6, "start": start}), silent)
    assert again["path"].data["rows"][0][1] == start
    only = DanceParameters.model_validate({"bpm": 112, "bars": 6, "allowed": [{"document": "a"}]})
    assert {row[2] for row in DANCE.run(labelled, only, silent)["path"].data["rows"]} == {"a"}


@pytest.mark.parametrize("bpm", [39.9, 241.0, 0.0, -120.0, float("nan"), float("inf"), None])
def test_bpm_out_of_range(bpm: float | None) -> None:
    refused("bpm-out-of-range", PAIR, bpm=bpm)


def test_bpm_and_music_together_are_refused() -> None:
    refused("bpm-out-of-range", PAIR, music={"beats": [0.5, 1, 1.5, 2]})


def test_tempo_too_far_says_what_works() -> None:
    error = refused("tempo-too-far", PAIR, bpm=240.0, pulse="1", max_stretch=1.2)
    low, high = error.details["ranges"][0]
    assert low < 112 < high < 150
    DANCE.run(PAIR, DanceParameters(bpm=low + 1, bars=2, pulse="1", max_stretch=1.2), silent)


def test_bars_not_divisible_says_the_nearest() -> None:
    error = refused("bars-not-divisible", PAIR, bars=5, pulse="2", bpm=220)
    assert error.details["nearest"] in (4, 6)
    assert refused("bars-not-divisible", PAIR, bars=1, pulse="2", bpm=220).details["nearest"] == 2


def test_too_many_bars_in_and_out(monkeypatch: pytest.MonkeyPatch) -> None:
    assert refused("too-many-bars", PAIR, bars=513).details["most"] == 512
    assert refused("too-many-bars", PAIR, bars=300, pulse="1/2").details["most"] == 512
    monkeypatch.setattr(bar_graph, "MOST_BARS", 11)
    assert refused("too-many-bars", PAIR).details["most"] == 11


def test_music_that_is_none() -> None:
    refused("music-no-beats", PAIR, bpm=None, music={"beats": [0.5, 1.0]})


def test_music_gives_the_grid_and_the_first_pose_waits_for_it() -> None:
    beats = (0.7 + np.arange(40) * 60 / 112).tolist()
    parameters = DanceParameters.model_validate({"bars": 4, "music": {"beats": beats, "downbeat": 5}})
    parts = DANCE.run(PAIR, parameters, silent)
    clip = parts["clip"].clip
    assert clip is not None
    grid = parts["speed"].arrays["grid"]
    assert grid[0] == pytest.approx(beats[4])
    assert len(clip.rotations) == int(beats[20] * PAIR[0].fps + 0.5)
    waiting = int(grid[0] * PAIR[0].fps)
    assert np.array_equal(clip.rotations[0], clip.rotations[waiting - 1])
    assert not np.array_equal(clip.rotations[0], clip.rotations[waiting + 9])


@pytest.mark.parametrize("bad", [{"interval_tolerance": 0}, {"source_bpm": 24}, {"blend": "other"}, {"unknown": 1}])
def test_parameters_out_of_their_range_never_reach_the_analysis(bad: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        DanceParameters.model_validate({"bpm": 120, **bad})
