"""Files of clips as Blender opens them: bones stand where joints do, in metres."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.files.motion import convert
from mcml.files.motion import read as read_motion
from mcml.formats import WRITERS
from mcml.motion.clip import ClipStream
from tests.blender import find_blender, why_not
from tests.formats.scenes.clips import CLIPS, hostile, stated, told
from tests.formats.scenes.reading import expected, height, read_glb, size_of
from tests.formats.test_real_files import opened

SCRIPT = Path(__file__).with_name("blender_reads.py")
MADE = ("bvh", "asf", "htr", "htr with gaps", "trc", "c3d", "listed 1", "base 3")
REAL = ("bvh/bandai/dataset-1_bow_old_001.bvh", "htr/xbot_walking.HTR", "c3d/body/mocap36.c3d")
SCENES = (
    "fbx/cmu_07_01_blender_7400.fbx", "fbx/jog_max_biped_7400.fbx", "fbx/arnaud_rig_7500.fbx",
    "fbx/max_transformed_skin_7500_binary.fbx", "fbx/maya_scale_no_inherit_7700_ascii.fbx", "glb/CesiumMan.gltf",
    "usd/skeleton.usda", "usd/arm.usda", "npz/cmu131_01_smplx_165.npz", "mvnx/Meri-020.mvnx",
)  # fmt: skip
MOST = 300
"""Frames that are compared of one clip."""
PRECISION = 1e-4
"""Heights of the body: Blender 4.5 keeps bones at rest in single precision, which short ones feel (3.4: 2e-6)."""
TO_Z = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""From Y up, row by row."""


def ask(asked: list[dict[str, object]], folder: Path) -> None:
    if why_not():
        pytest.skip(why_not())
    (folder / "asked.json").write_text(json.dumps(asked))
    command = [str(find_blender()), "-b", "--factory-startup", "--python-exit-code", "3", "-P", str(SCRIPT), "--"]
    done = subprocess.run([*command, str(folder / "asked.json")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


def compare(clips: Mapping[str, ClipStream], folder: Path) -> dict[str, float]:
    """The largest distance of a joint from where it should be, in heights of the body, by clip."""
    if why_not():
        pytest.skip(why_not())
    asked: list[dict[str, object]] = []
    for number, clip in enumerate(clips.values()):
        path = folder / f"{number}.glb"
        path.write_bytes(b"".join(WRITERS["glb"].write(replace(clip, notices=[]), "glb")))
        rate = 1 / (clip.head.seconds_per_frame() or 1 / 120)
        count = min(len(expected(clip)), MOST)
        asked.append({"path": str(path), "rate": rate, "frames": count, "out": str(folder / f"{number}.npy")})
    ask(asked, folder)
    return {
        title: _away(clip, Path(str(item["path"])), Path(str(item["out"])))
        for (title, clip), item in zip(clips.items(), asked, strict=True)
    }


def _away(clip: ClipStream, path: Path, out: Path) -> float:
    found = np.load(out)
    said = json.loads(Path(f"{out}.json").read_text())
    scene = read_glb(path.read_bytes())
    wanted = expected(clip, size_of(scene, clip), told(clip)[1])[: len(found)] @ TO_Z
    names = [scene.model["nodes"][joint].get("name", "") for joint in scene.joints]
    assert len(said["names"]) == len(names)
    order = [said["names"].index(name) for name in names] if len(set(names)) == len(names) else range(len(names))
    corners = scene.body()[min(len(found), len(scene.matrices())) - 1] @ TO_Z
    extents = np.array([corners.min(axis=0), corners.max(axis=0)])
    np.testing.assert_allclose(said["extents"], extents, atol=1e-4 * height(wanted))
    return float(np.abs(found[:, list(order)] - wanted).max()) / height(wanted)


def test_bones_are_where_joints_are(tmp_path: Path) -> None:
    clips = {title: CLIPS[title]() for title in MADE}
    clips |= {title: stated(title)[0] for title in ("centimetres, Z up", "inches, X up")}
    for title, away in compare(clips, tmp_path).items():
        print(f"{title}: {away:.2g}")
        assert away < PRECISION, title


def test_hostile_names_open(tmp_path: Path) -> None:
    compare({"hostile": hostile()}, tmp_path)


def test_real_bones_are_where_joints_are(shared: Path, tmp_path: Path) -> None:
    for title, away in compare({name: opened(shared / name) for name in REAL}, tmp_path).items():
        print(f"{title}: {away:.2g}")
        assert away < PRECISION, title


@pytest.mark.slow
@pytest.mark.parametrize("form", ["bvh", "glb", "usda"])
def test_scenes_of_other_programs_are_where_they_were(shared: Path, tmp_path: Path, form: str) -> None:
    """FBX, glTF, USD, AMASS and MVNX, converted for Blender, against their places in the file that was read."""
    asked: list[dict[str, object]] = []
    for number, name in enumerate(SCENES):
        path = tmp_path / f"{number}.{form}"
        convert(shared / name, path, **({"for_": "blender"} if form == "bvh" else {}))
        motion = read_motion(shared / name)
        count = min(len(motion), 40)
        facts = {"rate": 1 / (motion.frame_time or 1 / 30), "frames": count, "out": str(tmp_path / f"{number}.npy")}
        asked.append({"path": str(path), **facts})
    ask(asked, tmp_path)
    for name, item in zip(SCENES, asked, strict=True):
        motion, found = read_motion(shared / name), np.load(str(item["out"]))
        calibration = motion.calibration
        places = motion.frames(space="positions")[: len(found)] * calibration.metres
        wanted = places if calibration.up == "Z" else places @ TO_Z
        # Bones stand in the order of the tree; names of USD are others.
        assert found.shape == wanted.shape, name
        away = float(np.abs(np.sort(found, axis=1) - np.sort(wanted, axis=1)).max()) / height(wanted)
        print(f"{name}: {away:.2g}")
        assert away < 1e-5, name
