"""Motion beats: minima of the speed of the body, refined, and their dominant period.

Ho, Tsai, Lin, Chen (ICASSP 2013): minima as beats. Choi (2024): conditions F1 to F3. Kim, Park, Shin (SIGGRAPH 2003):
dominant period. Frames are 0-based, windows are in seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.hub import walked
from mcml.motion.skeleton import Array
from mcml.numerics.runs import find_equal
from mcml_service.analysis.dance.figure import Figure

Difference = Literal["central", "forward"]
Frames = NDArray[np.intp]
REASONS = ("beat", "end", "F1", "F2", "F3")
"""Verdicts on a candidate by their number: accepted; too near an end of the clip; the first condition that fails."""

BAND = (0.5, 3.0)
"""Hz: 30 to 180 beats a minute."""
_FLANK, _BELOW = (0.2, 0.5), 0.05
_BLOCK = 8192
_CUT = 4.0


@dataclass(frozen=True)
class Candidates:
    """Minima of the speed. frames: (C,). verdicts: (C,) into REASONS. dips, rests: (C,) the figures of F2 and F3.

    dip: mean speed of the window less the candidate's. rest: the candidate's speed. Both as parts of the mean speed.
    """

    frames: Frames
    verdicts: NDArray[np.int8]
    dips: Array
    rests: Array

    @property
    def beats(self) -> Frames:
        accepted: Frames = self.frames[self.verdicts == 0]
        return accepted


@dataclass(frozen=True)
class Period:
    """A possible period of the beats.

    seconds: of a beat. strength: power of the bin of their spectrum, or the strength from the motion (tempo.py).
    """

    seconds: float
    strength: float


def half_up(value: float) -> int:
    """round(x) of the specification: floor(x + 0.5)."""
    return int(np.floor(value + 0.5))


def whole(frames: Array) -> Frames:
    """The frames (n,) that instants between frames are nearest to."""
    nearest: Frames = np.floor(frames + 0.5).astype(np.intp)
    return nearest


def window_of(fps: float) -> int:
    """w, frames: a third of a second, which admits beats up to 180 a minute."""
    return half_up(fps / 3)


def speed_signal(
    figure: Figure,
    translations: Array,
    rotations: Array,
    fps: float,
    smooth: float = 0.04,
    difference: Difference = "central",
) -> Array:
    """Mean speed y (F,) of the joints that count, units a second. Ho et al. (2013), eq. 1.

    translations: (F, J, 3), rotations: (F, J, 4). smooth: standard deviation, seconds, of the Gaussian over the
    positions (0: none). Memory is bounded by blocks of frames. O(F J).
    """
    frames = len(rotations)
    halo = int(_CUT * smooth * fps + 0.5) + 1
    speed = np.zeros(frames)
    for first in range(0, frames, _BLOCK):
        last = min(frames, first + _BLOCK)
        low, high = max(0, first - halo), min(frames, last + halo)
        positions, _ = walked(figure.skeleton, translations[low:high], rotations[low:high])
        positions = np.ascontiguousarray(positions[:, figure.used].transpose(1, 2, 0))
        speed[first:last] = mean_speed(positions, fps, smooth, difference)[first - low : last - low]
    return speed


def mean_speed(positions: Array, fps: float, smooth: float = 0.04, difference: Difference = "central") -> Array:
    """Mean speed (F,) of points (P, 3, F), units a second."""
    frames = positions.shape[-1]
    if frames < 2 or not len(positions):
        return np.zeros(frames)
    if smooth > 0:
        positions = scipy.ndimage.gaussian_filter1d(positions, smooth * fps, axis=-1, mode="nearest", truncate=_CUT)
    steps = np.diff(positions, axis=-1)
    velocity = np.empty_like(positions)
    velocity[..., :-1] = steps
    velocity[..., -1] = steps[..., -1]
    if difference == "central":
        velocity[..., 1:-1] = (positions[..., 2:] - positions[..., :-2]) / 2
    squares = np.einsum("pcf,pcf->pf", velocity, velocity)
    speed: Array = np.sqrt(squares).mean(axis=0) * fps
    return speed


def minima(speed: Array) -> Frames:
    """Strict local minima of (F,) away from the ends; of a run of equal values its middle frame.

    >>> minima(np.array([3.0, 1, 2, 0, 0, 0, 0, 5, 5, 6])).tolist()
    [1, 4]
    """
    if len(speed) < 3:
        return np.empty(0, dtype=np.intp)
    starts, ends = find_equal(speed).T
    values = speed[starts]
    lower = (values[1:-1] < values[:-2]) & (values[1:-1] < values[2:])
    middles: Frames = ((starts[1:-1] + ends[1:-1] - 1) // 2)[lower]
    return middles


def window_means(speed: Array, window: int) -> Array:
    """(F,) mean over the frames within `window` of each, as far as the clip goes."""
    sums = np.concatenate([[0.0], np.cumsum(speed)])
    frames = np.arange(len(speed))
    low, high = np.maximum(frames - window, 0), np.minimum(frames + window, len(speed) - 1) + 1
    means: Array = (sums[high] - sums[low]) / (high - low)
    return means


def refine(speed: Array, fps: float, k2: float = 2 / 15, k3: float = 1.0) -> Candidates:
    """Minima with the verdict of F1 (least of its window, and a window after the beat before), F2 (deep), F3 (slow).

    Choi (2024), eqs. 1 to 3. speed: (F,). k2: least dip, k3: greatest rest, parts of the mean speed. O(F).
    """
    window, frames, mean = window_of(fps), minima(speed), float(speed.mean()) if len(speed) else 0.0
    if not len(frames) or mean <= 0:
        return Candidates(frames[:0], np.empty(0, dtype=np.int8), np.empty(0), np.empty(0))
    margin = max(1, window // 4)
    at_end = (frames < margin) | (len(speed) - 1 - frames < margin)
    least = scipy.ndimage.minimum_filter1d(speed, 2 * window + 1, mode="nearest")[frames]
    values = speed[frames]
    dips, rests = (window_means(speed, window)[frames] - values) / mean, values / mean
    verdicts = np.select([at_end, values > least, dips < k2, rests > k3], [1, 2, 3, 4], 0).astype(np.int8)
    before = -window - 1
    for place in np.flatnonzero((verdicts != 1) & (verdicts != 2)):
        if frames[place] - before <= window:
            verdicts[place] = 2
        elif verdicts[place] == 0:
            before = frames[place]
    return Candidates(frames, verdicts, dips, rests)


def locate(speed: Array, beats: Frames, fps: float) -> Array:
    """Return beats (n,), between frames, at the rests of the movement: midway between the zeros of its two flanks.

    Smoothing shifts a minimum towards the side with less movement, by up to half the Gaussian's width, and within a
    rest it is arbitrary. The flanks keep their place: each is the line through 0.2 and 0.5 of the way from the minimum
    to the lower of the two crests within w frames, followed down to 0, but no further than 0.05 s below the minimum. A
    beat without crests is the vertex of the parabola through its three frames. None moves more than w / 4.
    """
    if not len(beats):
        return np.empty(0)
    window = window_of(fps)
    away = np.arange(window + 1)
    least = speed[beats]
    flanks = [speed[np.clip(beats[:, None] + side * away, 0, len(speed) - 1)] for side in (-1, 1)]
    height = np.minimum(flanks[0].max(axis=1), flanks[1].max(axis=1)) - least
    rises = height > 1e-9 * speed.mean()
    scale = np.where(rises, height, 1.0)
    move = np.zeros(len(beats))
    for side, flank in zip((-1, 1), flanks, strict=True):
        low, high = (_crossing(flank, least + part * scale) for part in _FLANK)
        pace = (high - low) / ((_FLANK[1] - _FLANK[0]) * scale)
        move += side / 2 * (low - _FLANK[0] * scale * pace - np.minimum(least * pace, _BELOW * fps))
    move = np.where(rises, move, _vertex(speed, beats))
    located: Array = np.clip(beats + np.clip(move, -(window // 4), window // 4), 0, len(speed) - 1)
    return located


def _vertex(speed: Array, beats: Frames) -> Array:
    """(n,) frames from a minimum to the vertex of the parabola through it and its neighbours."""
    before = speed[np.maximum(beats - 1, 0)]
    after = speed[np.minimum(beats + 1, len(speed) - 1)]
    curve = before - 2 * speed[beats] + after
    vertex: Array = np.where(curve > 0, 0.5 * (before - after) / np.where(curve > 0, curve, 1.0), 0.0)
    return vertex


def _crossing(flank: Array, level: Array) -> Array:
    """(n,) where rows (n, k) first reach their level, between columns; 0 where they do not."""
    above = flank >= level[:, None]
    column = above.argmax(axis=1)
    rows = np.arange(len(flank))
    reached, before = flank[rows, column], flank[rows, np.maximum(column - 1, 0)]
    part = (reached - level) / np.where(reached > before, reached - before, 1.0)
    return np.where(above.any(axis=1), column - part, 0.0)


def beat_wave(beats: Array, frames: int) -> Array:
    """s (frames,): a cosine whose crests are the beats (n,), frames or between; 0 outside. Kim et al. (2003)."""
    wave = np.zeros(frames)
    if len(beats) < 2:
        return wave
    first, last = int(np.ceil(beats[0])), int(np.ceil(beats[-1]))
    time = np.arange(first, last)
    interval = np.searchsorted(beats, time, side="right") - 1
    start, end = beats[interval], beats[interval + 1]
    wave[first:last] = np.cos(2 * np.pi * (time - start) / (end - start))
    return wave


def periods(beats: Array, frames: int, fps: float, count: int = 3) -> list[Period]:
    """The highest peaks of the power spectrum of `beat_wave` between 30 and 180 a minute, the highest first.

    Empty with fewer than two beats or without a peak. Of peaks within 1e-9 of the highest the faster one
    comes first. O(F log F).
    """
    if len(beats) < 2:
        return []
    length = 1 << (8 * frames - 1).bit_length()
    power = np.abs(np.fft.rfft(beat_wave(beats, frames), length)) ** 2
    bins = np.arange(1, len(power) - 1)
    hertz = bins * fps / length
    inside = (hertz >= BAND[0]) & (hertz <= BAND[1])
    peaks = bins[inside & (power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:])]
    if not len(peaks):
        return []
    order = peaks[np.lexsort((-peaks, -power[peaks]))]
    equal = power[order] >= power[order[0]] * (1 - 1e-9)
    order = np.concatenate([np.sort(order[equal])[::-1], order[~equal]])[:count]
    return [Period(length / (fps * _crest(power, peak)), float(power[peak])) for peak in order]


def _crest(power: Array, peak: int) -> float:
    """The bin, not whole, of the parabola through the logarithms of three bins."""
    before, at, after = np.log(np.maximum(power[peak - 1 : peak + 2], np.finfo(float).tiny))
    curve = before - 2 * at + after
    return float(peak + (0.5 * (before - after) / curve if curve < 0 else 0.0))
