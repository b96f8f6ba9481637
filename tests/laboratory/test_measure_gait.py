"""The gait of motions in files: points, sources of events, units, and what the answer says of itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest

import mcml
from mcml.errors import DocumentError, NotFoundError
from mcml.files.gait_labels import read_event_name
from mcml.files.motion import Motion
from mcml.laboratory.gait_events import SIDES, times_of
from tests.laboratory.walkers import Gait, events_of, make_c3d
from tests.motion.bodies.made import person

Read: TypeAlias = Callable[..., Motion]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def read_bytes(content: bytes, name: str = "walk.c3d") -> Motion:
        path = tmp_path / name
        path.write_bytes(content)
        return mcml.read(path)

    return read_bytes


def test_labels_come_before_positions_with_their_exact_times(read: Read) -> None:
    gait = Gait(seconds=4, heading=30)
    events = events_of(gait)
    motion = read(make_c3d(gait, events, first=286))
    measured = motion.measure_gait()
    assert {event.source for event in measured.events} == {"label"}
    assert [event.seconds for event in measured.events] == pytest.approx(
        sorted(event.seconds for event in events), abs=1e-5
    )
    assert measured.summary("left", "stride_time").mean == pytest.approx(gait.stride_time, abs=1e-4)
    assert not np.isfinite(measured.uncertainty(measured.events[0]))
    found = motion.measure_gait("positions")
    assert {event.source for event in found.events} == {"positions"}
    assert found.uncertainty(found.events[0]) == pytest.approx(0.045)
    assert found.summary("left", "stride_length").mean == pytest.approx(gait.speed * gait.stride_time, abs=0.02)
    assert found.points["left_heel"] == ("LHEE",)
    assert not found.warnings


def test_one_kind_of_label_leaves_the_others_to_positions_and_says_so(read: Read) -> None:
    gait = Gait(seconds=4)
    strikes = [event for event in events_of(gait) if event.kind == "strike"]
    measured = read(make_c3d(gait, strikes)).measure_gait()
    assert {(event.kind, event.source) for event in measured.events} == {("strike", "label"), ("off", "positions")}
    assert "left offs are from positions: the clip has no labels of them" in measured.warnings
    fewer = [event for event in events_of(gait) if event.seconds < 2]
    measured = read(make_c3d(gait, fewer)).measure_gait()
    assert any("more left strikes are in the positions" in warning for warning in measured.warnings)
    alone = read(make_c3d(gait, strikes)).measure_gait("labels")
    assert not [event for event in alone.events if event.kind == "off"]
    assert not alone.strides
    assert sum(alone.incomplete.values()) > 2


def test_labels_of_a_standing_trial_are_not_used(read: Read) -> None:
    gait = Gait(seconds=4, speed=0.0)
    events = [event for event in events_of(gait) if event.seconds < 1]
    measured = read(make_c3d(gait, events)).measure_gait()
    assert not measured.events
    assert f"{len(events)} labels of events were not used: nobody walks in this clip" in measured.warnings


def test_without_a_unit_times_are_known_and_lengths_are_not(read: Read) -> None:
    measured = read(make_c3d(Gait(seconds=4), unit="")).measure_gait()
    assert measured.summary("left", "stride_time").mean == pytest.approx(1.1, abs=0.02)
    assert np.isnan(measured.summary("left", "stride_length").mean)
    assert np.isnan(measured.belt.speed)
    assert any("lengths and speeds are unknown, because the unit is" in warning for warning in measured.warnings)


def test_a_belt_is_known_by_planted_feet(read: Read) -> None:
    measured = read(make_c3d(Gait(on_belt=True, heading=90))).measure_gait()
    assert measured.belt.is_belt
    assert measured.belt.speed == pytest.approx(1.2, abs=0.03)
    assert measured.summary("right", "stride_length").mean == pytest.approx(1.32, abs=0.04)
    assert any("belt of 1.2" in warning for warning in measured.warnings)


def test_few_frames_a_second_are_not_called_clinical(read: Read) -> None:
    measured = read(make_c3d(Gait(rate=30, seconds=8))).measure_gait()
    assert measured.events
    assert not measured.is_clinical
    assert "30 frames a second are too few for clinical use, which needs 50" in measured.warnings
    assert measured.uncertainty(measured.events[0]) > 0.07


def test_cycles_go_from_strike_to_strike_of_their_side(read: Read) -> None:
    gait = Gait(seconds=6)
    motion = read(make_c3d(gait, events_of(gait)))
    measured = motion.measure_gait()
    strikes = times_of(measured.events, "left", "strike")
    seconds = np.arange(len(motion)) / gait.rate
    cycles, mean = measured.cycles(np.cos(2 * np.pi * (seconds - strikes[0]) / gait.stride_time), "left")
    assert mean.n == len([stride for stride in measured.strides if stride.side == "left"]) == len(cycles.curves) > 2
    assert mean.mean == pytest.approx(np.cos(2 * np.pi * np.linspace(0, 1, 101)), abs=1e-3)
    assert mean.sd.max() < 1e-3


def test_joints_will_do_and_a_rig_without_toes_is_told(read: Read) -> None:
    motion = read(person(3, 120), "walk.bvh")
    measured = motion.measure_gait()
    assert measured.points["right_heel"] == ("right_foot",)
    assert any("ankles and toe joints" in warning for warning in measured.warnings)
    bare = person(3, 120).replace(b"left_toes", b"left_nail")
    with pytest.raises(DocumentError, match="Unknown: toes"):
        read(bare, "bare.bvh").measure_gait()


def test_a_person_who_is_not_there_is_refused(read: Read) -> None:
    with pytest.raises(NotFoundError, match="prefix 'Anna'"):
        read(make_c3d(Gait(seconds=2))).measure_gait(subject="Anna")


def test_one_of_several_people_is_chosen(read: Read) -> None:
    motion = read(make_c3d(Gait(seconds=4), people=("Anna:", "Bert:")))
    with pytest.raises(DocumentError, match="several people: 'Anna', 'Bert'"):
        motion.measure_gait()
    measured = motion.measure_gait(subject="Bert")
    assert measured.points["left_heel"] == ("Bert:LHEE",)
    assert len(measured.strides) > 2


@pytest.mark.parametrize(
    ("name", "meaning"),
    [
        ("left-foot-strike", ("left", "strike")),
        ("right-foot-off", ("right", "off")),
        ("Left-Heel-Strike", ("left", "strike")),
        ("right-hs", ("right", "strike")),
        ("l-to", ("left", "off")),
        ("left-touch-down", ("left", "strike")),
        ("general-event", None),
        ("left-turn", None),
        ("foot-strike", None),
        ("anna-left-foot-strike", None),
        ("left-leg-flexion", None),
    ],
)
def test_words_of_events(name: str, meaning: tuple[str, str] | None) -> None:
    assert read_event_name(name) == meaning


def test_an_event_of_several_people_is_that_of_its_person() -> None:
    assert read_event_name("anna-b-left-foot-strike", "Anna B") == ("left", "strike")
    assert read_event_name("anna-b-left-foot-strike", "Bert") is None
    assert all(read_event_name(f"{side}-foot-strike", "Bert") for side in SIDES)


def test_a_missed_strike_makes_no_cycle_of_two_strides(read: Read) -> None:
    gait = Gait(seconds=6)
    events = sorted(events_of(gait))
    missed = next(event for event in events if (event.side, event.kind) == ("left", "strike") and event.seconds > 2)
    motion = read(make_c3d(gait, [event for event in events if event != missed]))
    measured = motion.measure_gait()
    assert measured.incomplete["left"] == 1
    cycles, _ = measured.cycles(np.arange(len(motion)) / gait.rate, "left")
    assert [end - begin for begin, end in cycles.intervals] == pytest.approx([gait.stride_time] * len(cycles.intervals))
    assert cycles.curves[:, -1] - cycles.curves[:, 0] == pytest.approx(gait.stride_time)


def test_odd_frame_times_are_measured_or_refused(read: Read) -> None:
    def with_time(seconds: str) -> bytes:
        return person(3, 120).replace(b"Frame Time: 0.01666667", f"Frame Time: {seconds}".encode())

    assert not read(with_time("1000"), "slow.bvh").measure_gait().is_clinical
    assert read(with_time("0.0001"), "fast.bvh").measure_gait().is_clinical
    with pytest.raises(DocumentError, match="up to 10000 frames a second; this clip has 1e\\+09"):
        read(with_time("1e-9"), "odd.bvh").measure_gait()


def test_one_frame_has_no_gait(read: Read) -> None:
    measured = read(person(3, 1), "one.bvh").measure_gait()
    assert not measured.events
    assert measured.is_running is None
