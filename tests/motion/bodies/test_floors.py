"""Which axis of a marker trial is up, and how high its floor is: of made trials, and of real ones."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.bodies.calibration import Calibration, calibrate
from mcml.motion.bodies.quantities import compute
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart, full_shape
from mcml.motion.conventions.resizing import scale, turn_up
from mcml.motion.floor_plates import (
    SECTION,
    floor_of_plates,
    kept_plates,
    match_plates,
    normal_axis,
    section_of_plates,
    usable_plates,
)
from mcml.motion.guesses import likely_up, told_up
from mcml.motion.markers import marker_skeleton
from mcml.motion.pictures.figures import axis_of
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import named, positions_of, stretch_of

NAMES = ("LFHD", "RFHD", "C7", "CLAV", "LASI", "RASI", "LKNE", "RKNE", "LANK", "RANK", "LHEE", "RHEE", "LTOE", "RTOE")
HEIGHTS = (1700, 1700, 1500, 1400, 1000, 1000, 500, 500, 80, 80, 40, 40, 30, 30)
PLATE = np.array([[[500.0, 300, 0], [500, -300, 0], [-500, -300, 0], [-500, 300, 0]]])
"""At z = 0 of the laboratory; x is y of the laboratory, y is x, so z is down."""
TURNS = {"Z": (0, 1), "X": (1, 1), "Y": (2, 1), "-Z": (0, -1), "-X": (1, -1), "-Y": (2, -1)}
"""How Z becomes each axis: steps of a cycle of the axes, and the sign of all."""


def walker(seed: int = 0, feet: float = 0.0) -> np.ndarray:
    """(90, 14, 3) in mm, Z up: a person who walks 4 m along X. feet: added to the heights."""
    rng = np.random.default_rng(seed)
    body = np.array([[rng.uniform(-150, 150), rng.uniform(-200, 200), height + feet] for height in HEIGHTS])
    time = np.linspace(0, 1, 90)
    return body + np.stack([4000 * time, 20 * np.sin(9 * time), 15 + 15 * np.sin(30 * time)], axis=1)[:, None]


def head_of(
    names: tuple[str, ...] = NAMES, plates: np.ndarray | None = None, up: str = "", unit: str = "mm"
) -> ClipHead:
    fields = {"calibration_unit": unit} | ({"global_axis_of_gravity": up} if up else {})
    sections = () if plates is None else (section_of_plates(plates),)
    return ClipHead("c3d", marker_skeleton(names), fields, sources=(SourcePart("c3d", sections=sections),))


def turned(places: np.ndarray, up: str) -> np.ndarray:
    steps, sign = TURNS[up]
    return sign * np.roll(places, steps, axis=-1)


def origin(found: Calibration, name: str) -> tuple[str, str]:
    return found.origins[name].kind, found.origins[name].reason


@pytest.mark.parametrize("up", TURNS)
def test_names_tell_up_and_0_is_the_floor(up: str) -> None:
    found = calibrate(head_of(), turned(walker(), up))
    assert (found.up, found.floor) == (up, 0.0)
    kind, why = origin(found, "up")
    assert kind == "guessed"
    assert "heads and hips are above feet along it, by 100% of their distance" in why
    assert origin(found, "floor") == ("guessed", "0 of the file: the lowest marker of a foot is 30 mm above 0")


@pytest.mark.parametrize("up", TURNS)
def test_plates_tell_up_and_the_floor(up: str) -> None:
    nameless = tuple(f"p{place}" for place in range(len(NAMES)))
    plates = turned(PLATE - np.array([0, 0, 25]), up)
    found = calibrate(head_of(nameless, plates), turned(walker(), up))
    assert (found.up, found.floor) == (up, -25.0)
    assert origin(found, "up")[0] == "guessed"
    assert "the force plates are level in it" in origin(found, "up")[1]
    assert origin(found, "floor") == ("stated", "the surface of the force plates")
    # Without any point the order of the corners tells the side; some files have it the other way round.
    assert normal_axis(PLATE, np.empty((0, 3, 3))) == "Z"
    assert normal_axis(plates[:, ::-1], turned(walker(), up)) == up


@pytest.mark.parametrize(("lean", "named_up"), [(10, True), (20, True), (35, False), (90, False)])
def test_bodies_that_lie_or_swim_are_not_told_by_names(lean: float, named_up: bool) -> None:
    angle = np.radians(lean)
    turn = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    lying = walker() @ turn
    lying -= lying.reshape(-1, 3).min(axis=0)
    found = likely_up(marker_skeleton(NAMES), lying, PLATE)
    assert found.axis == "Z"
    assert ("force plates" in found.why) != named_up
    # Along an axis, names without plates are wrong.
    assert ("the body may lie" in found.why) == (lean == 90)
    assert lean == 35 or (likely_up(marker_skeleton(NAMES), lying).axis == "Z") == named_up


def test_a_stated_axis_counts_and_a_contradiction_is_told() -> None:
    agreed = calibrate(head_of(up="Z"), walker())
    assert agreed.up == "Z"
    assert origin(agreed, "up") == ("stated", "heads and hips are above feet along it, by 100% of their distance")
    told = calibrate(head_of(up="Y"), walker())
    assert told.up == "Y"
    assert origin(told, "up")[0] == "stated"
    assert origin(told, "up")[1].startswith("but Z is likely: heads and hips")


def test_a_body_upside_down_is_above_the_plates() -> None:
    hanging = walker() * [1, 1, -1] + [0, 0, 1800]
    assert likely_up(marker_skeleton(NAMES), hanging).axis == "-Z"
    found = likely_up(marker_skeleton(NAMES), hanging, PLATE)
    assert (found.axis, "below feet" in found.why) == ("Z", True)


def test_without_names_and_a_walkway_the_lowest_points_tell() -> None:
    rng = np.random.default_rng(3)
    time = np.linspace(0, 1, 200)[:, None]
    feet = np.stack([rng.uniform(-300, 300, (200, 3)), rng.uniform(-300, 300, (200, 3)), 0 * time + [20, 30, 40]], 2)
    arms = rng.uniform(-900, 900, (200, 9, 3)) + np.array([0, 0, 900])
    places = np.concatenate([feet, arms], axis=1)
    for up in ("X", "Y", "Z"):
        found = likely_up(marker_skeleton([f"p{place}" for place in range(12)]), turned(places, up))
        assert (found.axis, found.sure) == (up, False)
        assert "the lowest points travel least along it" in found.why


@pytest.mark.parametrize(
    ("feet", "floor", "why"),
    [
        (-49, 0.0, "0 of the file: the lowest marker of a foot is -19 mm above 0"),
        (69, 0.0, "0 of the file: the lowest marker of a foot is 99 mm above 0"),
        (-60, -30.0, "the lowest marker of a foot; 0 of the file is not the floor"),
        (300, 330.0, "the lowest marker of a foot; 0 of the file is not the floor"),
    ],
)
def test_0_counts_only_under_the_feet(feet: float, floor: float, why: str) -> None:
    found = calibrate(head_of(), walker(feet=feet))
    assert found.floor == pytest.approx(floor, abs=0.5)
    assert origin(found, "floor")[0] == "guessed"
    assert origin(found, "floor")[1].startswith(why)


def test_without_a_unit_0_is_not_checked() -> None:
    found = calibrate(head_of(unit=""), walker())
    assert found.floor == pytest.approx(30, abs=0.5)
    assert "the unit is unknown" in origin(found, "floor")[1]


def test_steps_of_plates_are_told() -> None:
    stairs = np.concatenate([PLATE, PLATE + np.array([1000, 0, 180])])
    found = calibrate(head_of(plates=stairs), walker())
    assert (found.floor, *origin(found, "floor")) == (
        0.0, "guessed", "force plates have several heights: the lowest one"
    )  # fmt: skip
    wall = np.roll(PLATE, 1, axis=2)
    assert normal_axis(np.concatenate([PLATE, wall]), walker()) is None
    assert floor_of_plates(wall, axis_of("Z")) is None
    assert calibrate(head_of(plates=wall), walker()).floor == 0.0


def test_plates_are_named_where_they_stand() -> None:
    far = PLATE + np.array([1000, 0, 0])
    named = {"1": PLATE[0], "2": PLATE[0], "4": far[0] + 0.01}
    plates = np.concatenate([far, PLATE, PLATE, PLATE, far + np.array([0, 5, 0])])
    assert match_plates(plates, named) == ["4", "1", "2", None, None]
    assert match_plates(PLATE * np.nan, named) == [None]
    assert match_plates(PLATE[:, :, [0, 2, 1]], named) == [None], "turned"


def test_plates_go_with_the_clip() -> None:
    clip = opened_clip(head_of(plates=PLATE + np.array([0, 0, 40]), up="Z"), walker(feet=40))
    metres = scale(clip, 0.001, unit="m")
    assert calibrate(metres.head, walker(feet=40) / 1000).floor == pytest.approx(0.04)
    assert not len(kept_plates(scale(clip, 0.5).head)), "the body no longer fits the laboratory"
    for end in ("X", "Y"):
        up = turn_up(clip, "Z", end)
        found = calibrate(up.head, positions_of(up))
        assert (found.up, found.floor) == (end, 40.0)
        assert origin(found, "up")[1].startswith("heads and hips are above")


def opened_clip(head: ClipHead, places: np.ndarray) -> ClipStream:
    columns = head.skeleton.columns()
    block = FrameBlock(places.reshape(len(places), -1), columns, (full_shape(columns),), np.arange(len(places)))
    return ClipStream(head, lambda: iter([block]), len(places))


@given(st.lists(st.floats(-1e300, 1e300), min_size=36, max_size=36))
def test_kept_plates_are_the_same_numbers(numbers: list[float]) -> None:
    plates = usable_plates(np.array(numbers).reshape(-1, 4, 3))
    head = head_of(plates=plates)
    assert np.allclose(kept_plates(head), plates, rtol=1e-6)


def test_damaged_sections_are_passed_over() -> None:
    text = "1 2 3\nnan " + "1 " * 11 + "\n" + "a " * 12 + "\n" + "7 " * 12 + "\n" + section_of_plates(PLATE)[1]
    head = replace(head_of(), sources=(SourcePart("c3d", sections=((SECTION, text),)),))
    assert np.array_equal(kept_plates(head), PLATE)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("largest", [1e-300, 1e200, 1.7e308])
def test_numbers_of_any_size(largest: float) -> None:
    assert likely_up(marker_skeleton(NAMES), walker() * [0, 0, largest / 2000], PLATE).axis == "Z"
    far = np.where(walker() > 500, largest, -largest)
    told = told_up(marker_skeleton(NAMES), far, PLATE)
    assert told is not None
    assert told.axis in ("X", "Y", "Z", "-Z")


LABORATORY = (
    "hc030a05", "s4_am_gait04", "s4_am_cal_01", "mh0222_bp06", "cb_dynamic0003", "treadmill_events", "walking5",
    "bmc_gait", "ja1gait35",
)  # fmt: skip


@pytest.mark.parametrize("name", LABORATORY)
def test_laboratories(shared: Path, name: str) -> None:
    expected = json.loads((shared / "lab/expected.json").read_text())[f"{name}.c3d"]
    clip = named(opened(shared / f"lab/{name}.c3d"))
    positions = positions_of(clip)
    found = likely_up(clip.head.skeleton, positions)
    assert f"+{found.axis}" == expected["up_by_names"]
    assert "heads and hips are above feet" in found.why
    calibration = calibrate(clip.head, positions)
    assert f"+{calibration.up}" == expected["up_by_names"]
    if "plates" in expected and name != "s4_am_cal_01":
        corners = np.concatenate([plate["corners"] for plate in expected["plates"]])
        assert calibration.floor == pytest.approx(corners[:, 2].mean(), abs=1)
        assert calibration.origins["floor"].kind == "stated"
        assert np.allclose(kept_plates(clip.head)[: len(expected["plates"])].reshape(-1, 3), corners, atol=0.01)
    else:
        assert calibration.floor == 0.0
    # Feet stand on it: a marker is at most a sole and its radius above.
    foot = next(joint.name for joint in clip.head.skeleton.joints if joint.source_name.endswith(FEET))
    heights = compute("height", (foot,), stretch_of(clip, calibration))
    assert -0.02 < np.nanpercentile(heights, 1) < 0.1


FEET = ("LHEE", "LTOE", "L.Heel", "LFCC", "L_FCC", "LCAL")
