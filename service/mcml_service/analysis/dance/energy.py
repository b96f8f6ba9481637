"""Energy along the music: its loudness by bar, against how far hands and feet move in a beat."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.bar_graph import AllBars
from mcml_service.analysis.dance.figure import Figure
from mcml_service.analysis.dance.motion_beats import speed_signal
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.interface import AnalysisError

_LIMB = re.compile(r"hand|wrist|foot|ankle|toe", re.IGNORECASE)
_LEAST = 1e-3
"""Seconds of a bar of which the loudness must be known."""


@dataclass(frozen=True)
class Loudness:
    """Loudness of music. beats: (n,) seconds, ascending. levels: (n,) RMS from each beat to the next."""

    beats: Array
    levels: Array


def measure_levels(samples: Array, rate: float, beats: Array) -> Array:
    """(n,) RMS of sound from each beat to the next, of the last one for as long as the one before. beats: seconds."""
    ends = np.append(beats[1:], 2 * beats[-1] - beats[-2] if len(beats) > 1 else len(samples) / rate)
    edges = np.clip((np.stack([beats, ends]) * rate).astype(np.intp), 0, len(samples))
    sums = np.concatenate([[0.0], np.cumsum(np.square(samples, dtype=np.float64))])
    squares = (sums[edges[1]] - sums[edges[0]]) / np.maximum(edges[1] - edges[0], 1)
    levels: Array = np.sqrt(np.maximum(squares, 0.0))
    return levels


def check_loudness(beats: Sequence[float] | None, levels: Sequence[float] | None, needed: bool) -> Loudness | None:
    """Return the loudness of music, if it is known. Raises AnalysisError `loudness-unknown` where it is needed."""
    if beats is None or levels is None:
        if needed:
            raise AnalysisError(
                "loudness-unknown",
                "The dance is to follow the loudness of music, which is not given.",
                remedy="Send music with its loudness, as POST /music answers, or set energy to 0.",
            )
        return None
    if len(levels) != len(beats):
        raise AnalysisError(
            "loudness-unknown",
            f"The music has {len(beats)} beats and {len(levels)} values of loudness.",
            remedy="Give one value for each beat, or leave loudness out.",
        )
    return Loudness(np.array(beats), np.array(levels))


def find_bar_loudness(loudness: Loudness, grid: Array) -> Array:
    """(M,) RMS of each bar of a dance; NaN where no beat of the music tells. grid: (4 M + 1,) motion beats, seconds."""
    beats = loudness.beats
    last = 2 * beats[-1] - beats[-2]
    ends = np.append(beats, last)
    sums = np.concatenate([[0.0], np.cumsum(loudness.levels**2 * np.diff(ends))])
    edges = np.clip(grid[::4], ends[0], ends[-1])
    seconds = np.diff(edges)
    covered = seconds > _LEAST
    power = np.diff(np.interp(edges, ends, sums)) / np.where(covered, seconds, 1.0)
    levels: Array = np.where(covered, np.sqrt(np.maximum(power, 0.0)), np.nan)
    return levels


def find_efforts(clips: Sequence[Clip], bars: AllBars) -> Array:
    """(B,) mean way of hands and feet in a beat of each bar, in body sizes; a dance keeps it at any tempo."""
    efforts = np.empty(len(bars))
    for owner, clip in enumerate(clips):
        own = np.flatnonzero(bars.owners == owner)
        motion = clip.motion
        speed = speed_signal(find_limbs(clip.figure), motion.translations, motion.rotations, clip.fps)
        sums = np.concatenate([[0.0], np.cumsum(speed)])
        edges = np.clip(np.floor(bars.frames[own][:, [0, 3]] + 0.5).astype(np.intp), 0, len(speed) - 1)
        means = (sums[edges[:, 1] + 1] - sums[edges[:, 0]]) / (edges[:, 1] - edges[:, 0] + 1)
        efforts[own] = means * bars.seconds[own] / (clip.figure.size or 1.0)
    return efforts


def find_limbs(figure: Figure) -> Figure:
    """The figure with hands and feet alone, without fingers; as it is if no joint is named like them."""
    names = [(figure.skeleton.joints[joint].name, figure.skeleton.joints[joint].source_name) for joint in figure.used]
    limbs = figure.used[[any(map(_LIMB.search, pair)) for pair in names]]
    if not len(limbs):
        return figure
    return Figure(figure.skeleton, figure.size, limbs, figure.tips, figure.feet, figure.moved)


def rank(values: Array) -> Array:
    """Ranks from 0 to 1, equal values alike; NaN stays NaN, and a single value is 0.5.

    >>> rank(np.array([5.0, 1.0, 9.0])).tolist()
    [0.5, 0.0, 1.0]
    """
    known = np.isfinite(values)
    ranks = np.full(len(values), np.nan)
    count = int(known.sum())
    ranks[known] = (scipy.stats.rankdata(values[known]) - 1) / (count - 1) if count > 1 else 0.5
    return ranks


def energy_costs(levels: Array, efforts: Array, available: NDArray[np.bool_], weight: float) -> Array:
    """(M, B) cost of each bar at each position: weight * (rank of loudness - rank of effort) squared; 0 where the
    loudness is unknown. levels: (M,). efforts, available: (B,), ranks are among available bars."""
    loud, strong = rank(levels), rank(np.where(available, efforts, np.nan))
    costs: Array = np.nan_to_num(weight * (loud[:, None] - strong[None]) ** 2)
    return costs


def match_energy(levels: Array, efforts: Array) -> float | None:
    """Rank correlation (Spearman) of loudness and effort of a dance's bars (M,); None if either does not vary."""
    known = np.isfinite(levels)
    if known.sum() < 3 or np.ptp(levels[known]) == 0 or np.ptp(efforts[known]) == 0:
        return None
    return float(scipy.stats.spearmanr(levels[known], efforts[known]).statistic)
