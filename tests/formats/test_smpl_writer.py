"""SMPL poses as AMASS writes them: what was read leaves with the same numbers, other bodies are retargeted."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.errors import ConversionError
from mcml.files.motion import convert, read
from mcml.formats import WRITERS, transfer
from mcml.formats.smpl.skeleton import body_of
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.conventions.convert import scale, turn_up
from mcml.motion.skeleton import Array
from tests.formats.readers.posing import npz, places_of, read_clip
from tests.formats.readers.test_smpl import expected_places
from tests.formats.scenes.clips import timed
from tests.fuzz import examples
from tests.motion.bodies.made import clip_of, person

SAMPLES = Path(os.environ.get("MCML_SHARED", "/nowhere"), "data/npz")


def write(clip: ClipStream) -> dict[str, Array]:
    return dict(np.load(io.BytesIO(b"".join(WRITERS["smpl"].write(clip, "npz"))), allow_pickle=False))


def same_turns(one: Array, other: Array) -> float:
    """The largest difference of the rotations of poses, as matrices."""
    first, second = (Rotation.from_rotvec(np.asarray(each, float).reshape(-1, 3)).as_matrix() for each in (one, other))
    return float(np.abs(first - second).max())


@given(st.sampled_from([22, 24, 52, 55]), st.integers(0, 2**32 - 1))
@examples(20)
def test_poses_leave_as_they_came(joints: int, seed: int) -> None:
    chance = np.random.default_rng(seed)
    poses = np.cumsum(chance.normal(0, 0.4, (7, 3 * joints)), axis=0)
    trans, betas = chance.normal(0, 2, (7, 3)), chance.normal(0, 2, 16)
    clip = read_clip("smpl", npz(poses=poses, trans=trans, mocap_framerate=60.0, betas=betas, gender="male"))
    made = write(clip)
    assert same_turns(made["poses"], poses) < 1e-9
    assert np.abs(made["trans"] - trans).max() < 1e-9
    assert np.allclose(made["betas"], betas, rtol=1e-8)
    assert (str(made["gender"]), float(made["mocap_framerate"]), float(made["mocap_frame_rate"])) == ("male", 60, 60)
    assert str(made["surface_model_type"]) == {52: "smplh", 55: "smplx"}.get(joints, "smpl")


@pytest.mark.parametrize("name", ["cmu131_01_smpl_72", "cmu131_01_smplh_156", "cmu131_01_smplx_165"])
def test_samples_of_amass_come_back(name: str, tmp_path: Path) -> None:
    path = SAMPLES / f"{name}.npz"
    if not path.exists():
        pytest.skip("the samples of AMASS are not here (set MCML_SHARED to their folder)")
    before = np.load(path, allow_pickle=False)
    (document,) = convert(path, tmp_path / "clip.mcml", **({} if "mocap" in str(before.files) else {"rate": 30}))
    after = np.load(convert(document, tmp_path / "again.npz")[0], allow_pickle=False)
    assert same_turns(before["poses"], after["poses"]) < 1e-6
    assert np.abs(before["trans"] - after["trans"]).max() < 1e-6
    if "betas" in before.files:
        assert np.abs(before["betas"] - after["betas"]).max() < 1e-6
        assert str(after["gender"]) == ("female" if "smplx" in name else "neutral")
    assert ("fps" in after.files) == (name == "cmu131_01_smpl_72")
    again = read(tmp_path / "again.npz")
    assert np.abs(again.frames(space="positions") - read(document).frames(space="positions")).max() < 1e-6


def test_unit_and_axis_of_a_document_are_undone() -> None:
    chance = np.random.default_rng(4)
    poses, trans = chance.normal(0, 1, (5, 156)), chance.normal(0, 1, (5, 3))
    clip = read_clip("smpl", npz(poses=poses, trans=trans, mocap_framerate=60.0))
    in_mm = scale(clip, 1000, unit="mm")
    made = write(in_mm)
    assert same_turns(made["poses"], poses) < 1e-9
    assert np.abs(made["trans"] - trans).max() < 1e-9
    # The same numbers with Y stated as up: the whole body is turned to Z.
    fields = {**clip.head.fields, "global_axis_of_gravity": "Y"}
    upright = write(clip.with_head(replace(clip.head, fields=fields)))
    places = expected_places(upright["poses"], upright["trans"])
    before = places_of(clip)
    assert np.allclose(places, np.stack([before[..., 0], -before[..., 2], before[..., 1]], axis=-1), atol=1e-9)


def test_an_unknown_axis_is_not_called_z() -> None:
    made = write(read_clip("smpl", npz(poses=np.zeros((3, 72)), trans=np.zeros((3, 3))), rate=30))
    assert float(made["fps"]) == 30
    assert "mocap_framerate" not in made
    clip = read_clip("smpl", npz(**made))
    assert "global_axis_of_gravity" not in clip.head.fields


def test_betas_that_are_not_known_are_zeros_and_told() -> None:
    clip = read_clip("smpl", npz(poses=np.zeros((3, 156)), trans=np.zeros((3, 3)), mocap_framerate=60))
    made = write(clip)
    assert made["betas"].shape == (16,)
    assert not made["betas"].any()
    assert any("mean shape" in notice.what for notice in clip.notices)


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_bones_of_another_body_point_as_in_the_clip(up: str) -> None:
    clip = timed(clip_of(person(4, 10)))
    clip = turn_up(clip, "Y", up)
    clip = clip.with_head(replace(clip.head, fields={**clip.head.fields, "global_axis_of_gravity": up}))
    made = write(clip)
    assert made["poses"].shape == (10, 156)
    assert str(made["surface_model_type"]) == "smplh"
    body = body_of(52)
    places = expected_places(made["poses"], made["trans"])
    before = places_of(clip)
    before = before if up == "Z" else np.stack([before[..., 0], -before[..., 2], before[..., 1]], axis=-1)
    names = {joint.name: index for index, joint in enumerate(clip.head.skeleton.joints)}
    for (start, end), (first, last) in {
        ("left_up_leg", "left_low_leg"): ("left_hip", "left_knee"),
        ("right_low_leg", "right_foot"): ("right_knee", "right_ankle"),
        ("left_up_arm", "left_low_arm"): ("left_shoulder", "left_elbow"),
        ("right_low_arm", "right_hand"): ("right_elbow", "right_wrist"),
    }.items():
        one = before[:, names[end]] - before[:, names[start]]
        two = places[:, body.names.index(last)] - places[:, body.names.index(first)]
        cosines = (one * two).sum(axis=1) / np.linalg.norm(one, axis=1) / np.linalg.norm(two, axis=1)
        assert cosines.min() > np.cos(np.radians(0.01)), (start, end)
    # It stands: feet near the ground of the clip, in metres.
    assert 0.5 < places[:, 0, 2].mean() < 1.2
    assert any("retargeted" in notice.what for notice in clip.notices)


def test_what_is_no_person_is_refused() -> None:
    clip = timed(clip_of(person(4, 10)))
    joints = tuple(replace(joint, name=f"b{at}", source_name=f"b{at}", mapped=False)
                   for at, joint in enumerate(clip.head.skeleton.joints[:4]))  # fmt: skip
    head = replace(clip.head, skeleton=replace(clip.head.skeleton, joints=joints))
    with pytest.raises(ConversionError, match=r"lacks .*left_knee"):
        write(ClipStream(head, lambda: iter(()), 0))


def test_no_frames_and_no_rate_are_refused() -> None:
    clip = read_clip("smpl", npz(poses=np.zeros((3, 156)), trans=np.zeros((3, 3)), mocap_framerate=60))
    with pytest.raises(ConversionError, match="the clip has none"):
        write(ClipStream(clip.head, lambda: iter(()), 0))
    fields = {name: text for name, text in clip.head.fields.items() if name != "dataframe_rate"}
    with pytest.raises(ConversionError, match="how fast frames follow"):
        write(ClipStream(replace(clip.head, fields=fields), clip.blocks, 3))


def test_long_clips_are_refused_before_they_are_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    clip, drawn = timed(clip_of(person(4, 10))), []

    def blocks() -> Iterator[FrameBlock]:
        for block in [*clip.blocks()] * 100:
            drawn.append(len(block))
            yield block

    monkeypatch.setattr(transfer, "_MOST", 52 * 25)
    fields = {**clip.head.fields, "global_axis_of_gravity": "Y"}
    with pytest.raises(ConversionError, match="more than 25 frames of 52 joints"):
        write(ClipStream(replace(clip.head, fields=fields), blocks, None))
    assert sum(drawn) <= 40
