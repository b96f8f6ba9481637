"""Bodies of real files: what is asked of them agrees with what people do, whatever the rig."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mcml.motion.bodies import local_fit
from mcml.motion.bodies.poses import pose_distances, pose_features
from mcml.motion.bodies.quantities import compute
from mcml.motion.bodies.stretch import Stretch
from mcml.numerics.runs import find_true
from tests.formats.test_real_files import NOT_MOTION, opened
from tests.motion.bodies.made import named, part_of, stretch_of

WALKS = (
    "asfamc/cmu_misc/07_05-walk.amc",
    "bvh/bandai/dataset-1_walk_normal_001.bvh",
    "bvh/exporters/blender_walk01.bvh",
    "htr/xbot_walk_f_mixamo.com.htr",
)


@cache
def body(path: Path) -> Stretch:
    clip = named(opened(path))
    if clip.head.seconds_per_frame() is None:
        clip = clip.with_head(replace(clip.head, frame_time="0.0083333"))
    return stretch_of(clip)


def percentile(values: np.ndarray, percent: float) -> float:
    return float(np.nanpercentile(values, percent))


@pytest.mark.parametrize("name", WALKS)
def test_walks_are_walks_on_any_rig(shared: Path, name: str) -> None:
    walk = body(shared / name)
    for side in ("left", "right"):
        assert 63 <= percentile(compute("angle", [f"{side}-knee-flexion"], walk), 98) <= 77
        assert 4 <= percentile(compute("angle", [f"{side}-arm-abduction"], walk), 50) <= 18
        thigh = compute("angle", [f"{side}-leg-flexion"], walk)
        assert 20 <= percentile(thigh, 98) <= 40
        assert -45 <= percentile(thigh, 2) <= -5
    assert 0.95 <= np.nanmean(compute("speed", ["Root"], walk)) <= 1.7
    assert abs(percentile(compute("angle", ["trunk-flexion"], walk), 50)) < 10
    assert (compute("height", ["Head"], walk) > 1.2).all()


def longest_flight(stretch: Stretch) -> float:
    """Seconds."""
    left, right = (compute("contact", [f"{side}_toes"], stretch) for side in ("left", "right"))
    assert stretch.frame_time is not None
    flights = find_true((left == 0) & (right == 0)).tolist()
    return max((end - first for first, end in flights), default=0) * stretch.frame_time


def test_who_runs_flies_and_who_walks_does_not(shared: Path) -> None:
    for path in sorted((shared / "bvh" / "bandai").glob("*_walk_*")):
        assert longest_flight(body(path)) < 0.1, path
    flights = [longest_flight(body(path)) for path in sorted((shared / "bvh" / "bandai").glob("*_run_*"))]
    assert sum(flight >= 0.1 for flight in flights) >= 4
    assert longest_flight(body(shared / "asfamc/cmu_misc/09_06-run.amc")) >= 0.1
    speeds = [
        np.nanmean(compute("speed", ["Root"], body(path)))
        for path in sorted((shared / "bvh" / "bandai").glob("*_run_normal_*"))
    ]
    assert min(speeds) > 2


@pytest.mark.slow
def test_units_axes_and_poses_before_the_motion(shared: Path) -> None:
    kinds: Counter[tuple[str, str]] = Counter()
    up, leaps = {}, set()
    for folder in ("bvh", "asfamc", "htr"):
        for path in sorted((shared / folder).rglob("*.*")):
            if path.suffix.lower() == ".asf" or path.name in NOT_MOTION or path.parent.name == "malformed":
                continue
            calibration = body(path).calibration
            kinds[path.suffix.lower(), calibration.origins["metres"].kind] += 1
            if calibration.up != "Y":
                up[path.name] = calibration.up
            if calibration.leaps:
                leaps.add(path.name)
    assert kinds == {
        (".bvh", "guessed"): 90,
        (".bvh", "unknown"): 8,
        (".amc", "guessed"): 60,
        (".amc", "unknown"): 1,
        (".htr", "stated"): 7,
    }
    one = {"A_test.bvh", "B_test.bvh", "C_test.bvh", "example.bvh", "ipi_studio.bvh", "secondlife_hug.bvh"}
    # Blended in from a T-pose; and a run whose first two frames are those of another place.
    blended = {"cmu_daz_walk.bvh", "60_10_scaled.bvh", "61_10_scaled.bvh", "16_15.amc"}
    assert leaps == one | blended
    bodies = {"bvh_test1.bvh": "Z", "bvh_test3.bvh": "Z", "fair_dab.bvh": "Z", "video2bvh_cxk.bvh": "Z"}
    # The last one is no body.
    assert up == bodies | {"test_simple.bvh": "Z"}


def test_the_first_frame_of_a_clip_that_leaps_is_left_out(shared: Path) -> None:
    stretch = body(shared / "bvh/exporters/ipi_studio.bvh")
    kept = replace(stretch, calibration=replace(stretch.calibration, skipped=0))
    assert np.isnan(compute("speed", ["left_hand"], stretch)[0])
    assert np.nanmax(compute("speed", ["left_hand"], stretch)[:3]) < 6
    assert np.nanmax(compute("speed", ["left_hand"], kept)[:3]) > 10


def test_speeds_are_those_of_the_motion_not_of_the_frame_rate(shared: Path) -> None:
    """Differences of neighbours are half as fast again at 120 frames a second as at 30."""
    at_120 = body(shared / "asfamc/hdm05_reach/HDM_bd_grabHighR_001_120.amc")
    at_30 = replace(
        part_of(at_120, 0, at_120.frames),
        places={name: steps[::4] for name, steps in at_120.places.items()},
        frames=len(range(0, at_120.frames, 4)),
        frame_time=4 * 0.0083333,
    )
    fast, slow = (percentile(compute("speed", ["right_hand"], one), 99) for one in (at_120, at_30))
    assert fast == pytest.approx(slow, rel=0.03)
    rates = [local_fit.rate(compute("angle", ["right-elbow-flexion"], one), one.frame_time) for one in (at_120, at_30)]
    assert percentile(rates[0], 99) == pytest.approx(percentile(rates[1], 99), rel=0.05)


def test_like_poses_are_found_on_other_rigs(shared: Path) -> None:
    paths = [path for path in sorted((shared / "bvh" / "bandai").glob("*")) if "_old_" not in path.name]
    found = np.concatenate([pose_features(body(path)) for path in paths])
    walks = np.concatenate([np.full(body(path).frames, "_walk_" in path.name) for path in paths])
    for name in ("asfamc/cmu_misc/07_05-walk.amc", "htr/xbot_walk_mixamo.com.htr"):
        nearest = np.argsort(pose_distances(found, pose_features(body(shared / name))[::8]), axis=0)[:20]
        assert walks[nearest].mean() > 0.9
