"""Beats of music as a line or as they are, and what happens to files that are no music."""

from __future__ import annotations

import importlib.util
import io
import sys
import wave

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import UnsupportedError
from mcml_service.analysis.dance import music
from mcml_service.analysis.dance.music_tempo import Heard, is_clear, meters_of, rivals_of
from mcml_service.analysis.interface import AnalysisError


@given(bpm=st.floats(60, 190), start=st.floats(0, 2), seed=st.integers(0, 999))
def test_the_tempo_of_quantised_beats_is_found(bpm: float, start: float, seed: int) -> None:
    """Trackers give times in steps of 23 ms: the line averages them out."""
    true = start + np.arange(200) * 60 / bpm
    heard = np.round(true / 0.0232) * 0.0232
    heard = np.delete(heard, np.random.default_rng(seed).integers(1, 199, 5))
    tempo = music.fit_tempo(heard.tolist())
    assert abs(tempo.bpm - bpm) < 0.02
    assert tempo.even
    assert abs(tempo.start - start) < 0.01


def test_the_line_is_the_least_squares_line() -> None:
    beats = [0.1, 0.6, 1.15, 2.1, 2.6]
    tempo = music.fit_tempo(beats)
    assert tempo.indices.tolist() == [0, 1, 2, 4, 5]
    slope, start = np.polyfit([0, 1, 2, 4, 5], beats, 1)
    assert (tempo.period, tempo.start) == (pytest.approx(slope), pytest.approx(start))


@pytest.mark.parametrize("beats", [[], [1.0, 2.0, 3.0], [1.0, 2.0, 2.0, 3.0], [1.0, float("nan"), 3.0, 4.0]])
def test_too_few_beats_are_named(beats: list[float]) -> None:
    with pytest.raises(AnalysisError) as error:
        music.fit_tempo(beats)
    assert error.value.code == "music-no-beats"


def test_even_music_goes_on_as_its_line() -> None:
    beats = (0.4 + np.arange(20) * 0.5).tolist()
    grid = music.music_grid(beats, 10, downbeat=3)
    assert len(grid) == 41
    assert grid[0] == pytest.approx(1.9)
    assert np.allclose(np.diff(grid), 0.5)
    assert np.allclose(np.diff(music.music_grid(beats, 4, factor=2.0)), 0.25)
    assert np.allclose(np.diff(music.music_grid(beats, 4, factor=0.5)), 1.0)


def test_uneven_music_keeps_its_beats_and_ends_with_them() -> None:
    beats = np.cumsum(np.linspace(0.4, 0.8, 30)).tolist()
    assert not music.fit_tempo(beats).even
    grid = music.music_grid(beats, 5, downbeat=2)
    assert np.allclose(grid, beats[2:23])
    assert np.allclose(music.music_grid(beats, 5, factor=2.0)[::2], beats[:11])
    with pytest.raises(AnalysisError) as error:
        music.music_grid(beats, 9)
    assert (error.value.code, error.value.details["most"]) == ("too-many-bars", 7)


def test_a_downbeat_after_the_last_beat_is_refused() -> None:
    with pytest.raises(AnalysisError, match="beat 21"):
        music.music_grid((np.arange(20) * 0.5).tolist(), 2, downbeat=20)


@pytest.mark.parametrize("bpm", [39.9, 240.1, 0.0, -10.0, float("nan"), float("inf")])
def test_tempi_out_of_range_are_named(bpm: float) -> None:
    with pytest.raises(AnalysisError) as error:
        music.check_bpm(bpm)
    assert error.value.code == "bpm-out-of-range"


def test_without_librosa_the_way_out_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "librosa", None)
    with pytest.raises(UnsupportedError) as error:
        music.track_beats(io.BytesIO(b"RIFF"), "song.wav")
    assert "audio" in (error.value.remedy or "")


class Broken:
    """A decoder that finds nothing it can decode, or nothing at all."""

    def __init__(self, samples: np.ndarray | None) -> None:
        self.samples = samples

    def load(self, stream: object, **options: object) -> tuple[np.ndarray, int]:
        if self.samples is None:
            raise RuntimeError("Format not recognised.")
        return self.samples, 22050


@pytest.mark.parametrize("samples", [None, np.zeros(0)])
def test_what_is_no_music_is_named(samples: np.ndarray | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "librosa", Broken(samples))
    with pytest.raises(AnalysisError) as error:
        music.track_beats(io.BytesIO(b"nothing"), "song.wav")
    assert error.value.code == "music-undecodable"


def clicks(bpm: float, seconds: float) -> io.BytesIO:
    rate = 22050
    sound = np.zeros(int(seconds * rate))
    tick = np.sin(2 * np.pi * 1000 * np.arange(800) / rate) * np.exp(-np.arange(800) / 100)
    for beat in np.arange(0.5, seconds - 0.1, 60 / bpm):
        start = int(beat * rate)
        sound[start : start + 800] += tick[: len(sound) - start]
    file = io.BytesIO()
    with wave.open(file, "wb") as target:
        target.setparams((1, 2, rate, 0, "NONE", ""))
        target.writeframes((sound * 20000).astype("<i2").tobytes())
    file.seek(0)
    return file


needs_librosa = pytest.mark.skipif(
    importlib.util.find_spec("librosa") is None, reason="librosa, of the extra `audio`, is not installed"
)


@pytest.mark.slow
@needs_librosa
@pytest.mark.parametrize(
    ("name", "content", "code", "said"),
    [
        ("text.mp3", b"no sound", "music-undecodable", "text.mp3 is no WAV, FLAC or MP3."),
        ("silence.wav", clicks(120.0, 0.02).getvalue(), "music-no-beats", "0 beats"),
    ],
)
def test_what_librosa_cannot_use_is_refused(name: str, content: bytes, code: str, said: str) -> None:
    with pytest.raises(AnalysisError, match=said) as error:
        music.track_beats(io.BytesIO(content), name)
    assert error.value.code == code
    assert error.value.remedy


@pytest.mark.slow
@needs_librosa
def test_clicks_give_their_tempo() -> None:
    tempo = music.fit_tempo(music.track_beats(clicks(128.0, 30.0)).beats.tolist())
    assert abs(tempo.bpm - 128) < 0.2
    late = (tempo.start - 0.5) % (60 / 128)
    assert min(late, 60 / 128 - late) < 0.02


RATE = 22050


def played(bpm: float, per_bar: int, seconds: float = 24.0) -> io.BytesIO:
    """A drum on the first beat of each bar, a softer one on the others."""
    rng = np.random.default_rng(1)
    sound = np.zeros(int(seconds * RATE))
    length = np.arange(1600)
    drum = np.sin(2 * np.pi * 70 * length / RATE) * np.exp(-length / 400)
    soft = 0.5 * rng.normal(size=1600) * np.exp(-length / 250)
    for number, beat in enumerate(np.arange(0.5, seconds - 0.1, 60 / bpm)):
        start = int(beat * RATE)
        stroke = drum if number % per_bar == 0 else 0.6 * soft
        sound[start : start + 1600] += stroke[: len(sound) - start]
    file = io.BytesIO()
    with wave.open(file, "wb") as target:
        target.setparams((1, 2, RATE, 0, "NONE", ""))
        target.writeframes((np.clip(sound, -1, 1) * 20000).astype("<i2").tobytes())
    file.seek(0)
    return file


@needs_librosa
@pytest.mark.parametrize("bpm", [60, 90, 120, 150, 174, 200])
@pytest.mark.parametrize("kind", ["clicks", "four", "three"])
def test_the_tempo_of_steady_music_or_its_rival(kind: str, bpm: int) -> None:
    """The tempo is right, or it is said to be ambiguous, and the right one is among the rivals with its strength."""
    found = music.track_beats(clicks(bpm, 24.0) if kind == "clicks" else played(bpm, 4 if kind == "four" else 3))
    right = [rival for rival in found.rivals if rival.bpm == pytest.approx(bpm, rel=0.02)]
    assert right
    assert 0 < right[0].strength <= 1
    if found.clear:
        assert found.rivals[0].bpm == pytest.approx(bpm, rel=0.02)
    assert music.fit_tempo(found.beats.tolist()).bpm == pytest.approx(found.rivals[0].bpm, rel=0.03)
    if kind == "three":
        assert found.rivals[0].bpm == pytest.approx(bpm, rel=0.02)
        assert [meter.beats for meter in found.meters] == [3, 4]
        assert found.meters[0].strength > found.meters[1].strength


@needs_librosa
@pytest.mark.parametrize("bpm", [75.0, 150.0])
def test_a_tempo_that_is_given_is_taken(bpm: float) -> None:
    found = music.track_beats(played(150.0, 4), bpm=bpm)
    assert found.clear
    assert found.rivals[0].bpm == pytest.approx(bpm, rel=0.02)
    assert music.fit_tempo(found.beats.tolist()).bpm == pytest.approx(bpm, rel=0.02)


def heard(period: float, accents: list[float], seconds: float = 30.0) -> Heard:
    times = np.arange(0.0, seconds, period)
    return Heard(times, np.resize(np.array(accents), len(times)))


def test_each_ratio_is_told_with_its_strength() -> None:
    """Of plain strokes the tempo fits best; with a softer stroke between two, twice it fits as well."""

    def track(bpm: float) -> np.ndarray:
        return np.arange(0.0, 30.0, 60.0 / bpm)

    plain = rivals_of(100.0, track, heard(0.6, [1.0]), 40.0, 240.0)
    assert [str(rival.ratio) for rival in plain][:1] == ["1"]
    assert {str(rival.ratio) for rival in plain} == {"1", "2", "1/2", "3/2", "2/3"}
    assert is_clear(plain)
    halves = rivals_of(100.0, track, heard(0.3, [1.0, 0.7]), 40.0, 240.0)
    assert {round(rival.bpm) for rival in halves[:2]} == {100, 200}
    assert not is_clear(halves)
    threes = rivals_of(100.0, track, heard(0.4, [1.0, 0.5, 0.5]), 40.0, 240.0)
    assert threes[0].bpm == pytest.approx(150)
    assert rivals_of(100.0, track, Heard(np.zeros(0), np.zeros(0)), 40.0, 240.0)[0].strength == 0


@pytest.mark.parametrize(("accents", "beats"), [([1, 0.5, 0.5], 3), ([1, 0.4, 0.7, 0.4], 4), ([1.0], 4)])
def test_accents_tell_bars(accents: list[float], beats: int) -> None:
    found = meters_of(np.arange(0.0, 30.0, 0.5), heard(0.5, accents))
    assert found[0].beats == beats
    assert {meter.beats for meter in found} == {3, 4}


def test_of_music_in_three_bars_are_danced_to() -> None:
    beats = (0.4 + np.arange(60) * 0.4).tolist()
    grid = music.music_grid(beats, 3, downbeat=3, per_bar=3)
    assert len(grid) == 13
    assert grid[0] == pytest.approx(1.6)
    assert np.allclose(np.diff(grid), 1.2)
    assert np.allclose(music.music_grid(beats, 3, per_bar=2), music.music_grid(beats, 3))
