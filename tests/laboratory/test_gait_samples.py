"""Gait of public trials of laboratories, against the events and parameters that their files state."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcml
from mcml.files.motion import Motion
from mcml.laboratory.gait_events import SIDES, GaitEvent, WalkerPaths, find_events, times_of
from mcml.laboratory.gait_parameters import measure_belt
from mcml.laboratory.measure_gait import WITHIN
from mcml.motion.skeleton import Array

EDGE = 0.12
"""Seconds at the ends of a trial in which an event may be missed."""
TRIALS = {
    "hc030a05": (0.012, 0.013),
    "s4_am_gait04": (0.012, 0.016),
    "mh0222_bp06": (0.012, 0.031),
    "treadmill_events": (0.008, 0.009),
    "ja1gait35": (0.018, 0.004),
}
"""Of each trial with events: the largest median error of strikes and of offs, in seconds."""


@pytest.fixture(scope="module")
def expected(shared: Path) -> dict[str, Any]:
    if not (shared / "lab" / "expected.json").exists():
        pytest.skip("the trials of laboratories are not here (set MCML_SHARED to their folder)")
    found: dict[str, Any] = json.loads((shared / "lab" / "expected.json").read_text())
    return found


def read(shared: Path, name: str) -> Motion:
    return mcml.read(shared / "lab" / f"{name}.c3d")


def stated_events(trial: dict[str, Any]) -> list[GaitEvent]:
    begin = (trial["first_frame"] - 1) / trial["rate"]
    return [
        GaitEvent(time - begin, context.lower(), "strike" if "Strike" in label else "off", "label")
        for time, context, label in trial["events"]
    ]


def errors(found: list[GaitEvent], stated: list[GaitEvent], seconds: float) -> dict[str, list[float]]:
    """Seconds from each stated event to the nearest one, by kind; fails where one is missed inside the trial."""
    by_kind: dict[str, list[float]] = {"strike": [], "off": []}
    for event in stated:
        own = times_of(found, event.side, event.kind)
        error = min((at - event.seconds for at in own), key=abs, default=9.0)
        if abs(error) < 0.15:
            by_kind[event.kind].append(error)
        else:
            assert not EDGE < event.seconds < seconds - EDGE, f"{event} was missed"
    return by_kind


@pytest.mark.parametrize("name", TRIALS)
def test_events_are_near_those_of_the_file(shared: Path, expected: dict[str, Any], name: str) -> None:
    motion = read(shared, name)
    stated = stated_events(expected[f"{name}.c3d"])
    measured = motion.measure_gait("positions")
    found = errors(list(measured.events), stated, len(motion) * float(motion.frame_time or 0))
    for kind, most in zip(("strike", "off"), TRIALS[name], strict=True):
        assert np.median(np.abs(found[kind])) <= most
        assert np.percentile(np.abs(found[kind]), 95) <= WITHIN
    # Between the first and the last event of a side there are no others.
    for side in SIDES:
        for kind in ("strike", "off"):
            true = times_of(stated, side, kind)  # type: ignore[arg-type]
            own = times_of(measured.events, side, kind)  # type: ignore[arg-type]
            inner = [at for at in own if true and true[0] - 0.05 < at < true[-1] + 0.05]
            assert len(inner) <= len(true)


@pytest.mark.parametrize(
    ("name", "within"),
    [("s4_am_gait04", 0.017), ("mh0222_bp06", 0.027), ("walking5", 0.025), ("bmc_gait", 0.012), ("ja1gait35", 0.016)],
)
def test_events_are_near_those_of_force_plates(
    shared: Path, expected: dict[str, Any], name: str, within: float
) -> None:
    measured = read(shared, name).measure_gait("positions")
    for letter, kind, seconds in expected[f"{name}.c3d"]["plate_events_s_from_first_frame"]:
        own = times_of(measured.events, {"L": "left", "R": "right"}[letter], kind)  # type: ignore[arg-type]
        assert min(abs(at - seconds) for at in own) <= within


def test_events_of_the_file_are_those_that_are_used(shared: Path, expected: dict[str, Any]) -> None:
    for name in TRIALS:
        measured = read(shared, name).measure_gait()
        stated = sorted(event.seconds for event in stated_events(expected[f"{name}.c3d"]))
        assert [event.seconds for event in measured.events] == pytest.approx(stated, abs=1e-5)
        assert {event.source for event in measured.events} == {"label"}


NAMES = {
    "Cadence": "cadence",
    "Walking Speed": "speed",
    "Stride Time": "stride_time",
    "Step Time": "step_time",
    "Foot Off": "stance",
    "Stride Length": "stride_length",
    "Step Length": "step_length",
    "Step Width": "step_width",
}


def test_parameters_are_those_of_the_laboratory(shared: Path, expected: dict[str, Any]) -> None:
    measured = read(shared, "s4_am_gait04").measure_gait()
    compared = 0
    for context, stated, value, unit in expected["s4_am_gait04.c3d"]["analysis"]:
        side = context.lower()
        (stride,) = (one for one in measured.strides if one.side == side)
        if stated in NAMES:
            summary = measured.summary(side, NAMES[stated])
            assert summary.n == 1
            limit = 0.001 if unit == "m" else 0.001 * value
            assert summary.mean == pytest.approx(value, abs=limit), (side, stated)
            compared += 1
        elif stated in ("Double Support", "Single Support"):
            percent = stride.double_support if stated == "Double Support" else stride.single_support
            assert percent * stride.stride_time / 100 == pytest.approx(value, abs=0.001), (side, stated)
            compared += 1
    assert compared == 20


def test_a_standing_trial_has_no_gait(shared: Path, expected: dict[str, Any]) -> None:
    measured = read(shared, "s4_am_cal_01").measure_gait()
    assert not measured.events
    assert not measured.strides


def test_the_belt_has_one_speed_for_both_feet(shared: Path, expected: dict[str, Any]) -> None:
    measured = read(shared, "treadmill_events").measure_gait()
    assert measured.belt.is_belt
    assert measured.belt.speed == pytest.approx(1.095, abs=0.01)
    assert measured.belt.sd < 0.01
    for name in ("hc030a05", "s4_am_gait04", "mh0222_bp06", "walking5", "bmc_gait", "ja1gait35"):
        belt = read(shared, name).measure_gait().belt
        assert not belt.is_belt
        assert abs(belt.speed) <= 0.055


def test_a_skeleton_has_events_of_ankles_and_toes(shared: Path, expected: dict[str, Any]) -> None:
    path = shared / "lab" / "skeleton_walk_gait2392.npz"
    with np.load(path) as file:
        at: dict[str, Array] = dict(zip(file["joints"].tolist(), file["positions"].transpose(1, 0, 2), strict=True))
    walker = WalkerPaths(
        heels={"left": at["ankle_l"], "right": at["ankle_r"]},
        toes={"left": at["mtp_l"], "right": at["mtp_r"]},
        pelvis=(at["hip_l"] + at["hip_r"]) / 2,
        across=at["hip_l"] - at["hip_r"],
        up=np.array([0.0, 0.0, 1.0]),
        rate=60.0,
    )
    found = find_events(walker)
    assert found.is_running is False
    belt = measure_belt(walker, found.events)
    assert belt.is_belt
    assert belt.speed == pytest.approx(1.135, abs=0.02)
