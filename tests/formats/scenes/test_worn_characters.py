"""Clips worn by the characters of files: the mesh of the file, on its own rig, moved as the clip moves."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pygltflib
import pytest

import mcml
from mcml.errors import ConversionError, LimitError, RequestError, UnsupportedError
from mcml.files.limits import FileLimits
from mcml.files.wear_character import check_own, wear_file
from mcml.formats.format import SourceFile
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import turn_up
from mcml.motion.kinematics import Walker
from mcml.motion.retargeting import move_character
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of
from tests.formats.readers.posing import read_clip
from tests.formats.readers.skinned_files import skinned_vertices, tube
from tests.formats.scenes.reading import read_glb, stating
from tests.motion.bodies.made import clip_of, person


def poses(clip: ClipStream) -> tuple[Array, Array]:
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    found = [walker.poses(block) for block in clip.blocks()]
    return np.concatenate([one for one, _ in found]), np.concatenate([two for _, two in found])


@pytest.fixture
def own_body(tmp_path: Path) -> Path:
    """Our own figure as a file: the character of a person."""
    source = tmp_path / "person.bvh"
    source.write_bytes(person(2, 3))
    (path,) = mcml.convert(source, tmp_path / "figure.glb", character="own")
    return path


def wear(clip: ClipStream, path: Path) -> ClipStream:
    return wear_file(clip, SourceFile(path.name, io.BytesIO(path.read_bytes())), FileLimits())


def direction(positions: Array, skeleton: list[str], one: str, two: str) -> Array:
    bone = positions[:, skeleton.index(two)] - positions[:, skeleton.index(one)]
    return bone / np.linalg.norm(bone, axis=1, keepdims=True)


@pytest.mark.parametrize(("unit", "up"), [("cm", "Y"), ("m", "Z"), ("mm", "X")])
def test_a_person_moves_the_body_of_another(own_body: Path, unit: str, up: str) -> None:
    """Whatever unit and axis the clip has, arms and legs of the character point as the clip's do."""
    clip = clip_of(person(3, 12))
    turned = stating(turn_up(clip, "Y", up) if up != "Y" else clip, calibration_unit=unit, global_axis_of_gravity=up)
    worn = wear(turned, own_body)
    places, _ = poses(clip)
    moved, _ = poses(worn)
    names = [joint.name for joint in clip.head.skeleton.joints]
    rig = [joint.name for joint in worn.head.skeleton.joints]
    sources = [joint.source_name for joint in clip.head.skeleton.joints]
    for one, two in (("left_up_leg", "left_low_leg"), ("right_low_arm", "right_hand")):
        wanted = direction(places, names, one, two)
        ends = [rig[0] and sources[names.index(name)] for name in (one, two)]
        found = direction(moved, [joint.source_name for joint in worn.head.skeleton.joints], *ends)
        assert np.degrees(np.arccos(np.clip((wanted * found).sum(axis=1), -1, 1))).max() < 1.0
    assert not isinstance(worn.character, bool)
    body = worn.character.move(*poses(worn))
    assert 1.4 < np.ptp(body[0, :, 1]) < 2.0, "metres, upright along Y, at the character's own size"


def test_exports_hold_the_mesh_and_the_rig_of_the_file(shared: Path, tmp_path: Path) -> None:
    """The vertices of the written file, by pygltflib, are where the retargeted joints move the mesh of the other."""
    character = shared / "glb" / "CesiumMan.gltf"
    source = shared / "bvh" / "bandai" / "dataset-1_bow_angry_001.bvh"
    (path,) = mcml.convert(source, tmp_path / "bow.glb", character=character, frames="1-20")
    model = pygltflib.GLTF2.load(path)
    (written,) = model.meshes
    assert model.accessors[written.primitives[0].attributes.POSITION].count == 3273
    assert written.primitives[0].attributes.COLOR_0 is not None
    assert [model.nodes[joint].name for joint in model.skins[0].joints] == [f"node_{number}" for number in range(2, 21)]
    found = skinned_vertices(model, 0, np.arange(20) / 30)
    worn = wear(read_clip("bvh", source.read_bytes()), character)
    assert not isinstance(worn.character, bool)
    positions, rotations = poses(worn)
    wanted = worn.character.move(positions[:20], rotations[:20])
    assert np.abs(found - wanted).max() < 1e-5
    assert 1.3 < np.ptp(found[0, :, 1]) < 1.7
    assert np.abs(found[:, :, 1].min(axis=1)).max() < 0.15, "it stands on the floor"


@pytest.mark.parametrize(
    "options", [{"height": 1.0}, {"fps": 10}, {"scale": 2.0}, {"in_place": True}, {"for_": "unreal"}]
)
def test_other_options_of_exports_apply_to_the_character(
    own_body: Path, tmp_path: Path, options: dict[str, object]
) -> None:
    source = tmp_path / "walk.bvh"
    source.write_bytes(person(3, 40))
    (plain,) = mcml.convert(source, tmp_path / "plain.glb", character=own_body)
    (path,) = mcml.convert(source, tmp_path / "changed.glb", to="glb", character=own_body, **options)  # type: ignore[arg-type]
    one, two = read_glb(plain.read_bytes()), read_glb(path.read_bytes())
    body, changed = one.body(), two.body()
    assert body.shape[1] == changed.shape[1]
    size = np.ptp(changed[0], axis=0).max() / np.ptp(body[0], axis=0).max()
    assert size == pytest.approx({"scale": 2.0, "height": 0.55}.get(next(iter(options)), 1.0), rel=0.12)
    # The mesh stays around its joints.
    for scene, vertices in ((one, body), (two, changed)):
        away = np.abs(vertices.mean(axis=1) - scene.positions().mean(axis=1)).max()
        assert away < 0.2 * np.ptp(vertices[0], axis=0).max()


def test_turned_and_scaled_characters_move_alike(own_body: Path) -> None:
    worn = wear(clip_of(person(3, 6)), own_body)
    assert not isinstance(worn.character, bool)
    body = worn.character.move(*poses(worn))
    turned = turn_up(worn, "Y", "Z")
    assert not isinstance(turned.character, bool)
    found = turned.character.move(*poses(turned))
    quarter = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    assert np.abs(found - rotate(quarter, body)).max() < 1e-9


def test_refusals_say_why(own_body: Path, shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "walk.bvh"
    source.write_bytes(person(3, 6))
    chain = tmp_path / "chain.glb"
    chain.write_bytes(tube(9).data())
    with pytest.raises(ConversionError, match="joints of the clip are known in the character, which has 9"):
        mcml.convert(source, tmp_path / "a.glb", character=chain)
    with pytest.raises(UnsupportedError, match="has no skinned mesh"):
        mcml.convert(source, tmp_path / "a.glb", character=shared / "glb" / "BoxAnimated_no_skin.gltf")
    with pytest.raises(UnsupportedError, match="has no skinned mesh"):
        mcml.convert(source, tmp_path / "a.glb", character=source)
    with pytest.raises(UnsupportedError, match="BVH holds no body with a skin"):
        mcml.convert(source, tmp_path / "a.bvh", character=own_body)
    with pytest.raises(UnsupportedError, match="cannot be read"):
        mcml.convert(source, tmp_path / "a.glb", character="nothing.glb")
    monkeypatch.setattr(move_character, "MOST_POSES", 100)
    with pytest.raises(LimitError, match="is moved through at most"):
        mcml.convert(source, tmp_path / "a.glb", character=own_body)
    with pytest.raises(RequestError, match="'mine' is no character"):
        check_own("mine")


def test_usd_holds_it_too(own_body: Path, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    source = tmp_path / "walk.bvh"
    source.write_bytes(person(3, 4))
    (path,) = mcml.convert(source, tmp_path / "walk.usda", character=own_body)
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Clip/Body"))
    count = len(mesh.GetPointsAttr().Get())
    assert count > 1500
    assert len(mesh.GetDisplayColorPrimvar().Get()) == count
