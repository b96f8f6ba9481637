"""Reaches of HDM05, three actors, to the floor and high up: blended over the target."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml_service.analysis.interface import AnalysisError, Motion
from mcml_service.analysis.reach_blending.fit import Fitted, fit
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.analysis.reach_blending.synthesis import Wish, synthesize
from tests.analysis.reach.arrivals import leave_people_out
from tests.analysis.reach.hdm05 import INCHES, read_reaches


@pytest.fixture(scope="module")
def reaches(shared: Path) -> list[Motion]:
    folder = shared / "asfamc" / "hdm05_reach"
    if not folder.is_dir():
        pytest.skip("the reach clips of HDM05 are not here")
    return read_reaches(folder)


@pytest.fixture(scope="module")
def fitted(reaches: list[Motion]) -> Fitted:
    return fit(reaches, options_of(attributes=("target",)))


@pytest.mark.slow
def test_most_clips_are_used_and_the_others_say_why(reaches: list[Motion], fitted: Fitted) -> None:
    found = fitted
    assert len(reaches) == 34
    assert len(found.clips) >= 29
    assert {left.code for left in found.excluded} <= {"no-clear-peak", "peak-at-border"}
    for clip in found.clips:
        t1, t2, end = clip.phases.times
        assert 0 < t1 < t2 < end


def test_few_eigenposes_hold_a_clip_and_few_eigenmotions_the_set(reaches: list[Motion], fitted: Fitted) -> None:
    paper = fit(reaches, options_of("paper", attributes=("target",), duplicates="mean"))
    assert paper.pose_shares[:, -1].min() > 0.98
    for found in (paper, fitted):
        assert found.components.cumulative()[9] > 0.779


@pytest.mark.parametrize("space", ["tangent", "eigenposes"])
def test_the_hand_rises_with_the_target(reaches: list[Motion], fitted: Fitted, space: str) -> None:
    found = fitted if space == "tangent" else fit(reaches, options_of(attributes=("target",), space=space))
    template = found.model.sources[0].document
    heights = []
    for target in (0.0, 0.25, 0.5, 0.75, 1.0):
        made = synthesize(found.model, Wish({"target": target}, template=template))
        clip = made.clip
        motion = Motion("made", 1, "made", clip.skeleton, clip.frame_time, clip.rotations, clip.translations)
        heights.append(motion.walk()[0][:, found.body.hand, 1] * INCHES)
        assert made.support == ("gap" if 0 < target < 1 else "inside")
    assert np.all(np.diff([height.mean() for height in heights]) > 0)
    # Measured hands go to 0.1 m and to 1.6 m; means of people who move at different times go less far.
    assert heights[0].min() < 0.5
    assert heights[-1].max() > 1.2


@pytest.mark.slow
def test_hands_of_people_left_out_arrive_and_feet_stay(reaches: list[Motion]) -> None:
    compared = list(leave_people_out(reaches, attributes=("target",), align="start"))
    assert len(compared) >= 29
    # Blends miss by decimetres, because a clip of another person is the nearest that they know.
    assert np.median([each.blend for each in compared]) > 0.2
    assert max(each.arrive for each in compared) < 0.01
    assert max(each.slide[0] for each in compared) < 0.03
    assert np.median([each.slide[1] for each in compared]) > 0.2
    accelerations = np.array([each.acceleration for each in compared])
    assert np.median(accelerations[:, 0] / accelerations[:, 1]) < 1.2
    assert accelerations[:, 0].max() <= 1.5 * np.percentile(accelerations[:, 2], 99)


def test_two_targets_are_equal_attributes_to_the_paper(reaches: list[Motion]) -> None:
    with pytest.raises(AnalysisError) as error:
        fit(reaches, options_of("paper", attributes=("target",)))
    assert error.value.code == "duplicate-attributes"
