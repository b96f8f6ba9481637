"""Weights of blend shapes in glTF, FBX and USD: as SciPy, the curves and the samples have them; joints stay."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

from mcml.errors import FormatError
from mcml.formats import FORMATS, WRITERS
from mcml.motion.clip import ClipStream
from mcml.motion.frames import joined
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Array
from mcml.testing import frames
from tests.builders import assign
from tests.formats.readers.fbx_text import fbx_text
from tests.formats.readers.posing import places_of, read_clip
from tests.formats.readers.test_gltf import gltf, model_of

NAMES = ["smile", "jawOpen"]


def weights_of(clip: ClipStream) -> dict[str, Array]:
    """(n,) of each blend shape, by its own name."""
    block, skeleton = joined(clip.blocks()), clip.head.skeleton
    place = {joint: column for column, (joint, _) in enumerate(block.columns)}
    return {skeleton.joints[index].source_name: block.values[:, place[index]] for index in skeleton.blend_shapes}


def with_face(model: dict[str, Any], binary: bytes, tracks: list[tuple[int, str, Array, Array]]) -> bytes:
    """A file of a model with a mesh of two targets at node 3, below Hips. tracks: animation, mode, times, values."""
    model["nodes"] = [*model["nodes"], {"name": "Face", "mesh": 0}]
    model["nodes"][1] = {"name": "Hips", "children": [2, 3]}
    model["meshes"] = [
        {
            "name": "Head",
            "primitives": [{"attributes": {}, "targets": [{}, {}]}],
            "weights": [0.25, 0.5],
            "extras": {"targetNames": NAMES},
        }
    ]
    for animation, mode, times, values in tracks:
        accessors = []
        for numbers in (times, values):
            data = np.asarray(numbers, "<f4").tobytes()
            model["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
            view = len(model["bufferViews"]) - 1
            accessor = {"bufferView": view, "componentType": 5126, "count": len(data) // 4, "type": "SCALAR"}
            model["accessors"].append(accessor)
            accessors.append(len(model["accessors"]) - 1)
            binary += data
        one = model["animations"][animation]
        one["samplers"].append({"input": accessors[0], "output": accessors[1], "interpolation": mode})
        one["channels"].append({"sampler": len(one["samplers"]) - 1, "target": {"node": 3, "path": "weights"}})
    return gltf(model, binary)


TIMES = np.arange(13) / 24
TRAVEL = (1, "translation", "LINEAR", TIMES, np.column_stack([TIMES, TIMES**2, -TIMES]))


@settings(deadline=None, max_examples=30)
@given(st.sampled_from(["LINEAR", "STEP", "CUBICSPLINE"]), st.integers(2, 6), st.integers(0, 10**6))
def test_gltf_weights_are_those_of_scipy(mode: str, keys: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.sort(rng.choice(np.arange(1, 12), keys, replace=False)).astype(np.float32).astype(float) / 24
    times = np.concatenate([[0.0], times])
    values = rng.uniform(0, 1, (len(times), 3 if mode == "CUBICSPLINE" else 1, 2)).astype(np.float32).astype(float)
    clip = read_clip("glb", with_face(*model_of([TRAVEL]), [(0, mode, times, values)]))
    found = np.column_stack([weights_of(clip)[name] for name in NAMES])
    at = np.clip(np.arange(13) / 24, times[0], times[-1])
    stored = times.astype(np.float32).astype(float)
    if mode == "CUBICSPLINE":
        slopes = [values[:, 2], values[:, 0]]
        expected = np.array([_hermite(stored, values[:, 1], *slopes, time) for time in at])
    elif mode == "LINEAR":
        expected = np.column_stack([np.interp(at, stored, values[:, 0, shape]) for shape in range(2)])
    else:
        expected = values[np.clip(np.searchsorted(stored, at + 1e-6, "right") - 1, 0, len(times) - 1), 0]
    np.testing.assert_allclose(found, expected, atol=2e-5)


def _hermite(times: Array, values: Array, out: Array, into: Array, at: float) -> Array:
    """Between two keys by SciPy, whose splines have one slope at a key: so each stretch is a spline of its own."""
    left = min(int(np.searchsorted(times, at, "right")) - 1, len(times) - 2)
    ends = [left, left + 1]
    one = CubicHermiteSpline(times[ends], values[ends], np.stack([out[left], into[left + 1]]))
    result: Array = one(at)
    return result


def test_joints_are_the_same_with_a_face_and_without() -> None:
    bare = read_clip("glb", gltf(*model_of([TRAVEL])))
    values = np.linspace(0, 1, 26).reshape(13, 2)
    clip = read_clip("glb", with_face(*model_of([TRAVEL]), [(0, "LINEAR", TIMES, values)]))
    np.testing.assert_array_equal(places_of(clip)[:, : len(bare.head.skeleton)], places_of(bare))
    assert clip.head.skeleton.names[: len(bare.head.skeleton)] == bare.head.skeleton.names
    np.testing.assert_allclose(weights_of(clip)["jawOpen"], values[:, 1], atol=1e-6)


def test_a_face_that_no_animation_moves_is_left_as_it_was() -> None:
    clip = read_clip("glb", with_face(*model_of([TRAVEL]), []))
    assert clip.head.skeleton.blend_shapes == ()


def test_a_face_alone_is_a_clip() -> None:
    model, binary = model_of([])
    del model["skins"]
    clip = read_clip("glb", with_face(model, binary, [(0, "LINEAR", TIMES, np.linspace(0, 1, 26))]))
    assert [joint.source_name for joint in clip.head.skeleton.joints][-2:] == NAMES
    assert any("has no skeleton" in notice.what for notice in clip.notices)


def test_unnamed_targets_are_called_after_their_mesh() -> None:
    model, binary = model_of([TRAVEL])
    content = with_face(model, binary, [(0, "LINEAR", TIMES, np.linspace(0, 1, 26))])
    clip = read_clip("glb", content.replace(b'"targetNames"', b'"othersNames"'))
    assert list(weights_of(clip)) == ["Head_target_0", "Head_target_1"]


def test_weights_that_do_not_fit_are_refused() -> None:
    content = with_face(*model_of([TRAVEL]), [(0, "LINEAR", TIMES, np.linspace(0, 1, 24))])
    with pytest.raises(FormatError, match="weights of node 3 has 13 keys and 12 values"):
        read_clip("glb", content)


@pytest.mark.parametrize("takes", [("One",), ("One", "Two")])
def test_fbx_weights_are_those_of_the_curves(takes: tuple[str, ...]) -> None:
    pytest.importorskip("ufbx")
    percents = {"smile": [10.0 * frame for frame in range(11)], "still": [50.0] * 11, "jawOpen": [100.0, *[0.0] * 10]}
    for take in takes:
        clip = read_clip("fbx", fbx_text(takes, shapes=percents), take=take)
        bare = read_clip("fbx", fbx_text(takes), take=take)
        found = weights_of(clip)
        assert list(found) == ["smile", "jawOpen"], "a shape that never changes moves nothing"
        for name, values in found.items():
            np.testing.assert_allclose(values, np.array(percents[name]) / 100, atol=1e-6)
        np.testing.assert_array_equal(places_of(clip)[:, :2], places_of(bare))


def test_no_memory_of_an_fbx_scene_is_used_after_its_release(monkeypatch: pytest.MonkeyPatch) -> None:
    """The debug allocator overwrites released memory, in the program that reads the file too."""
    pytest.importorskip("ufbx")
    monkeypatch.setenv("PYTHONMALLOC", "debug")
    clip = read_clip(
        "fbx", fbx_text(("One", "Two"), shapes={"smile": [10.0 * frame for frame in range(11)]}), take="Two"
    )
    np.testing.assert_allclose(weights_of(clip)["smile"], np.linspace(0, 1, 11), atol=1e-6)


USD = """#usda 1.0
(
    timeCodesPerSecond = 24
    metersPerUnit = 1
    upAxis = "Y"
)
def SkelRoot "Model" ( prepend apiSchemas = ["SkelBindingAPI"] )
{
    def Skeleton "Skel" ( prepend apiSchemas = ["SkelBindingAPI"] )
    {
        uniform token[] joints = ["A", "A/B"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,2,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,2,1))]
        rel skel:animationSource = </Model/Skel/Anim>
        def SkelAnimation "Anim"
        {
            uniform token[] joints = ["A/B"]
            float3[] translations = [(0, 0, 2)]
            quatf[] rotations.timeSamples = { 1: [(1, 0, 0, 0)], 5: [(0.70710678, 0.70710678, 0, 0)] }
            half3[] scales = [(1, 1, 1)]
            uniform token[] blendShapes = ["smile", "jawOpen"]
            float[] blendShapeWeights.timeSamples = { 1: [0, 1], 9: [0.8, 0.5] }
        }
    }
}
"""


def test_usd_weights_are_those_of_the_samples() -> None:
    pytest.importorskip("pxr")
    clip = read_clip("usd", USD.encode())
    found = weights_of(clip)
    np.testing.assert_allclose(found["smile"], np.linspace(0, 0.8, 9), atol=1e-6)
    np.testing.assert_allclose(found["jawOpen"], np.linspace(1, 0.5, 9), atol=1e-6)


def test_a_usd_face_without_joints_is_a_clip() -> None:
    pytest.importorskip("pxr")
    bare = re.sub(r"uniform matrix4d\[\] (bind|rest)Transforms = \[.*?\)\)\]\n", "", USD, flags=re.DOTALL)
    bare = re.sub(r"(float3|quatf|half3)\[\] .*\n", "", re.sub(r"uniform token\[\] joints = .*\n", "", bare))
    clip = read_clip("usd", bare.encode())
    np.testing.assert_allclose(weights_of(clip)["smile"], np.linspace(0, 0.8, 9), atol=1e-6)
    assert [joint.name for joint in clip.head.skeleton.joints] == ["Skel", "smile", "jawOpen"]
    assert any("no skeleton" in notice.what for notice in clip.notices)
    with pytest.raises(FormatError, match="no skeleton"):
        read_clip("usd", re.sub(r"float\[\] blendShapeWeights.*\n", "", bare).encode())


def test_an_fbx_face_without_bones_is_a_clip() -> None:
    pytest.importorskip("ufbx")
    percents = {"jawOpen": [10.0 * frame for frame in range(11)]}
    clip = read_clip("fbx", fbx_text(shapes=percents).replace(b"LimbNode", b"Null"))
    np.testing.assert_allclose(weights_of(clip)["jawOpen"], np.linspace(0, 1, 11), atol=1e-6)
    assert any("no skeleton" in notice.what for notice in clip.notices)
    with pytest.raises(FormatError, match="no blend shape moves"):
        frames(read_clip("fbx", fbx_text(shapes={"jawOpen": [10.0] * 11}).replace(b"LimbNode", b"Null")))


def test_formats_of_joints_leave_them_out_and_say_so() -> None:
    clip = read_clip("glb", with_face(*model_of([TRAVEL]), [(0, "LINEAR", TIMES, np.linspace(0, 1, 26))]))
    from mcml.files.targets import convert_clip

    made = convert_clip(clip, "bvh")
    content = b"".join(FORMATS["bvh"].write(made, "bvh"))
    assert b"smile" not in content
    assert any("blend shapes" in notice.what for notice in made.notices)
    again = read_clip("glb", b"".join(WRITERS["glb"].write(convert_clip(clip, "glb"), "glb")))
    before, after = weights_of(clip), weights_of(again)
    assert list(after) == list(before) == NAMES
    for name, weights in before.items():
        np.testing.assert_allclose(after[name], weights, atol=1e-5)


def test_retargeting_keeps_weights_of_the_same_name_and_rests_others() -> None:
    one = read_clip("glb", with_face(*model_of([TRAVEL]), [(0, "LINEAR", TIMES, np.linspace(0.1, 1, 26))]))
    skeleton = assign(one.head.skeleton)
    block = joined(one.blocks())
    made = retarget(skeleton, block, skeleton, suggest_matches(skeleton, skeleton), 1 / 24)
    place = {joint: column for column, (joint, _) in enumerate(made.block.columns)}
    own = {joint: column for column, (joint, _) in enumerate(block.columns)}
    for index in skeleton.blend_shapes:
        np.testing.assert_allclose(made.block.values[:, place[index]], block.values[:, own[index]])
    bare = assign(read_clip("glb", gltf(*model_of([TRAVEL]))).head.skeleton)
    rested = retarget(bare, joined(read_clip("glb", gltf(*model_of([TRAVEL]))).blocks()), skeleton,
                      suggest_matches(bare, skeleton), 1 / 24)  # fmt: skip
    assert not rested.block.values[:, [place[index] for index in skeleton.blend_shapes]].any()
