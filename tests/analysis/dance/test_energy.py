"""Dances whose energy follows the loudness of music."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml_schemas.analyses.dance import DanceParameters
from mcml_service.analysis.dance import energy
from mcml_service.analysis.dance.analyses import DANCE
from mcml_service.analysis.dance.energy import Loudness
from mcml_service.analysis.dance.time_warp import even_grid
from mcml_service.analysis.interface import AnalysisError, silent
from tests.analysis.dance.motions import generated

CLIPS = [generated(style, style, bars=10, seed=seed, tempo=112.0)[0] for seed, style in enumerate(("step", "groove"))]


def test_levels_are_the_root_mean_square_between_beats() -> None:
    rate = 100.0
    samples = np.repeat([0.0, 1.0, -2.0, 3.0], 50)
    levels = energy.measure_levels(samples, rate, np.array([0.0, 0.5, 1.0, 1.5]))
    assert levels == pytest.approx([0, 1, 2, 3])
    assert energy.measure_levels(samples, rate, np.array([0.5, 1.5])) == pytest.approx([np.sqrt(2.5), 3.0])


@given(seed=st.integers(0, 999), bars=st.integers(1, 8), bpm=st.sampled_from([60.0, 90.0, 120.0]))
def test_the_loudness_of_a_bar_is_that_of_its_beats(seed: int, bars: int, bpm: float) -> None:
    levels = np.random.default_rng(seed).random(4 * bars)
    grid = even_grid(bpm, bars + 1, 0.3)
    measured = energy.find_bar_loudness(Loudness(grid[: 4 * bars], levels), grid)
    assert measured[:bars] == pytest.approx(np.sqrt((levels**2).reshape(bars, 4).mean(axis=1)))
    assert np.isnan(measured[bars])


@given(seed=st.integers(0, 999), weight=st.floats(0, 9))
def test_costs_are_least_for_bars_of_the_same_rank(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    efforts, available = rng.permutation(7) * 1.0, np.ones(7, dtype=bool)
    costs = energy.energy_costs(np.array([3.0, np.nan, 1.0, 2.0]), efforts, available, weight)
    assert ((costs >= 0) & (costs <= weight)).all()
    assert not costs[1].any()
    if weight > 1e-3:
        assert [efforts[row.argmin()] for row in costs[[0, 2, 3]]] == [6, 0, 3]


def make_dance(**options: Any) -> dict[str, Any]:
    """Metrics of a dance to music that is soft and loud in turns of four bars."""
    beats = (np.arange(4 * 32 + 1) * 60 / 112).tolist()
    music = {"beats": beats, "loudness": np.tile(np.repeat([0.05, 0.3], 16), 5)[: len(beats)].tolist()}
    parameters = {"music": music, "bars": 32, "dry_run": True, **options}
    return dict(DANCE.run(CLIPS, DanceParameters.model_validate(parameters), silent)["metrics"].data["rows"])


def test_a_dance_follows_the_loudness() -> None:
    before, after = make_dance(), make_dance(energy=4)
    assert after["energy_match"] > 0.6
    assert after["energy_match"] > before["energy_match"] + 0.3
    assert after["most_uses"] <= before["most_uses"] + 2


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"bpm": 120, "energy": 1}, "which is not given"),
        ({"music": {"beats": [0.5, 1, 1.5, 2, 2.5], "loudness": [0.1]}, "energy": 1}, "5 beats and 1 values"),
    ],
)
def test_energy_needs_the_loudness_of_music(options: dict[str, Any], problem: str) -> None:
    parameters = DanceParameters.model_validate({"bars": 1, **options})
    assert DANCE.check is not None
    with pytest.raises(AnalysisError, match=problem) as raised:
        DANCE.check(parameters, [clip.document for clip in CLIPS])
    assert raised.value.code == "loudness-unknown"
