"""CSV of faces: weights of blend shapes and angles by name, rows in the frames that their timecodes name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import FormatError, LimitError, McmlError
from mcml.files.gather_files import recognise
from mcml.formats.format import Limits
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.frames import joined
from mcml.motion.skeleton import Convention
from tests.builders import source
from tests.formats.readers.posing import read_clip, reads_or_refuses, spoil

SHAPES = ("EyeBlinkLeft", "JawOpen", "MouthSmileLeft", "TongueOut")
ANGLES = tuple(f"{joint}{angle}" for joint in ("Head", "LeftEye", "RightEye") for angle in ("Yaw", "Pitch", "Roll"))


def frames(clip: ClipStream) -> FrameBlock:
    return joined(clip.blocks())


def timecode(frame: int, base: int = 60, start: int = 13 * 3600) -> str:
    second = (start + frame // base) % 86400
    return f"{second // 3600:02}:{second // 60 % 60:02}:{second % 60:02}:{frame % base:02}.000"


def table(
    rows: int,
    step: int = 2,
    names: tuple[str, ...] = (*SHAPES, *ANGLES),
    dropped: tuple[int, ...] = (),
    base: int = 60,
    start: int = 13 * 3600,
) -> bytes:
    """A table whose cells are `number of the row + number of the column / 100`."""
    lines = [f"Timecode,BlendShapeCount,{','.join(names)}"]
    for row in range(rows):
        if row not in dropped:
            cells = ",".join(f"{row + column / 100:.10f}" for column in range(len(names)))
            lines.append(f"{timecode(row * step, base, start)},{len(names)},{cells}")
    return "\n".join(lines).encode()


def test_columns_are_found_by_their_names() -> None:
    clip = read_clip("arkit", table(5))
    skeleton = clip.head.skeleton
    assert skeleton.names == ("head", "left_eye", "right_eye", *SHAPES)
    assert [joint.channels for joint in skeleton.joints] == [("Ry", "Rx", "Rz")] * 3 + [("weight",)] * 4
    assert {joint.convention for joint in skeleton.joints[3:]} == {Convention.BLEND_SHAPE}
    assert all(joint.parent == 0 for joint in skeleton.joints[1:])
    assert clip.head.fields == {"dataframe_rate": "30", "units_angle": "rad"}
    assert clip.head.properties == (("timecode", "13:00:00:00.000", ""),)
    block = frames(clip)
    places = [*range(4, 13), *range(4)]
    np.testing.assert_array_equal(block.values, np.round(np.arange(5)[:, None] + np.array(places) / 100, 10))


@given(order=st.permutations((*SHAPES, *ANGLES)), upper=st.booleans())
def test_order_and_case_of_columns_do_not_count(order: list[str], upper: bool) -> None:
    clip = read_clip("arkit", table(2, names=tuple(name.upper() if upper else name for name in order)))
    block = frames(clip)
    joints = clip.head.skeleton.joints
    for value, (joint, channel) in zip(block.values[0], block.columns, strict=True):
        angle = {3: "pitch", 4: "yaw", 5: "roll", 8: ""}[channel]
        name = joints[joint].source_name.lower().replace("_", "") + angle
        assert round(value * 100) == [each.lower() for each in order].index(name)


@pytest.mark.parametrize(
    ("rows", "step", "base", "rate", "is_guess"),
    [(90, 1, 60, "60", False), (90, 2, 60, "30", False), (9, 2, 60, "30", True), (90, 1, 30, "30", True)],
)
def test_the_rate_is_that_of_the_timecodes(rows: int, step: int, base: int, rate: str, is_guess: bool) -> None:
    clip = read_clip("arkit", table(rows, step, base=base))
    assert clip.head.fields["dataframe_rate"] == rate
    assert clip.frames == rows
    assert any(notice.kind == "guess" for notice in clip.notices) == is_guess


def test_a_frame_without_a_row_has_no_samples() -> None:
    clip = read_clip("arkit", table(600, dropped=(300, 301)))
    assert clip.frames == 600
    values = frames(clip).values
    assert np.flatnonzero(np.isnan(values).all(axis=1)).tolist() == [300, 301]
    assert not np.isnan(values[:300]).any()
    assert values[302, 9] == 302
    assert any("2 frames have no row" in notice.what for notice in clip.notices)


def test_midnight_is_no_step_back() -> None:
    clip = read_clip("arkit", table(90, start=86400 - 1))
    assert clip.frames == 90
    assert not np.isnan(frames(clip).values).any()


def test_a_blank_cell_is_no_sample_and_large_weights_stay() -> None:
    rows = table(3).decode().splitlines()
    cells = rows[2].split(",")
    cells[2], cells[3] = "", "1.053"
    rows[2] = ",".join(cells)
    block = frames(read_clip("arkit", "\r\n".join(rows).encode("utf-8-sig")))
    assert np.isnan(block.values[1, 9])
    assert block.values[1, 10] == 1.053
    assert np.isnan(block.values).sum() == 1


def test_a_rate_that_is_wanted_leaves_rows_out_with_a_warning() -> None:
    clip = read_clip("arkit", table(60), rate=15)
    assert clip.frames == 31
    assert any("rows fall into the frame" in notice.what for notice in clip.notices)
    assert not np.isnan(frames(clip).values).any()


@pytest.mark.parametrize(
    ("change", "words", "line"),
    [
        (lambda text: text.replace("13:00:00:02.000", "13:00"), "is not a timecode", 3),
        (lambda text: text.replace("13:00:00:04.000", "12:59:00:04.000"), "before that of the line above", 4),
        (lambda text: text.replace("0.0000000000,", "", 1), "cells, the first line has", 2),
        (lambda text: text.replace("1.0100000000", "1_01"), "JawOpen is not a number", 3),
        (lambda text: text.replace("1.0100000000", "inf"), "JawOpen is not a number", 3),
        (lambda text: text.replace("JawOpen", "TongueOut"), "names 'TongueOut' twice", 1),
        (lambda text: text.splitlines()[0], "has no rows", None),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_line(change: object, words: str, line: int | None) -> None:
    with pytest.raises(FormatError, match=words) as refused:
        frames(read_clip("arkit", change(table(4).decode()).encode()))  # type: ignore[operator]
    place = refused.value.at
    assert (None if place is None else place.line) == line


def test_what_is_too_large_is_refused() -> None:
    far = table(2) + b"\n23:00:00:00.000,13," + b",".join([b"1"] * 13)
    with pytest.raises(LimitError, match="frames"):
        read_clip("arkit", far, limits=Limits(frames=1000))
    with pytest.raises(LimitError):
        read_clip("arkit", table(2), limits=Limits(joints=3))
    with pytest.raises(McmlError, match="longer than"):
        read_clip("arkit", table(1) + b"\n" + b"1" * 70_000)


def test_other_tables_are_not_taken_for_faces() -> None:
    assert recognise(source("a.txt", table(1))) == ("arkit", "csv")
    with pytest.raises(McmlError):
        recognise(source("a.csv", b"time,x,y\n1,2,3\n"))


@pytest.mark.parametrize("seed", range(3))
def test_damaged_files_are_read_or_refused(seed: int) -> None:
    chance = np.random.default_rng(seed)
    for _ in range(60):
        reads_or_refuses("arkit", spoil(table(8), chance, int(chance.integers(1, 6))))


def test_a_real_recording_is_read_whole(shared: Path) -> None:
    content = (shared / "arkit" / "alex_rom_3_600.csv").read_bytes()
    clip = read_clip("arkit", content)
    assert (clip.frames, len(clip.head.skeleton), clip.head.fields["dataframe_rate"]) == (601, 55, "30")
    values = frames(clip).values
    (gap,) = np.flatnonzero(np.isnan(values).all(axis=1))
    rows = [line.split(",") for line in content.decode("utf-8-sig").splitlines()]
    place = {name: number for number, name in enumerate(rows[0])}
    names = [joint.source_name for joint in clip.head.skeleton.joints]
    wanted = np.array([float(row[place["JawOpen"]]) for row in rows[1:]])
    column = clip.head.skeleton.columns().index((names.index("JawOpen"), 8))
    np.testing.assert_array_equal(np.delete(values[:, column], gap), wanted)
