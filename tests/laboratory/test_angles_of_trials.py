"""`mo:angle` on trials of markers, against the angles that the laboratory's own program wrote."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.files.motion import Motion
from mcml.motion.markers import read_marker_positions
from mcml.motion.skeleton import Array

OWN = {"hip-flexion": ("HipAngles", "x"), "hip-adduction": ("HipAngles", "y"), "knee-flexion": ("KneeAngles", "x"),
       "hip-internal-rotation": ("HipAngles", "z"), "knee-varus": ("KneeAngles", "y"),
       "ankle-dorsiflexion": ("AnkleAngles", "x")}  # fmt: skip
MARKERS = {"LASI", "RASI", "LPSI", "RPSI", "SACR", "LTHI", "LKNE", "LTIB", "LANK", "LHEE", "LTOE", "RTHI", "RKNE",
           "RTIB", "RANK", "RHEE", "RTOE", "CLAV", "C7", "STRN", "T10", "LSHO", "LELB", "LWRA", "LWRB", "RSHO", "RELB",
           "RWRA", "RWRB"}  # fmt: skip


@pytest.fixture
def lab(shared: Path) -> Path:
    if not (shared / "lab" / "expected.json").exists():
        pytest.skip("the trials of laboratories are not here (set MCML_SHARED to their folder)")
    return shared / "lab"


def rms(away: Array) -> float:
    assert np.isfinite(away).sum() > 20
    return float(np.sqrt(np.nanmean(away**2)))


@pytest.mark.parametrize("trial", ["hc030a05", "s4_am_gait04", "s4_am_cal_01", "mh0222_bp06", "walking5"])
@pytest.mark.parametrize(("side", "letter"), [("left", "L"), ("right", "R")])
def test_clinical_angles_are_those_of_the_laboratory(lab: Path, trial: str, side: str, letter: str) -> None:
    motion = mcml.read(lab / f"{trial}.c3d")
    for angle, (quantity, axis) in OWN.items():
        # An ankle is measured from heel to toe, a laboratory's from its standing trial.
        most = 5.2 if angle.startswith("ankle") else 0.02
        away = motion.angle(f"{side}-{angle}") - motion.quantity(f"{letter}{quantity}", axis)
        assert rms(away) <= most, angle
    # The order of rotations differs: ours does not depend on where the body walks (Baker 2001).
    away = motion.angle("pelvis-tilt") - motion.quantity("LPelvisAngles", "x")
    assert rms(away) <= 0.5


def bare_markers(motion: Motion, folder: Path) -> Motion:
    """The same trial with its markers alone: no points of a model, no measures."""
    keep = [index for index, name in enumerate(motion.source_names) if name in MARKERS]
    names = [motion.source_names[index] for index in keep]
    places = read_marker_positions(motion._clip, keep)
    rate = 1 / (motion.frame_time or 1)
    lines = [
        "PathFileType\t4\t(X/Y/Z)\tx.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{rate}\t{rate}\t{len(places)}\t{len(keep)}\tmm\t{rate}\t1\t{len(places)}",
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{place + 1}" for place in range(len(keep)) for axis in "XYZ"),
        "",
    ]
    for frame, row in enumerate(places.reshape(len(places), -1)):
        numbers = "\t".join("" if np.isnan(each) else f"{each:.4f}" for each in row)
        lines.append(f"{frame + 1}\t{frame / rate:.5f}\t{numbers}")
    (folder / "bare.trc").write_text("\n".join(lines) + "\n")
    return mcml.read(folder / "bare.trc")


@pytest.mark.parametrize("trial", ["hc030a05", "s4_am_gait04", "s4_am_cal_01", "mh0222_bp06"])
@pytest.mark.parametrize(("side", "letter"), [("left", "L"), ("right", "R")])
def test_markers_alone_tell_legs(lab: Path, tmp_path: Path, trial: str, side: str, letter: str) -> None:
    whole = mcml.read(lab / f"{trial}.c3d")
    bare = bare_markers(whole, tmp_path)
    # The wand of one thigh is turned by 16 degrees, which only the measures of the file say.
    turned = (trial, side) == ("mh0222_bp06", "right")
    for angle, most in (("knee-flexion", 6.5 if turned else 1.5), ("hip-flexion", 3.8 if turned else 2.1)):
        quantity, axis = OWN[angle]
        assert rms(bare.angle(f"{side}-{angle}") - whole.quantity(f"{letter}{quantity}", axis)) <= most, angle
    for joint, most in (("up_leg", 28), ("low_leg", 26 if turned else 11), ("foot", 20)):
        own = np.stack([bare.position(f"{side}_{joint}", axis) for axis in "xyz"], axis=1)
        centre = {"up_leg": "HJC", "low_leg": "KJC", "foot": "AJC"}[joint]
        model = np.stack([whole.quantity(f"cgm1:{letter}{centre}", axis) for axis in "xyz"], axis=1)
        assert np.nanmedian(np.linalg.norm(own * 1000 - model, axis=1)) <= most, joint
    assert np.isfinite(bare.height("Root")).sum() > 20


@pytest.mark.parametrize("trial", ["hc030a05", "s4_am_gait04", "mh0222_bp06"])
@pytest.mark.parametrize(("side", "letter"), [("left", "L"), ("right", "R")])
def test_measures_of_the_subject_place_knees(lab: Path, tmp_path: Path, trial: str, side: str, letter: str) -> None:
    whole = mcml.read(lab / f"{trial}.c3d")
    bare = bare_markers(whole, tmp_path)._clip
    measured = Motion(trial, bare.with_head(replace(bare.head, properties=whole._clip.head.properties)))
    assert rms(measured.angle(f"{side}-knee-flexion") - whole.quantity(f"{letter}KneeAngles", "x")) <= 1.1
    for joint, centre, most in (("low_leg", "KJC", 6), ("foot", "AJC", 9.5)):
        own = np.stack([measured.position(f"{side}_{joint}", axis) for axis in "xyz"], axis=1)
        model = np.stack([whole.quantity(f"cgm1:{letter}{centre}", axis) for axis in "xyz"], axis=1)
        # What is left comes from the hip, which is not that of Davis 1991.
        assert np.nanmedian(np.linalg.norm(own * 1000 - model, axis=1)) <= most, joint
