"""Meshes of FBX files: vertices are where ufbx's own skinning puts them in all frames."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import FormatError, LimitError, McmlError
from mcml.formats import colours
from mcml.formats.fbx import meshes
from mcml.formats.fbx.format import Fbx
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.characters.rigged import RiggedCharacter
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of
from tests.formats.readers import fbx_skinning
from tests.formats.readers.fbx_text import Skin, fbx_text
from tests.formats.readers.posing import read_clip, spoil

REAL = (
    "arnaud_rig_7500.fbx", "blender_279_sausage_6100_ascii.fbx",
    "blender_279_sausage_7400_binary.fbx", "huesitos_25fps_7400.fbx", "max7_skin_5000_binary.fbx",
    "maya_transformed_skin_6100_ascii.fbx", "maya_transformed_skin_7700_binary.fbx",
)  # fmt: skip
FRAMES = 20


def source(data: bytes) -> dict[str, SourceFile]:
    return {"fbx": SourceFile("body.fbx", io.BytesIO(data))}


def read(data: bytes) -> RiggedCharacter:
    found = Fbx().read_character(source(data), ReadOptions())
    assert found is not None
    return found


def expected_triangles(data: bytes, frames: int) -> Array:
    """(n, T, 3, 3) the corners of the triangles in the world, by ufbx."""
    command = [sys.executable, fbx_skinning.__file__, str(frames)]
    told = json.loads(subprocess.run(command, input=data, capture_output=True, check=True).stdout)
    fans = [(face[0], face[at], face[at + 1]) for face in told["faces"] for at in range(1, len(face) - 1)]
    return np.array(told["places"])[:, fans]


def found_triangles(data: bytes, frames: int) -> Array:
    take = Fbx().takes(source(data), ReadOptions())[0]
    clip = read_clip("fbx", data, take=take)
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    poses = [walker.poses(block) for block in clip.blocks()]
    positions, rotations = (np.concatenate([pose[part] for pose in poses])[:frames] for part in (0, 1))
    made = read(data).character
    return made.move(positions, rotations)[:, made.faces]


@pytest.mark.parametrize("name", REAL)
def test_vertices_of_real_files_are_where_ufbx_puts_them(shared: Path, name: str) -> None:
    data = (shared / "fbx" / name).read_bytes()
    found = found_triangles(data, FRAMES)
    expected = expected_triangles(data, len(found))
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() < 2e-6 * size_of(expected)


def test_vertices_with_more_joints_are_near(shared: Path) -> None:
    data = (shared / "fbx" / "armature_7400.fbx").read_bytes()
    assert any("more than four joints" in notice.what for notice in read(data).notices)
    found = found_triangles(data, FRAMES)
    expected = expected_triangles(data, len(found))
    assert np.abs(found - expected).max() < 0.01 * size_of(expected)


def test_joints_that_are_scaled_are_told(shared: Path) -> None:
    data = (shared / "fbx" / "motionbuilder_sausage_rrss_7700_binary.fbx").read_bytes()
    assert np.isfinite(found_triangles(data, FRAMES)).all()
    clip = read_clip("fbx", data, take=Fbx().takes(source(data), ReadOptions())[0])
    list(clip.blocks())
    assert any("the scale of" in notice.what for notice in clip.notices)


def size_of(triangles: Array) -> float:
    return float(np.ptp(triangles[0].reshape(-1, 3), axis=0).max())


PRISM = Skin(
    [(-1, 90, 0), (1, 90, 0), (1, 90, 2), (-1, 90, 2), (-1, 120, 0), (1, 120, 0), (1, 120, 2), (-1, 120, 2)],
    [(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
    [1, 1, 0.75, 0.5, 0, 0.25, 0, 0],
)


@pytest.mark.parametrize("up", [1, 2])
def test_a_skin_of_two_bones(up: int) -> None:
    data = fbx_text(up=up, skin=PRISM)
    found = found_triangles(data, 11)
    assert found.shape == (11, 12, 3, 3)
    expected = expected_triangles(data, 11)
    assert np.abs(found - expected).max() < 1e-9 * size_of(expected)
    character = read(data).character
    assert len(character.points) == 8
    assert np.unique(np.asarray(character.colours), axis=0).tolist() == [[255, 0, 0]]
    a, b, c = (character.points[character.faces[:, corner]] for corner in range(3))
    centre = character.points.mean(axis=0)
    outwards = np.einsum("ti,ti->t", np.cross(b - a, c - a), (a + b + c) / 3 - centre)
    assert (outwards > 0).all()


def test_a_character_without_animation_is_a_clip_of_its_rest_pose() -> None:
    data = fbx_text(takes=(), skin=PRISM)
    clip = read_clip("fbx", data)
    (block,) = clip.blocks()
    assert len(block) == 1
    assert any("no animation" in notice.what for notice in clip.notices)
    assert found_triangles(data, 1).shape == (1, 12, 3, 3)
    with pytest.raises(FormatError, match="no motion"):
        read_clip("fbx", fbx_text(takes=()))


def test_pictures_colour_the_vertices() -> None:
    image = pytest.importorskip("PIL.Image")
    picture, stream = image.new("RGB", (2, 2)), io.BytesIO()
    # The upper left corner is green, the lower right one blue.
    picture.putpixel((0, 0), (0, 255, 0))
    picture.putpixel((1, 1), (0, 0, 255))
    picture.save(stream, "PNG")
    uv = [(0.25, 0.75)] * 4 + [(0.75, 0.25)] * 4
    data = fbx_text(skin=replace(PRISM, uv=uv, picture=stream.getvalue()))
    character = read(data).character
    low = character.points[:, 1] < 100
    assert np.unique(np.asarray(character.colours)[low], axis=0).tolist() == [[0, 255, 0]]
    assert np.unique(np.asarray(character.colours)[~low], axis=0).tolist() == [[0, 0, 255]]
    found = read(fbx_text(skin=replace(PRISM, uv=uv, picture=b"no picture")))
    assert [notice.what for notice in found.notices] == ["textures are left out: they are damaged"]


def test_pictures_are_bounded_together(monkeypatch: pytest.MonkeyPatch) -> None:
    image = pytest.importorskip("PIL.Image")
    stream = io.BytesIO()
    image.new("RGB", (10, 10)).save(stream, "PNG")
    monkeypatch.setattr(colours, "MOST_PIXELS", 250)
    pictures = colours.Pictures()
    found = [pictures.read(stream.getvalue()) for _ in range(3)]
    assert [picture is not None for picture in found] == [True, True, False]
    assert pictures.left_out == {"they are too large"}


def test_files_without_a_skin_have_no_character(shared: Path) -> None:
    assert Fbx().read_character(source(fbx_text()), ReadOptions()) is None
    data = (shared / "fbx" / "jog_max_biped_7400.fbx").read_bytes()
    assert Fbx().read_character(source(data), ReadOptions()) is None


def test_vertices_are_counted_without_reading_files_that_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Fbx().count_vertices(io.BytesIO(fbx_text(skin=PRISM))) == 8
    assert Fbx().count_vertices(io.BytesIO(fbx_text(skin=PRISM)[:4000])) == 0
    monkeypatch.setattr(meshes, "_run", lambda *_, **__: pytest.fail("a program was started"))
    assert Fbx().count_vertices(io.BytesIO(fbx_text())) == 0


def test_large_meshes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshes, "MOST_VERTICES", 7)
    with pytest.raises(LimitError, match="8 vertices, the limit is 7"):
        read(fbx_text(skin=PRISM))
    monkeypatch.undo()
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 11)
    with pytest.raises(LimitError, match="12 triangles, the limit is 11"):
        read(fbx_text(skin=PRISM))


@pytest.mark.slow
def test_damaged_files_are_refused_or_read(shared: Path) -> None:
    whole = (shared / "fbx" / "maya_transformed_skin_7700_binary.fbx").read_bytes()
    refused = 0
    chance = np.random.default_rng(11)
    for _ in range(60):
        try:
            Fbx().read_character(source(spoil(whole, chance)), ReadOptions())
        except McmlError:
            refused += 1
    assert refused > 5
