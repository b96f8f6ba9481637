"""What is guessed of a clip that says little, and that people can say otherwise."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from service.errors import RequestError
from service.motion.bodies.calibration import Calibration, calibrate, calibration_frames
from service.motion.clip import ClipHead
from service.motion.skeleton import Convention, Joint, Skeleton
from tests.motion.bodies.made import clip_of, person, positions_of, stretch_of

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
    assert chosen[:12].tolist() == list(range(12))
    assert chosen[-1] == 99_999
    assert 5000 <= len(chosen) <= 5012
    assert (np.diff(chosen)[12:] <= 21).all()


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
