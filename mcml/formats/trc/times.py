"""Derive the rate of a TRC from its times. A document has a rate, not a time for each frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.errors import Notice
from mcml.formats.format import note
from mcml.formats.text.lines import shown
from mcml.motion.skeleton import Array

_HALF: Final = 0.5001
"""Of a time's last digit: how far rounding may have moved it."""

_LEAST_DECIMALS: Final = 2
"""Programs do not round times to fewer decimals, so whole seconds with zeros are exact."""

_STEPS: Final = 60
_MOST_DECIMALS: Final = 12


@dataclass(frozen=True)
class Times:
    """The second column. seconds: (F,), NaN where a cell is no number. decimals: as written. kept: without the zeros
    that end every one of them, since some programs fill up times that they have rounded before."""

    seconds: Array
    decimals: int
    kept: int


def decide_rate(times: Times, stated: str, usable: bool, notices: list[Notice]) -> str | None:
    """Return the frame rate in Hz as text: DataRate, or the rate of the times if they are even and differ from it.

    stated: DataRate as written. usable: whether it is a valid rate. Returns None if the rate is unknown.
    """
    rate = float(stated) if usable else None
    for decimals in dict.fromkeys((times.decimals, max(times.kept, _LEAST_DECIMALS))):
        allowed = _HALF * 10.0**-decimals
        if not len(times.seconds) or (rate is not None and follows(times.seconds, rate, allowed)):
            break
        found = even_rate(times.seconds, allowed)
        if found is not None:
            what = f"DataRate says {stated}" if usable else f"DataRate {shown(stated)} is no rate"
            note(notices, "guess", f"{what}, and the times are even at {found} frames a second: the times count")
            return found
    else:
        if rate is not None:
            note(notices, "warning", "the times do not follow from DataRate, which is all that the document holds")
    if rate is None:
        note(notices, "warning", f"DataRate {shown(stated)} is no rate: how fast the frames follow is unknown")
    return stated if usable else None


def first_time(times: Times, rate: float | None) -> float:
    """When the first frame is, seconds: 0.083 at 120 Hz is ten frames, rounded, and so are the times that follow."""
    first = float(times.seconds[0])
    if rate is None or not math.isfinite(first * rate):
        return first
    whole = round(first * rate) / rate
    return whole if abs(whole - first) <= _HALF * 10.0**-times.decimals else first


def follows(seconds: Array, rate: float, allowed: float) -> bool:
    """Tell whether times (F,) match a rate, each within `allowed`, from any start."""
    return bool(_spread(seconds, float(np.float64(1) / rate)) <= 2 * allowed + 2e-9 * np.abs(seconds).max())


def even_rate(seconds: Array, allowed: float) -> str | None:
    """Return the rate with the fewest decimals that matches times (F,), each within `allowed`; None if they are uneven.

    At least three times are needed, because two are always even.
    """
    count = len(seconds)
    if count < 3 or not np.isfinite(seconds).all():
        return None
    step = float(seconds[-1] - seconds[0]) / (count - 1)
    if not np.isfinite(step):
        return None
    reach = 2 * allowed / (count - 1)
    low, high = step - reach, step + reach
    best = _least(seconds, low, high)
    if _spread(seconds, best) > 2 * allowed:
        return None
    shortest = _edge(seconds, best, low, 2 * allowed)
    longest = _edge(seconds, best, high, 2 * allowed)
    if shortest <= 0:
        return None
    for decimals in range(_MOST_DECIMALS + 1):
        text = f"{1 / best:.{decimals}f}"
        if float(text) > 0 and shortest <= 1 / float(text) <= longest:
            return text
    return None


def _spread(seconds: Array, step: float) -> float:
    """How far apart times (F,) are from those of a step, the first one free. Convex in the step."""
    rest = seconds - step * np.arange(len(seconds))
    return float(rest.max() - rest.min())


def _least(seconds: Array, low: float, high: float) -> float:
    """The step between two others at which the spread is least, by thirds."""
    for _ in range(2 * _STEPS):
        third = (high - low) / 3
        if _spread(seconds, low + third) <= _spread(seconds, high - third):
            high -= third
        else:
            low += third
    return (low + high) / 2


def _edge(seconds: Array, inside: float, outside: float, allowed: float) -> float:
    """The last step on the way from one to another at which the spread is allowed, by halves."""
    for _ in range(_STEPS):
        middle = (inside + outside) / 2
        if _spread(seconds, middle) <= allowed:
            inside = middle
        else:
            outside = middle
    return inside
