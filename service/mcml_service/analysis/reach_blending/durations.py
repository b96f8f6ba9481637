"""Durations of phases as blended values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

CUT = 0.1
"""Seconds: a clip with a shorter preparation or a shorter rest after the reach is cut there."""


def find_cut(times: Array, fps: float) -> NDArray[np.bool_]:
    """Find clips that are cut at the reach, (N, 2): at its beginning, at its end. times: (N, 3) in frames at fps."""
    durations = np.diff(times, axis=1, prepend=0.0)
    return np.asarray(durations[:, [0, 2]] < CUT * fps)


def to_time_values(times: Array, log_times: bool, fps: float) -> Array:
    """Return the blended values for times (N, 3) in base frames: log t1, log(t2 - t1), log(end - t2), or themselves.

    A clip that is cut at t1 or t2 does not tell how long preparation or rest take: its duration is the median of the
    clips that go on. The mean of logarithms would else play the rest of whole clips within two frames.
    """
    if not log_times:
        return times
    durations = np.diff(times, axis=1, prepend=0.0)
    for column, cut in zip((0, 2), find_cut(times, fps).T, strict=True):
        if cut.any() and not cut.all():
            durations[cut, column] = np.median(durations[~cut, column])
    values: Array = np.log(np.maximum(durations, 0.5))
    return values


def from_time_values(values: Array, log_times: bool) -> Array:
    """Return times (q, 3) from blended values: with logarithms, always in order."""
    times: Array = np.cumsum(np.exp(values), axis=1) if log_times else values
    return times


def about_cuts(times: Array, fps: float) -> list[tuple[str, str]]:
    """Warnings, (code, sentence), about clips that are cut while others go on."""
    found = []
    places = ("begin", "before the reach"), ("end", "after the reach")
    for (verb, place), cut in zip(places, find_cut(times, fps).T, strict=True):
        if cut.any() and not cut.all():
            text = f"{int(cut.sum())} of {len(cut)} clips {verb} within {CUT} s of the reach"
            found.append(("cut-clips", f"{text}: how long motions last {place} is known from the others."))
    return found
