"""GLB files as Blender opens them."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mcml.formats import WRITERS
from mcml.motion.clip import ClipStream
from tests.formats.scenes.clips import CLIPS, hostile, stated, told
from tests.formats.scenes.reading import expected, height, read_glb, size_of
from tests.formats.test_real_files import opened

SCRIPT = Path(__file__).with_name("blender_reads.py")
MADE = ("bvh", "asf", "htr", "htr with gaps", "trc", "c3d", "listed 1", "base 3")
REAL = ("bvh/bandai/dataset-1_bow_old_001.bvh", "htr/xbot_walking.HTR", "c3d/body/mocap36.c3d")
MOST = 300
"""Frames that are compared of one clip."""


@cache
def why_not() -> str:
    """Why Blender cannot read glTF here; empty where it can."""
    if shutil.which("blender") is None:
        return "Blender is not here (apt-get install blender python3-numpy)"
    done = subprocess.run(
        ["blender", "-b", "--factory-startup", "--python-expr", "import numpy; print('numpy is there')"],
        capture_output=True,
        text=True,
        check=False,
    )
    return "" if "numpy is there" in done.stdout else "Blender has no NumPy, which its glTF reader needs"


def compare(clips: Mapping[str, ClipStream], folder: Path) -> dict[str, float]:
    """The largest distance of a joint from where it should be, in heights of the body, by clip."""
    if why_not():
        pytest.skip(why_not())
    asked = []
    for number, clip in enumerate(clips.values()):
        path = folder / f"{number}.glb"
        path.write_bytes(b"".join(WRITERS["glb"].write(replace(clip, notices=[]), "glb")))
        seconds = clip.head.seconds_per_frame() or 1 / 120
        count = min(len(expected(clip)), MOST)
        times = [frame * seconds for frame in range(count)]
        asked.append({"path": str(path), "times": times, "out": str(folder / f"{number}.npy")})
    (folder / "asked.json").write_text(json.dumps(asked))
    command = ["blender", "-b", "--factory-startup", "--python-exit-code", "3", "-P", str(SCRIPT), "--"]
    done = subprocess.run([*command, str(folder / "asked.json")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return {
        title: _away(clip, Path(item["path"]), Path(str(item["out"])))
        for (title, clip), item in zip(clips.items(), asked, strict=True)
    }


def _away(clip: ClipStream, path: Path, out: Path) -> float:
    found = np.load(out)
    said = json.loads(Path(f"{out}.json").read_text())
    scene = read_glb(path.read_bytes())
    wanted = expected(clip, size_of(scene, clip), told(clip)[1])[: len(found)]
    wanted = wanted @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    names = [scene.model["nodes"][joint].get("name", "") for joint in scene.joints]
    assert len(said["names"]) == len(names)
    order = [said["names"].index(name) for name in names] if len(set(names)) == len(names) else range(len(names))
    corners = scene.body()[min(len(found), len(scene.matrices())) - 1] @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    extents = np.array([corners.min(axis=0), corners.max(axis=0)])
    np.testing.assert_allclose(said["extents"], extents, atol=1e-4 * height(wanted))
    return float(np.abs(found[:, list(order)] - wanted).max()) / height(wanted)


def test_bones_are_where_joints_are(tmp_path: Path) -> None:
    clips = {title: CLIPS[title]() for title in MADE}
    clips |= {title: stated(title)[0] for title in ("centimetres, Z up", "inches, X up")}
    for title, away in compare(clips, tmp_path).items():
        print(f"{title}: {away:.2g}")
        assert away < 1e-5, title


def test_hostile_names_open(tmp_path: Path) -> None:
    compare({"hostile": hostile()}, tmp_path)


def test_real_bones_are_where_joints_are(shared: Path, tmp_path: Path) -> None:
    for title, away in compare({name: opened(shared / name) for name in REAL}, tmp_path).items():
        print(f"{title}: {away:.2g}")
        assert away < 1e-5, title
