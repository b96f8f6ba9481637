"""When each bar plays: the music's grid, the rate of the dance against it, and the map from output to source time.

Park, Shin, Shin (SCA 2002): incremental time warping; here a monotone cubic through the beats. Times in seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Literal

import numpy as np
import scipy

from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.motion_beats import half_up

Warp = Literal["beats", "uniform"]
PULSES = (Fraction(1), Fraction(2), Fraction(1, 2))
"""Music beats per motion beat, the preferred one first."""


def even_grid(bpm: float, bars: int, start: float = 0.0) -> Array:
    """(4 bars + 1,) times of music beats at a tempo. Nothing is rounded: a tempo does not drift."""
    return np.array([start + beat * 60.0 / bpm for beat in range(4 * bars + 1)])


def frame_count(grid: Array, fps: float) -> int:
    """Frames of the whole dance: frame k shows the time k / fps."""
    return half_up(float(grid[-1]) * fps)


def motion_grid(grid: Array, pulse: Fraction) -> Array:
    """Times of motion beats, 4 M + 1: every pulse-th music beat, midpoints added for one half."""
    if pulse == Fraction(1, 2):
        halves = np.empty(2 * len(grid) - 1)
        halves[::2] = grid
        halves[1::2] = (grid[:-1] + grid[1:]) / 2
        return halves
    return grid[:: int(pulse)]


def choose_pulse(music_beat: float, own_beat: float, bars: int) -> Fraction:
    """The pulse that divides the bars and brings pulse * music beat nearest to the dance's own beat, in |log2|."""
    fitting = [pulse for pulse in PULSES if divides(pulse, bars)]
    return min(fitting, key=lambda pulse: round(abs(float(np.log2(float(pulse) * music_beat / own_beat))), 9))


def divides(pulse: Fraction, bars: int) -> bool:
    """Tell whether a number of bars of music are whole bars of motion."""
    return (bars / pulse).denominator == 1


@dataclass(frozen=True)
class Segment:
    """Bars of a path that follow each other in their clip, from one jump to the next.

    first, last: positions in the path. start, end: output times. beat: output time of its first beat. knots: (2, n)
    output times and source frames.
    """

    first: int
    last: int
    start: float
    end: float
    beat: float
    knots: Array


def segments(
    path: Sequence[int],
    natural: Sequence[bool],
    bars: Array,
    entries: Array,
    leaves: Array,
    grid: Array,
    warp: Warp = "beats",
    play_on: bool = False,
) -> list[Segment]:
    """Runs of natural pairs with the knots of their time maps.

    path: (M,) bars. natural: (M - 1,) whether the step to the next bar is natural. bars: (B, 4), entries, leaves: (B,)
    source frames. grid: (4 M + 1,) motion beats. warp: "uniform" keeps the first and last knot of each bar (Choi 2024).
    play_on: maps end a beat later, at leave, for a blend in which the first motion plays on.
    """
    cuts = [0, *(place + 1 for place, follows in enumerate(natural) if not follows), len(path)]
    pieces = []
    for first, stop in pairwise(cuts):
        last = stop - 1
        times: list[float] = []
        frames: list[float] = []
        if first > 0:
            times.append(grid[4 * first - 1])
            frames.append(entries[path[first]])
        for place in range(first, stop):
            inner = (0, 1, 2, 3) if warp == "beats" else (0, 3) if place == 0 else (3,)
            times += [grid[4 * place + beat] for beat in inner]
            frames += [bars[path[place]][beat] for beat in inner]
        ends = len(path) - 1 == last
        end = float(grid[-1] if ends else grid[4 * last + 3])
        if ends or play_on:
            times.append(grid[4 * last + 4])
            frames.append(leaves[path[last]])
        start = float(grid[0] if first == 0 else grid[4 * first - 1])
        pieces.append(Segment(first, last, start, end, float(grid[4 * first]), np.array([times, frames], dtype=float)))
    return pieces


def source_frames(segment: Segment, times: Array) -> Array:
    """Fractional source frames (n,) at output times, by a monotone cubic; still before and after the knots."""
    knots = segment.knots
    curve = scipy.interpolate.PchipInterpolator(knots[0], knots[1])
    frames: Array = curve(np.clip(times, knots[0, 0], knots[0, -1]))
    return frames


def sample(translations: Array, rotations: Array, frames: Array) -> tuple[Array, Array]:
    """Poses at fractional frames (n,): lerp of translations (F, J, 3), shortest slerp of rotations (F, J, 4).

    Outside the clip its first or last pose holds.
    """
    inside = np.clip(frames, 0, len(rotations) - 1)
    before = np.minimum(inside.astype(np.intp), max(0, len(rotations) - 2))
    after = np.minimum(before + 1, len(rotations) - 1)
    part = (inside - before)[:, None]
    moved = translations[before] + (translations[after] - translations[before]) * part[..., None]
    return moved, slerp(rotations[before], rotations[after], np.broadcast_to(part, rotations[before].shape[:-1]))
