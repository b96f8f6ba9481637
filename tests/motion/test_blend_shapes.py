"""Blend shapes: weights without a place, through kinematics, edits and conversions."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest

from mcml.errors import ConversionError
from mcml.files.targets import convert_clip
from mcml.formats import WRITERS
from mcml.language.joint_names import named
from mcml.language.reader import read_document
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.blend_shapes import without_blend_shapes
from mcml.motion.conventions.convert import convert
from mcml.motion.edits.mirroring import mirrored
from mcml.motion.edits.resampling import resampled
from mcml.motion.edits.smoothing import smoothed
from mcml.motion.frames import in_columns, joined
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import CHANNEL_INDEX, Convention
from mcml.motion.units import reading_of
from mcml.testing import check_block
from tests.builders import FACE

WEIGHT = CHANNEL_INDEX["weight"]


def face() -> ClipStream:
    return read_document(BytesIO(FACE)).clip


def test_blend_shapes_have_no_position() -> None:
    clip = face()
    positions, _ = Walker(clip.head.skeleton, reading_of(clip.head)).poses(joined(clip.blocks()))
    assert np.isfinite(positions[:, 0]).all()
    assert np.isnan(positions[:, 1:]).all()


def test_many_frames_are_as_few() -> None:
    clip = face()
    block = joined(clip.blocks())
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    rows = np.resize(np.arange(len(block)), 9000)
    shape_of = None if block.shape_of is None else block.shape_of[rows]
    ids = np.arange(9000, dtype=np.int64)
    long = replace(block, values=block.values[rows], ids=ids, shape_of=shape_of, motion_names=None)
    positions, _ = walker.poses(long)
    assert np.isnan(positions[:, 1:]).all()
    assert not np.isnan(positions[:, 0]).any()


def test_weights_are_resampled_in_straight_lines() -> None:
    clip = face()
    block, columns = joined(clip.blocks()), clip.head.skeleton.columns()
    edited = resampled(clip.head.skeleton, block, 1 / 30, 1 / 60, reading_of(clip.head)).block
    jaw = edited.values[:, edited.columns.index((1, WEIGHT))]
    assert columns.index((1, WEIGHT)) > 0
    np.testing.assert_allclose(jaw[:3], [0.25, 0.5, 0.75], rtol=0, atol=1e-15)
    assert np.isnan(jaw[3:6]).all()
    assert jaw[6] == 0.5


def test_weights_are_smoothed_and_not_mixed() -> None:
    clip = face()
    block = joined(clip.blocks())
    edited = smoothed(clip.head.skeleton, block, 1.0, np.ones(len(block)), None, reading_of(clip.head)).block
    for joint in (1, 2):
        column = edited.columns.index((joint, WEIGHT))
        before = block.values[:, block.columns.index((joint, WEIGHT))]
        after = edited.values[:, column]
        assert (np.isnan(after) == np.isnan(before)).all()
        assert np.nanmin(before) <= np.nanmin(after) <= np.nanmax(after) <= np.nanmax(before)
        assert not np.array_equal(after[:2], before[:2])


@pytest.mark.parametrize("name", ["bvh", "htr", "asf-amc", "usd", "c3d"])
def test_formats_without_blend_shapes_leave_them_out_and_say_so(name: str) -> None:
    clip = convert_clip(face(), name)
    assert [joint.name for joint in clip.head.skeleton.joints if joint.name in ("JawOpen", "EyeBlinkLeft")] == []
    for block in clip.blocks():
        check_block(block)
    assert any("2 blend shapes are left out" in notice.what for notice in clip.notices)
    content = b"".join(WRITERS[name].write(clip, WRITERS[name].parts[-1].name))
    assert b"JawOpen" not in content


def test_bvh_has_degrees() -> None:
    clip = convert(face(), Convention.LISTED)
    block = joined(clip.blocks())
    assert clip.head.fields.get("units_angle", "deg").startswith("deg")
    columns = [(0, CHANNEL_INDEX[channel]) for channel in ("Rx", "Ry", "Rz")]
    before = in_columns(joined(face().blocks()), columns)
    np.testing.assert_allclose(in_columns(block, columns)[:2], np.degrees(before)[:2], atol=1e-9)


def test_a_document_of_blend_shapes_alone_is_refused() -> None:
    alone = FACE.replace(b'<root order="Ry Rx Rz" position="0 0 0" name="Head" convention="listed"/>', b"")
    for frame in (b' Rx="0.1" Ry="0.2" Rz="-0.1"', b' Rx="0.3" Ry="0.2" Rz="0"', b"", b' Rx="0.2" Ry="0" Rz="0.1"'):
        alone = alone.replace(b'<frame_bone name="Head"' + frame + b"/>", b"")
    with pytest.raises(ConversionError, match="blend shapes alone"):
        without_blend_shapes(read_document(BytesIO(alone)).clip)


def test_joints_below_a_blend_shape_move_to_the_joint_above() -> None:
    tip = b'<bone convention="listed"><name>Tip</name></bone>'
    nested = FACE.replace(b"</order></bone>\n<bone", b"</order>" + tip + b"</bone>\n<bone")
    clip = without_blend_shapes(read_document(BytesIO(nested)).clip)
    assert [(joint.name, joint.parent) for joint in clip.head.skeleton.joints] == [("Head", -1), ("Tip", 0)]


def test_names_of_blend_shapes_are_no_parts_of_a_body() -> None:
    skeleton, report = named(face().head.skeleton)
    assert [joint.name for joint in skeleton.joints][1:] == ["JawOpen", "EyeBlinkLeft"]
    assert report is not None


def test_weights_are_mirrored_to_the_other_side() -> None:
    text = FACE.replace(b"JawOpen", b"EyeBlinkRight")
    clip = read_document(BytesIO(text)).clip
    block = joined(clip.blocks())
    edited = mirrored(clip.head.skeleton, block, reading=reading_of(clip.head)).block
    left, right = ((joint, WEIGHT) for joint in (2, 1))
    before, after = block.values, edited.values
    np.testing.assert_array_equal(after[:, edited.columns.index(left)], before[:, block.columns.index(right)])
    np.testing.assert_array_equal(after[:, edited.columns.index(right)], before[:, block.columns.index(left)])
