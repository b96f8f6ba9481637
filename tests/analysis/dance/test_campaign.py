"""Long campaigns over styles, rates, tempi and dancers (`make fuzz`)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters
from mcml_service.analysis.dance.analyses import BEATS, DANCE
from mcml_service.analysis.dance.metrics import nearest
from mcml_service.analysis.dance.sources import channels_of
from mcml_service.analysis.dance.tempo import tempo_of
from mcml_service.analysis.interface import AnalysisError, silent
from mcml_service.demo.dance_clips import Style
from tests.analysis.dance.motions import BEAT_STYLES, STYLES, generated


@pytest.mark.fuzz
@settings(max_examples=300)
@given(
    style=st.sampled_from(BEAT_STYLES),
    fps=st.sampled_from([24.0, 30.0, 59.94, 100.0, 120.0]),
    tempo=st.floats(76, 140),
    seed=st.integers(200, 10_000),
)
def test_beats_of_any_dancer_are_found(style: Style, fps: float, tempo: float, seed: int) -> None:
    motion, truth = generated(style, fps=fps, tempo=tempo, bars=10, seed=seed, dancer=seed)
    found = np.array([row[3] for row in BEATS.run([motion], BeatsParameters(), silent)["beats"].data["rows"]])
    near = nearest(truth.beats, found) <= max(1 / fps, 1 / 60) + 1e-9
    # The promise of 0.95 is over clips (test_generated.py); a single one of forty beats may miss five.
    assert near.sum() >= 35
    assert len(found) <= 42


@pytest.mark.fuzz
@settings(max_examples=150)
@given(
    style=st.sampled_from(STYLES),
    fps=st.sampled_from([30.0, 60.0]),
    bpm=st.floats(40, 240),
    bars=st.integers(1, 24),
    seed=st.integers(200, 10_000),
    options=st.fixed_dictionaries(
        {
            "strategy": st.sampled_from(["beam", "random"]),
            "blend": st.sampled_from(["hold", "classic", "none"]),
            "warp": st.sampled_from(["beats", "uniform"]),
            "placement": st.sampled_from(["cloud", "facing"]),
            "stride": st.sampled_from([1, 4]),
            "lead_in": st.sampled_from(["beat", "third"]),
            "beats_from": st.sampled_from(["auto", "detected", "tracked"]),
            "blend_beats": st.floats(0.2, 1),
            "fps": st.one_of(st.none(), st.floats(10, 100)),
        }
    ),
)
def test_every_dance_is_whole_or_refused_by_name(
    style: Style, fps: float, bpm: float, bars: int, seed: int, options: dict[str, object]
) -> None:
    clips = [generated(style, f"{n}", fps=fps, bars=5, seed=seed + n, tempo=100.0 + 9 * n)[0] for n in range(2)]
    parameters = DanceParameters.model_validate({"bpm": bpm, "bars": bars, **options})
    refusals: list[AnalysisError] = []
    try:
        parts = DANCE.run(clips, parameters, silent)
    except AnalysisError as error:
        refusals.append(error)
    if refusals:
        assert refusals[0].code in {"no-beats", "no-bars", "no-edges", "tempo-too-far"}
        assert refusals[0].remedy
        return
    clip = parts["clip"].clip
    assert clip is not None
    rate = 1 / clip.frame_time
    assert len(clip.rotations) == int(np.floor(240 * bars / bpm * rate + 0.5))
    assert np.isfinite(clip.translations).all()
    assert np.abs(np.linalg.norm(clip.rotations, axis=-1) - 1).max() < 1e-9
    assert all(row[9] is None or row[9] >= 0 for row in parts["path"].data["rows"])


@pytest.mark.fuzz
@settings(max_examples=200)
@given(
    style=st.sampled_from(STYLES),
    fps=st.floats(20, 150),
    other=st.floats(20, 150),
    true=st.floats(72, 165),
    seed=st.integers(200, 10_000),
)
def test_the_tempo_of_any_dancer_is_found_at_any_rate(
    style: Style, fps: float, other: float, true: float, seed: int
) -> None:
    found = []
    for rate in (fps, other):
        motion, _ = generated(style, fps=rate, tempo=true, bars=8, seed=seed, dancer=seed)
        tempo = tempo_of([channels_of(motion)])
        assert tempo is not None
        ratio = tempo.peaks[0].bpm / true
        # Where an octave is as likely, that is said.
        assert abs(ratio - 1) < 0.04 or "tempo-octave" in [code for code, _ in tempo.warnings()]
        found.append(tempo.peaks[0].bpm)
    if min(fps, other) >= 24:
        assert abs(found[0] / found[1] - 1) < 0.01 or abs(np.log2(found[0] / found[1])) > 0.4
