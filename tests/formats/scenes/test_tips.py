"""Ends of bones without a joint there, such as BVH's end sites, leave in glTF and USD and come back."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest

from mcml.files.targets import convert_clip
from mcml.formats import WRITERS
from mcml.motion.clip import ClipStream
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of
from mcml.testing import frames
from tests.formats.readers.posing import read_clip
from tests.formats.scenes.clips import CLIPS, STATED, stated

BODIES = ("bvh", "asf", "htr", "a leg", "chain", "one frame", "listed 1", "fixed 2", "base 3", "listed 4", "base 5")


def write(clip: ClipStream, form: str) -> bytes:
    return b"".join(WRITERS[form].write(convert_clip(clip, form), WRITERS[form].parts[0].name))


def distances(clip: ClipStream) -> Array:
    """(n, J + T, J) between joints, and between tips and joints, in the order of the names of joints.

    Tips of a joint in their order. Units and axes of files differ, distances only by a factor.
    """
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    walker = Walker(skeleton, reading)
    parts = [walker.poses_with_tips(block) for block in clip.blocks()]
    places, tips = (np.concatenate([part[number] for part in parts]) for number in (0, 2))
    names = [joint.own_name for joint in skeleton.joints]
    order = sorted(range(len(names)), key=lambda joint: names[joint])
    owners = [owner for owner, _ in rest_of(skeleton, reading).tips]
    by_name = sorted(range(len(owners)), key=lambda tip: (names[owners[tip]], tip))
    points = np.concatenate([places[:, order], tips[:, by_name]], axis=1)
    return np.linalg.norm(points[:, :, None] - places[:, None, order], axis=-1)


@pytest.mark.parametrize("form", ["glb", "usd"])
@pytest.mark.parametrize("title", [*BODIES, *(f"stated {title}" for title in STATED)])
def test_tips_come_back(title: str, form: str) -> None:
    clip = CLIPS[title]() if title in CLIPS else stated(title.removeprefix("stated "))[0]
    before, after = distances(clip), distances(read_clip(form, write(clip, form)))
    assert after.shape == before.shape
    assert before.shape[1] > before.shape[2], "there are tips"
    size = before[0].max()
    factor = after[0].max() / size
    np.testing.assert_allclose(after / factor, before, atol=2e-6 * size)


def change(content: bytes, tips: object) -> bytes:
    """The GLB with these tips at every joint."""
    size = struct.unpack("<I", content[12:16])[0]
    model = json.loads(content[20 : 20 + size])
    for node in model["nodes"]:
        node["extras"] = tips
    text = json.dumps(model).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + size :]
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


@pytest.mark.parametrize(
    ("extras", "wanted"),
    [
        ({"mcml_tips": [[1, 2, 3]]}, 1),
        ({"mcml_tips": [[1, 2], [1, 2, "3"], [1, 2, 3, 4], 5, [0, 0, 1e999]]}, 0),
        ({"mcml_tips": [[0, 1, 0]] * 1000}, 64),
        ({"mcml_tips": "[[1, 2, 3]]"}, 0),
        ({"mcml_tips": {}}, 0),
        (["mcml_tips"], 0),
        (3, 0),
    ],
)
def test_extras_that_are_no_tips_are_left_out(extras: object, wanted: int) -> None:
    clip = read_clip("glb", change(write(CLIPS["chain"](), "glb"), extras))
    frames(clip)
    assert [len(joint.end_sites) for joint in clip.head.skeleton.joints] == [wanted] * 3


@pytest.mark.parametrize("text", ["", "[", "[" * 100_000, "3", '[[0, [1, 2]], ["0", [1, 2, 3]], [9, [1, 2, 3]]]'])
def test_custom_data_that_is_no_tips_is_left_out(text: str) -> None:
    content = write(CLIPS["chain"](), "usda").decode()
    start = content.index('mcml_tips = "') + len('mcml_tips = "')
    escaped = text.replace('"', '\\"')
    clip = read_clip("usd", f"{content[:start]}{escaped}{content[content.index(chr(34) + chr(10), start) :]}".encode())
    frames(clip)
    assert not any(joint.end_sites for joint in clip.head.skeleton.joints)
