"""Meshes of glTF files: vertices are where the specification puts them in all frames; damaged files are refused."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import FormatError, LimitError, McmlError, UnsupportedError
from mcml.formats.colours import to_linear, to_srgb
from mcml.formats.format import ReadOptions, SourceFile
from mcml.formats.gltf import meshes
from mcml.formats.gltf.format import Gltf
from mcml.motion.characters.rigged import RiggedCharacter
from mcml.motion.kinematics import Walker
from mcml.motion.skin import Character
from mcml.motion.units import reading_of
from tests.formats.readers.posing import read_clip, spoil
from tests.formats.readers.skinned_files import Builder, skinned_vertices, tube

REAL = ("CesiumMan.gltf", "Fox.glb", "RiggedSimple.gltf", "SimpleSkin.gltf")


def read(data: bytes) -> RiggedCharacter:
    found = Gltf().read_character({"glb": SourceFile("body.glb", io.BytesIO(data))}, ReadOptions())
    assert found is not None
    return found


def open_model(data: bytes) -> pygltflib.GLTF2:
    is_binary = data.startswith(b"glTF")
    return pygltflib.GLTF2.load_from_bytes(data) if is_binary else pygltflib.GLTF2.from_json(data.decode())


def largest_distance(data: bytes, made: Character, rate: float = 30.0, take: int = 0) -> float:
    """Between the vertices by the specification and by our joints, in all frames, in sizes of the mesh."""
    name = Gltf().takes({"glb": SourceFile("body.glb", io.BytesIO(data))}, ReadOptions())[take]
    clip = read_clip("glb", data, rate=rate, take=name)
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    poses = [walker.poses(block) for block in clip.blocks()]
    positions, rotations = (np.concatenate([pose[part] for pose in poses]) for part in (0, 1))
    model = open_model(data)
    if model.animations:
        inputs = {sampler.input for sampler in model.animations[take].samplers}
        first = min(model.accessors[each].min[0] if model.accessors[each].min else 0.0 for each in inputs)
        expected = skinned_vertices(model, take, first + np.arange(len(positions)) / rate)
    else:
        expected = skinned_vertices(model, None, np.zeros(1))
    found = made.move(positions, rotations)
    assert found.shape == expected.shape
    return float(np.abs(found - expected).max() / np.ptp(expected[0], axis=0).max())


@pytest.mark.parametrize("name", REAL)
def test_vertices_of_real_files_are_where_the_specification_puts_them(shared: Path, name: str) -> None:
    data = (shared / "glb" / name).read_bytes()
    found = read(data)
    expected = ["weights of 188 vertices do not add up to 1: they are scaled"] if name == "CesiumMan.gltf" else []
    assert [notice.what for notice in found.notices] == expected
    made = found.character
    assert largest_distance(data, made) < 2e-6
    assert np.abs(made.weights.sum(axis=1) - 1).max() < 1e-9
    assert np.abs(np.linalg.norm(made.normals, axis=1) - 1).max() < 1e-9
    a, b, c = (made.points[made.faces[:, corner]] for corner in range(3))
    outwards = np.einsum("ti,ti->t", np.cross(b - a, c - a), made.normals[made.faces[:, 0]])
    assert (outwards >= 0).mean() > 0.9, "normals look where the triangles do"


def test_textures_colour_the_vertices(shared: Path) -> None:
    pytest.importorskip("PIL")
    colours = read((shared / "glb" / "CesiumMan.gltf").read_bytes()).character.colours
    assert colours is not None
    assert len(np.unique(colours, axis=0)) > 100, "it has a suit, a visor and lettering"
    plain = read((shared / "glb" / "RiggedSimple.gltf").read_bytes()).character.colours
    assert plain is not None
    assert np.unique(plain, axis=0).tolist() == [[144, 209, 127]]


@given(st.integers(1, 6), st.integers(0, 10_000))
def test_bind_poses_and_scales_of_any_kind(joints: int, seed: int) -> None:
    data = tube(joints, seed).data()
    assert largest_distance(data, read(data).character) < 1e-4


def test_a_character_without_animation_is_a_clip_of_its_rest_pose() -> None:
    data = tube(4, 5, still=True).data()
    clip = read_clip("glb", data)
    (block,) = clip.blocks()
    assert len(block) == 1
    assert any("no animation" in notice.what for notice in clip.notices)
    assert largest_distance(data, read(data).character) < 1e-4


def test_files_without_a_skinned_mesh_have_no_character(shared: Path) -> None:
    for name in ("BoxAnimated_no_skin.gltf", "kaykit_barbarian_animations.glb", "vrm1_humanoid_no_animation.vrm"):
        files = {"glb": SourceFile(name, io.BytesIO((shared / "glb" / name).read_bytes()))}
        assert Gltf().read_character(files, ReadOptions()) is None


def test_more_than_four_joints_are_the_four_nearest() -> None:
    made = tube(6, 1)
    count = 40
    joints = np.tile(np.arange(6), (count, 1))
    joints = np.pad(joints, ((0, 0), (0, 2)))
    weights = np.tile([0.02, 0.3, 0.3, 0.2, 0.15, 0.03, 0, 0], (count, 1))
    points = np.random.default_rng(0).normal(size=(count, 3))
    faces = np.arange(count // 3 * 3).reshape(-1, 3)
    made.model["meshes"][0]["primitives"] = [made.primitive(points, joints, weights, faces)]
    found = read(made.data())
    assert [notice.what for notice in found.notices] == [
        "vertices that follow more than four joints follow the four nearest"
    ]
    assert sorted(found.character.joints[0].tolist()) == [1, 2, 3, 4]
    assert found.character.weights[0].tolist() == pytest.approx([0.3 / 0.95, 0.3 / 0.95, 0.2 / 0.95, 0.15 / 0.95])


def test_meshes_that_hang_from_joints_follow_them() -> None:
    made = tube(3, 2)
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    attributes = {"POSITION": made.add(points)}
    made.model["meshes"].append({"primitives": [{"attributes": attributes, "mode": 5}]})
    made.model["nodes"][2]["children"] = [3, 5]
    made.model["nodes"].append({"name": "hat", "mesh": 1, "translation": [0, 7, 0]})
    made.model["nodes"].append({"name": "stone", "mesh": 1})
    found = read(made.data())
    assert [notice.what for notice in found.notices] == ["meshes that hang from no joint are left out"]
    whole = found.character
    assert (whole.joints[-3:, 0] == 1).all()
    # One hundredth of the file's numbers, as the armature scales them; 7 along an axis of the joint.
    assert np.linalg.norm(whole.points[-3] - whole.places[1]) == pytest.approx(0.07, rel=1e-5)
    assert whole.faces[-1].tolist() == [40, 41, 42]


def change_primitive(**changes: Any) -> Builder:
    made = tube(3, 3)
    made.model["meshes"][0]["primitives"][0].update(changes)
    return made


def test_damaged_meshes_are_refused_with_the_place() -> None:
    far = change_primitive()
    far.model["meshes"][0]["primitives"][0]["indices"] = far.add([[0], [1], [99]], 5125)
    with pytest.raises(FormatError, match=r"a triangle names vertex 99 of 40"):
        read(far.data())
    stranger = change_primitive()
    stranger.model["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = stranger.add(np.full((40, 4), 9), 5123)
    with pytest.raises(FormatError, match="a vertex follows joint 9 of a skin of 3"):
        read(stranger.data())
    short = change_primitive()
    short.model["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = short.add(np.ones((3, 4)))
    with pytest.raises(FormatError, match="has 3 elements for 40 vertices"):
        read(short.data())
    with pytest.raises(UnsupportedError, match="compressed"):
        read(change_primitive(extensions={"KHR_draco_mesh_compression": {"bufferView": 0}}).data())
    with pytest.raises(FormatError, match="have no triangles"):
        read(change_primitive(mode=0).data())


def test_large_meshes_are_refused_before_they_are_read() -> None:
    made = tube(3, 4)
    made.model["accessors"][made.model["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["count"] = 100_001
    with pytest.raises(LimitError, match="have 100001 vertices, the limit is 100000"):
        read(made.data())
    made = tube(3, 4)
    made.model["accessors"][made.model["meshes"][0]["primitives"][0]["indices"]]["count"] = 3_000_000
    with pytest.raises(LimitError, match="3000000 numbers of triangles"):
        read(made.data())
    made = tube(3, 4)
    made.model["nodes"] += [{"mesh": 0, "skin": 0}] * 3000
    with pytest.raises(LimitError, match="vertices"):
        read(made.data())


def test_spoilt_files_are_read_or_refused() -> None:
    data = tube(3, 6).data()
    chance = np.random.default_rng(1)
    for _ in range(200):
        spoilt = spoil(data, chance)
        try:
            found = Gltf().read_character({"glb": SourceFile("a.glb", io.BytesIO(spoilt))}, ReadOptions())
        except McmlError:
            continue
        if found is not None:
            assert found.character.faces.max() < len(found.character.points)
            assert found.character.joints.max() < len(found.names)


def test_colours_go_both_ways() -> None:
    values = np.arange(256, dtype=np.uint8)
    assert (to_srgb(to_linear(values)) == values).all()
    assert meshes.MOST_VERTICES == 100_000
