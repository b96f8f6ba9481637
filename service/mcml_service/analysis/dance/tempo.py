"""The tempo of a motion itself, of one clip or of several to the same music: periodicity of rests, braking and bounce.

It does not rest on beats, so it does not depend on where they were found, nor on the frame rate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from mcml.motion.hub import walked
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.figure import Figure

TempoRule = Literal["robust", "paper"]
RATE = 60.0
"""Hz to which every clip is brought."""
JUMP = 6.0
"""Mean speeds above which no dancer moves: a pose of calibration is left."""
_BLOCK = 4096
_HALO = 40
_DRIFT = 0.05
"""Frames by which a clip at a multiple of 60 Hz may stray from it."""
_WINDOW, _WHOLE = 20.0, 25.0
TEMPI = np.geomspace(35.0, 240.0, 2400)
_PADDED = 1 << 15
_WEIGHTS = np.array([0.5, 1.0, 0.5]) / 2.0
_USUAL, _WIDTH = 120.0, 0.8
_SAME = 0.04
_RELATED = (1.0, 2.0, 0.5, 3.0, 1 / 3, 1.5, 2 / 3)
_RIVAL, _STRENGTH, _LONG = 0.3, 1.3, 70.0
_OCTAVE, _STEADY = 0.5, 0.6
_LEAST, _BEATS, _AGREED = 0.15, 16.0, 0.8
"""Periodicity, beats of motion, and the share of windows that agree, that a clear tempo has at least. Chosen with a few
dances to known music and motions that are no dance in view, not on a collection of captures with known music: bows,
walks and steps of five seconds are as regular as a dance, so what is short is never clear."""


@dataclass(frozen=True)
class Peak:
    """A tempo that the motion may have. bpm: beats a minute. strength: its periodicity, 0 to 1. score: weighed by how
    usual it is, as a part of the best one's."""

    bpm: float
    strength: float
    score: float


@dataclass(frozen=True)
class Tempo:
    """peaks: the best first, at least one. rival: the best score at no simple ratio to the first, octave: at one, of
    those at 1 at most. steady: share of the windows that agree, octaves aside. seconds: of motion, all clips."""

    peaks: tuple[Peak, ...]
    rival: float
    octave: float
    steady: float
    seconds: float

    @property
    def clear(self) -> bool:
        """Whether one tempo is far above chance and other motion, so that it is certain."""
        least = max(_LEAST, _STRENGTH / min(self.seconds, _LONG))
        told = self.rival <= _RIVAL and self.peaks[0].strength >= least
        return told and self.steady >= _AGREED and self.seconds / self.period >= _BEATS

    @property
    def period(self) -> float:
        """Seconds a beat."""
        return 60.0 / self.peaks[0].bpm

    def warnings(self) -> list[tuple[str, str]]:
        """(code, sentence)."""
        best = f"{self.peaks[0].bpm:.1f} beats a minute"
        others = ", ".join(f"{peak.bpm:.1f}" for peak in self.peaks[1:3])
        texts = []
        if not self.clear:
            rivals = f" as well as {others}" if others else ""
            texts.append(
                ("tempo-unclear", f"The tempo is ambiguous: {best}{rivals}. State it as source_bpm if it is known.")
            )
        if self.octave >= _OCTAVE:
            texts.append(("tempo-octave", f"The tempo may be {best}, or a simple multiple or part of it ({others})."))
        if self.steady < _STEADY:
            share = f"{100 * (1 - self.steady):.0f} %"
            texts.append(("tempo-changes", f"{share} of the windows of 20 s have another tempo than {best}."))
        return texts


def body_channels(figure: Figure, translations: Array, rotations: Array, fps: float) -> Array:
    """(3, n) at 60 Hz: rests, braking and vertical movement of a body, without what is slower than a second or two.

    translations: (F, J, 3), rotations: (F, J, 4), Y up, F >= 2. Memory is bounded by blocks of frames. O(F J).
    """
    if not len(figure.used):
        return np.zeros((3, 0))
    first = _after_calibration(figure, translations, rotations, fps)
    translations, rotations = translations[first:], rotations[first:]
    every = max(1, round(fps / RATE))
    if abs(fps / RATE / every - 1) * len(rotations) < _DRIFT:
        # At its knots a spline equals the original values.
        translations, rotations, fps = translations[::every], rotations[::every], RATE
    frames = len(rotations)
    count = int((frames - 1) / fps * RATE + 1e-9) + 1
    movement = np.empty((3, count))
    halo = int(np.ceil(_HALO * max(1.0, fps / RATE)))
    for start in range(0, count, _BLOCK):
        stop = min(count, start + _BLOCK)
        around = max(0, start - _HALO // 2), min(count, stop + _HALO // 2)
        low = max(0, int(around[0] * fps / RATE) - halo)
        high = min(frames, int(np.ceil(around[1] * fps / RATE)) + halo + 1)
        positions, _ = walked(figure.skeleton, translations[low:high], rotations[low:high])
        used = positions[:, figure.used].reshape(high - low, -1)
        if fps == RATE:
            here = used[around[0] - low : around[1] - low]
        else:
            here = scipy.interpolate.CubicSpline(np.arange(low, high) / fps, used)(np.arange(*around) / RATE)
        points = np.ascontiguousarray(here.T).reshape(-1, 3, around[1] - around[0])
        movement[:, start:stop] = _movement(points)[:, start - around[0] : stop - around[0]]
    speed, braking, rising = movement
    return np.stack([_rests(speed), _brakes(braking), _bounce(rising)])


def _after_calibration(figure: Figure, translations: Array, rotations: Array, fps: float) -> int:
    """The frame behind a jump within the first second, else 0."""
    head, _ = walked(figure.skeleton, translations[: 4 * int(fps) + 2], rotations[: 4 * int(fps) + 2])
    steps = np.linalg.norm(np.diff(head[:, figure.used], axis=0), axis=2).mean(axis=1)
    jumps = np.flatnonzero(steps[: int(fps)] > JUMP * steps.mean())
    return int(jumps[-1]) + 1 if len(jumps) and jumps[-1] + 2 < len(rotations) else 0


def _movement(positions: Array) -> Array:
    """Mean speed, mean braking, mean vertical velocity, (3, n), of points (P, 3, n) at 60 Hz."""
    smooth = scipy.ndimage.gaussian_filter1d(positions, 0.05 * RATE, axis=-1, mode="nearest")
    velocity = np.gradient(smooth, axis=-1) * RATE if positions.shape[-1] > 1 else np.zeros_like(positions)
    speeds = np.sqrt(np.einsum("pcf,pcf->pf", velocity, velocity))
    slowing = np.maximum(0.0, -np.gradient(speeds, axis=-1) * RATE) if speeds.shape[-1] > 1 else np.zeros_like(speeds)
    return np.stack([speeds.mean(axis=0), slowing.mean(axis=0), velocity[:, 1].mean(axis=0)])


def _blur(series: Array, seconds: float) -> Array:
    blurred: Array = scipy.ndimage.gaussian_filter1d(series, seconds * RATE, mode="nearest")
    return blurred


def _quick(series: Array) -> Array:
    return series - _blur(series, 0.75)


def _rests(speed: Array) -> Array:
    floor = 0.1 * float(np.median(speed))
    return np.clip(-_quick(np.log(speed + floor)), -2, 2) if floor > 0 else np.zeros_like(speed)


def _brakes(braking: Array) -> Array:
    mean = float(braking.mean())
    return _quick(np.clip(braking / (_blur(braking, 1.5) + 0.1 * mean), 0, 4)) if mean > 0 else np.zeros_like(braking)


def _bounce(rising: Array) -> Array:
    spread = float(rising.std())
    if not spread > 0:
        return np.zeros_like(rising)
    return _quick(np.clip(rising / (np.sqrt(_blur(rising**2, 1.5)) + 0.1 * spread), -3, 3))


def tempo_of(clips: Sequence[Array]) -> Tempo | None:
    """The tempo of clips that share their music, from the channels (3, n) of each; None where nothing moves in time."""
    strengths = [periodicity(window) for channels in clips for window in _windows(channels)]
    if not strengths:
        return None
    whole = np.mean(strengths, axis=0)
    peaks = _peaks(whole)
    if not peaks:
        return None
    best = peaks[0].bpm
    related = {peak: any(_near(peak.bpm / best, ratio) for ratio in _RELATED) for peak in peaks[1:]}
    own = [each[0].bpm for each in map(_peaks, strengths) if each]
    return Tempo(
        peaks,
        rival=max((peak.score for peak, is_related in related.items() if not is_related), default=0.0),
        octave=max((peak.score for peak, is_related in related.items() if is_related), default=0.0),
        steady=sum(_is_octave(bpm / best) for bpm in own) / len(strengths),
        seconds=sum(channels.shape[1] for channels in clips) / RATE,
    )


def _near(ratio: float, wanted: float) -> bool:
    return abs(math.log(ratio / wanted)) <= math.log1p(_SAME)


def _is_octave(ratio: float) -> bool:
    return _near(ratio, 2.0 ** round(math.log2(ratio)))


def _windows(channels: Array) -> list[Array]:
    """Windows of 20 s, half overlapping; the whole up to 25 s."""
    count, size = channels.shape[1], int(_WINDOW * RATE)
    if count <= _WHOLE * RATE:
        return [channels] if count > RATE else []
    starts = np.linspace(0, count - size, int(np.ceil((count - size) / (size / 2))) + 1)
    return [channels[:, start : start + size] for start in starts.astype(int).tolist()]


def periodicity(window: Array) -> Array:
    """Q (2400,) at `TEMPI`: comb of the autocorrelation times coherence, of all channels (3, n)."""
    count = window.shape[1]
    size = 1 << (2 * count - 1).bit_length()
    lags = 60.0 / TEMPI * RATE
    hann = np.hanning(count)
    length = max(_PADDED, 1 << (count - 1).bit_length())
    hertz = np.arange(length // 2 + 1) * RATE / length
    strengths = np.zeros(len(TEMPI))
    for channel, weight in zip(window, _WEIGHTS, strict=True):
        energy = float(channel @ channel)
        if not energy > 0:
            continue
        products = np.fft.irfft(np.abs(np.fft.rfft(channel, size)) ** 2, size)[:count] / energy
        correlation = scipy.interpolate.CubicSpline(
            np.arange(count), products * np.minimum(count / (count - np.arange(count)), 4.0)
        )

        def at(multiple: int, correlation: scipy.interpolate.CubicSpline = correlation) -> Array:
            return np.where(multiple * lags <= count - 1, correlation(np.minimum(multiple * lags, count - 1)), 0.0)

        comb = np.maximum(0.0, (at(1) + at(2) + at(3) / 2 + at(4)) / 3.5)
        power = np.abs(np.fft.rfft(hann * channel, length)) ** 2
        least = float(((hann * channel) ** 2).sum() * (hann**2).sum())
        coherence = np.sqrt(2 * np.interp(TEMPI / 60.0, hertz, power) / least)
        strengths += weight * comb * coherence
    return strengths


def _peaks(strength: Array, most: int = 8) -> tuple[Peak, ...]:
    """Local maxima of the score, the best first, none within 4 % of a better one."""
    score = strength * np.exp(-((np.log2(TEMPI / _USUAL) / _WIDTH) ** 2) / 2)
    places = np.flatnonzero((score[1:-1] > score[:-2]) & (score[1:-1] >= score[2:])) + 1
    peaks: list[Peak] = []
    cell = float(np.log(TEMPI[1] / TEMPI[0]))
    for place in places[np.argsort(-score[places], kind="stable")].tolist():
        before, at, after = np.log(np.maximum(score[place - 1 : place + 2], 1e-300))
        curve = before - 2 * at + after
        move = float(np.clip(0.5 * (before - after) / curve, -0.5, 0.5)) if curve < 0 else 0.0
        bpm = float(TEMPI[place] * np.exp(cell * move))
        if not any(_near(bpm / other.bpm, 1.0) for other in peaks):
            peaks.append(Peak(bpm, float(strength[place]), float(score[place] / score[places].max())))
        if len(peaks) == most:
            break
    return tuple(peaks)
