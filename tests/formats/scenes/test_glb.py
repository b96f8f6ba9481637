"""GLB: where every joint is after another reader has read it, what is stated, and what the skin shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError
from mcml.formats import WRITERS
from mcml.formats.scenes import glb
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import scale
from tests.formats.scenes.clips import (
    CLIPS,
    HOSTILE,
    STATED,
    cut,
    enormous,
    hostile,
    stated,
    timed,
    told,
    without_joints,
)
from tests.formats.scenes.reading import Scene, expected, height, read_glb, size_of
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, person


def written(clip: ClipStream) -> Scene:
    return read_glb(b"".join(WRITERS["glb"].write(clip, "glb")))


def compare(clip: ClipStream, metres: float = 1.0, up: str = "Y") -> float:
    """The largest distance of a joint from where it should be, in heights of the body."""
    clip = replace(clip, notices=[])
    scene = written(clip)
    if "calibration_unit" not in clip.head.fields:
        metres = size_of(scene, clip)
    wanted = expected(clip, metres, up)
    found = scene.positions()
    assert [scene.model["nodes"][joint].get("name", "") for joint in scene.joints] == [
        joint.source_name.encode("utf-8", "replace").decode() for joint in clip.head.skeleton.joints
    ]
    if len(found) == 1 and len(wanted) > 1:
        found = np.repeat(found, len(wanted), axis=0)
    assert found.shape == wanted.shape
    away = float(np.abs(found - wanted).max()) / height(wanted)
    _check_body(scene, found)
    return away


def _check_body(scene: Scene, joints: np.ndarray) -> None:
    """Each octahedron begins at the joint that carries it, or is around it."""
    corners = scene.body().reshape(len(joints), -1, 6, 3)
    carriers = scene.array(scene.model["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"])[::6, 0]
    begins = np.abs(corners[:, :, 0] - joints[:, carriers]).max(axis=(0, 2))
    around = np.abs((corners[:, :, 0] + corners[:, :, 5]) / 2 - joints[:, carriers]).max(axis=(0, 2))
    assert (np.minimum(begins, around) < 1e-4 * height(joints)).all()


@pytest.mark.parametrize("title", CLIPS)
def test_joints_are_where_they_were(title: str) -> None:
    clip = CLIPS[title]()
    assert compare(clip, *told(clip)) < 1e-5


@pytest.mark.parametrize("title", STATED)
def test_what_is_stated_becomes_metres_with_y_up(title: str) -> None:
    clip, metres, up = stated(title)
    assert compare(clip, metres, up) < 1e-5
    list(WRITERS["glb"].write(clip, "glb"))
    said = " ".join(notice.what for notice in clip.notices)
    assert ("unit" in said) == (title == "a unit of its own")
    assert ("up axis" in said) == (title == "a unit of its own")


@pytest.mark.parametrize(
    ("title", "kinds", "size"), [("person", ["guess", "guess"], 0.01), ("chain", ["note"] * 2, None)]
)
def test_only_a_person_is_guessed(title: str, kinds: list[str], size: float | None) -> None:
    clip = replace(clip_of(person(1, 3)) if title == "person" else CLIPS[title](), notices=[])
    root = written(clip).model["nodes"][len(clip.head.skeleton)]
    assert root.get("scale") == (size and [size] * 3)
    assert not root.get("rotation")
    assert [notice.kind for notice in clip.notices if "states no" in notice.what] == kinds


def test_times_are_those_of_the_frames() -> None:
    clip = CLIPS["many frames"]()
    np.testing.assert_allclose(written(clip).times(), np.arange(1500) * float(clip.head.frame_time or 0), rtol=1e-7)
    untold = clip.with_head(replace(clip.head, frame_time=None))
    with pytest.raises(ConversionError, match="says how fast frames follow"):
        written(untold)


def test_quaternions_do_not_leap() -> None:
    scene = written(CLIPS["many frames"]())
    for channel in scene.model["animations"][0]["channels"]:
        if channel["target"]["path"] == "rotation":
            values = scene.array(scene.model["animations"][0]["samplers"][channel["sampler"]]["output"]).astype(float)
            assert ((values[1:] * values[:-1]).sum(axis=1) > 0).all()


def test_what_stands_still_has_no_track() -> None:
    clip = clip_of(person(1, 30))
    channels = written(clip).model["animations"][0]["channels"]
    moved = [channel["target"]["node"] for channel in channels if channel["target"]["path"] == "translation"]
    assert moved == [0]
    assert len(channels) == 1 + len(clip.head.skeleton)


def test_long_clips_are_read_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = b"".join(WRITERS["glb"].write(CLIPS["many frames"](), "glb"))
    monkeypatch.setattr(glb, "_AT_ONCE", 30_000)
    pieces = list(WRITERS["glb"].write(CLIPS["many frames"](), "glb"))
    assert b"".join(pieces) == whole
    assert max(map(len, pieces)) <= 30_000
    monkeypatch.setattr(glb, "_LONGEST", len(whole) - 1)
    with pytest.raises(ConversionError, match="Export a part"):
        list(WRITERS["glb"].write(CLIPS["many frames"](), "glb"))


def test_clips_without_frames_or_joints() -> None:
    empty = cut(clip_of(person(1)), 0)
    scene = written(empty)
    assert "animations" not in scene.model or not scene.model["animations"]
    _check_body(scene, scene.positions())
    none = written(without_joints()).model
    assert len(none["nodes"]) == 1
    assert not none.get("skins")


def test_hostile_names_stay_what_they_are() -> None:
    names = [node.get("name", "") for node in written(hostile()).model["nodes"]]
    assert names[: len(HOSTILE) - 1] == list(HOSTILE[:-1])
    # JSON in UTF-8 has no place for half a character.
    assert names[len(HOSTILE) - 1] == "?"


def test_numbers_beyond_single_precision_are_refused() -> None:
    with pytest.raises(ConversionError, match="single precision"):
        written(enormous())
    with pytest.raises(ConversionError, match="single precision"):
        written(scale(clip_of(person(1)), 1e37))
    slow = clip_of(person(1, 3))
    with pytest.raises(ConversionError, match="times"):
        written(slow.with_head(replace(slow.head, frame_time="1e308")))
    tiny = CLIPS["chain"]()
    late = tiny.with_head(replace(tiny.head, frame_time="1e-300"))
    with pytest.raises(ConversionError, match="apart"):
        written(late)


REAL = (
    "bvh/bandai/dataset-1_bow_old_001.bvh",
    "bvh/exporters/rokoko_jesse_dance.bvh",
    "bvh/edge/rotation_first_root.bvh",
    "asfamc/cmu16/run_veer_left_16_48.amc",
    "asfamc/hdm05_reach/HDM_bd_grabHighR_001_120.amc",
    "htr/egnaro_skel_anim.htr",
    "htr/xbot_walking.HTR",
    "c3d/body/mocap36.c3d",
    "trc/dataWithBlanksForMissingMarkers.trc",
)


@pytest.mark.parametrize("name", REAL)
def test_real_joints_are_where_they_were(shared: Path, name: str) -> None:
    clip = timed(opened(shared / name))
    assert compare(clip, *told(clip)) < 1e-5
