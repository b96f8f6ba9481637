"""Weights of blend shapes in written glTF: another reader finds them by their names, and so does this one."""

from __future__ import annotations

import struct
from dataclasses import replace
from typing import Any

import numpy as np
import pygltflib
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml.files.targets import convert_clip
from mcml.formats import WRITERS
from mcml.formats.scenes import glb
from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.frames import joined
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from tests.formats.readers.posing import read_clip
from tests.formats.readers.test_blend_weights import weights_of
from tests.motion.bodies.made import clip_of, person


def with_shapes(clip: ClipStream, names: list[str], weights: Array) -> ClipStream:
    """A clip with blend shapes at its last joint. weights: (n, S)."""
    skeleton, block = clip.head.skeleton, joined(clip.blocks())
    below = len(skeleton) - 1
    shapes = tuple(
        Joint(name, below, name, Convention.BLEND_SHAPE, channels=("weight",), mapped=False) for name in names
    )
    wider = Skeleton((*skeleton.joints, *shapes))
    columns = wider.columns()
    order = {column: place for place, column in enumerate(columns)}
    values = np.full((len(block), len(columns)), np.nan)
    values[:, [order[column] for column in block.columns]] = block.values
    values[:, [order[column] for column in columns if column not in block.columns]] = weights
    made = FrameBlock(values, columns, (full_shape(columns),), block.ids, None, block.motion_names)
    return replace(clip, head=replace(clip.head, skeleton=wider), blocks=lambda: iter([made]), notices=[])


def written(clip: ClipStream) -> bytes:
    return b"".join(WRITERS["glb"].write(convert_clip(clip, "glb"), "glb"))


def read_track(data: bytes) -> tuple[list[str], Array]:
    """Names and weights (n, S) as pygltflib reads them."""
    model = pygltflib.GLTF2.load_from_bytes(data)
    (node,) = (number for number, one in enumerate(model.nodes) if one.name == "blend shapes")
    mesh = model.meshes[model.nodes[node].mesh]
    animation = model.animations[0]
    (channel,) = (one for one in animation.channels if one.target.path == "weights")
    assert channel.target.node == node
    accessor = model.accessors[animation.samplers[channel.sampler].output]
    view = model.bufferViews[accessor.bufferView]
    start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
    numbers = struct.unpack_from(f"<{accessor.count}f", model.binary_blob(), start)
    names: list[str] = mesh.extras["targetNames"]
    assert len(mesh.primitives[0].targets) == len(mesh.weights) == len(names)
    return names, np.array(numbers).reshape(-1, len(names))


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 30), st.integers(1, 4), st.integers(0, 999))
def test_weights_are_found_again(frames: int, shapes: int, seed: int) -> None:
    weights = np.random.default_rng(seed).uniform(-0.5, 1.5, (frames, shapes)).astype(np.float32)
    names = [f"shape {number}" for number in range(shapes)]
    clip = with_shapes(clip_of(person(2, frames)), names, weights)
    data = written(clip)
    told, found = read_track(data)
    assert told == names
    np.testing.assert_array_equal(found, weights)
    if frames > 1:
        again = weights_of(read_clip("glb", data))
        np.testing.assert_array_equal(np.column_stack([again[name] for name in names]), weights)


def test_long_clips_are_written_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    weights = np.random.default_rng(3).uniform(0, 1, (50, 3)).astype(np.float32)
    clip = with_shapes(clip_of(person(2, 50)), ["a", "b", "c"], weights)
    whole = written(clip)
    monkeypatch.setattr(glb, "_AT_ONCE", 200)
    assert written(clip) == whole


def test_missing_weights_are_told() -> None:
    weights = np.array([[0.2], [np.nan], [0.7]])
    clip = with_shapes(clip_of(person(2, 3)), ["smile"], weights)
    made = convert_clip(clip, "glb")
    data = b"".join(WRITERS["glb"].write(made, "glb"))
    np.testing.assert_allclose(read_track(data)[1][:, 0], [0.2, 0.2, 0.7], atol=1e-7)
    assert any("1 weights of blend shapes are missing" in notice.what for notice in made.notices)


def test_faces_without_joints_are_written() -> None:
    skeleton = Skeleton(tuple(
        Joint(name, -1, name, Convention.BLEND_SHAPE, channels=("weight",), mapped=False) for name in ("a", "b")
    ))  # fmt: skip
    weights = np.array([[0.0, 1.0], [0.25, 0.75], [0.5, 0.5]])
    columns = skeleton.columns()
    block = FrameBlock(weights, columns, (full_shape(columns),), np.arange(1, 4))
    head = replace(clip_of(person(2, 1)).head, skeleton=skeleton, frame_time="0.1")
    data = written(ClipStream(head, lambda: iter([block]), 3))
    told, found = read_track(data)
    assert told == ["a", "b"]
    np.testing.assert_array_equal(found, weights)


def test_a_recorded_face_is_written(shared: Any) -> None:
    data = (shared / "arkit" / "alex_rom_3_600.csv").read_bytes()
    clip = read_clip("arkit", data)
    names, found = read_track(written(clip))
    expected = weights_of(clip)
    assert names == list(expected)
    weights = np.column_stack(list(expected.values()))
    there = np.isfinite(weights)
    assert there.mean() > 0.9
    np.testing.assert_allclose(found[there], weights[there], atol=1e-7)
