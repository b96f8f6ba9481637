"""Preparation, reach and settling found in the angular speed of one joint.

Times are in frames since the first frame, at the clip's rate, and may be fractions. Speeds are in radians a second.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array
from mcml_service.analysis.interface import AnalysisError

Method = Literal["robust", "paper"]

FEWEST_FRAMES = 8
SLOWEST_PEAK = 0.5
PEAK_OVER_MEDIAN = 2.0
SMOOTHING = 1 / 30
"""Seconds: deviation of the Gaussian over the speed."""
MINIMUM_BELOW, REST_BELOW = 0.30, 0.15
SETTLED = (0.04, 0.08, 0.16)
PATIENCE = 0.15
"""Seconds by which a tighter threshold may be crossed later than the widest one."""
PAPER_SETTLED = 0.10
BY_HAND = (
    "If the clip is a whole reach, set its phases yourself: `times` of its document, with t1, t2 and end in frames."
)
SEVERAL = "peak-between-minima"
"""Flag of a clip with several fast movements."""


@dataclass(frozen=True)
class Phases:
    """t1: the reach begins. t2: it ends. end: the last frame used. peak: the greatest speed, at `peak_frame`.

    flags: guesses: peak-between-minima, t1-from-threshold, no-preparation, t2-from-8-percent, t2-from-16-percent,
    speed-never-settles, given.
    """

    t1: float
    t2: float
    end: float
    peak: float
    peak_frame: int
    flags: tuple[str, ...] = ()

    @property
    def times(self) -> tuple[float, float, float]:
        return self.t1, self.t2, self.end


def angular_speed(rotations: Array, fps: float, method: Method = "robust") -> Array:
    """Speed (F,) of a joint's rotations (F, 4), rad/s; frame f has that since f - 1, the first that of the second.

    robust: the angle of q_f q_(f-1)^-1. paper: |Im(2 (q_f - q_(f-1)) q_(f-1)^-1)|, twice the sine of half the angle,
    1 % low at 30 degrees a frame. The signs of the quaternions do not matter.
    """
    if len(rotations) < 2:
        return np.zeros(len(rotations))
    step = multiply(rotations[1:], inverse(rotations[:-1]))
    sine = np.linalg.norm(step[:, :3], axis=1)
    angle = 2 * sine if method == "paper" else 2 * np.arctan2(sine, np.abs(step[:, 3]))
    speed = angle * fps
    return np.concatenate([speed[:1], speed])


def smooth_speed(speed: Array, fps: float) -> Array:
    """The speed (F,) under a Gaussian of 1/30 s."""
    smooth: Array = scipy.ndimage.gaussian_filter1d(speed, SMOOTHING * fps, mode="nearest")
    return smooth


def find_phases(rotations: Array, fps: float, method: Method = "robust") -> Phases:
    """The phases of a clip by the rotations (F, 4) of one joint.

    Raises AnalysisError `too-few-frames`, `too-slow`, `no-clear-peak`, `peak-at-border`.
    """
    if len(rotations) < FEWEST_FRAMES:
        raise AnalysisError("too-few-frames", f"The clip has {len(rotations)} frames; {FEWEST_FRAMES} are needed.")
    speed = angular_speed(rotations, fps, method)
    judged = smooth_speed(speed, fps) if method == "robust" else speed
    peak_frame = int(np.argmax(judged))
    peak = float(judged[peak_frame])
    if peak < SLOWEST_PEAK:
        raise AnalysisError("too-slow", f"The joint turns by at most {peak:.2f} rad/s; {SLOWEST_PEAK} are needed.")
    flags = _clearness(judged, peak_frame, method)
    if peak_frame <= 1 or peak_frame >= len(judged) - 2:
        raise AnalysisError(
            "peak-at-border", "The joint is fastest at the clip's border: the reach is cut.", remedy=BY_HAND
        )
    if method == "paper":
        t1, t2 = _paper_times(speed, peak_frame)
        return Phases(t1, t2, float(len(speed) - 1), peak, peak_frame)
    t1, before = _start(judged, peak_frame, fps)
    t2, after = _settle(judged, peak_frame, fps)
    end = float(len(speed) - 1)
    t2 = min(max(t2, peak_frame + 0.5), end - 1)
    return Phases(t1, t2, end, peak, peak_frame, flags + before + after)


def _clearness(speed: Array, peak: int, method: Method) -> tuple[str, ...]:
    """Flags of a clear peak. Raises AnalysisError `no-clear-peak`.

    A peak is clear above twice the median. By the robust method it also is where the speed falls below 30 % of it both
    before and after: clips cut to the movement alone, or with two fast movements, have a high median.
    """
    if speed[peak] >= PEAK_OVER_MEDIAN * float(np.median(speed)):
        return ()
    least = float(max(speed[:peak].min(initial=np.inf), speed[peak + 1 :].min(initial=np.inf)))
    if method == "robust" and least < MINIMUM_BELOW * speed[peak]:
        return (SEVERAL,)
    raise AnalysisError(
        "no-clear-peak",
        "The joint's greatest speed is less than twice its median speed"
        + (", and the speed does not fall below 30 % of it on both sides." if method == "robust" else "."),
        remedy=BY_HAND,
    )


def check_phases(rotations: Array, fps: float, times: tuple[float, float, float], method: Method) -> Phases:
    """Phases that a person set. Raises AnalysisError `phase-order` unless 0 < t1 < t2 < end <= last frame."""
    t1, t2, end = times
    if not 0 < t1 < t2 < end <= len(rotations) - 1:
        raise AnalysisError(
            "phase-order",
            f"The times {t1:g}, {t2:g}, {end:g} are not in order within 0 and {len(rotations) - 1}.",
            remedy="Give times with 0 < t1 < t2 < end, none beyond the last frame.",
        )
    speed = angular_speed(rotations, fps, method)
    judged = smooth_speed(speed, fps) if method == "robust" else speed
    peak_frame = int(np.argmax(judged))
    return Phases(t1, t2, end, float(judged[peak_frame]), peak_frame, ("given",))


def _paper_times(speed: Array, peak: int) -> tuple[float, float]:
    minima = [f for f in range(1, peak) if speed[f] < speed[f - 1] and speed[f] < speed[f + 1]]
    below = np.flatnonzero(speed[peak + 1 :] < PAPER_SETTLED * speed[peak])
    t2 = peak + 1 + (int(below[0]) if len(below) else int(np.argmin(speed[peak + 1 :])))
    # The last frame must be after t2, or the settling phase has no length.
    return float(minima[-1] if minima else 0), float(min(t2, len(speed) - 2))


def _start(speed: Array, peak: int, fps: float) -> tuple[float, tuple[str, ...]]:
    """t1 of a smoothed speed: a backward difference belongs to half a frame earlier."""
    least = max(1.0, fps / 30)
    top = speed[peak]
    flags: tuple[str, ...] = ()
    inner = speed[1:peak]
    is_minimum = (inner <= speed[: peak - 1]) & (inner < speed[2 : peak + 1])
    minima = np.flatnonzero(is_minimum & (inner < MINIMUM_BELOW * top))
    if len(minima):
        f = int(minima[-1]) + 1
        bend = speed[f - 1] - 2 * speed[f] + speed[f + 1]
        start = f + 0.5 * (speed[f - 1] - speed[f + 1]) / bend - 0.5
    elif len(quiet := np.flatnonzero(speed[:peak] < REST_BELOW * top)):
        start, flags = int(quiet[-1]) - 0.5, ("t1-from-threshold",)
    else:
        start, flags = least, ("no-preparation",)
    return float(min(max(start, least), peak - 0.5)), flags


def _settle(speed: Array, peak: int, fps: float) -> tuple[float, tuple[str, ...]]:
    crossings = [_first_below(speed, peak, share * speed[peak]) for share in SETTLED]
    widest = crossings[-1]
    if widest is None:
        return float(peak + 1 + np.argmin(speed[peak + 1 :])) - 0.5, ("speed-never-settles",)
    for share, crossing in zip(SETTLED, crossings, strict=True):
        if crossing is not None and crossing <= widest + PATIENCE * fps:
            return crossing - 0.5, () if share == SETTLED[0] else (f"t2-from-{share * 100:.0f}-percent",)
    return widest - 0.5, ()


def _first_below(speed: Array, peak: int, level: float) -> float | None:
    """Where the speed after its peak first falls below a level, between frames."""
    below = np.flatnonzero(speed[peak + 1 :] < level)
    if not len(below):
        return None
    f = peak + 1 + int(below[0])
    return float(f - 1 + (speed[f - 1] - level) / (speed[f - 1] - speed[f]))
