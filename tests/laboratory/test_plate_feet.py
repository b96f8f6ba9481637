"""Loads of force plates are those of the foot that is on them; unclear ones are of no foot."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.laboratory.force_plates import Plate, PlateForces
from mcml.laboratory.gait_events import GaitEvent, Side, WalkerPaths
from mcml.laboratory.measure_gait import find_walker
from mcml.laboratory.plate_feet import (
    Load,
    find_crossing,
    find_loads,
    find_step_events,
    is_whole_step,
    prefer_plates,
    sum_forces,
)
from mcml.motion.skeleton import Array

RATE, FRAMES = 100.0, 60
UP = np.array([0.0, 0.0, 1.0])


def feet(left: float, right: float) -> WalkerPaths:
    """Somebody whose feet stand at places along x, 0.25 m long, 0.2 m apart."""
    whole = np.ones((FRAMES, 1))
    at = {"left": np.array([left, 0.1, 0.03]), "right": np.array([right, -0.1, 0.03])}
    return WalkerPaths(
        heels={side: whole * place for side, place in at.items()},  # type: ignore[misc]
        toes={side: whole * (place + np.array([0.25, 0.0, 0.0])) for side, place in at.items()},  # type: ignore[misc]
        pelvis=whole * [0.0, 0.0, 0.9],
        across=whole * [0.0, 0.25, 0.0],
        up=UP,
        rate=RATE,
    )


def plate(first: int, end: int, cop: Array, newtons: float = 700.0, turning: float = 2.0) -> PlateForces:
    """Loaded from a frame to before another one at a centre of pressure."""
    is_loaded = np.zeros(FRAMES, bool)
    is_loaded[first:end] = True
    force = np.zeros((FRAMES, 3))
    force[is_loaded] = [30.0, -10.0, newtons]
    pressure = np.where(is_loaded[:, None], cop, np.nan)
    return PlateForces(force, pressure, np.where(is_loaded, turning, np.nan), UP, False, np.nan, ())


def sides(*plates: PlateForces, paths: WalkerPaths | None = None) -> list[tuple[int, int, int, Side | None]]:
    loads = find_loads(plates, feet(0.0, 0.5) if paths is None else paths)
    return [(load.plate, load.first, load.end, load.side) for load in loads]


def test_the_foot_under_the_centre_of_pressure_is_the_one() -> None:
    one = plate(10, 40, np.array([0.1, 0.1, 0.0]))
    other = plate(20, 60, np.array([0.7, -0.05, 0.0]))
    assert sides(one, other) == [(0, 10, 40, "left"), (1, 20, 60, "right")]


@pytest.mark.parametrize(
    ("cop", "why"),
    [
        ((0.1, 0.21, 0.0), "beside the foot"),
        ((0.45, 0.1, 0.0), "before the toe"),
        ((-0.2, 0.1, 0.0), "behind the heel"),
    ],
)
def test_a_load_far_from_both_feet_is_of_none(cop: tuple[float, ...], why: str) -> None:
    assert sides(plate(10, 40, np.array(cop))) == [(0, 10, 40, None)], why


def test_loads_of_both_feet_and_short_or_light_ones_are_of_none() -> None:
    # The centre of pressure goes from one foot to the other, as in a step with both feet on one plate.
    wandering = plate(0, 60, np.array([0.1, 0.1, 0.0]))
    wandering.centre_of_pressure[35:] = [0.1, -0.1, 0.0]
    assert sides(wandering, paths=feet(0.0, 0.0)) == [(0, 0, 60, None)]
    assert sides(plate(10, 20, np.array([0.1, 0.1, 0.0]))) == [(0, 10, 20, None)]
    assert sides(plate(10, 40, np.array([0.1, 0.1, 0.0]), newtons=140.0)) == [(0, 10, 40, None)]


def test_feet_that_are_not_seen_have_no_load() -> None:
    paths = feet(0.0, 0.5)
    paths.heels["left"][:] = np.nan
    assert sides(plate(10, 40, np.array([0.1, 0.1, 0.0])), paths=paths) == [(0, 10, 40, None)]


def test_a_foot_on_two_plates_has_their_sum_about_the_common_centre() -> None:
    one = plate(10, 40, np.array([0.05, 0.1, 0.0]), newtons=300.0)
    other = plate(10, 40, np.array([0.2, 0.1, 0.0]), newtons=600.0)
    plates = [one, other]
    loads = find_loads(plates, feet(0.0, 0.5))
    both = sum_forces(plates, loads, "left")
    np.testing.assert_allclose(both.force[20], [60.0, -20.0, 900.0])
    np.testing.assert_allclose(both.centre_of_pressure[20], [0.15, 0.1, 0.0])
    # By hand: (-0.1, 0, 0) × (30, -10, 300) + (0.05, 0, 0) × (30, -10, 600), the vertical part: 1 - 0.5.
    np.testing.assert_allclose(both.free_moment[20], 2 + 2 + 1.0 - 0.5)
    assert np.isnan(both.force[[0, 9, 40, 59]]).all()
    assert np.isnan(sum_forces(plates, loads, "right").force).all()


def test_an_unclear_load_makes_both_feet_unknown_while_it_lasts() -> None:
    clear, unclear = plate(10, 40, np.array([0.1, 0.1, 0.0])), plate(30, 50, np.array([3.0, 0.0, 0.0]))
    loads = find_loads([clear, unclear], feet(0.0, 0.5))
    force = sum_forces([clear, unclear], loads, "left").force[:, 2]
    assert np.isfinite(force[10:30]).all()
    assert np.isnan(force[30:]).all()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("walking5", {"left": [(1.96, 2.47)], "right": [(2.38, 2.97)]}),
        ("bmc_gait", {"left": [(2.57, 3.15)], "right": [(2.08, 2.65)]}),
        ("mh0222_bp06", {"left": [(1.2, 1.77)], "right": [(0.69, 1.3)]}),
    ],
)
def test_steps_of_laboratories_are_of_the_foot_that_they_say(
    shared: Path, name: str, expected: dict[str, list[tuple[float, float]]]
) -> None:
    """Times from the plates' own records and the EVENT groups of the files."""
    motion = mcml.read(shared / "lab" / f"{name}.c3d")
    assert motion.frame_time is not None
    for side, steps in expected.items():
        known = np.isfinite(motion.force(side, "z"))
        edges = np.flatnonzero(np.diff(known.astype(int), prepend=0, append=0)) * motion.frame_time
        np.testing.assert_allclose(edges.reshape(-1, 2), steps, atol=0.015)
        assert np.nanmax(motion.force(side, "z")) > 500


@pytest.mark.parametrize("name", ["walking5", "bmc_gait", "mh0222_bp06", "treadmill_events", "s4_am_gait04"])
def test_events_of_plates_are_those_that_the_prototype_found(shared: Path, name: str) -> None:
    """Every one within a millisecond; belts crossed over, and steps that two feet share, have none."""
    expected = json.loads((shared / "lab" / "expected.json").read_text())[f"{name}.c3d"]
    known = {(side, kind): [] for side in "LR" for kind in ("strike", "off")}  # type: dict[tuple[str, str], list[float]]
    for side, kind, seconds in expected["plate_events_s_from_first_frame"]:
        known[side, kind].append(seconds)
    motion = mcml.read(shared / "lab" / f"{name}.c3d")
    walker = find_walker(motion._clip.head.skeleton, motion._body.stretch)
    events = motion._measurements.find_events(motion._ids, walker)
    matched = 0
    for event in events:
        # The file of expected values leaves out sides of some trials.
        near = known[event.side[0].upper(), event.kind]
        matched += bool(near)
        assert not near or min(abs(seconds - event.seconds) for seconds in near) < 1e-3
    assert matched >= 2


def test_events_of_plates_replace_those_of_positions_near_them() -> None:
    found = [GaitEvent(1.0, "left", "strike", "positions"), GaitEvent(1.05, "right", "strike", "positions")]
    plates = [GaitEvent(1.02, "left", "strike", "plate"), GaitEvent(3.0, "left", "strike", "plate")]
    assert prefer_plates(found, plates) == (plates[0], found[1], plates[1])


def test_a_crossing_lies_between_samples() -> None:
    force = np.array([0.0, 10.0, 30.0, 500.0, 30.0, 0.0, np.nan])
    assert find_crossing(force, rising=True) == 1.5
    assert find_crossing(force, rising=False) == pytest.approx(4 + 1 / 3)
    assert np.isnan(find_crossing(force[3:4], rising=True))


def test_a_step_is_whole_where_one_foot_alone_is_on_the_plate_inside_the_record() -> None:
    corners = np.array([[0.3, 0.2, 0], [0.3, 0.0, 0], [-0.1, 0.0, 0], [-0.1, 0.2, 0]])
    board = Plate(2, corners, np.zeros(3), (0, 1, 2, 3, 4, 5), (1.0,) * 6)
    step = Load(0, 10, 40, "left")
    assert is_whole_step(step, board, feet(0.0, 0.5))
    assert not is_whole_step(step, board, feet(-0.2, 0.5))
    assert not is_whole_step(step, board, feet(0.2, 0.5))
    beside = feet(0.0, 0.0)
    beside.heels["right"][:, 1] = beside.toes["right"][:, 1] = 0.05
    assert not is_whole_step(step, board, beside)
    for first, end, side in ((0, 40, "left"), (10, FRAMES, "left"), (10, 40, None)):
        assert not is_whole_step(Load(0, first, end, side), board, feet(0.0, 0.5))  # type: ignore[arg-type]


def test_the_first_of_several_crossings_strikes_and_the_last_leaves() -> None:
    bouncing = np.array([0.0, 40.0, 0.0, 40.0, 500.0, 40.0, 0.0, 40.0, 0.0])
    assert find_crossing(bouncing, rising=True) == 0.5
    assert find_crossing(bouncing, rising=False) == 7.5
    assert np.isnan(find_crossing(np.full(5, 500.0), rising=True))


def test_a_step_whose_samples_cannot_be_read_keeps_the_other_end() -> None:
    corners = np.array([[0.3, 0.2, 0], [0.3, 0.0, 0], [-0.1, 0.0, 0], [-0.1, 0.2, 0]])
    board = Plate(2, corners, np.zeros(3), (0, 1, 2, 3, 4, 5), (1.0,) * 6)
    loaded = plate(10, 40, np.array([0.1, 0.1, 0.0]))
    paths = feet(0.0, 0.5)

    def read_upward(place: int, at: int) -> Array | None:
        return None if at < 20 else np.array([700.0, 500.0, 10.0, 0.0])

    events = find_step_events(find_loads([loaded], paths), [board], [loaded], paths, (2, 2 * RATE), read_upward)
    assert [(event.side, event.kind, event.source) for event in events] == [("left", "off", "plate")]
    assert events[0].seconds == pytest.approx(
        39 / RATE + find_crossing(np.array([700.0, 500.0, 10.0]), rising=False) / 200
    )


def test_both_feet_on_plates_share_nothing_and_one_plate_may_follow_another() -> None:
    one, other = plate(10, 40, np.array([0.02, 0.1, 0.0])), plate(25, 50, np.array([0.2, 0.1, 0.0]), newtons=300.0)
    found = sum_forces([one, other], find_loads([one, other], feet(0.0, 0.5)), "left")
    assert found.force[15, 2] == 700.0
    assert found.force[30, 2] == 1000.0
    assert found.centre_of_pressure[30, 0] == pytest.approx((0.02 * 700 + 0.2 * 300) / 1000)
    assert found.force[45, 2] == 300.0
    assert np.isnan(found.force[55]).all()
