"""Strikes and offs that are found in positions, of walkers whose events are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from mcml.laboratory.gait_events import (
    KINDS,
    SIDES,
    GaitEvent,
    WalkerPaths,
    bridge_gaps,
    choose_events,
    find_events,
    find_facing,
    smooth,
    times_of,
)
from tests.fuzz import examples
from tests.laboratory.walkers import WALKS, Gait, make_walker, true_events

EDGE = 0.25
"""Seconds at the ends of a clip, where an event may be missed."""


def _check(gait: Gait, walker: WalkerPaths, within: float) -> None:
    found = find_events(walker).events
    for (side, kind), times in true_events(gait).items():
        own = np.array(times_of(found, side, kind))  # type: ignore[arg-type]
        true = [at for at in times if EDGE < at < gait.seconds - EDGE]
        for at in true:
            assert np.abs(own - at).min(initial=9) <= within, (side, kind, at, own)
        inner = own[(own > EDGE) & (own < gait.seconds - EDGE)]
        assert all(np.abs(np.array(times) - at).min() <= within for at in inner), "an event that is none"


@given(WALKS)
@examples(60)
def test_events_are_found_in_any_direction(gait: Gait) -> None:
    _check(gait, make_walker(gait), 0.025)


@given(WALKS)
@examples(15)
def test_noise_of_a_millimetre_changes_little(gait: Gait) -> None:
    walker, rng = make_walker(gait), np.random.default_rng(1)
    noisy = {
        name: {side: path + rng.normal(0, 0.0005, path.shape) for side, path in getattr(walker, name).items()}
        for name in ("heels", "toes")
    }
    _check(gait, replace(walker, **noisy), 0.04)


def test_runners_leave_the_ground_early() -> None:
    gait = Gait(rate=200, speed=3.5, stride_time=0.7, duty=0.32)
    found = find_events(make_walker(gait))
    assert found.is_running
    assert found.duty_factor == pytest.approx(0.32, abs=0.03)
    assert find_events(make_walker(Gait())).is_running is False


def test_short_gaps_change_nothing_and_long_ones_hide_their_events() -> None:
    gait = Gait()
    walker = make_walker(gait)
    whole = find_events(walker).events
    heel = walker.heels["left"].copy()
    heel[200:208] = np.nan
    again = find_events(replace(walker, heels={**walker.heels, "left": heel})).events
    assert len(again) == len(whole)
    assert all(abs(one.seconds - other.seconds) < 0.03 for one, other in zip(whole, again, strict=True))
    heel[150:350] = np.nan
    holed = find_events(replace(walker, heels={**walker.heels, "left": heel})).events
    assert not [at for at in times_of(holed, "left", "strike") if 1.5 < at < 3.5]
    assert times_of(holed, "left", "strike")
    assert times_of(holed, "right", "strike") == times_of(whole, "right", "strike")


def test_nothing_is_found_without_steps_or_without_a_pelvis() -> None:
    walker = make_walker(Gait())
    stands = {side: np.tile(path[:1], (len(walker), 1)) for side, path in walker.heels.items()}
    pelvis = np.tile(walker.pelvis[:1], (len(walker), 1))
    standing = replace(walker, heels=stands, toes=stands, pelvis=pelvis)
    assert not find_events(standing).events
    assert find_events(standing).is_running is None
    assert not find_events(replace(walker, pelvis=np.full_like(walker.pelvis, np.nan))).events
    assert not find_events(replace(walker, across=np.zeros_like(walker.across))).events


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5])
def test_few_frames_are_no_error(frames: int) -> None:
    whole = make_walker(Gait())
    cut = WalkerPaths(
        {side: whole.heels[side][:frames] for side in SIDES},
        {side: whole.toes[side][:frames] for side in SIDES},
        whole.pelvis[:frames],
        whole.across[:frames],
        whole.up,
        whole.rate,
    )
    assert not find_events(cut).events
    assert find_facing(cut).shape == (frames, 3)


def test_a_bridge_is_a_line_and_ends_stay_open() -> None:
    values = np.array([[np.nan], [1.0], [np.nan], [np.nan], [4.0], [np.nan], [np.nan], [np.nan], [0.0]])
    assert bridge_gaps(values, 20)[:5, 0].tolist()[1:] == [1.0, 2.0, 3.0, 4.0]
    assert np.isnan(bridge_gaps(values, 20)[[0, 5, 6, 7], 0]).all()


def test_the_filter_has_no_delay_and_halves_twice_at_its_corner() -> None:
    seconds = np.arange(2000) / 200
    wave = np.sin(2 * np.pi * 10 * seconds)[:, None]
    smoothed = smooth(wave, 200, 10.0)
    middle = slice(500, 1500)
    # Two runs of -3 dB / 2 each at the corner: 0.7071 of the amplitude in all.
    gain = float((smoothed[middle] * wave[middle]).sum() / (wave[middle] ** 2).sum())
    assert gain == pytest.approx(0.7071, abs=0.02)
    slow = np.sin(2 * np.pi * 0.5 * seconds)[:, None]
    assert np.abs(smooth(slow, 200, 10.0)[middle] - slow[middle]).max() < 1e-3


def test_a_more_trusted_source_is_never_mixed_with_another() -> None:
    labels = [GaitEvent(1.0, "left", "strike", "label")]
    found = [GaitEvent(0.98, "left", "strike", "positions"), GaitEvent(2.1, "left", "strike", "positions")]
    found += [GaitEvent(1.6, "left", "off", "positions")]
    chosen = choose_events([labels, found])
    assert chosen == (labels[0], found[2])
    for side in SIDES:
        for kind in KINDS:
            assert len({event.source for event in chosen if (event.side, event.kind) == (side, kind)}) <= 1
