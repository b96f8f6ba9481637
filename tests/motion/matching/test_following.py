"""Motion matching: tracks, features, the search, and bodies that follow paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FolderPath

import numpy as np
import pytest

import mcml
from mcml.motion.bodies.clip_body import body_of
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.resizing import turn_up
from mcml.motion.matching.following import MEMORY, SHORTEST, Followed, follow
from mcml.motion.matching.library import TAIL, WIDTH, MatchingLibrary, features_of, turn
from mcml.motion.matching.paths import Path
from mcml.motion.matching.tracks import JOINTS, RATE, track_of
from mcml.motion.skeleton import Array
from tests.motion.matching.curved_walks import curved_walk, track_of_clip, with_names

TURNS = (0.0, 45.0, -45.0, 90.0, -90.0)
CIRCLE = np.array([[2 * np.sin(a), 2 - 2 * np.cos(a)] for a in np.linspace(0, 2 * np.pi, 60)])
PATHS = {
    "straight": np.array([[0.0, 0.0], [8.0, 0.0]]),
    "corners": np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]),
    "left circle": CIRCLE,
    "right circle": CIRCLE * [1, -1],
    "crossing": np.array([[3 * np.sin(a), 1.5 * np.sin(2 * a)] for a in np.linspace(0, 2 * np.pi, 100)]),
}


@pytest.fixture(scope="module")
def library() -> MatchingLibrary:
    clips = [curved_walk(turn, heading=37 * index, away=50 * index) for index, turn in enumerate(TURNS)]
    return MatchingLibrary.of([track_of_clip(clip) for clip in clips])


def test_a_track_is_the_way_of_the_body() -> None:
    track = track_of_clip(curved_walk(30.0, heading=90.0, away=200.0))
    # Ground coordinates are z and x: heading 90 degrees is along x, the second one.
    assert track.place[0] == pytest.approx([0.0, 2.0], abs=0.03)
    assert np.degrees(track.facing[0]) == pytest.approx(90, abs=1)
    assert np.degrees(track.facing[-1] - track.facing[0]) == pytest.approx(30 * (len(track) - 1) / RATE, abs=1)
    speeds = np.linalg.norm(np.diff(track.place, axis=0), axis=1) * RATE
    assert np.median(speeds) == pytest.approx(0.75 * 1.70, rel=0.02)
    assert track.known.all()
    assert (track.feet[:, :, 2].min(axis=0) > -0.02).all()
    assert (track.feet[:, :, 2].max() < 0.6).all()


@pytest.mark.parametrize("up", ["X", "Z"])
def test_another_axis_up_changes_nothing(up: str) -> None:
    clip = curved_walk(40.0, heading=20.0)
    stated = clip.with_head(replace(clip.head, fields={**clip.head.fields, "global_axis_of_gravity": "Y"}))
    plain, turned = track_of_clip(stated), track_of_clip(turn_up(stated, "Y", up))
    assert plain.facing - plain.facing[0] == pytest.approx(turned.facing - turned.facing[0], abs=1e-3)
    assert features_of(turned) == pytest.approx(features_of(plain), abs=2e-3)


def test_features_do_not_depend_on_place_and_heading() -> None:
    one, two = (features_of(track_of_clip(curved_walk(25.0, heading=h, away=a))) for h, a in ((0, 0), (130, 900)))
    assert one.shape[1] == WIDTH
    assert two == pytest.approx(one, abs=5e-3)


def test_clips_of_other_rates_have_the_same_features() -> None:
    clip = curved_walk(25.0, seconds=4.0)
    blocks = list(clip.blocks())
    assert len(blocks) == 1
    half = replace(blocks[0], values=blocks[0].values[::2], ids=blocks[0].ids[::2])
    slow = ClipStream(replace(clip.head, frame_time=repr(2 / 60)), lambda: iter([half]), len(half.values))
    one, two = features_of(track_of_clip(clip)), features_of(track_of_clip(slow))
    assert len(two) == pytest.approx(len(one), abs=1)
    assert two[:100] == pytest.approx(one[:100], abs=0.02)


def test_what_has_no_track() -> None:
    clip = with_names(curved_walk(0.0, seconds=1.0))
    stretch = body_of(clip.head, clip.blocks()).stretch(JOINTS)
    assert track_of(replace(stretch, frame_time=None)) is None
    assert track_of(replace(stretch, places={})) is None
    assert track_of(replace(stretch, calibration=replace(stretch.calibration, metres=None))) is None
    with pytest.raises(ValueError, match="long"):
        MatchingLibrary.of([track_of_clip(curved_walk(0.0, seconds=0.2))])


def test_the_nearest_row_is_that_of_brute_force(library: MatchingLibrary) -> None:
    rng = np.random.default_rng(4)
    rows = np.flatnonzero(library.targets)
    for _ in range(50):
        query = library.features[rng.choice(rows)] + rng.normal(0, 0.3, WIDTH)
        apart = np.linalg.norm(library.features[rows].astype(np.float64) - query, axis=1)
        row, distance = library.nearest(query)
        assert distance == pytest.approx(apart.min(), rel=1e-5)
        assert apart[np.flatnonzero(rows == row)[0]] == pytest.approx(apart.min(), rel=1e-5)
        other, farther = library.nearest(query, {row})
        assert other != row
        assert farther == pytest.approx(np.sort(apart)[1], rel=1e-5)


@pytest.mark.parametrize("name", PATHS)
def test_a_body_follows_a_path(library: MatchingLibrary, name: str) -> None:
    path = Path.through(PATHS[name])
    made = follow(library, path, speed=1.2)
    assert made.complete
    assert made.way == pytest.approx(path.length, abs=0.8)
    assert made.distances.mean() < 0.15
    assert made.distances.max() < 0.5
    assert len(made.places) / RATE == pytest.approx(path.length / 1.2, rel=0.2)
    assert_sound(library, made)


def assert_sound(library: MatchingLibrary, made: Followed) -> None:
    """Runs play rows of their clips one after the other, and lie where the body was."""
    at = 0
    for run in made.runs:
        track = library.tracks[run.clip]
        assert 0 <= run.first <= run.last + 1 <= len(track)
        rows = track.place[run.first : run.last + 1]
        assert turn(rows, run.angle) + run.shift == pytest.approx(made.places[at : at + len(rows)], abs=1e-9)
        at += len(rows)
    assert at == len(made.places)
    steps = np.linalg.norm(np.diff(made.places, axis=0), axis=1) * RATE
    assert steps.max() < 2.5
    for run in made.runs[1:-1]:
        track = library.tracks[run.clip]
        assert run.last - run.first + 1 >= SHORTEST or run.last == len(track) - 1
        assert run.first <= len(track) - TAIL
    _assert_no_repeats(library, made)


def _assert_no_repeats(library: MatchingLibrary, made: Followed) -> None:
    rows = np.concatenate([library.starts[run.clip] + np.arange(run.first, run.last + 1) for run in made.runs])
    for cut in np.cumsum([run.last - run.first + 1 for run in made.runs[:-1]]):
        assert rows[cut] - 1 not in rows[max(0, cut - MEMORY) : cut]


def test_without_turns_in_the_clips_the_body_is_steered() -> None:
    straight = MatchingLibrary.of([track_of_clip(curved_walk(0.0, seconds=8.0))])
    path = Path.through(CIRCLE)
    free, held = (follow(straight, path, speed=1.2, steering=np.radians(angle)) for angle in (20, 0))
    assert free.distances.mean() < 0.5 < held.distances.mean()
    assert not held.complete or held.distances.max() > 1.0


def test_facing_beside_the_course() -> None:
    """A body that walks sideways is found where clips walk sideways."""
    forward, aside = curved_walk(0.0), curved_walk(0.0)
    track = track_of_clip(aside)
    sideways = replace(track, facing=track.facing + np.pi / 2)
    library = MatchingLibrary.of([track_of_clip(forward), sideways])
    path = Path.through(PATHS["straight"])
    for facing, clip in ((0.0, 0), (np.pi / 2, 1)):
        made = follow(library, path, speed=1.2, facing=facing)
        assert {run.clip for run in made.runs} == {clip}


def test_paths() -> None:
    path = Path.through(np.array([[0, 0], [0, 0], [3, 0], [3, 4]], float))
    assert path.length == pytest.approx(7, abs=0.2)
    places, directions = path.at(np.array([0.0, 1.0, 5.0, 99.0]))
    assert places[[0, 3]] == pytest.approx(np.array([[0, 0], [3, 4]]), abs=1e-9)
    assert directions == pytest.approx([0, 0, np.pi / 2, np.pi / 2], abs=0.01)
    way, distance = path.progress(np.array([1.0, 0.5]), 0.0)
    assert (way, distance) == pytest.approx((1.0, 0.5), abs=0.02)
    assert path.progress(np.array([0.0, 0.0]), 2.0)[0] >= 2.0
    with pytest.raises(ValueError, match="two places"):
        Path.through(np.zeros((3, 2)))


@pytest.mark.parametrize("seed", range(6))
def test_random_paths(library: MatchingLibrary, seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = np.cumsum(rng.uniform(-1.0, 1.0, 8))
    points: Array = np.cumsum(np.stack([np.cos(turns), np.sin(turns)], axis=1) * rng.uniform(1, 3, (8, 1)), axis=0)
    made = follow(library, Path.through(points), speed=float(rng.uniform(1.0, 1.4)))
    assert made.complete
    assert made.distances.mean() < 0.3
    assert_sound(library, made)


def test_real_walks(shared: FolderPath) -> None:
    """Straight walks and runs of one person go round both ways: cuts steer."""
    files = sorted((shared / "bvh" / "bandai").glob("*_walk_*.bvh")) + sorted(
        (shared / "bvh" / "bandai").glob("*_run_*.bvh")
    )
    assert len(files) == 12
    tracks = [track_of(mcml.read(file)._body.stretch(JOINTS)) for file in files]  # what it is made of
    library = MatchingLibrary.of([track for track in tracks if track is not None])
    assert len(library.tracks) == 12
    for name in ("left circle", "right circle", "corners"):
        path = Path.through(PATHS[name] * 1.5)
        made = follow(library, path, speed=library.usual_speed)
        assert made.complete
        assert made.distances.mean() < 0.4, name
        assert_sound(library, made)
