"""Contacts of feet: from strike to off of made walkers, and unknown where no event tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from mcml.laboratory.gait_contacts import find_contacts
from mcml.laboratory.gait_events import SIDES, GaitEvent, find_events
from tests.laboratory.walkers import WALKS, Gait, events_of, make_walker


@given(WALKS)
@settings(max_examples=40, deadline=None)
def test_feet_are_on_the_ground_from_strike_to_off(gait: Gait) -> None:
    frames = int(gait.seconds * gait.rate)
    events = events_of(gait)
    for side in SIDES:
        own = sorted(event for event in events if event.side == side)
        contacts = find_contacts(events, side, gait.rate, frames)
        for frame in range(frames):
            at = frame / gait.rate
            before = [event for event in own if event.seconds <= at]
            if abs(at - min((event.seconds for event in own), key=lambda time: abs(time - at))) < 1e-9:
                continue
            if not before or before[-1] is own[-1]:
                assert np.isnan(contacts[frame])
            else:
                assert contacts[frame] == (before[-1].kind == "strike")


@pytest.mark.parametrize("on_belt", [False, True])
def test_positions_tell_nearly_the_same_on_the_ground_and_on_a_belt(on_belt: bool) -> None:
    gait = Gait(on_belt=on_belt)
    frames = int(gait.seconds * gait.rate)
    found = find_events(make_walker(gait)).events
    for side in SIDES:
        wanted = find_contacts(events_of(gait), side, gait.rate, frames)
        contacts = find_contacts(found, side, gait.rate, frames)
        known = ~np.isnan(contacts) & ~np.isnan(wanted)
        assert known.mean() > 0.7
        assert (contacts == wanted)[known].mean() > 0.95


def test_nothing_is_said_between_events_of_one_kind_or_over_long_pauses() -> None:
    gait = Gait()
    frames = int(gait.seconds * gait.rate)
    events = sorted(events_of(gait))
    left = [event for event in events if event.side == "left"]
    off = next(event for event in left if event.kind == "off" and event.seconds > 1.5)
    without = find_contacts([event for event in events if event != off], "left", gait.rate, frames)
    before = max(event for event in left if event < off)
    after = min(event for event in left if event > off)
    assert before.kind == after.kind == "strike"
    at = slice(int(np.ceil(before.seconds * gait.rate)), int(after.seconds * gait.rate))
    assert np.isnan(without[at]).all()
    # A strike and an off are missing: the swing would seem to last for more than a stride.
    fewer = [event for event in events if event not in (off, before) and event.side == "left"]
    swing = find_contacts([*fewer, *(event for event in events if event.side == "right")], "left", gait.rate, frames)
    assert np.isnan(swing[at]).all()
    assert find_contacts([], "left", gait.rate, 3).tolist() != [0.0, 0.0, 0.0]
    assert np.isnan(find_contacts([], "left", gait.rate, 3)).all()
    assert np.isnan(find_contacts([GaitEvent(0.0, "left", "strike", "label")], "left", 100.0, 3)).all()


def test_a_late_start_moves_nothing() -> None:
    gait = Gait()
    events = events_of(gait)
    later = [replace(event, seconds=event.seconds + 1) for event in events]
    assert np.array_equal(
        find_contacts(later, "right", 100.0, 700)[100:], find_contacts(events, "right", 100.0, 600), equal_nan=True
    )
