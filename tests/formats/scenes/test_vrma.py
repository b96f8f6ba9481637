"""VRM Animation: bones point as in the clip, on a humanoid in T-pose, read again by the project's own reader."""

from __future__ import annotations

import json
import os
import struct
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError
from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.on_disk import opened_files
from mcml.files.open_clip import open_clip
from mcml.formats import WRITERS
from mcml.formats.scenes.vrma import make_humanoid
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import scale, turn_up
from mcml.motion.kinematics import rest_positions
from mcml.motion.skeleton import Array
from tests.formats.readers.posing import npz, places_of, read_clip
from tests.formats.scenes.clips import timed
from tests.motion.bodies.made import clip_of, person

SAMPLES = Path(os.environ.get("MCML_SHARED", "/nowhere"), "data/glb")
LIMBS = {
    "left_up_leg": "leftUpperLeg", "left_low_leg": "leftLowerLeg", "left_foot": "leftFoot",
    "right_up_leg": "rightUpperLeg", "right_low_leg": "rightLowerLeg", "right_foot": "rightFoot",
    "left_up_arm": "leftUpperArm", "left_low_arm": "leftLowerArm", "left_hand": "leftHand",
    "right_up_arm": "rightUpperArm", "right_low_arm": "rightLowerArm", "right_hand": "rightHand",
}  # fmt: skip


def write(clip: ClipStream) -> bytes:
    return b"".join(WRITERS["vrma"].write(clip, "vrma"))


def facts_of(data: bytes) -> dict[str, object]:
    (length,) = struct.unpack_from("<I", data, 12)
    found: dict[str, object] = json.loads(data[20 : 20 + length])
    return found


def directions(places: Array, names: list[str], bones: list[str]) -> Array:
    """(frames, bones - 2, 3) unit vectors along the limbs."""
    found = []
    for number, (start, end) in enumerate(pairwise(bones)):
        if number % 3 != 2:
            bone = places[:, names.index(end)] - places[:, names.index(start)]
            found.append(bone / np.linalg.norm(bone, axis=-1, keepdims=True))
    return np.stack(found, axis=1)


@pytest.mark.parametrize("up", ["Y", "Z"])
@pytest.mark.parametrize("unit", ["cm", "m"])
def test_a_clip_comes_back_on_the_humanoid(up: str, unit: str) -> None:
    clip = timed(clip_of(person(4, 12)))
    fields = {**clip.head.fields, "calibration_unit": "cm", "global_axis_of_gravity": "Y"}
    upright = clip.with_head(replace(clip.head, fields=fields))
    stated = turn_up(scale(upright, 1.0 if unit == "cm" else 0.01, unit=unit), "Y", up)
    again = read_clip("glb", write(stated), "walk.vrma")
    assert again.frames == 12
    names = [joint.source_name for joint in again.head.skeleton.joints]
    places, before = places_of(again), places_of(upright)
    source = [joint.name for joint in upright.head.skeleton.joints]
    one, two = directions(before, source, list(LIMBS)), directions(places, names, list(LIMBS.values()))
    assert np.abs(one - two).max() < 1e-5
    # The hips travel by the ratio of the legs, above a ground that is that of the clip.
    travel = np.ptp(places[:, names.index("hips")], axis=0)
    assert np.allclose(
        travel, np.ptp(before[:, source.index("Root")], axis=0) * 0.78 / _leg(upright), rtol=0.2, atol=0.02
    )


def _leg(clip: ClipStream) -> float:
    places = places_of(clip)[0]
    at = [[joint.name for joint in clip.head.skeleton.joints].index(name) for name in list(LIMBS)[:3]]
    return float(np.linalg.norm(np.diff(places[at], axis=0), axis=1).sum())


def test_the_file_keeps_the_rules_of_the_specification() -> None:
    facts = facts_of(write(timed(clip_of(person(4, 12)))))
    animation = facts["extensions"]["VRMC_vrm_animation"]  # type: ignore[index]
    assert animation["specVersion"] == "1.0"
    assert facts["extensionsUsed"] == ["VRMC_vrm_animation"]
    assert "meshes" not in facts or not facts["meshes"]
    nodes, bones = facts["nodes"], animation["humanoid"]["humanBones"]
    assert all(nodes[bone["node"]]["name"] == name for name, bone in bones.items())  # type: ignore[index]
    assert {"hips", "spine", "head", "leftHand", "rightFoot"} <= bones.keys()
    assert not {"leftEye", "rightEye"} & bones.keys()
    hips = bones["hips"]["node"]
    (motion,) = facts["animations"]  # type: ignore[misc]
    targets = [channel["target"] for channel in motion["channels"]]
    assert {target["path"] for target in targets} <= {"rotation", "translation"}
    assert [target["node"] for target in targets if target["path"] == "translation"] == [hips]
    assert all("rotation" not in node and "scale" not in node for node in nodes)  # type: ignore[union-attr]


def test_the_rest_pose_is_a_t_that_stands_on_the_ground() -> None:
    skeleton = make_humanoid()
    names = list(skeleton.names)
    places = rest_positions(skeleton)
    at = {name: places[index] for index, name in enumerate(names)}
    assert at["leftToes"][1] == pytest.approx(0.025)
    for side, sign in (("left", 1), ("right", -1)):
        arm = [at[side + name] for name in ("UpperArm", "LowerArm", "Hand", "MiddleDistal")]
        assert all(sign * (after - before)[0] > 0 for before, after in pairwise(arm))
        assert np.allclose(np.diff(arm, axis=0)[:, 1:], 0)
        leg = np.diff([at[side + name] for name in ("UpperLeg", "LowerLeg", "Foot")], axis=0)
        assert np.allclose(leg[:, [0, 2]], 0)
        assert (leg[:, 1] < 0).all()
        assert (at[f"{side}Toes"] - at[f"{side}Foot"])[2] > 0
    few = make_humanoid(frozenset(names) - {"chest", "upperChest", "neck", "leftShoulder"})
    for index, name in enumerate(few.names):
        assert np.allclose(rest_positions(few)[index], at[name])


def test_bones_that_a_clip_lacks_are_left_out() -> None:
    clip = read_clip("smpl", npz(poses=np.zeros((4, 66)), trans=np.zeros((4, 3)), mocap_framerate=60))
    animation = facts_of(write(clip))["extensions"]["VRMC_vrm_animation"]  # type: ignore[index]
    assert not [name for name in animation["humanoid"]["humanBones"] if "Thumb" in name or name == "jaw"]


def test_a_trunk_of_few_joints_has_no_gaps() -> None:
    """VRM requires a spine, and an upper chest only above a chest."""
    clip = timed(clip_of(person(4, 10)))
    bones = facts_of(write(clip))["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"]  # type: ignore[index]
    trunk = [name for name in ("spine", "chest", "upperChest") if name in bones]
    assert trunk == ["spine", "chest", "upperChest"][: len(trunk)]
    assert trunk


@pytest.mark.parametrize("name", ["test.vrma", "CesiumMan.gltf"])
def test_files_of_others_come_back(name: str) -> None:
    path = SAMPLES / name
    if not path.exists():
        pytest.skip("the samples of glTF are not here (set MCML_SHARED to their folder)")
    with opened_files(path) as files, gathered(files, FileLimits(), options=ImportOptions()) as sorted_files:
        clip = open_clip(sorted_files.clips[0], ImportOptions(), FileLimits()).stream
        again = read_clip("glb", write(clip), "again.vrma")
        assert again.frames == clip.frames
        places, before = places_of(again), places_of(clip)
    source = [joint.name for joint in clip.head.skeleton.joints]
    target = [joint.source_name for joint in again.head.skeleton.joints]
    one, two = directions(before, source, list(LIMBS)), directions(places, target, list(LIMBS.values()))
    assert np.abs(one - two).max() < 1e-4


def test_what_is_no_humanoid_is_refused() -> None:
    clip = timed(clip_of(person(4, 10)))
    joints = tuple(replace(joint, name=f"b{at}", source_name=f"b{at}", mapped=False)
                   for at, joint in enumerate(clip.head.skeleton.joints[:4]))  # fmt: skip
    head = replace(clip.head, skeleton=replace(clip.head.skeleton, joints=joints))
    with pytest.raises(ConversionError, match=r"lacks .*leftLowerLeg"):
        write(ClipStream(head, lambda: iter(()), 0))
    with pytest.raises(ConversionError, match="no frames"):
        write(ClipStream(clip.head, lambda: iter(()), 0))
