"""Bars: four beats a period apart, as detected or tracked, and the frames before and after them that a bar plays.

Choi (2024) with the reference beats of Kim, Park, Shin (2003); tracking: Ellis (2007), on minima.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.motion_beats import Frames, locate, window_means, window_of

Source = Literal["detected", "tracked", "auto"]
Tolerance = float | Literal["window"]
EntryFrom = Literal["beat", "third"]
TIGHTNESS = 10.0
"""Weight of a step's distance from the period, in the logarithm, against a beat's strength."""
ENOUGH = 4
"""Bars of a clip below which `auto` takes tracked beats of another tempo."""
SAME_TEMPO = 0.02
"""Greatest part by which the tempi of detected and tracked bars differ if they are the same."""
Reason = Literal["requested", "no tempo", "more bars", "no more bars", "other tempo", "few bars"]
"""Why a clip has these beats: as requested; no tempo, so no bars; tracked beats give more bars, or no more, at the
tempo of the detected ones; their tempo differs; or detected beats give fewer than four bars."""
_SUPPORTED = 3


@dataclass(frozen=True)
class Bars:
    """Beats of a clip and its bars, in frames or between them. beats: (n,). supported: (n,) whether there is a dip.

    bars: (m, 4). source: the kind of beats. entries, leaves: (m,) start of the lead-in and end of the following beat;
    they may be outside the clip, where a pose is held. reason: why these beats. compared: bars of detected and of
    tracked beats, if both were made.
    """

    source: Literal["detected", "tracked"]
    beats: Array
    supported: NDArray[np.bool_]
    bars: Array
    entries: Array
    leaves: Array
    reason: Reason = "requested"
    compared: tuple[int, int] | None = None

    @property
    def period(self) -> float | None:
        """The median beat of the bars, in frames; None without bars."""
        return float(np.median(self.bars[:, 3] - self.bars[:, 0])) / 3 if len(self.bars) else None

    @property
    def support(self) -> float:
        """Share of the beats with a dip."""
        return float(self.supported.mean()) if len(self.supported) else 0.0


def good_intervals(beats: Array, period: float, tolerance: Tolerance = 0.2, window: int = 0) -> NDArray[np.bool_]:
    """(n - 1,) whether successive beats are a period (frames) apart, within a part of it, or +- w frames ("window")."""
    allowed = window if tolerance == "window" else tolerance * period
    good: NDArray[np.bool_] = np.abs(np.diff(beats) - period) <= allowed
    return good


def group(good: NDArray[np.bool_], supported: NDArray[np.bool_], stride: int = 4) -> list[int]:
    """Indices of the first beats of bars: three good intervals in a row, at least three of four beats supported."""
    groups, beat = [], 0
    while beat + 3 <= len(good):
        if good[beat : beat + 3].all() and supported[beat : beat + 4].sum() >= _SUPPORTED:
            groups.append(beat)
            beat += stride
        else:
            beat += 1
    return groups


def bars_of(
    beats: Array,
    supported: NDArray[np.bool_],
    source: Literal["detected", "tracked"],
    period: float | None,
    window: int,
    tolerance: Tolerance = 0.2,
    stride: int = 4,
    lead_in: EntryFrom = "beat",
) -> Bars:
    """Bars among beats, with entry and leave. period: frames, None: no bars."""
    if period is None or len(beats) < ENOUGH:
        return Bars(source, beats, supported, np.empty((0, 4)), np.empty(0), np.empty(0))
    good = good_intervals(beats, period, tolerance, window)
    first = group(good, supported, stride)
    bars = np.array([beats[start : start + 4] for start in first]).reshape(-1, 4)
    thirds = np.floor((bars[:, 3] - bars[:, 0]) / 3 + 0.5)
    entries, leaves = bars[:, 0] - thirds, bars[:, 3] + thirds
    for place, start in enumerate(first if lead_in == "beat" else []):
        if start > 0 and good[start - 1]:
            entries[place] = beats[start - 1]
        if start + 3 < len(good) and good[start + 3]:
            leaves[place] = beats[start + 4]
    return Bars(source, beats, supported, bars, entries, leaves)


def find_bars(
    speed: Array,
    fps: float,
    candidates: Frames,
    beats: Array,
    period: float | None,
    which: Source = "auto",
    k2: float = 2 / 15,
    tolerance: Tolerance = 0.2,
    stride: int = 4,
    lead_in: EntryFrom = "beat",
    middle: bool = True,
) -> Bars:
    """Bars of a clip. speed: (F,). candidates, beats: frames. period: seconds of a beat, None where unknown.

    auto: see `choose_bars`. middle: tracked beats, too, move to the middle of the rest.
    """
    window, step = window_of(fps), None if period is None else period * fps
    sure = np.ones(len(beats), dtype=bool)
    detected = bars_of(beats, sure, "detected", step, window, tolerance, stride, lead_in)
    if step is None or which == "detected":
        return replace(detected, reason="requested" if which == "detected" else "no tempo")
    strength = beat_strength(speed, candidates, window)
    path = track(strength, step)
    supported = strength[path] >= k2
    moved = np.where(supported, locate(speed, path, fps), path) if middle else path.astype(float)
    tracked = bars_of(moved, supported, "tracked", step, window, tolerance, stride, lead_in)
    return tracked if which == "tracked" else choose_bars(detected, tracked)


def choose_bars(detected: Bars, tracked: Bars) -> Bars:
    """Choose between detected and tracked beats, and say why.

    If their bars have the same tempo within 2 %, those with more bars, detected ones if equal. Otherwise detected ones,
    unless they give fewer than four bars and tracked ones more.
    """
    first, second = detected.period, tracked.period
    more = len(tracked.bars) > len(detected.bars)
    reason: Reason = "more bars" if more else "no more bars"
    if more and (first is None or second is None or abs(first / second - 1) > SAME_TEMPO):
        more = len(detected.bars) < ENOUGH
        reason = "few bars" if more else "other tempo"
    counts = len(detected.bars), len(tracked.bars)
    return replace(tracked if more else detected, reason=reason, compared=counts)


def beat_strength(speed: Array, candidates: Frames, window: int) -> Array:
    """S (F,): the dip below the mean of its window at candidates, as a part of the mean speed, 0 elsewhere."""
    strength = np.zeros(len(speed))
    mean = float(speed.mean()) if len(speed) else 0.0
    if mean > 0:
        strength[candidates] = np.maximum(0.0, (window_means(speed, window) - speed)[candidates]) / mean
    return strength


def track(strength: Array, period: float) -> Frames:
    """Beats by dynamic programming: strong frames at steps near the period (frames). Ellis (2007), eqs. 5, 6.

    C(t) = S(t) + max(0, max over lags l in [2p/3, 3p/2] of C(t - l) - 10 ln(l / p)^2), from its greatest value back.
    Ties: the shortest lag. Frames nearer than the shortest lag do not depend on each other: blocks at once. O(F p).
    """
    shortest, longest = max(1, int(np.ceil(2 * period / 3 - 1e-9))), int(np.floor(3 * period / 2 + 1e-9))
    frames = len(strength)
    if not frames or not strength.any() or longest < shortest:
        return np.empty(0, dtype=np.intp)
    lags = np.arange(shortest, longest + 1)
    penalty = TIGHTNESS * np.log(lags / period) ** 2
    score = np.full(longest + frames, -np.inf)
    before = np.zeros(frames, dtype=np.intp)
    for first in range(0, frames, shortest):
        last = min(frames, first + shortest)
        # Row t - first holds C(t - longest) .. C(t - shortest); reversed, the shortest lag is first.
        earlier = sliding_window_view(score[first : last + longest - shortest], len(lags))[: last - first, ::-1]
        gains = earlier - penalty
        best = gains.argmax(axis=1)
        gain = gains[np.arange(last - first), best]
        score[longest + first : longest + last] = strength[first:last] + np.maximum(0.0, gain)
        before[first:last] = np.where(gain > 0, lags[best], 0)
    frame = int(score[longest:].argmax())
    path = [frame]
    while before[frame]:
        frame -= int(before[frame])
        path.append(frame)
    return np.array(path[::-1], dtype=np.intp)


def find_held_frames(entries: Array, leaves: Array, frames: int) -> Array:
    """Return (m,) frames of each bar's lead-in and leave outside the clip, where a pose is held."""
    held: Array = np.maximum(0, -entries) + np.maximum(0, leaves - (frames - 1))
    return held
