"""USD: where every joint is after OpenUSD has read it, and what is stated."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError, UnsupportedError
from mcml.formats import WRITERS
from mcml.formats.scenes import usd
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import scale
from mcml.motion.units import metres_of
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
from tests.formats.scenes.reading import expected, height
from tests.formats.scenes.test_glb import REAL
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, person

pxr = pytest.importorskip("pxr", reason="the extra `usd` is not installed")
from pxr import Usd, UsdGeom, UsdSkel  # noqa: E402

TO_Y = {"Y": np.eye(3), "Z": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])}


def written(clip: ClipStream, folder: Path, format: str = "usd") -> Usd.Stage:
    # A file that is open is not replaced: the library keeps what it read.
    path = folder / f"clip{len(list(folder.iterdir()))}.{format}"
    path.write_bytes(b"".join(WRITERS[format].write(clip, format)))
    stage = Usd.Stage.Open(str(path))
    assert stage.GetDefaultPrim().GetPath() == "/Clip"
    return stage


def positions(stage: Usd.Stage) -> np.ndarray:
    """(n, J, 3) of the joints in metres with Y up, as UsdSkel finds them."""
    root = UsdSkel.Root(stage.GetDefaultPrim())
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Clip/Skeleton")))
    assert query
    assert query.HasBindPose()
    metres = UsdGeom.GetStageMetersPerUnit(stage)
    turn = TO_Y[UsdGeom.GetStageUpAxis(stage)]
    found = []
    for frame in range(int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode()) + 1):
        placed = UsdGeom.XformCache(frame).GetLocalToWorldTransform(query.GetPrim())
        world = np.array([np.array(joint * placed) for joint in query.ComputeJointSkelTransforms(frame)])
        found.append(world[:, 3, :3])
    return np.array(found) @ (turn * metres).T


def away(clip: ClipStream, folder: Path, metres: float, up: str, format: str = "usd") -> float:
    """The largest distance of a joint from where it should be, in heights of the body."""
    told = replace(clip, notices=[])
    stage = written(told, folder, format)
    if metres_of(clip.head) is None:
        metres = UsdGeom.GetStageMetersPerUnit(stage)
    wanted = expected(clip, metres, up)
    found = positions(stage)
    assert found.shape == wanted.shape
    _check_body(stage)
    return float(np.abs(found - wanted).max()) / height(wanted)


def _check_body(stage: Usd.Stage) -> None:
    """The body follows the joints in the last frame."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Clip/Body"))
    cache = UsdSkel.Cache()
    root = UsdSkel.Root(stage.GetDefaultPrim())
    cache.Populate(root, Usd.PrimDefaultPredicate)
    skinning = cache.GetSkinningQuery(mesh.GetPrim())
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Clip/Skeleton")))
    last = stage.GetEndTimeCode()
    points = mesh.GetPointsAttr().Get()
    carriers = np.array(UsdSkel.BindingAPI(mesh.GetPrim()).GetJointIndicesAttr().Get())[::6]
    assert skinning.ComputeSkinnedPoints(query.ComputeSkinningTransforms(last), points, last)
    corners = np.array(points).reshape(-1, 6, 3)
    joints = np.array([np.array(joint) for joint in query.ComputeJointSkelTransforms(last)])[carriers, 3, :3]
    begins = np.abs(corners[:, 0] - joints).max(axis=1)
    around = np.abs((corners[:, 0] + corners[:, 5]) / 2 - joints).max(axis=1)
    assert (np.minimum(begins, around) < 1e-4 * np.ptp(joints, axis=0).max() + 1e-4).all()


@pytest.mark.parametrize("title", CLIPS)
def test_joints_are_where_they_were(title: str, tmp_path: Path) -> None:
    clip = CLIPS[title]()
    assert away(clip, tmp_path, *told(clip)) < 1e-5


@pytest.mark.parametrize("title", STATED)
def test_what_is_stated_is_said(title: str, tmp_path: Path) -> None:
    clip, metres, up = stated(title)
    assert away(clip, tmp_path, metres, up, "usda") < 1e-5
    stage = written(clip, tmp_path)
    assert UsdGeom.StageHasAuthoredMetersPerUnit(stage)
    assert stage.HasAuthoredMetadata("upAxis")
    assert UsdGeom.GetStageUpAxis(stage) == ("Z" if up == "Z" else "Y")
    said = " ".join(notice.what for notice in clip.notices)
    assert ("unit of length" in said) == (title == "a unit of its own")


def test_text_and_binary_say_the_same(tmp_path: Path) -> None:
    text, binary = (written(CLIPS["bvh"](), tmp_path, format) for format in ("usda", "usd"))
    np.testing.assert_array_equal(positions(text), positions(binary))
    assert (tmp_path / "clip0.usda").read_bytes().startswith(b"#usda 1.0")
    assert (tmp_path / "clip1.usd").read_bytes().startswith(b"PXR-USDC")


def test_frames_have_the_rate_of_the_document(tmp_path: Path) -> None:
    clip = CLIPS["bvh"]()
    stage = written(clip, tmp_path)
    assert stage.GetTimeCodesPerSecond() == pytest.approx(1 / float(clip.head.frame_time or 0), rel=1e-12)
    with pytest.raises(ConversionError, match="USD says how fast frames follow") as caught:
        written(clip.with_head(replace(clip.head, frame_time=None)), tmp_path)
    assert "frame_time" in (caught.value.remedy or "")


def test_unit_and_up_axis_are_written_where_nobody_states_them(tmp_path: Path) -> None:
    """The library's own checker wants both. A person is 1.8 of what: metres, or a hundred times that."""
    for clip, metres in ((clip_of(person(1)), 0.01), (_metres(clip_of(person(1))), 1.0), (CLIPS["chain"](), 0.01)):
        stage = written(clip, tmp_path)
        assert UsdGeom.StageHasAuthoredMetersPerUnit(stage)
        assert UsdGeom.GetStageMetersPerUnit(stage) == metres
        assert stage.HasAuthoredMetadata("upAxis")
        said = [notice for notice in clip.notices if "unit of length" in notice.what]
        assert [notice.kind for notice in said] == [
            "note" if metres == 0.01 and len(clip.head.skeleton) < 9 else "guess"
        ]
    assert written(without_joints(), tmp_path).HasAuthoredMetadata("upAxis")


def _metres(clip: ClipStream) -> ClipStream:
    return scale(clip, 0.01, unit="")


def test_clips_without_frames_or_joints(tmp_path: Path) -> None:
    stage = written(cut(clip_of(person(1)), 0), tmp_path)
    rest = positions(stage)
    assert rest.shape == (1, 21, 3)
    assert np.ptp(rest[0], axis=0).max() > 1
    assert not written(without_joints(), tmp_path).GetPrimAtPath("/Clip/Skeleton")


def test_hostile_names_become_identifiers(tmp_path: Path) -> None:
    clip = hostile()
    stage = written(clip, tmp_path)
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/Clip/Skeleton"))
    joints = list(skeleton.GetJointsAttr().Get())
    assert len(set(joints)) == len(joints) == len(HOSTILE)
    assert UsdSkel.Topology(joints).Validate()[0]
    assert list(skeleton.GetJointNamesAttr().Get()) == list(clip.head.skeleton.names)
    assert any("names that USD cannot hold" in notice.what for notice in clip.notices)
    assert away(hostile(), tmp_path, 1.0, "Y", "usda") < 1e-5


def test_what_cannot_be_written_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConversionError, match="single precision"):
        written(enormous(), tmp_path)
    monkeypatch.setattr(usd, "_MOST", 100)
    with pytest.raises(ConversionError, match="no more than 4 frames"):
        written(CLIPS["bvh"](), tmp_path)
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(UnsupportedError, match="mcml-repository\\[usd\\]"):
        written(CLIPS["bvh"](), tmp_path)


@pytest.mark.parametrize("name", REAL)
def test_real_joints_are_where_they_were(shared: Path, name: str, tmp_path: Path) -> None:
    clip = timed(opened(shared / name))
    assert away(clip, tmp_path, *told(clip)) < 1e-5
