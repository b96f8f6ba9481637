"""glTF files: our own and made ones, against SciPy; damaged ones are refused."""

from __future__ import annotations

import base64
import io
import json
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation, Slerp

from mcml.errors import FormatError, LimitError, McmlError, UnsupportedError
from mcml.files.gather_files import gathered
from mcml.files.limits import FileLimits
from mcml.formats import READERS, WRITERS, find_format
from mcml.formats.format import SourceFile
from mcml.formats.gltf import document
from mcml.formats.gltf.tracks import Track, find_rate, frame_times
from mcml.motion.skeleton import Array
from mcml.testing import frames
from tests.formats.readers.posing import places_of, read_clip, reads_or_refuses, spoil
from tests.formats.scenes.clips import timed
from tests.motion.bodies.made import clip_of, person

READER = READERS["glb"]


def gltf(model: dict[str, object], binary: bytes, *, form: str = "glb") -> bytes:
    """A file of a model and its numbers: "glb", "data" (text with the numbers in it) or "text"."""
    model = {"asset": {"version": "2.0"}, **model}
    buffer: dict[str, object] = {"byteLength": len(binary)}
    if form == "data":
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    elif form == "text":
        buffer["uri"] = "folder/numbers%20one.bin"
    text = json.dumps({**model, "buffers": [buffer]}).encode()
    if form != "glb":
        return text
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def model_of(tracks: list[tuple[int, str, str, Array, Array]]) -> tuple[dict[str, object], bytes]:
    """Two joints, the second 1 above the first, with tracks (node, path, mode, times, values)."""
    binary, views, accessors, samplers, channels = b"", [], [], [], []
    for number, (node, path, mode, times, values) in enumerate(tracks):
        for numbers, kind in ((times, "SCALAR"), (values, "VEC4" if path == "rotation" else "VEC3")):
            data = np.asarray(numbers, "<f4").tobytes()
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
            accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(data) // 4 // {"SCALAR": 1, "VEC4": 4, "VEC3": 3}[kind], "type": kind})  # fmt: skip  # noqa: E501
            binary += data
        samplers.append({"input": 2 * number, "output": 2 * number + 1, "interpolation": mode})
        channels.append({"sampler": number, "target": {"node": node, "path": path}})
    model: dict[str, object] = {
        "nodes": [
            {"name": "Armature", "scale": [2, 2, 2], "children": [1]},
            {"name": "Hips", "children": [2]},
            {"name": "Spine", "translation": [0, 1, 0]},
        ],
        "skins": [{"joints": [2, 1]}],
        "animations": [{"name": "Walk", "samplers": samplers, "channels": channels}],
        "bufferViews": views,
        "accessors": accessors,
    }
    return model, binary


TIMES = np.arange(13) / 24
TURNS = Rotation.from_rotvec(np.column_stack([np.sin(TIMES * 9), TIMES, np.cos(TIMES * 7)]))


def test_linear_rotations_and_translations_are_those_of_scipy() -> None:
    keys = TIMES[::3]
    moved = np.column_stack([keys, keys**2, -keys])
    model, binary = model_of(
        [(1, "rotation", "LINEAR", keys, TURNS[::3].as_quat()), (1, "translation", "LINEAR", keys, moved)]
    )
    clip = read_clip("glb", gltf(model, binary), rate=24)
    between = Slerp(keys, TURNS[::3])(TIMES)
    root = 2 * np.column_stack([np.interp(TIMES, keys, moved[:, axis]) for axis in range(3)])
    places = places_of(clip)
    assert clip.head.skeleton.names == ("Hips", "Spine")
    assert np.abs(places[:, 0] - root).max() < 1e-6
    assert np.abs(places[:, 1] - (root + between.apply([0, 2, 0]))).max() < 1e-6


def test_splines_are_those_of_scipy_and_steps_stay() -> None:
    keys = np.array([0.0, 0.25, 0.5])
    values, tangents = (
        np.array([[0, 0, 0], [1, 2, 3], [0, 1, 0]], float),
        np.array([[3, 0, 1], [-2, 5, 0], [1, 1, 1]], float),
    )
    spline = np.stack([tangents, values, tangents], axis=1).reshape(-1, 3)
    model, binary = model_of(
        [(1, "translation", "CUBICSPLINE", keys, spline), (2, "translation", "STEP", keys, values)]
    )
    clip = read_clip("glb", gltf(model, binary), rate=24)
    places = places_of(clip)
    assert np.abs(places[:, 0] - 2 * CubicHermiteSpline(keys, values, tangents)(TIMES)).max() < 1e-5
    step = values[np.searchsorted(keys, TIMES + 1e-9, "right") - 1]
    assert np.abs(places[:, 1] - places[:, 0] - 2 * step).max() < 1e-5


@pytest.mark.parametrize("form", ["glb", "data"])
def test_forms_hold_the_same(form: str) -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    data = gltf(model, binary, form=form)
    assert find_format("a.gltf", data[:4096]) == (READER, "glb")
    assert frames(read_clip("glb", data)) == frames(read_clip("glb", gltf(model, binary)))


def test_numbers_in_a_file_of_their_own_come_with_it() -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    text = gltf(model, binary, form="text")
    with pytest.raises(FormatError, match=r"needs 'numbers one\.bin', which was not sent"):
        read_clip("glb", text)
    files = [SourceFile(name, io.BytesIO(data)) for name, data in
             (("a/walk.gltf", text), ("a/folder/numbers one.bin", binary), ("other.bin", b"1"))]  # fmt: skip
    with gathered(files, FileLimits()) as found:
        assert [clip.name for clip in found.clips] == ["a/walk.gltf"]
        assert set(found.clips[0].files) == {"buffer1", "glb"}
        assert [name for name, _ in found.problems] == ["other.bin"]


def test_our_own_files_come_back() -> None:
    clip = timed(clip_of(person(4, 30)))
    data = b"".join(WRITERS["glb"].write(clip, "glb"))
    again = read_clip("glb", data)
    own = [again.head.skeleton.names.index(name) for name in clip.head.skeleton.names]
    expected = places_of(clip)
    found = places_of(again)[:, own]
    # The unit is not stated: a person of this size is in centimetres.
    assert np.abs(found - expected * 0.01).max() < 1e-5 * np.ptp(expected)


def test_rates_are_found_by_the_distances_of_keys() -> None:
    def rate_of(times: Array) -> tuple[float, bool]:
        return find_rate([Track(0, "translation", "LINEAR", times, np.zeros((len(times), 3)))])

    assert rate_of(np.arange(50) / 24) == (24.0, True)
    assert rate_of((np.arange(50) / 29.97).astype(np.float32).astype(float)) == (29.97, True)
    gaps = np.delete(np.arange(100), [7, 8, 30]) / 60
    assert rate_of(gaps) == (60.0, True)
    assert rate_of(np.array([0.0, 0.5])) == (30.0, False)
    assert rate_of(np.array([1.0, 1 + 1 / 60])) == (60.0, True)
    ends = Track(1, "translation", "STEP", np.array([0.0, 1 / 25]), np.zeros((2, 3)))
    others = Track(0, "translation", "LINEAR", np.arange(9) / 60, np.zeros((9, 3)))
    assert find_rate([ends, others]) == (60.0, True)
    assert rate_of(np.cumsum(np.random.default_rng(1).uniform(0.01, 0.09, 50))) == (30.0, False)
    assert rate_of(np.arange(9) / 2) == (30.0, False)


def test_normalised_sparse_and_absent_numbers() -> None:
    turns = np.round(TURNS.as_quat() * 32767).astype("<i2")
    times = np.asarray(TIMES, "<f4").tobytes()
    binary = times + turns.tobytes()
    model, _ = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    model["bufferViews"] = [
        {"buffer": 0, "byteOffset": 0, "byteLength": len(times)},
        {"buffer": 0, "byteOffset": len(times), "byteLength": turns.nbytes},
    ]
    model["accessors"] = [
        {"bufferView": 0, "componentType": 5126, "count": len(TIMES), "type": "SCALAR"},
        {"bufferView": 1, "componentType": 5122, "normalized": True, "count": len(TIMES), "type": "VEC4"},
    ]
    places = places_of(read_clip("glb", gltf(model, binary)))
    assert np.abs(places[:, 1] - TURNS.apply([0, 2, 0])).max() < 1e-3
    zeros = dict(model)
    zeros["accessors"] = [model["accessors"][0], {"componentType": 5126, "count": len(TIMES), "type": "VEC3", "sparse": {  # type: ignore[index]  # noqa: E501
        "count": 1, "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3}}}]  # fmt: skip
    extra = bytes([12, 0, 0, 0]) + np.array([4, 5, 6], "<f4").tobytes()
    zeros["bufferViews"] = [
        *model["bufferViews"],  # type: ignore[misc]
        {"buffer": 0, "byteOffset": len(binary), "byteLength": 1},
        {"buffer": 0, "byteOffset": len(binary) + 4, "byteLength": 12},
    ]
    zeros["animations"] = [{"samplers": [{"input": 0, "output": 1}], "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}]  # fmt: skip  # noqa: E501
    root = places_of(read_clip("glb", gltf(zeros, binary + extra)))[:, 0]
    assert not root[:12].any()
    assert root[12].tolist() == [8, 10, 12]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"nodes": [{"children": [1]}, {"children": [0]}]}, "its own ancestors"),
        ({"nodes": [{"children": [2]}, {"children": [2]}, {}]}, "two parents"),
        ({"nodes": [{"children": [9]}]}, "the child 9"),
        ({"skins": [{"joints": [77]}]}, "names node 77"),
        ({"animations": []}, "a skeleton of 2 joints and no motion"),
        ({"skins": [], "animations": []}, "the glTF file has no skeleton: 3 nodes"),
        ({"accessors": []}, r"no accessors\[0\]"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 4}] * 2}, "ends before its elements"),
        ({"asset": {"version": "1.0"}}, "glTF 1.0 is not read"),
        ({"nodes": 7}, "nodes is no list"),
    ],
)
def test_what_is_wrong_is_told(change: dict[str, object], message: str) -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    with pytest.raises((FormatError, UnsupportedError), match=message):
        read_clip("glb", gltf({**model, **change}, binary))


def test_long_text_is_refused_before_it_is_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(document, "MOST_TEXT", 1000)
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    with pytest.raises(LimitError, match="the JSON of the glTF file"):
        read_clip("glb", gltf(model, binary, form="data"))


def test_compressed_animations_are_refused_by_name() -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    for view in model["bufferViews"]:  # type: ignore[attr-defined]
        view["extensions"] = {"EXT_meshopt_compression": {}}
    with pytest.raises(UnsupportedError, match="EXT_meshopt_compression"):
        read_clip("glb", gltf(model, binary))


def test_a_humanoid_names_its_bones() -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    for node in model["nodes"]:  # type: ignore[attr-defined]
        node.pop("name")
    human = {"humanoid": {"humanBones": {"hips": {"node": 1}, "spine": {"node": 2}}}}
    model |= {"skins": [], "extensions": {"VRMC_vrm_animation": human}}
    assert read_clip("glb", gltf(model, binary)).head.skeleton.names == ("hips", "spine")


def test_any_byte_may_be_wrong() -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    data = gltf(model, binary)
    chance = np.random.default_rng(3)
    for _ in range(200):
        reads_or_refuses("glb", spoil(data, chance))
    for end in range(0, len(data), 7):
        with pytest.raises(McmlError):
            read_clip("glb", data[:end])


@settings(deadline=None)
@given(
    st.sampled_from([23.976, 24.0, 29.97, 30.0, 59.94, 60.0, 119.88, 120.0]) | st.floats(10.5, 500),
    st.integers(2, 20000),
    st.floats(0, 100),
    st.sampled_from([1.0, 2e-6, -2e-6]),
)
def test_frames_are_the_keys_at_any_rate(rate: float, count: int, start: float, wrong: float) -> None:
    """59.94 is not read as 60: over a long clip frames would lie between keys. Writers round their frame times."""
    step = (1 + (wrong if abs(wrong) < 1 else 0)) / rate
    times = (start + np.arange(count) * step).astype(np.float32).astype(float)
    track = Track(0, "weights", "LINEAR", times, np.arange(count, dtype=float)[:, None])
    found, shown = find_rate([track])
    assert shown
    # Two keys at 100 s have their distance within 1e-5 s.
    assert found == pytest.approx(rate, rel=1e-2 / count + 3e-6 + 2e-5 * rate / (count - 1))
    frames = frame_times([track], found, shown)
    np.testing.assert_array_equal(track.sample(frames)[:, 0], np.arange(count))


def test_the_last_frame_of_a_long_clip_is_there() -> None:
    """A frame time of 0.0083333 is read as 120 Hz, and 993 of them end before the 993rd frame at that rate."""
    times = (np.arange(994) * 0.0083333).astype(np.float32).astype(float)
    track = Track(0, "rotation", "LINEAR", times, np.tile([0.0, 0.0, 0.0, 1.0], (994, 1)))
    rate, shown = find_rate([track])
    assert rate == 120
    assert len(frame_times([track], rate, shown)) == 994
