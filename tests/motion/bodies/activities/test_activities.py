"""Activities of bodies whose courses are made to be just that, of noise, and of real clips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mcml
from mcml.errors import RequestError
from mcml.motion.bodies.activities.activity import ACTIVITIES, Activity
from mcml.motion.bodies.activities.recognition import find_frames, find_unknown, recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.bodies.clip_body import ClipBody
from mcml.motion.bodies.positions import UNSEEN
from mcml.motion.skeleton import Array
from tests.motion.bodies.activities.puppet import ANKLE, HALF_HIPS, Puppet, still, walking, with_hand

BODIES = given(
    rate=st.sampled_from([24.0, 30.0, 60.0, 120.0, 240.0]),
    size=st.floats(0.4, 900.0),
    heading=st.floats(-3.0, 3.0),
)
"""The same motion at any rate, of any size, in any direction."""


def activities_in(body: ClipBody) -> Sequence[Activity]:
    return recognize_activities(body.stretch(JOINTS))


def names(body: ClipBody) -> set[str]:
    return {one.name for one in activities_in(body)}


@BODIES
def test_a_walk(rate: float, size: float, heading: float) -> None:
    found = activities_in(walking().body(5.0, rate, size, heading))
    assert {one.name for one in found} == {"walk"}
    (walk,) = found
    assert walk.steps == pytest.approx(10, abs=1)
    assert (walk.last - walk.first + 1) / rate == pytest.approx(5.0, abs=0.3)


@BODIES
def test_a_walk_on_a_treadmill(rate: float, size: float, heading: float) -> None:
    assert names(walking(in_place=True).body(5.0, rate, size, heading)) == {"walk"}


@BODIES
def test_a_walk_in_a_curve_turns(rate: float, size: float, heading: float) -> None:
    for curve, name in ((0.9, "turn left"), (-0.9, "turn right")):
        found = {one.name: one for one in activities_in(walking(curve=curve).body(3.0, rate, size, heading))}
        assert set(found) == {"walk", name}
        assert found[name].degrees == pytest.approx(np.degrees(0.9 * 3.0), rel=0.05)


def test_a_slow_curve_is_no_turn() -> None:
    assert names(walking(curve=0.2).body(6.0)) == {"walk"}


def test_a_twist_on_standing_feet_is_no_turn() -> None:
    twist = Puppet(turn=lambda times: np.radians(60) * np.sin(np.clip(times - 1, 0, 1) * np.pi / 2))
    body = twist.body(3.0)
    stretch = body.stretch(JOINTS)
    # The puppet's feet turn with it; hold them.
    places = {
        name: np.repeat(steps[:1], len(steps), axis=0) if name.endswith(("_foot", "_toes")) else steps
        for name, steps in stretch.places.items()
    }
    assert "turn left" in {one.name for one in recognize_activities(stretch)}
    assert not any("turn" in one.name for one in recognize_activities(replace(stretch, places=places)))


def hopping(height: float) -> Puppet:
    """Stands, bends its knees, flies, lands. height: of the jump, in leg lengths."""
    gravity = 9.81 / 0.85
    flight = 2 * np.sqrt(2 * height / gravity)

    def lift(times: Array) -> Array:
        within = times - 1.5
        rise = np.sqrt(2 * height * gravity) * within - gravity * within**2 / 2
        return np.where((within > 0) & (within < flight), rise, 0.0)

    def hips(times: Array) -> Array:
        crouch = 0.2 * (np.exp(-(((times - 1.25) / 0.12) ** 2)) + np.exp(-(((times - 1.75 - flight) / 0.12) ** 2)))
        return np.stack([0 * times, ANKLE + 0.98 - crouch + lift(times), 0 * times], axis=1)

    def ankle(sign: float):
        return lambda times: np.stack([0 * times + sign * HALF_HIPS, ANKLE + lift(times), 0 * times], axis=1)

    return Puppet(hips, {"left": ankle(1.0), "right": ankle(-1.0)})


@BODIES
def test_a_jump(rate: float, size: float, heading: float) -> None:
    found = activities_in(hopping(0.4).body(4.0, rate, size, heading))
    jumps = [one for one in found if one.name == "jump"]
    assert len(jumps) == 1
    assert jumps[0].first / rate == pytest.approx(1.25, abs=0.15)
    assert not {one.name for one in found} & {"walk", "run", "turn left", "left kick"}


def test_standing_on_the_toes_and_being_lifted_is_no_jump() -> None:
    assert "jump" not in names(hopping(0.02).body(4.0))
    lift = lambda times: 0.5 * np.sin(np.clip((times - 1) / 2, 0, 1) * np.pi)  # noqa: E731 - one term
    lifted = Puppet(
        lambda times: np.stack([0 * times, ANKLE + 0.98 + lift(times), 0 * times], axis=1),
        {
            side: lambda times, sign=sign: np.stack([0 * times + sign * HALF_HIPS, ANKLE + lift(times), 0 * times], 1)
            for side, sign in (("left", 1.0), ("right", -1.0))
        },
    )
    assert "jump" not in names(lifted.body(4.0))


@pytest.mark.slow
@BODIES
def test_postures(rate: float, size: float, heading: float) -> None:
    feet = {"left": still(HALF_HIPS, ANKLE, 0.5), "right": still(-HALF_HIPS, ANKLE, 0.5)}
    postures = {
        "stand": Puppet(),
        "sit": Puppet(still(0, ANKLE + 0.5, 0), feet),
        "crouch": Puppet(still(0, ANKLE + 0.45, -0.05)),
    }
    for name, puppet in postures.items():
        # The leg is measured where it is straight: one clip holds standing as well.
        assert names(puppet.body(3.0, rate, size, heading)) == {name}, name


def test_lying() -> None:
    feet = {"left": still(HALF_HIPS, 0.1, 0.95), "right": still(-HALF_HIPS, 0.1, 0.95)}
    flat = Puppet(still(0, 0.15, 0), feet, lean=lambda times: np.full_like(times, -np.pi / 2))
    assert names(flat.body(3.0)) == {"lie"}


@BODIES
def test_a_kick(rate: float, size: float, heading: float) -> None:
    def ankle(times: Array) -> Array:
        angle = np.radians(75) * np.exp(-(((times - 1.5) / 0.15) ** 2))
        hip = np.array([-HALF_HIPS, ANKLE + 0.99, 0.0])
        return hip + 0.99 * np.stack([0 * times, -np.cos(angle), np.sin(angle)], axis=1)

    kick = replace(Puppet(), ankles={"left": still(HALF_HIPS, ANKLE, 0), "right": ankle})
    assert names(kick.body(3.0, rate, size, heading)) - {"stand"} == {"right kick"}


def move_hand(start: Array, end: Array, begin: float, seconds: float):
    def course(times: Array) -> Array:
        part = np.clip((times - begin) / seconds, 0, 1)[:, None]
        smooth = part**3 * (10 - 15 * part + 6 * part**2)
        return start + (end - start) * smooth

    return course


@BODIES
def test_hands(rate: float, size: float, heading: float) -> None:
    rest, out, high = np.array([0.02, -0.63, 0.02]), np.array([0.1, 0.0, 0.6]), np.array([0.05, 0.62, 0.05])
    for side in ("left", "right"):
        reach = with_hand(Puppet(), side, move_hand(rest, out, 0.5, 0.9))
        assert names(reach.body(3.0, rate, size, heading)) - {"stand"} == {f"{side} reach"}
        raised = with_hand(Puppet(), side, move_hand(rest, high, 0.5, 0.9))
        assert names(raised.body(3.0, rate, size, heading)) - {"stand"} == {f"raise {side} hand"}

        def wave(times: Array) -> Array:
            swing = 0.18 * np.sin(2 * np.pi * 1.6 * times)
            return np.stack([0.2 + swing, 0.25 + 0 * times, 0.3 + 0 * times], axis=1)

        assert names(with_hand(Puppet(), side, wave).body(3.0, rate, size, heading)) - {"stand"} == {f"{side} wave"}


def test_arms_that_swing_in_a_walk_do_nothing_else() -> None:
    puppet = walking()
    for side, sign in (("left", 1.0), ("right", -1.0)):

        def swing(times: Array, sign: float = sign) -> Array:
            angle = np.radians(45) * sign * np.sin(2 * np.pi * times)
            return 0.63 * np.stack([0 * times, -np.cos(angle), np.sin(angle)], axis=1)

        puppet = with_hand(puppet, side, swing)
    assert names(puppet.body(5.0)) == {"walk"}


@given(
    seed=st.integers(0, 2**32 - 1),
    frames=st.integers(0, 400),
    rate=st.sampled_from([1.0, 30.0, 120.0, 1000.0]),
    size=st.sampled_from([0.0, 1e-6, 1.0, 1e6]),
    missing=st.sampled_from([0.0, 0.1, 0.9, 1.0]),
)
def test_noise_and_gaps_raise_nothing(seed: int, frames: int, rate: float, size: float, missing: float) -> None:
    rng = np.random.default_rng(seed)
    body = walking().body(max(frames, 3) / rate, rate)
    stretch = body.stretch(JOINTS)
    places = {}
    for name, steps in stretch.places.items():
        noisy = (steps + rng.normal(0, size, steps.shape)).astype(steps.dtype)
        noisy[rng.random(len(steps)) < missing] = UNSEEN
        places[name] = noisy
    found = recognize_activities(replace(stretch, places=places))
    for one in found:
        assert one.name in ACTIVITIES
        assert 0 <= one.first <= one.last < stretch.frames
        assert 0.5 <= one.confidence <= 1
        assert (one.degrees is None) == (not one.name.startswith("turn"))
        assert (one.steps is None) == (one.name not in ("walk", "run", "step"))
    for name in ("walk", "turn", "wave"):
        flags = find_frames(replace(stretch, places=places), name)
        assert np.isin(flags[np.isfinite(flags)], [0, 1]).all()


def test_gaps_hide_only_their_frames() -> None:
    stretch = walking().body(6.0, 60.0).stretch(JOINTS)
    gap = slice(150, 156)
    places = {}
    for name, steps in stretch.places.items():
        holed = steps.copy()
        holed[gap] = UNSEEN
        places[name] = holed
    holed_stretch = replace(stretch, places=places)
    flags = find_frames(holed_stretch, "walk")
    assert np.isnan(flags[gap]).all()
    assert flags[np.isfinite(flags)].mean() > 0.9


def test_what_is_unknown_is_said() -> None:
    stretch = walking().body(4.0).stretch(JOINTS)
    assert find_unknown(stretch) == []
    for changed, what in (
        (replace(stretch, frame_time=None), "frame time"),
        (replace(stretch, places={}), "left_up_leg"),
        (replace(stretch, calibration=replace(stretch.calibration, leg=None)), "length of the leg"),
    ):
        assert what in find_unknown(changed)[0]
        assert recognize_activities(changed) == ()
        assert np.isnan(find_frames(changed, "walk")).all()
    armless = {name: steps for name, steps in stretch.places.items() if not name.endswith(("_arm", "_hand"))}
    without = replace(stretch, places=armless)
    assert "left_up_arm" in find_unknown(without)[0]
    assert (find_frames(without, "walk") == 1).any()
    assert np.isnan(find_frames(without, "wave")).all()


def test_unknown_names_are_refused_with_the_known_ones() -> None:
    with pytest.raises(RequestError, match="no activity") as error:
        find_frames(walking().body(1.0).stretch(JOINTS), "hop")
    assert "turn left" in (error.value.remedy or "")


REAL = {
    "asfamc/cmu16/16_15.amc": {"walk"},
    "asfamc/cmu16/16_16.amc": {"walk"},
    "asfamc/cmu16/16_17.amc": {"walk", "turn left"},
    "asfamc/cmu16/16_18.amc": {"walk", "turn left"},
    "asfamc/cmu16/16_12.amc": {"walk", "turn left"},
    "asfamc/cmu16/16_13.amc": {"walk", "turn right"},
    "asfamc/cmu16/16_14.amc": {"walk", "turn right"},
    "asfamc/cmu16/run_veer_left_16_38.amc": {"run", "turn left"},
    "asfamc/cmu16/run_veer_left_16_48.amc": {"run", "turn left"},
    "asfamc/cmu16/run_veer_right_16_49.amc": {"run", "turn right"},
    "asfamc/cmu_misc/07_05-walk.amc": {"walk"},
    "asfamc/cmu_misc/09_06-run.amc": {"run"},
    "asfamc/hdm05_reach/HDM_bd_grabHighR_001_120.amc": {"raise right hand", "stand"},
    "asfamc/hdm05_reach/HDM_bd_depositFloorR_001_120.amc": {"right reach", "crouch"},
}
"""Clips of the CMU database and of HDM05 whose index or name says what they show: of subject 16, 12 walks and veers
left, 13 and 14 veer right, 17 and 18 turn left by 90 degrees."""


@pytest.mark.parametrize("name", REAL)
def test_real_clips_by_their_index(shared: Path, name: str) -> None:
    assert {one.name for one in activities_of(shared / name)} == REAL[name]


def test_turns_have_their_angles(shared: Path) -> None:
    for name in ("16_17", "16_18"):
        found = activities_of(shared / f"asfamc/cmu16/{name}.amc")
        assert [one.degrees for one in found if one.degrees] == [pytest.approx(90, abs=8)]


def test_real_clips_by_their_names(shared: Path) -> None:
    """Bandai-Namco-Research-Motiondataset: walks, runs, bows and goodbyes in six styles."""
    files = sorted((shared / "bvh/bandai").glob("*.bvh"))
    assert len(files) == 24
    for path in files:
        content = path.name.split("_")[1]
        found = {one.name for one in activities_of(path)}
        assert ("walk" in found) == (content == "walk"), path.name
        assert ("run" in found) == (content == "run"), path.name
        assert not any(name.startswith("turn") for name in found), path.name


def activities_of(path: Path) -> Sequence[Activity]:
    if path.suffix == ".bvh":
        return mcml.read(path).activities()
    (skeleton,) = [one for one in path.parent.glob("*.asf") if path.name.startswith(one.stem.partition("-")[0])] or [
        path.with_name("16.asf")
    ]
    return mcml.read([skeleton, path], frame_time="1/120").activities()
