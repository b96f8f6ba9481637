"""A trial has one gait, one body and the same forces in all units, axes and orders of its file."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.errors import NotFoundError
from mcml.files.motion import Motion
from mcml.laboratory.gait_parameters import Stride
from mcml.motion.skeleton import Array
from tests.laboratory.rewritten_trials import REWRITES, NotRewritableError, rewrite

TRIALS = ("s4_am_gait04", "bmc_gait", "treadmill_events", "walking5", "mh0222_bp06")
ANGLES = [
    f"{side}-{angle}"
    for side in ("left", "right")
    for angle in ("hip-flexion", "hip-adduction", "hip-internal-rotation", "knee-flexion", "knee-varus",
                  "ankle-dorsiflexion")
] + ["pelvis-tilt", "pelvis-obliquity"]  # fmt: skip


@pytest.fixture(scope="module")
def lab(shared: Path) -> Path:
    if not (shared / "lab" / "expected.json").exists():
        pytest.skip("the trials of laboratories are not here (set MCML_SHARED to their folder)")
    return shared / "lab"


def force_on(motion: Motion, side: str) -> Array:
    """(frames,) newtons on a foot, in any axes."""
    return np.linalg.norm([motion.force(side, axis) for axis in "xyz"], axis=0)


def numbers_of(stride: Stride) -> list[float]:
    return [value for value in asdict(stride).values() if isinstance(value, float)]


def angle_of(motion: Motion, name: str) -> Array | str:
    try:
        return motion.angle(name)
    except NotFoundError:
        return "unknown"


@pytest.mark.slow
@pytest.mark.parametrize("trial", TRIALS)
@pytest.mark.parametrize("name", REWRITES)
def test_a_trial_written_anew_has_the_same_answers(lab: Path, tmp_path: Path, trial: str, name: str) -> None:
    try:
        rewrite(lab / f"{trial}.c3d", name, tmp_path / "anew.c3d")
    except NotRewritableError as error:
        pytest.skip(str(error))
    motion, anew = mcml.read(lab / f"{trial}.c3d"), mcml.read(tmp_path / "anew.c3d")
    gait, again = motion.measure_gait(), anew.measure_gait()
    assert [(event.side, event.kind, event.source) for event in gait.events] == [
        (event.side, event.kind, event.source) for event in again.events
    ]
    assert [event.seconds for event in again.events] == pytest.approx(
        [event.seconds for event in gait.events], abs=1e-4
    )
    for stride, other in zip(gait.strides, again.strides, strict=True):
        assert numbers_of(other) == pytest.approx(numbers_of(stride), rel=1e-3, abs=1e-4, nan_ok=True)
    for angle in ANGLES:
        own, others = angle_of(motion, angle), angle_of(anew, angle)
        # Points are rounded to steps of a hundredth of a millimetre along the axes, which a turn changes.
        np.testing.assert_allclose(others, own, atol=0.05, err_msg=angle) if isinstance(own, np.ndarray) else None
        assert isinstance(own, str) is isinstance(others, str), angle
    for side in ("left", "right"):
        np.testing.assert_allclose(force_on(anew, side), force_on(motion, side), rtol=1e-5, atol=0.01)


def test_descriptions_tell_markers_of_one_label_apart(lab: Path) -> None:
    """Labels that are cut to four letters name the lateral and the medial marker of a knee alike."""
    motion = mcml.read(lab / "bmc_gait.c3d")
    assert {"R.Knee", "R.Knee.Medial", "LHEE"} <= set(motion.bones)
    for side in ("left", "right"):
        flexion = motion.angle(f"{side}-knee-flexion")
        assert np.nanmax(flexion) == pytest.approx(62, abs=3)
        assert np.nanpercentile(flexion, 20) == pytest.approx(3, abs=3)
