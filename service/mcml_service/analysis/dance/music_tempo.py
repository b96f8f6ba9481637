"""Find the tempo of music and the beats of its bars: every simple ratio of the detected tempo, with the quality of its
fit.

Trackers take half or double the tempo, or three beats for two, and are as steady at it. So each ratio is rated by an
F-measure: the strength of the sound on its beats, and the share of the sound on beats.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from mcml.motion.skeleton import Array

RATIOS = tuple(Fraction(text) for text in ("1", "2", "1/2", "3", "1/3", "3/2", "2/3"))
NEAR = 0.07
"""Seconds within which what is heard belongs to a beat, at most an eighth of a beat."""
CLEAR = 1.5
"""Ratio of the best tempo's strength to any other from which the tempo is clear."""
USUAL, WIDTH = 120.0, 1.2
"""Beats a minute that are usual, and octaves around it: of tempi that fit as well the more usual one is taken."""
METERS = (4, 3)
_ACCENT = 0.1
"""How much more regular accents of a meter are than those of the other."""

Track: TypeAlias = Callable[[float], Array]
"""Beat times (n,) at about a tempo."""


@dataclass(frozen=True)
class Heard:
    """Onsets of sounds: times (n,) in seconds, and loudness (n,), at least 0."""

    times: Array
    strengths: Array


@dataclass(frozen=True)
class Rival:
    """A tempo at a simple ratio of the first one. strength: from 0 to 1, how well its beats fit what is heard."""

    bpm: float
    ratio: Fraction
    strength: float
    beats: Array


@dataclass(frozen=True)
class Meter:
    """Beats of a bar. strength: regularity of accents after this number of beats, from 0 to 1."""

    beats: int
    strength: float


def rivals_of(bpm: float, track: Track, heard: Heard, slowest: float, fastest: float) -> list[Rival]:
    """The tempi at simple ratios of one, the likeliest first."""
    rivals = []
    for ratio in RATIOS:
        other = bpm * float(ratio)
        if slowest <= other <= fastest:
            beats = track(other)
            if len(beats) >= 4:
                own = 60.0 / _period(beats)
                # A tracker with independent beats has no evidence for this tempo.
                if abs(np.log2(own / other)) < 0.2:
                    rivals.append(Rival(own, ratio, _fits(beats, heard), beats))
    return sorted(rivals, key=lambda rival: -rival.strength * _usual(rival.bpm))


def is_clear(rivals: list[Rival]) -> bool:
    """Whether the first tempo fits clearly better than all others."""
    return all(rivals[0].strength >= CLEAR * other.strength for other in rivals[1:])


def meters_of(beats: Array, heard: Heard) -> list[Meter]:
    """Bars of four and of three beats, the likelier first; four where accents tell nothing."""
    accents = _loudest(beats, heard)
    accents = accents - accents.mean() if len(accents) else accents
    energy = float(accents @ accents)
    meters = []
    for count in METERS:
        again = 0.0
        if energy > 0 and len(accents) > 4 * count:
            pairs = len(accents) - count
            again = float(accents[count:] @ accents[:-count]) / energy * len(accents) / pairs
        meters.append(Meter(count, float(np.clip(again, 0.0, 1.0))))
    return sorted(meters, key=lambda meter: -meter.strength - (_ACCENT if meter.beats == METERS[0] else 0.0))


def _period(beats: Array) -> float:
    """Seconds a beat, the slope of the line through beats whose steps are rounded."""
    steps = np.diff(beats)
    indices = np.concatenate([[0.0], np.cumsum(np.maximum(1.0, np.round(steps / np.median(steps))))])
    spread = indices - indices.mean()
    return float(spread @ beats / (spread @ spread))


def _usual(bpm: float) -> float:
    return float(np.exp(-((np.log2(bpm / USUAL) / WIDTH) ** 2) / 2))


def _fits(beats: Array, heard: Heard) -> float:
    total = float(heard.strengths.sum())
    if not total > 0:
        return 0.0
    loud = float(np.percentile(heard.strengths, 80.0))
    on = _loudest(beats, heard)
    precision = float(np.clip(on / max(loud, 1e-12), 0.0, 1.0).mean())
    near = _reach(beats)
    places = np.clip(np.searchsorted(beats, heard.times), 1, len(beats) - 1)
    away = np.minimum(np.abs(heard.times - beats[places - 1]), np.abs(heard.times - beats[places]))
    share = float(heard.strengths[away <= near].sum()) / total
    return 2 * precision * share / (precision + share) if precision + share > 0 else 0.0


def _reach(beats: Array) -> float:
    return min(NEAR, float(np.median(np.diff(beats))) / 8)


def _loudest(beats: Array, heard: Heard) -> Array:
    """Return (n,) the loudest onset at each beat, 0 without one."""
    near = _reach(beats)
    first, last = np.searchsorted(heard.times, beats - near), np.searchsorted(heard.times, beats + near)
    return np.array([heard.strengths[start:other].max(initial=0.0) for start, other in zip(first, last, strict=True)])
