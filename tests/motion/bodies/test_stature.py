"""Heights of standing bodies by their bones, in any pose and at any rest, and clips scaled to a height."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mcml
from mcml.errors import ConversionError, RequestError
from mcml.files.reshape_clip import Reshaping, fit_height
from mcml.motion.bodies.clip_body import body_of
from mcml.motion.bodies.stature import ANKLE, HEAD_JOINT, LEG, Stature, find_stature
from mcml.motion.clip import ClipStream
from mcml.motion.units import reading_of
from tests.motion.bodies.made import clip_of, person
from tests.motion.bodies.rig import OFFSETS, write_rig


def stature_of(clip: ClipStream) -> Stature | None:
    calibration = body_of(clip.head, clip.blocks()).calibration
    return find_stature(clip.head.skeleton, reading_of(clip.head), calibration)


def test_bones_up_to_the_joint_of_the_head_and_a_skull() -> None:
    expected = (42 + 41 + (10 + 5) + 40 + 15) / (HEAD_JOINT - ANKLE)
    rng = np.random.default_rng(4)
    for _ in range(5):
        rest = {name: Rotation.random(random_state=int(rng.integers(1 << 30))) for name in OFFSETS if name != "Root"}
        found = stature_of(clip_of(write_rig(rest=rest)))
        assert found is not None
        assert found.height == pytest.approx(expected, rel=1e-3)
        assert found.kind == "guessed"
        assert "skull" in found.reason


def test_points_above_the_head_are_its_top() -> None:
    content = write_rig()
    ends = content.split(b"OFFSET 0 0 3")
    raised = b"OFFSET 0 14 0".join([ends[0], b"OFFSET 0 0 3".join(ends[1:])])
    found = stature_of(clip_of(raised))
    assert found is not None
    assert found.kind == "measured"
    assert found.height == pytest.approx((83 + 70 + 14) / (1 - ANKLE), rel=1e-3)


def test_markers_are_told_by_a_leg_and_bodies_without_legs_by_nothing(shared: Path) -> None:
    motion = mcml.read(shared / "c3d/body/HDM_dg_06-03_03_120.c3d")
    found = stature_of(motion._clip)
    leg = motion._body.calibration.leg
    assert found is not None
    assert leg is not None
    assert found.height == pytest.approx(leg / LEG)
    assert stature_of(mcml.read(shared / "glb/SimpleSkin.gltf")._clip) is None


@pytest.mark.parametrize(
    "name",
    ["bvh/dance/131_01.bvh", "npz/cmu131_01_smplx_165.npz", "fbx/jog_max_biped_7400.fbx", "mvnx/Meri-020.mvnx"],
)
def test_real_people_have_the_height_of_people(shared: Path, name: str) -> None:
    motion = mcml.read(shared / name)
    found, metres = stature_of(motion._clip), motion._body.calibration.metres
    assert found is not None
    assert metres is not None
    assert 1.4 < found.height * metres < 2.0


def test_a_clip_is_scaled_to_a_height_and_says_so() -> None:
    clip = clip_of(person(3))
    made = fit_height(clip, 1.75)
    calibration = body_of(made.head, made.blocks()).calibration
    found = stature_of(made)
    assert found is not None
    assert calibration.metres is not None
    assert found.height * calibration.metres == pytest.approx(1.75, rel=1e-6)
    assert any("1.75 m" in notice.what for notice in made.notices)
    with pytest.raises(ConversionError, match="guess"):
        fit_height(clip_of(person(3)), 1.75, guesses=False)
    with pytest.raises(RequestError, match="Both"):
        Reshaping(height=1.75, scale=2.0)


def test_exports_stay_in_place(tmp_path: Path) -> None:
    source, made = tmp_path / "walk.bvh", tmp_path / "stays.bvh"
    source.write_bytes(person(5))
    mcml.convert(source, made, in_place=True, frames="5-20", height=1.6)
    before, after = mcml.read(source), mcml.read(made)
    for axis in "xz":
        assert len(after.position("Root", axis)) == 16
        assert np.ptp(after.position("Root", axis)) < 1e-5
        assert np.ptp(before.position("Root", axis)[4:20]) > 1e-2


def test_a_guessed_unit_of_a_preset_is_that_of_the_height(shared: Path, tmp_path: Path) -> None:
    """The numbers of this file are no common unit: the preset guesses it, and the height holds in the new one."""
    made = tmp_path / "tall.bvh"
    mcml.convert(shared / "bvh/dance/131_01.bvh", made, for_="motionbuilder", height=1.9)
    motion = mcml.read(made, unit="cm")
    found = stature_of(motion._clip)
    assert found is not None
    assert found.height == pytest.approx(190, rel=1e-3)
