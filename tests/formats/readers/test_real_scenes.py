"""Real files of scenes: joints stand where other programs put them, also after a way through MCML and BVH."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcml.errors import McmlError
from mcml.files.convert_files import convert_files
from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.open_clip import open_clip
from mcml.formats.format import SourceFile
from mcml.language.elements import to_head
from mcml.motion.clip import ClipStream
from mcml.testing import read
from tests.conftest import shared_folder
from tests.formats.readers.posing import places_of

RATES = {"SimpleSkin.gltf": 2.0, "test.vrma": 2.0, "interpolations.glb": 20.0, "cmu131_01_smpl_72.npz": 60.0}
"""What is asked for where a file has no rate."""


def expected() -> dict[str, dict[str, Any]]:
    folder = shared_folder()
    path = None if folder is None else folder / "expected_formats_in.json"
    if path is None or not path.is_file():
        return {}
    files: dict[str, dict[str, Any]] = json.loads(path.read_text())["files"]
    return {name: facts for name, facts in files.items() if facts["format"] != "arkit"}


CASES = sorted(expected())


def clips_of(path: Path) -> dict[str | None, ClipStream]:
    """The clips of a file by their takes."""
    options = ImportOptions(rate=RATES.get(path.name))
    with gathered([SourceFile(path.name, io.BytesIO(path.read_bytes()))], FileLimits(), options=options) as found:
        for _, error in found.problems:
            raise error
        clips = {}
        for clip in found.clips:
            opened = open_clip(clip, options, FileLimits())
            head = to_head(opened.document, opened.stream.head.frame_time)
            blocks = list(opened.stream.blocks())
            clips[clip.take] = ClipStream(head, lambda blocks=blocks: iter(blocks), None, opened.stream.notices)
        return clips


def largest_error(clip: ClipStream, positions: dict[str, dict[str, list[float]]], facts: dict[str, Any]) -> float:
    """The largest difference of any joint in any frame, in the unit of the expected values."""
    places, metres = places_of(clip), facts.get("unit_metres", 1.0)
    names = [joint.source_name for joint in clip.head.skeleton.joints]
    worst = 0.0
    for frame, joints in positions.items():
        for name, wanted in joints.items():
            found = places[int(frame), names.index(name)]
            if "Y up" in facts["route"]:
                found = found * metres
                found = found[[0, 2, 1]] * [1, 1, -1] if facts["up"] == "Z" else found
            worst = max(worst, float(np.abs(found - wanted).max()))
    return worst


@pytest.mark.parametrize("name", CASES or ["absent"])
def test_joints_stand_where_other_programs_put_them(shared: Path, name: str) -> None:
    if not CASES:
        pytest.skip("the expected positions are not here")
    facts = expected()[name]
    if name.startswith("usd/"):
        pytest.importorskip("pxr")
    try:
        clips = clips_of(shared / name)
    except McmlError:
        assert "refused" in facts.get("expect", "refused")
        assert "positions" not in facts
        return
    takes = facts.get("takes") or [facts]
    listed = list(takes.items()) if isinstance(takes, dict) else [(take.get("name"), take) for take in takes]
    assert len(clips) >= len(listed)
    compared = 0
    for number, (take, about) in enumerate(listed):
        clip = clips[take] if take in clips else list(clips.values())[number]
        if "frames" in about:
            assert sum(len(block) for block in clip.blocks()) == about["frames"]
        positions = about.get("positions") or (facts.get("positions") if number == 0 else None)
        if positions:
            compared += 1
            assert largest_error(clip, positions, facts) < facts["tolerance_m"]
    assert compared or "tolerance_m" not in facts or name in ("mvnx/Meri-020.mvnx", "glb/SimpleSkin.gltf")


@pytest.mark.parametrize("name", ["fbx/jog_max_biped_7400.fbx", "glb/CesiumMan.gltf", "mvnx/test_mocap.mvnx"])
def test_positions_stay_in_bvh(shared: Path, name: str) -> None:
    path = shared / name
    if not path.is_file():
        pytest.skip("the file is not here")
    clip = next(iter(clips_of(path).values()))
    with convert_files([SourceFile(path.name, io.BytesIO(path.read_bytes()))], "bvh", FileLimits()) as done:
        again = read(_bvh(), {"bvh": b"".join(done.files[".bvh"])})
    wanted = places_of(clip)
    assert np.abs(places_of(again) - wanted).max() < 1e-6 * np.ptp(wanted)


def _bvh() -> Any:
    from mcml.formats import FORMATS

    return FORMATS["bvh"]
