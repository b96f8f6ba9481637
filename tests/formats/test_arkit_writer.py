"""ARKit CSV as it is written: the table that was read, and blend shapes of other formats."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import ConversionError
from mcml.files.targets import convert_clip
from mcml.formats import WRITERS
from mcml.formats.arkit.names import SHAPES, shape_of
from mcml.formats.arkit.timecodes import RATES
from mcml.language.reader import read_document
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.frames import joined
from mcml.motion.skeleton import Convention, Joint, Skeleton
from tests.builders import FACE
from tests.formats.readers.posing import read_clip
from tests.formats.readers.test_arkit import ANGLES, table


def write(clip: ClipStream) -> bytes:
    return b"".join(WRITERS["arkit"].write(convert_clip(clip, "arkit"), "csv"))


def rows_of(data: bytes) -> list[list[str]]:
    """The cells as Python's own reader of CSV finds them."""
    return list(csv.reader(io.StringIO(data.decode())))


def face(names: tuple[str, ...], values: np.ndarray, rate: float = 30, start: str = "13:00:00:30.000") -> ClipStream:
    """A clip of blend shapes alone. values: (n, names)."""
    joints = (Joint(f"shape{index}", -1, name, Convention.BLEND_SHAPE, ("weight",)) for index, name in enumerate(names))
    skeleton = Skeleton(tuple(joints))
    properties = (("timecode", start, ""),) if start else ()
    head = ClipHead("glb", skeleton, {"dataframe_rate": repr(rate)}, properties=properties)
    columns = skeleton.columns()
    block = FrameBlock(values, columns, (full_shape(columns),), np.arange(1, len(values) + 1))
    return ClipStream(head, lambda: iter([block]), len(values))


@pytest.mark.parametrize("dropped", [(), (3, 4), (17,)])
def test_a_table_is_written_as_it_was_read(dropped: tuple[int, ...]) -> None:
    data = table(40, names=(*SHAPES, *ANGLES), dropped=dropped)
    assert write(read_clip("arkit", data)) == data + b"\n"


@given(order=st.permutations(SHAPES), cells=st.lists(st.floats(-2, 2), min_size=52, max_size=52))
def test_any_order_and_any_numbers_come_back(order: list[str], cells: list[float]) -> None:
    lines = ["Timecode,BlendShapeCount," + ",".join(order)]
    lines += [f"10:00:0{row}:30.000,52," + ",".join(map(repr, cells)) for row in range(2)]
    data = "\n".join(lines).encode()
    clip, again = read_clip("arkit", data), read_clip("arkit", write(read_clip("arkit", data)))
    assert again.head.skeleton == clip.head.skeleton
    np.testing.assert_array_equal(joined(again.blocks()).values, joined(clip.blocks()).values)


@pytest.mark.parametrize("rate", RATES)
def test_every_usual_rate_is_read_again(rate: float) -> None:
    values = np.random.default_rng(1).random((400, 2))
    again = read_clip("arkit", write(face(("JawOpen", "MouthClose"), values, rate)))
    assert again.head.seconds_per_frame() == 1 / rate
    np.testing.assert_array_equal(joined(again.blocks()).values, values)


def test_midnight_is_passed() -> None:
    data = write(face(("JawOpen",), np.arange(90.0)[:, None], start="23:59:59:10.500"))
    codes = [row[0] for row in rows_of(data)[1:]]
    assert (codes[0], codes[24], codes[25]) == ("23:59:59:10.500", "23:59:59:58.500", "00:00:00:00.500")
    assert read_clip("arkit", data).frames == 90


def test_names_get_the_spelling_of_the_app() -> None:
    clip = face(("jawOpen", "Grin", "JAWOPEN", "a,b", "=1+1", "HeadYaw"), np.ones((2, 6)))
    names = rows_of(write(clip))[0][2:]
    assert names == ["JawOpen", "Grin", "JawOpen_2", "a_b", "_=1+1", "_HeadYaw"]
    texts = [notice.what for notice in clip.notices]
    assert any("names that ARKit's CSV cannot hold" in text for text in texts)
    assert any(text.startswith("51 of ARKit's 52 blend shapes have no column") for text in texts)


def test_missing_samples_are_blank_and_missing_frames_have_no_row() -> None:
    clip = face(("JawOpen", "MouthClose"), np.array([[0.5, np.nan], [np.nan, np.nan], [0.25, 1.5]]))
    assert [row[1:] for row in rows_of(write(clip))[1:]] == [["2", "0.5", ""], ["2", "0.25", "1.5"]]
    assert any("1 frames without samples have no row" in notice.what for notice in clip.notices)


def test_a_part_has_the_timecodes_of_its_frames() -> None:
    clip = face(("JawOpen",), np.ones((4, 1)))
    part = replace(next(clip.blocks()), ids=np.arange(61, 65))
    assert rows_of(write(replace(clip, blocks=lambda: iter([part]))))[1][0] == "13:00:02:30.000"


def test_angles_are_radians_whatever_the_document_says() -> None:
    radians = rows_of(write(read_document(io.BytesIO(FACE)).clip))
    degrees = rows_of(write(read_document(io.BytesIO(FACE.replace(b'angle="rad"', b'angle="deg"'))).clip))
    place = radians[0].index("HeadYaw")
    assert [float(row[place]) for row in radians[1:]] == [0.2, 0.2, 0.0]
    np.testing.assert_allclose(float(degrees[1][place]), np.radians(0.2), rtol=1e-15)


@pytest.mark.parametrize("text", ["noon", ""])
def test_a_clip_without_a_timecode_starts_at_midnight_with_a_note(text: str) -> None:
    clip = face(("JawOpen",), np.ones((2, 1)), start=text)
    assert [row[0] for row in rows_of(write(clip))[1:]] == ["00:00:00:00.000", "00:00:00:02.000"]
    assert any("00:00:00:00.000" in notice.what for notice in clip.notices)


def test_a_table_too_short_to_show_its_base_is_said() -> None:
    short = face(("JawOpen",), np.ones((5, 1)), rate=60, start="")
    write(short)
    assert any("too short to show" in notice.what for notice in short.notices)


def test_clips_without_blend_shapes_or_frames_are_refused() -> None:
    with pytest.raises(ConversionError, match="no frames"):
        write(face(("JawOpen",), np.ones((0, 1))))
    clip = face(("JawOpen",), np.ones((2, 1)))
    bare = clip.with_head(replace(clip.head, skeleton=Skeleton((Joint("a", -1, "a", Convention.MARKER, ("Tx",)),))))
    with pytest.raises(ConversionError, match="holds blend shapes"):
        write(bare)


def test_a_body_is_left_out_with_a_warning() -> None:
    clip = face(("JawOpen",), np.ones((2, 1)))
    hips = Joint("hips", -1, "Hips", Convention.BASE, ("Rx", "Ry", "Rz"), "ZYX", offset=("0", "0", "0"))
    clip = clip.with_head(replace(clip.head, skeleton=Skeleton((*clip.head.skeleton.joints, hips))))
    assert rows_of(write(clip))[0] == ["Timecode", "BlendShapeCount", "JawOpen"]
    assert any("1 joints are left out" in notice.what for notice in clip.notices)


def test_a_real_recording_comes_back(shared: Path) -> None:
    content = (shared / "arkit" / "alex_rom_3_600.csv").read_bytes()
    clip = read_clip("arkit", content)
    data = write(clip)
    before, after = (rows_of(each) for each in (content, data))
    # All texts but the timecodes, which the phone writes with a jitter of thousandths.
    assert [row[1:] for row in after] == [row[1:] for row in before]
    assert after[1][0] == before[1][0]
    again = read_clip("arkit", data)
    assert again.head.skeleton == clip.head.skeleton
    np.testing.assert_array_equal(joined(again.blocks()).values, joined(clip.blocks()).values)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("jawOpen", "JawOpen"),
        ("Face_blendShapes.jawOpen", "JawOpen"),
        ("ns:Head.EYEBLINKLEFT", "EyeBlinkLeft"),
        ("eyeBlink_L", "EyeBlinkLeft"),
        ("mouth_smile_right", "MouthSmileRight"),
        ("brow_inner_up", "BrowInnerUp"),
        ("mouthLeft", "MouthLeft"),
        ("mouth_l", "MouthLeft"),
        ("smile", None),
        ("eyeBlink", None),
        ("", None),
    ],
)
def test_names_of_other_programs_are_those_of_arkit(name: str, wanted: str | None) -> None:
    assert shape_of(name) == wanted
