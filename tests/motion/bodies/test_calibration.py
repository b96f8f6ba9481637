"""What is guessed of a clip that says little, and that people can say otherwise."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import RequestError
from mcml.motion.bodies.calibration import Calibration, calibrate, calibration_frames
from mcml.motion.bodies.positions import rounded
from mcml.motion.bodies.quantities import compute
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.clip import ClipHead
from mcml.motion.guesses import changed_up, likely_up, up_of_head
from mcml.motion.markers import marker_skeleton
from mcml.motion.skeleton import Convention, Joint, Skeleton
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, named, person, positions_of, stretch_of

LEG = np.hypot(42, 1) + np.hypot(41, 1)


@pytest.fixture(scope="module")
def head() -> ClipHead:
    return clip_of(person(3, 40)).head


@pytest.fixture(scope="module")
def positions() -> np.ndarray:
    found = positions_of(clip_of(person(3, 40)))
    found.setflags(write=False)
    return found


@pytest.mark.parametrize(
    ("scale", "metres", "reason"),
    [
        (1.0, 0.01, "a leg of 83.02 is 0.83 m in cm"),
        (10.0, 0.001, "a leg of 830.2 is 0.83 m in mm"),
        (0.01, 1.0, "a leg of 0.8302 is 0.83 m in m"),
        (1 / 2.54, 0.0254, "a leg of 32.69 is 0.83 m in inch"),
        (0.45 / 2.54, 0.0254 / 0.45, "a leg of 14.71 is 0.83 m in inch/0.45"),
        (7.0, None, "the file states none, and a leg of 581.2 fits no unit"),
    ],
)
def test_the_leg_tells_the_unit(scale: float, metres: float | None, reason: str) -> None:
    calibration = stretch_of(clip_of(person(3, 5, scale=scale))).calibration
    assert calibration.metres == metres
    assert calibration.origins["metres"].reason == reason
    assert calibration.origins["metres"].kind == ("unknown" if metres is None else "guessed")
    assert calibration.leg == pytest.approx(LEG * scale, abs=1e-4)
    assert calibration.step == (calibration.leg / 10_000 if metres is None else 1e-4 / metres)
    assert np.isnan(calibration.metres_per_step) == (metres is None)


def test_what_the_file_states_counts(head: ClipHead, positions: np.ndarray) -> None:
    fields = {"calibration_unit": "mm", "global_axis_of_gravity": "z"}
    found = calibrate(replace(head, fields=fields), positions)
    assert (found.metres, found.up) == (0.001, "Z")
    assert {found.origins[name].kind for name in ("metres", "up")} == {"stated"}
    assert found.origins["floor"].kind == "guessed", "it is never stated"
    assert calibrate(replace(head, fields={"units_length": "4"}), positions * 0.4 * 4).metres == 0.0254 / 4
    assert calibrate(replace(head, fields={"units_length": "none"}), positions).metres == 0.01


@pytest.mark.parametrize(("turn", "up"), [(0, "Y"), (1, "Z"), (2, "X")])
def test_up_is_where_the_head_is(head: ClipHead, positions: np.ndarray, turn: int, up: str) -> None:
    found = calibrate(head, np.roll(positions, turn, axis=2))
    assert found.up == up
    assert found.floor == pytest.approx(np.percentile(positions[:, _toes(head), 1], 5))
    assert calibrate(head, -np.roll(positions, turn, axis=2)).up == f"-{up}"


def _toes(head: ClipHead) -> list[int]:
    return [index for index, name in enumerate(head.skeleton.names) if name.endswith("_toes")]


def test_a_pose_before_the_motion_is_left_out(head: ClipHead, positions: np.ndarray) -> None:
    assert not calibrate(head, positions).leaps
    before = positions.copy()
    before[0] -= [0, 300, 0]
    found = calibrate(head, before)
    assert found.leaps
    assert "before the motion" in found.origins["leaps"].reason
    assert found.floor == calibrate(head, positions[1:]).floor
    assert not calibrate(head, before, {"leaps": False}).leaps
    # Of a sample, only one that begins with the clip shows it.
    assert not calibrate(head, before, frames=np.arange(len(before)) + 5).leaps


@pytest.mark.parametrize("frames", [1, 2, 5, 9])
def test_a_pose_that_is_blended_into_the_motion_is_left_out(head: ClipHead, positions: np.ndarray, frames: int) -> None:
    """With arms held out, in so many frames, straight or gently; the fastest hand is not in them."""
    still = np.repeat(positions[:1], 40, axis=0) + np.linspace(0, 1, 40)[:, None, None]
    pose = positions[0].copy()
    for side in ("left", "right"):
        at = [head.skeleton.names.index(f"{side}_{part}") for part in ("up_arm", "low_arm", "hand")]
        other = head.skeleton.names.index(f"{'right' if side == 'left' else 'left'}_up_arm")
        across = pose[at[0]] - pose[other]
        across = across / np.linalg.norm(across)
        for place, reach in zip(at[1:], (28.0, 53.0), strict=True):
            pose[place] = pose[at[0]] + reach * across
    for share in (np.linspace(0, 1, frames + 1), 0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, frames + 1))):
        clip = still.copy()
        clip[: frames + 1] = pose + share[:, None, None] * (still[: frames + 1] - pose)
        found = calibrate(head, clip)
        # Of a gentle blend the last steps are none that anybody would tell.
        assert found.leaps
        assert max(1, frames - 2) <= found.skipped <= frames + 2
        steps = rounded(clip, found.step)
        places = {joint.name: steps[:, index] for index, joint in enumerate(head.skeleton.joints)}
        speeds = compute("speed", ("left_hand",), Stretch(places, len(steps), 1 / 60, found))
        assert np.nanmax(speeds) < 12
        assert np.isnan(speeds[: found.skipped]).all()
        assert calibrate(head, clip, {"leaps": False}).skipped == 0
    # A quick start out of any other pose is motion.
    quick = still.copy()
    quick[:5, head.skeleton.names.index("left_hand")] += np.linspace(60, 0, 5)[:, None]
    assert not calibrate(replace(head, frame_time="0.0333"), quick).leaps


@pytest.mark.parametrize(("name", "skipped"), [("dance/61_10_scaled", 7), ("exporters/cmu_daz_walk", 7)])
def test_real_poses_that_are_blended_in(shared: Path, name: str, skipped: int) -> None:
    clip = named(opened(shared / f"bvh/{name}.bvh"))
    positions = positions_of(clip)
    found = calibrate(clip.head, positions)
    assert found.skipped == skipped
    stretch = stretch_of(clip, found)
    hand = compute("speed", ("left_hand",), stretch)
    moved = np.linalg.norm(np.diff(positions[:, clip.head.skeleton.names.index("left_hand")], axis=0), axis=1)
    assert int(np.argmax(moved)) < skipped
    assert int(np.nanargmax(hand)) > 20 + skipped


def _walkers(rng: np.random.Generator, names: tuple[str, ...], heights: dict[str, float]) -> np.ndarray:
    """Points of somebody of 1.7 m who goes 6 m along X, with Z up."""
    time = np.linspace(0, 1, 120)
    places = np.array([[rng.uniform(-0.2, 0.2), rng.uniform(-0.25, 0.25), heights[name]] for name in names])
    moved = np.stack([6 * time, 0.1 * np.sin(9 * time), 0.02 * np.sin(30 * time)], axis=1)
    return places + moved[:, None]


@pytest.mark.parametrize("turn", [0, 1, 2])
@pytest.mark.parametrize("known", ["LFHD RFHD LHEE RHEE", "head1 c7 L.Ankle R.Ankle", "LASI RASI LTOE RTOE", "a b c d"])
def test_walkways_are_not_up(turn: int, known: str) -> None:
    names = tuple(known.split())
    heights = dict(zip(names, (1.7, 1.6, 0.05, 0.1), strict=True))
    places = np.roll(_walkers(np.random.default_rng(turn), names, heights), turn, axis=2)
    skeleton = marker_skeleton(list(names))
    # Points that are seen one after the other make a walkway of the mean pose.
    for place in range(len(names)):
        hidden = np.ones(len(places), bool)
        hidden[30 * place : 30 * place + 40] = False
        places[hidden, place] = np.nan
    found = likely_up(skeleton, places)
    up = "ZXY"[turn]
    if known != "a b c d":
        assert (found.axis, found.sure) == (up, True)
        assert likely_up(skeleton, -places).axis == f"-{up}"
    whole = np.roll(_walkers(np.random.default_rng(turn), names, heights), turn, axis=2)
    assert (likely_up(skeleton, whole).axis, likely_up(skeleton, whole).sure) == (up, True)
    assert not likely_up(marker_skeleton(["p1", "p2"]), whole[0, :2]).sure


UPS = {
    "c3d/body/kinematics_tennis_serve_2players.c3d": "Z", "c3d/body/HDM_dg_06-03_03_120.c3d": "Z",
    "c3d/body/nick_freeform_001.c3d": "Y", "c3d/body/mocap36.c3d": "Z", "trc/init100.trc": "Z",
    "trc/dance/ballet_reduced.trc": "Y", "trc/dataWithBlanksForMissingMarkers.trc": "Z", "trc/walk_free_01.trc": "Y",
    "trc/std_walking2_markers.trc": "Z", "trc/gait10dof18musc_walk_CRLF_line_ending.trc": "Y",
    "c3d/edge/TESTBPI.c3d": "Z", "c3d/edge/badParameterOffset.c3d": "Z", "c3d/edge/bad_parameter_section.c3d": "Z",
    "c3d/edge/duplicate_labels.c3d": "Z", "c3d/edge/shd01.c3d": "Z",
}  # fmt: skip
"""Real trials: what they state, and where they state nothing, what looking at them tells."""


@pytest.mark.parametrize("name", UPS)
def test_up_of_real_trials(shared: Path, name: str) -> None:
    clip = named(opened(shared / name))
    assert up_of_head(clip.head, positions_of(clip)).axis == UPS[name]


def test_it_is_told_where_a_guess_has_changed(shared: Path) -> None:
    changed = named(opened(shared / "trc/std_walking2_markers.trc"))
    positions = positions_of(changed)
    assert changed_up(changed.head, positions) == ("X", "Z")
    assert changed_up(replace(changed.head, fields={"global_axis_of_gravity": "y"}), positions) is None
    same = named(opened(shared / "trc/walk_free_01.trc"))
    assert changed_up(same.head, positions_of(same)) is None
    assert changed_up(same.head, positions_of(same)[:0]) is None


def test_the_reference_pose(head: ClipHead, positions: np.ndarray) -> None:
    assert calibrate(head, positions).reference is None
    lying = Skeleton(tuple(replace(joint, offset=_turned(joint)) for joint in head.skeleton.joints))
    bent = positions.copy()
    bent[:, head.skeleton.names.index("Head"), 1] -= np.linspace(200, 0, len(bent))
    found = calibrate(replace(head, skeleton=lying), bent, {"up": "Y"}, np.arange(len(bent)) * 3)
    assert found.reference is not None
    assert found.reference > 60
    assert found.reference % 3 == 0
    assert calibrate(replace(head, skeleton=lying), bent[:0], {"up": "Y"}).reference is None


def _turned(joint: Joint) -> tuple[str, str, str]:
    assert joint.offset is not None
    x, y, z = joint.offset
    return y, x, z


def test_what_people_set_counts(head: ClipHead, positions: np.ndarray) -> None:
    found = calibrate(head, positions, {"leg": 830.0, "up": "-Z", "floor": 2})
    assert (found.leg, found.up, found.floor, found.metres) == (830.0, "-Z", 2, 0.001)
    assert {found.origins[name].kind for name in ("leg", "up", "floor")} == {"set"}
    assert "guessed" in {found.origins[name].kind for name in ("metres", "up", "floor")}
    known = calibrate(head, positions, {"metres": 1, "up": "Y", "floor": 0})
    assert {known.origins[name].kind for name in ("metres", "up", "floor")} == {"set"}
    assert calibrate(head, positions, {"reference": 4}).reference == 4


@pytest.mark.parametrize(
    "wrong",
    [{"metres": 0}, {"metres": "cm"}, {"leg": -1.0}, {"leg": True}, {"up": "W"}, {"up": 1}, {"floor": float("nan")},
     {"reference": -1}, {"reference": 1.5}, {"leaps": 1}, {"colour": "red"}],
)  # fmt: skip
def test_what_cannot_be_is_refused(head: ClipHead, positions: np.ndarray, wrong: dict[str, object]) -> None:
    with pytest.raises(RequestError, match=next(iter(wrong))):
        calibrate(head, positions, wrong)


def test_long_clips_are_calibrated_on_a_sample() -> None:
    assert calibration_frames(0).tolist() == []
    assert calibration_frames(5000).tolist() == list(range(5000))
    chosen = calibration_frames(100_000)
    assert chosen[:26].tolist() == list(range(26))
    assert chosen[-1] == 99_999
    assert 5000 <= len(chosen) <= 5026
    assert (np.diff(chosen)[26:] <= 21).all()


def test_as_json(head: ClipHead, positions: np.ndarray) -> None:
    for found in (calibrate(head, positions), calibrate(head, positions * 7)):
        assert Calibration.from_json(json.loads(json.dumps(found.to_json()))) == found


def test_without_frames_the_rest_pose_counts(head: ClipHead) -> None:
    found = calibrate(head, np.empty((0, len(head.skeleton), 3)))
    assert found.leg == pytest.approx(LEG)
    assert found.up == "Y"
    assert found.floor == pytest.approx(-4 - 42 - 41 - 7)


def test_points_have_no_leg() -> None:
    markers = Skeleton(tuple(Joint(f"m{n}", -1, f"m{n}", Convention.MARKER, ("Tx", "Ty", "Tz")) for n in range(3)))
    places = np.arange(45, dtype=float).reshape(5, 3, 3)
    places[2, 1] = np.nan
    found = calibrate(ClipHead("c3d", markers), places)
    assert found.leg is None
    assert found.metres is None
    assert found.floor is None
    assert found.step == 42 / 20_000
    assert {found.origins[name].kind for name in ("leg", "metres", "floor")} == {"unknown"}
    nothing = calibrate(ClipHead("c3d", markers), np.full((2, 3, 3), np.nan))
    assert nothing.step == 1e-4
