"""Music: its beats, and the grid that they make.

Beats are tracked by librosa (Ellis 2007), an optional extra: `audio`. Nothing else here needs it. Times in seconds.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np

from mcml.errors import LimitError, UnsupportedError
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.energy import measure_levels
from mcml_service.analysis.dance.music_tempo import Heard, Meter, Rival, is_clear, meters_of, rivals_of
from mcml_service.analysis.dance.time_warp import even_grid
from mcml_service.analysis.interface import AnalysisError

LONGEST = 15 * 60.0
LATENESS = 0.025
"""Seconds by which tracked beats were measured to come after the clicks they belong to."""
EVEN = 0.035
"""Seconds: beats whose distance from a line is smaller than this (RMS) are one tempo."""
SLOWEST, FASTEST = 40.0, 240.0
FEWEST = 4
WALTZ = 3
"""Beats of a bar that four beats of a dance do not fit into: a dance goes by its bars."""


@dataclass(frozen=True)
class Tempo:
    """Beats as a line: beat i is at start + i * period. residual: RMS distance from it. indices: (n,) of i."""

    start: float
    period: float
    residual: float
    indices: Array

    @property
    def bpm(self) -> float:
        return 60.0 / self.period

    @property
    def even(self) -> bool:
        """Whether the line represents the beats."""
        return self.residual <= EVEN


def fit_tempo(beats: Sequence[float]) -> Tempo:
    """The line through beat times by least squares over whole numbers, round(dt / median dt) apart.

    beats: ascending. Raises AnalysisError `music-no-beats` for fewer than four.
    """
    times = np.asarray(beats, dtype=float)
    steps = np.diff(times)
    if len(times) < FEWEST or not np.isfinite(times).all() or (steps <= 0).any():
        raise AnalysisError(
            "music-no-beats",
            f"The music has {len(times)} beats that can be used; a tempo needs {FEWEST}, one after the other.",
            remedy="Give the tempo as bpm, or set the beats by hand.",
        )
    indices = np.concatenate([[0.0], np.cumsum(np.maximum(1.0, np.floor(steps / np.median(steps) + 0.5)))])
    spread = indices - indices.mean()
    period = float(spread @ times / (spread @ spread))
    start = float(times.mean() - period * indices.mean())
    residual = float(np.sqrt(np.mean((times - start - period * indices) ** 2)))
    return Tempo(start, period, residual, indices)


def music_grid(beats: Sequence[float], bars: int, downbeat: int = 0, factor: float = 1.0, per_bar: int = 4) -> Array:
    """(4 bars + 1,) grid of music with these beats: the line if the tempo is even, else the beats themselves.

    downbeat: index of the beat at which the first bar starts. factor: 2 or 1/2 for music that was tracked at half or
    double its tempo. per_bar: beats of a bar of the music; of music in three, four of whose beats are no bar, each bar
    is one beat of the grid. Raises AnalysisError `music-no-beats`, `too-many-bars`, `bpm-out-of-range`.
    """
    times = np.asarray(beats, dtype=float)
    if per_bar == WALTZ:
        factor /= WALTZ
    tempo = fit_tempo(beats)
    if downbeat >= len(times):
        raise AnalysisError(
            "music-no-beats", f"The music has {len(times)} beats; the first bar cannot start at beat {downbeat + 1}.",
            remedy="Choose an earlier downbeat.",
        )  # fmt: skip
    if tempo.even:
        bpm = check_bpm(tempo.bpm * factor)
        first = tempo.start + tempo.period * tempo.indices[downbeat]
        return even_grid(bpm, bars, float(first))
    check_bpm(tempo.bpm * factor)
    index = np.arange(4 * bars + 1) / factor
    own = np.arange(len(times) - downbeat)
    if index[-1] > own[-1] + 1e-9:
        raise AnalysisError(
            "too-many-bars",
            f"The music has beats for {int(own[-1] * factor) // 4} bars; {bars} were requested.",
            remedy="Ask for fewer bars; this music has no steady tempo that could go on.",
            most=int(own[-1] * factor) // 4,
        )
    uneven: Array = np.interp(index, own, times[downbeat:])
    return uneven


def check_bpm(bpm: float) -> float:
    """The tempo, if it is one. Raises AnalysisError `bpm-out-of-range`."""
    if not (np.isfinite(bpm) and SLOWEST <= bpm <= FASTEST):
        raise AnalysisError(
            "bpm-out-of-range",
            f"{bpm:g} beats a minute is not a tempo to dance to.",
            remedy=f"Give a number from {SLOWEST:g} to {FASTEST:g}.",
            least=SLOWEST,
            most=FASTEST,
        )
    return bpm


def is_sound(first: bytes) -> bool:
    """Whether a file begins like WAV, FLAC or MP3 (with its tag, or with the sync word of a frame)."""
    wave = first[:4] in (b"RIFF", b"RF64") and first[8:12] == b"WAVE"
    return wave or first.startswith((b"fLaC", b"ID3")) or (first[:1] == b"\xff" and first[1:2] >= b"\xe0")


@dataclass(frozen=True)
class Beats:
    """beats: (n,) seconds. rivals: the tempi that the music may have, the taken one first. clear: whether it fits
    clearly better than the others, or was given. meters: beats of a bar, the likelier first. loudness: (n,) RMS of the
    sound from each beat to the next."""

    beats: Array
    rivals: tuple[Rival, ...]
    clear: bool
    meters: tuple[Meter, ...]
    loudness: Array


def track_beats(stream: BinaryIO, name: str = "music", bpm: float | None = None) -> Beats:
    """The beats of WAV, FLAC or MP3. bpm: at about this tempo; else at the one that fits best.

    Raises UnsupportedError without librosa, LimitError above 15 minutes, AnalysisError `music-undecodable`,
    `music-no-beats`.
    """
    try:
        librosa: Any = importlib.import_module("librosa")
    except ImportError:
        raise UnsupportedError(
            "Beats of music are found by librosa, which is not installed here.",
            remedy="Install the extra `audio`, or give the tempo as bpm.",
        ) from None
    known = is_sound(stream.read(12))
    stream.seek(0)
    try:
        samples, rate = librosa.load(stream, sr=22050, mono=True, duration=LONGEST + 1)
    except Exception as error:
        reason = "begins as sound does, but is cut off or damaged" if known else "is no WAV, FLAC or MP3"
        remedy = "Save it again with another program." if known else "Send WAV, FLAC or MP3."
        raise AnalysisError("music-undecodable", f"{name} {reason}.", remedy=remedy) from error
    if len(samples) > LONGEST * rate:
        raise LimitError(f"{name} is longer than 15 minutes.", remedy="Cut it.")
    if not len(samples):
        raise AnalysisError("music-undecodable", f"{name} has no sound in it.", remedy="Send WAV, FLAC or MP3.")
    loudness = librosa.onset.onset_strength(y=samples, sr=rate)
    at = librosa.onset.onset_detect(onset_envelope=loudness, sr=rate)
    heard = Heard(librosa.frames_to_time(at, sr=rate), loudness[at])

    def track(about: float | None) -> Array:
        options: dict[str, Any] = {} if about is None else {"bpm": about}
        _, beats = librosa.beat.beat_track(onset_envelope=loudness, sr=rate, units="time", trim=False, **options)
        return np.asarray(beats, dtype=float)

    first = fit_tempo(track(bpm).tolist())
    rivals = rivals_of(bpm or first.bpm, track, heard, SLOWEST, FASTEST)
    if bpm is not None:
        rivals.sort(key=lambda rival: rival.ratio != 1)
    beats = rivals[0].beats if rivals else track(bpm)
    meters = tuple(meters_of(beats, heard))
    beats = np.maximum(0.0, beats - LATENESS)
    fit_tempo(beats.tolist())
    clear = bpm is not None or (bool(rivals) and is_clear(rivals))
    return Beats(beats, tuple(rivals), clear, meters, measure_levels(samples, rate, beats))
