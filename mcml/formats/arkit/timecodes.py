"""Timecodes of rows to numbers of frames: which frame of a steady rate each row is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, Place
from mcml.motion.skeleton import Array

_TIMECODE = re.compile(r"([0-9]{1,2}):([0-9]{1,2}):([0-9]{1,2})[:;]([0-9]{1,3}(?:\.[0-9]{1,9})?)")
_DAY = 86400
RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)
SHOWS_BASE = 30
"""A count from which on timecodes can only count 60 frames a second."""
_NEAR = 0.01
_EVERY_SECOND = 1.5
"""Frames between two rows from which on they are more than one."""


@dataclass(frozen=True)
class Timing:
    """When rows were captured.

    base: frames a second that the timecodes count in. is_guess: whether no timecode counts far enough to tell.
    rate: frames a second. frames: (n,) number of the frame of each row, from 0, ascending; equal ones where two rows
    fall into one frame.
    """

    base: float
    is_guess: bool
    rate: float
    frames: NDArray[np.int64]


def read_timecode(text: str, line: int) -> tuple[int, float]:
    """(second of the day, frames beyond it) of `HH:MM:SS:FF.fff`. Raises FormatError."""
    found = _TIMECODE.fullmatch(text.strip())
    if found is None or int(found[2]) > 59 or int(found[3]) > 59:
        raise FormatError(
            f"{text[:40]!r} is not a timecode",
            at=Place(line=line),
            remedy="Write it as HH:MM:SS:FF.fff: hours, minutes, seconds and frames.",
        )
    return (int(found[1]) * 60 + int(found[2])) * 60 + int(found[3]), float(found[4])


def write_timecodes(counts: Array, base: int) -> list[str]:
    """Timecodes of times (n,) in frames of the base since midnight, to a thousandth of a frame."""
    seconds, rest = np.divmod(np.rint(np.asarray(counts) * 1000).astype(np.int64), 1000 * base)
    return [
        f"{second // 3600 % 24:02}:{second // 60 % 60:02}:{second % 60:02}:{part // 1000:02}.{part % 1000:03}"
        for second, part in zip(seconds.tolist(), rest.tolist(), strict=True)
    ]


def time_rows(seconds: Sequence[int], counts: Sequence[float], lines: Sequence[int], rate: float | None) -> Timing:
    """The timing of rows, by their seconds of the day and frames beyond. rate: if it is known already.

    Timecodes count 60 frames a second where one counts 30 or more. Else nothing says so: they do where they count every
    second frame, for phones capture 30 or 60 a second, and count 30 otherwise. A step back by half a day or more is
    midnight. Raises FormatError where times go back.
    """
    is_guess = max(counts, default=0.0) < SHOWS_BASE
    within = np.diff(np.array(counts, np.float64))[np.diff(np.array(seconds)) == 0]
    base = 60.0 if not is_guess or (len(within) and np.median(within) >= _EVERY_SECOND) else 30.0
    # In frames of the base: whole seconds times the base are exact.
    times = np.array(seconds, np.float64) * base + np.array(counts, np.float64)
    steps = np.diff(times)
    midnights = steps < -_DAY * base / 2
    times[1:] += np.cumsum(midnights) * _DAY * base
    steps = np.diff(times)
    back = np.flatnonzero(steps < 0)
    if len(back):
        raise FormatError(
            "the timecode is before that of the line above",
            at=Place(line=lines[int(back[0]) + 1]),
            remedy="Sort the rows by time, or send each recording as a file of its own.",
        )
    rate = rate or _rate_of(steps[steps > 0], base)
    frames = np.rint((times - times[:1]) / base * rate).astype(np.int64)
    return Timing(base, is_guess, rate, frames)


def _rate_of(steps: Array, base: float) -> float:
    """The rate of the median step (the lower of two), snapped to a usual one nearby; the base without any step."""
    if not len(steps):
        return base
    rate = base / float(np.sort(steps)[(len(steps) - 1) // 2])
    nearest = min(RATES, key=lambda usual: abs(usual - rate))
    return nearest if abs(nearest - rate) <= _NEAR * nearest else rate
