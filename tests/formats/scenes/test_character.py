"""Bodies with a skin in glTF and USD: the vertices are where other readers of the files move them."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.errors import ConversionError, UnsupportedError
from mcml.formats import WRITERS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.formats.gltf.format import Gltf
from mcml.formats.scenes.body import body_of
from mcml.formats.scenes.stage import look_through
from mcml.motion.bodies.clip_body import calibrate_clip
from mcml.motion.characters.figure import bind_character
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import turn_up
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Convention
from mcml.motion.units import reading_of
from tests.formats.scenes.clips import CLIPS
from tests.formats.scenes.reading import Scene, expected, height, read_glb, stating
from tests.motion.bodies.made import clip_of, person

KINDS = (Convention.LISTED, Convention.FIXED, Convention.BASE)
REAL = (
    "bvh/bandai/dataset-1_bow_angry_001.bvh",
    "bvh/exporters/perception_neuron_milad.bvh",
    "bvh/exporters/rokoko_jesse_dance.bvh",
)


def written(clip: ClipStream) -> Scene:
    return read_glb(b"".join(WRITERS["glb"].write(replace(clip, character=True, notices=[]), "glb")))


def check(clip: ClipStream, metres: float = 1.0, up: str = "Y") -> Scene:
    """In every frame the vertices are where the figure is by the service's own skinning, in metres with Y up."""
    scene = written(clip)
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    made = body_of(look_through(replace(clip, character=True, notices=[]), "glTF", "metres"))
    positions, rotations = Walker(skeleton, reading).poses(next(iter(clip.blocks())))
    start = calibrate_clip(clip, len(positions)).start
    figure = replace(
        bind_character(skeleton, reading, start),
        points=made.points, joints=made.joints, weights=made.weights, places=made.places, turns=made.turns,
    )  # fmt: skip
    joints = expected(clip, metres, up)
    turn = np.linalg.lstsq(positions.reshape(-1, 3), joints.reshape(-1, 3), rcond=None)[0]
    wanted = figure.move(positions, rotations) @ turn
    found = scene.body()
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() < 1e-5 * height(joints)
    (primitive,) = scene.model["meshes"][0]["primitives"]
    normals = scene.array(primitive["attributes"]["NORMAL"])
    assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-5
    points = scene.array(primitive["attributes"]["POSITION"])
    a, b, c = (points[scene.array(primitive["indices"])[corner::3, 0]] for corner in range(3))
    outwards = np.einsum("ti,ti->t", np.cross(b - a, c - a), normals[scene.array(primitive["indices"])[::3, 0]])
    assert (outwards > 0).mean() > 0.97
    return scene


@pytest.mark.parametrize("kind", KINDS)
def test_vertices_follow_the_joints(kind: Convention) -> None:
    check(stating(clip_of(person(1), kind), calibration_unit="m", global_axis_of_gravity="Y"))


@pytest.mark.parametrize(("unit", "metres", "up"), [("cm", 0.01, "Z"), ("mm", 0.001, "Y"), ("inch", 0.0254, "X")])
def test_units_and_axes_are_those_of_the_scene(unit: str, metres: float, up: str) -> None:
    clip = turn_up(clip_of(person(2, 12)), "Y", up)
    scene = check(stating(clip, calibration_unit=unit, global_axis_of_gravity=up), metres, up)
    body = scene.body()[0]
    assert np.argmax(np.ptp(body, axis=0)) == 1, "it stands along Y"


def test_our_own_reader_finds_the_same_joints() -> None:
    clip = clip_of(person(2, 12))
    content = b"".join(WRITERS["glb"].write(replace(clip, character=True), "glb"))
    scene = Gltf().open_scene({"glb": SourceFile("walk.glb", io.BytesIO(content))}, ReadOptions())
    (take,) = scene.takes
    assert list(take.rig.names) == [joint.source_name for joint in clip.head.skeleton.joints]
    assert take.frames == 12


def test_others_keep_their_bones_or_say_why() -> None:
    clip = clip_of(person(2, 3))
    plain = read_glb(b"".join(WRITERS["glb"].write(clip, "glb")))
    dressed = written(clip)
    count = [len(scene.array(scene.model["meshes"][0]["primitives"][0]["indices"])) for scene in (plain, dressed)]
    assert count[1] > 10 * count[0]
    assert "NORMAL" not in plain.model["meshes"][0]["primitives"][0]["attributes"]
    with pytest.raises(ConversionError, match="Markers have no bones"):
        written(CLIPS["trc"]())
    with pytest.raises(ConversionError, match="not recognised: left_up_arm"):
        written(CLIPS["chain"]())


def test_usd_moves_it_too(tmp_path: Path) -> None:
    pxr = pytest.importorskip("pxr")
    from pxr import Usd, UsdSkel

    assert pxr
    clip = clip_of(person(3, 6))
    path = tmp_path / "walk.usda"
    path.write_bytes(b"".join(WRITERS["usda"].write(replace(clip, character=True, notices=[]), "usda")))
    made = body_of(look_through(replace(clip, character=True, notices=[]), "USD", "metres"))
    stage = Usd.Stage.Open(str(path))
    root = UsdSkel.Root(stage.GetPrimAtPath("/Clip"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    query = cache.GetSkinningQuery(stage.GetPrimAtPath("/Clip/Body"))
    skeleton = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Clip/Skeleton")))
    positions, rotations = Walker(clip.head.skeleton, reading_of(clip.head)).poses(next(iter(clip.blocks())))
    start = calibrate_clip(clip, 6).start
    figure = replace(
        bind_character(clip.head.skeleton, reading_of(clip.head), start),
        points=made.points, joints=made.joints, weights=made.weights, places=made.places, turns=made.turns,
    )  # fmt: skip
    wanted = figure.move(positions, rotations)
    mesh = stage.GetPrimAtPath("/Clip/Body")
    for frame in (0, 5):
        from pxr import UsdGeom, Vt

        points = Vt.Vec3fArray(UsdGeom.Mesh(mesh).GetPointsAttr().Get())
        assert query.ComputeSkinnedPoints(skeleton.ComputeSkinningTransforms(frame), points, frame)
        assert np.abs(np.array(points) - wanted[frame]).max() < 1e-4 * np.ptp(wanted[frame], axis=0).max()


@pytest.mark.parametrize("name", REAL)
def test_real_rigs_are_exported_with_a_body(shared: Path, name: str, tmp_path: Path) -> None:
    target = tmp_path / "clip.glb"
    mcml.convert(shared / name, target, character="own", frames="1-20")
    scene = read_glb(target.read_bytes())
    body, joints = scene.body(), scene.positions()
    assert len(body) == 20
    tall = np.ptp(joints[0], axis=0).max()
    assert 0.9 * tall < np.ptp(body[0], axis=0).max() < 1.4 * tall
    # The body is around its joints in every frame.
    assert np.abs(body.mean(axis=1) - joints.mean(axis=1)).max() < 0.25 * tall
    assert [*mcml.read(target).bones]


def test_a_preset_whose_format_holds_none_becomes_gltf(tmp_path: Path) -> None:
    source = tmp_path / "walk.bvh"
    source.write_bytes(person(1, 4))
    (path,) = mcml.convert(source, tmp_path / "walk", for_="blender", character="own")
    assert path.suffix == ".glb"
    with pytest.raises(UnsupportedError, match="BVH holds no body with a skin"):
        mcml.convert(source, tmp_path / "walk2.bvh", character="own")
