"""Contacts of feet with the ground, from gait events."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mcml.laboratory.gait_events import SIDES, GaitEvent, Side, times_of
from mcml.motion.skeleton import Array


def find_contacts(events: Sequence[GaitEvent], side: Side, rate: float, frames: int) -> Array:
    """(n,) of a foot in each frame: 1 from a strike to the next off, 0 from an off to the next strike, NaN elsewhere.

    events: of both feet. rate: frames a second. Before the first and after the last event of the foot nothing is known,
    nor between two strikes or two offs, nor between an off and a strike that are further apart than the median stride,
    because events between them may be missing.
    """
    contacts = np.full(frames, np.nan)
    own = sorted(event for event in events if event.side == side)
    longest = _stride_time(events)
    times = np.arange(frames) / rate
    for event, following in pairwise(own):
        if event.kind == following.kind or not following.seconds - event.seconds < longest:
            continue
        first, end = np.searchsorted(times, (event.seconds, following.seconds))
        contacts[first:end] = event.kind == "strike"
    return contacts


def _stride_time(events: Sequence[GaitEvent]) -> float:
    """Seconds between two strikes of one foot, the median of both feet; NaN without a stride."""
    strides = [np.diff(times_of(events, side, "strike")) for side in SIDES]
    seconds = np.concatenate(strides)
    return float(np.median(seconds)) if len(seconds) else float("nan")
