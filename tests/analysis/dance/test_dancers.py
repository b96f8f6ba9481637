"""Several dancers on one stage: unison, canon, and paths of their own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.hub import walked
from mcml.motion.sides import partners
from mcml_schemas.analyses.dance import DanceParameters
from mcml_service.analysis.dance import stage as stages
from mcml_service.analysis.dance.analyses import DANCE
from mcml_service.analysis.dance.group_dance.formation import find_nearest, find_room, form_lines
from mcml_service.analysis.dance.stage import Stage
from mcml_service.analysis.interface import AnalysisError, MadeClip, Parts, silent
from tests import fuzz
from tests.analysis.dance.motions import generated

TEMPO = 120.0
DANCERS = [replace(generated("step", f"{seed}", bars=10, seed=seed, tempo=112.0)[0], metres=0.01) for seed in (3, 4)]
JOINTS = len(DANCERS[0].skeleton)


def make_group(count: int, mode: str = "unison", bars: int = 16, **options: Any) -> tuple[Parts, MadeClip, np.ndarray]:
    """The parts of a dance at 60 frames a second, its clip, and the ways of the roots (N, F), metres."""
    own = {name: options.pop(name) for name in ("delay", "spacing", "mirrored") if name in options}
    wish = {"bpm": TEMPO, "bars": bars, "fps": 60.0, "dancers": {"count": count, "mode": mode, **own}, **options}
    parts = DANCE.run(DANCERS, DanceParameters.model_validate(wish), silent)
    clip = parts["clip"].clip
    assert clip is not None
    roots = clip.translations[:, list(clip.skeleton.roots)]
    return parts, clip, (roots[..., 0] + 1j * roots[..., 2]).T * 0.01


def value_of(parts: Parts, metric: str) -> float:
    return dict(parts["metrics"].data["rows"])[metric]


def texts_of(parts: Parts) -> list[str]:
    return [row[0] for row in parts["warnings"].data["rows"]]


@given(count=st.integers(2, 6), spacing=st.floats(0.5, 10), facing=st.floats(-6, 6))
def test_neighbours_of_a_formation_are_a_spacing_apart(count: int, spacing: float, facing: float) -> None:
    places = form_lines(count, spacing, facing)
    assert abs(places.mean()) < 1e-9
    between = np.abs(places[:, None] - places) + np.diag(np.full(count, np.inf))
    assert between.min(axis=1) == pytest.approx(np.full(count, spacing), rel=1e-9)
    # The direction that they face, to the left of +Z, is square to the lines.
    ahead = (places * np.conj(np.sin(facing) + 1j * np.cos(facing))).real
    assert len(set(np.round(ahead, 6))) == (1 if count <= 3 else 2)


@given(radius=st.floats(0.1, 9), spacing=st.floats(0.5, 3), count=st.integers(2, 6), angle=st.floats(-3, 3))
def test_a_path_in_the_room_keeps_all_on_the_stage(radius: float, spacing: float, count: int, angle: float) -> None:
    places = form_lines(count, spacing, 0.3)
    for stage in (Stage(radius), Stage(None, radius, 2 * radius)):
        room = find_room(stage, places)
        if room is None:
            assert stage.outside(places).max() > -1e-9
        else:
            rim = 99 * np.exp(1j * angle)
            edge = rim - room.beyond(np.array([rim]))
            assert stage.outside(edge + places).max() < 1e-9


@fuzz.examples(6)
@given(count=st.integers(2, 6), spacing=st.floats(0.6, 2.0), staged=st.booleans())
def test_in_unison_all_keep_their_spacing(count: int, spacing: float, staged: bool) -> None:
    parts, clip, ways = make_group(count, bars=8, spacing=spacing, **({"stage": 6.0} if staged else {}))
    assert clip.rotations.shape[1] == count * JOINTS
    between = ways - ways[0]
    assert np.abs(between - between[:, :1]).max() < 1e-9
    assert value_of(parts, "least_distance") == pytest.approx(spacing, abs=1e-9)
    for body in range(1, count):
        own = slice(body * JOINTS, (body + 1) * JOINTS)
        assert np.array_equal(clip.rotations[:, own], clip.rotations[:, :JOINTS])
    if staged:
        assert value_of(parts, "outside_stage") == Stage(6.0).outside(ways).max() == 0


@pytest.mark.slow
@fuzz.examples(6)
@given(count=st.integers(2, 4), delay=st.integers(1, 3), staged=st.booleans())
def test_in_canon_each_dances_like_the_first_some_bars_later(count: int, delay: int, staged: bool) -> None:
    """At 120 a minute and 60 frames a second a bar has 120 frames."""
    parts, clip, ways = make_group(count, "canon", bars=16, delay=delay, **({"stage": 6.0} if staged else {}))
    frames = len(clip.rotations)
    assert frames == 16 * 120
    moved = clip.translations[:, :JOINTS].copy()
    moved[:, 0, [0, 2]] -= moved[0, 0, [0, 2]]
    for body in range(1, count):
        own = slice(body * JOINTS, (body + 1) * JOINTS)
        late = delay * body * 120
        there = np.maximum(np.arange(frames) - late, 0)
        assert np.abs(clip.rotations[:, own] - clip.rotations[there, :JOINTS]).max() < 1e-9
        mine = clip.translations[:, own].copy()
        mine[:, 0, [0, 2]] -= mine[0, 0, [0, 2]]
        assert np.abs(mine - moved[there]).max() < 1e-9
    assert np.ptp(clip.rotations[-120 * delay * (count - 1) :, :JOINTS], axis=0).max() < 1e-9
    starts = [row[1] for row in parts["dancers"].data["rows"]]
    assert starts == pytest.approx([2 * delay * body for body in range(count)])
    assert find_nearest(ways)[0] == pytest.approx(value_of(parts, "least_distance"))


def test_a_mirrored_neighbour_exchanges_left_and_right() -> None:
    _, clip, ways = make_group(2, mirrored=True)
    first, second = ways - ways[:, :1]
    assert np.abs(second - (-first.real + 1j * first.imag)).max() < 1e-9
    places, _ = walked(clip.skeleton, clip.translations, clip.rotations)
    one, two = places[:, :JOINTS], places[:, JOINTS:][:, partners(DANCERS[0].skeleton)]
    middle = (one[0, 0, 0] + two[0, 0, 0]) / 2
    assert np.abs(one[..., 0] + two[..., 0] - 2 * middle).max() < 1e-6
    assert np.abs(one[..., 1:] - two[..., 1:]).max() < 1e-6


@pytest.mark.slow
@fuzz.examples(5)
@given(
    count=st.integers(2, 4), seed=st.integers(0, 99), stage=st.sampled_from([None, 3.0, {"width": 5.0, "depth": 4.0}])
)
def test_dancers_on_own_paths_never_touch(count: int, seed: int, stage: Any) -> None:
    parts, _, ways = make_group(count, "free", bars=24, seed=seed, stage=stage)
    least, frame, _ = find_nearest(ways)
    assert least >= stages.NEAR
    assert least == pytest.approx(value_of(parts, "least_distance"))
    assert frame / 60 == pytest.approx(value_of(parts, "least_distance_at"))
    paths = np.array([row[-1] for row in parts["dancers"].data["rows"]])
    assert all((paths[one] != paths[other]).mean() > 0.5 for one in range(count) for other in range(one))


@pytest.mark.slow
def test_the_search_for_own_paths_keeps_dancers_apart() -> None:
    """Dancers in canon do not look at each other."""
    ways = [make_group(2, mode, bars=40, spacing=0.6, stage=2.0)[2] for mode in ("canon", "free")]
    assert find_nearest(ways[0])[0] < stages.NEAR <= find_nearest(ways[1])[0]


def test_dancers_that_touch_are_told() -> None:
    parts, _, ways = make_group(2, "canon", bars=40, spacing=0.6, stage=2.0)
    least, frame, _ = find_nearest(ways)
    assert any(
        text.startswith(f"Dancers 1 and 2 come within {least:.2f} m of each other at {frame / 60:.1f} s.")
        for text in texts_of(parts)
    )


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"count": 4, "mode": "canon", "delay": 8}, "canon-too-long"),
        ({"count": 6, "stage": 1.0}, "stage-too-small"),
    ],
)
def test_groups_that_cannot_be_are_refused(options: dict[str, Any], code: str) -> None:
    with pytest.raises(AnalysisError) as refused:
        make_group(**options)
    assert refused.value.code == code
    assert refused.value.remedy


def test_one_dancer_is_as_before() -> None:
    parameters = DanceParameters.model_validate({"bpm": TEMPO, "bars": 8})
    parts = DANCE.run(DANCERS, parameters, silent)
    assert parts["clip"].clip is not None
    assert parts["clip"].clip.skeleton == DANCERS[0].skeleton
    assert not {"dancers", "places"} & set(parts)
    assert "least_distance" not in dict(parts["metrics"].data["rows"])
