"""USD files, read by the program that evaluates them: our own come back, others by their text."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest

from mcml.errors import FormatError
from mcml.formats import READERS, WRITERS, find_format
from tests.formats.readers.posing import places_of, read_clip, zipped
from tests.formats.scenes.clips import timed
from tests.motion.bodies.made import clip_of, person

pytest.importorskip("pxr")
ARM = b"""#usda 1.0
(
    timeCodesPerSecond = 24
    metersPerUnit = 1
    upAxis = "Z"
)
def SkelRoot "Model" (
    prepend apiSchemas = ["SkelBindingAPI"]
)
{
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 5: (4, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Skeleton "Skel" ( prepend apiSchemas = ["SkelBindingAPI"] )
    {
        uniform token[] joints = ["A", "A/B", "A/B/A"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,2,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,4,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,2,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,2,1))]
        rel skel:animationSource = </Model/Skel/Anim>
        def SkelAnimation "Anim"
        {
            uniform token[] joints = ["A/B"]
            float3[] translations = [(0, 0, 2)]
            quatf[] rotations.timeSamples = { 1: [(1, 0, 0, 0)], 5: [(0.70710678, 0.70710678, 0, 0)] }
            half3[] scales = [(1, 1, 1)]
        }
    }
}
"""


def test_our_own_files_come_back() -> None:
    clip = timed(clip_of(person(4, 12)))
    for name in ("usd", "usda"):
        data = b"".join(WRITERS[name].write(clip, name))
        assert find_format("a", data[:4096]) == (READERS["usd"], "usd")
        again = read_clip("usd", data)
        expected, found = places_of(clip), places_of(again)
        assert len(again.head.skeleton) == len(clip.head.skeleton)
        assert np.abs(found - expected).max() < 1e-5 * np.ptp(expected)


def test_joints_have_their_path_and_follow_what_moves_above() -> None:
    clip = read_clip("usd", ARM)
    assert [joint.source_name for joint in clip.head.skeleton.joints] == ["A", "A/B", "A/B/A"]
    assert clip.head.skeleton.names == ("A", "B", "A#2")
    places = places_of(clip)
    assert np.abs(places[:, 0, 0] - np.arange(5)).max() < 1e-6
    assert places[-1, 2] == pytest.approx([4, -2, 2], abs=1e-5)
    assert clip.head.fields["global_axis_of_gravity"] == "Z"


def test_usdz_is_a_file_and_a_zip_of_layers_is_an_archive() -> None:
    packed = zipped({"arm.usda": ARM}, zipfile.ZIP_STORED)
    assert find_format("a.usdz", packed[:4096]) == (READERS["usd"], "usd")
    assert READERS["usd"].sniff("a.zip", zipped({"arm.usda": ARM})[:4096]) is None


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (ARM.replace(b"def Skeleton", b"def Scope"), "no skeleton"),
        (ARM[:400], "damaged or cut off"),
        (ARM.replace(b'"Model" (', b'"Model" (\n    references = @other.usda@'), "other files are not opened"),
        (b"PXR-USDC" + bytes(100), "damaged"),
    ],
)  # fmt: skip
def test_what_is_no_motion_is_refused(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_clip("usd", data)
