"""BVH: the contract, and every quirk of real files."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from mcml.errors import FormatError, LimitError
from mcml.formats import FORMATS
from mcml.formats.format import Limits, ReadOptions
from mcml.motion.clip import ClipStream
from mcml.testing import FormatContract, frames, read, written

HEAD = """HIERARCHY
ROOT Hips
{
\tOFFSET 0.00 1.0 0
\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
\tJOINT Left Arm
\t{
\t\tOFFSET 1.5 0 0
\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\tEnd Site
\t\t{
\t\t\tOFFSET 0.5 0 0
\t\t}
\t}
\tJOINT b:Right.Arm-1
\t{
\t\tOFFSET -1.5 0 0
\t\tCHANNELS 2 Yrotation Xrotation
\t\tEnd Site
\t\t{
\t\t\tOFFSET -0.5 0 0
\t\t}
\t}
}
MOTION
"""
MOTION = """Frames: 2
Frame Time: 0.0333333
0 1.1 0 10 20 30 1 2 3 4 5
0.5 1.1 0 11 21 31 1.5 2.5 3.5 4.5 5.5
"""
BASIC = (HEAD + MOTION).encode()
ODD_NUMBERS = "-0 -0.0 +1 .5 -.25 5. 1e-011 -4.0020632E-7 007 1E5 0"


def motion(text: str) -> bytes:
    return (HEAD + text).encode()


def clip_of(data: bytes, **options: object) -> ClipStream:
    return read(FORMATS["bvh"], {"bvh": data}, ReadOptions(**options))  # type: ignore[arg-type]


def values(data: bytes) -> list[list[float]]:
    clip = clip_of(data)
    return [row for block in clip.blocks() for row in block.values.tolist()]


def notices(data: bytes) -> str:
    clip = clip_of(data)
    frames(clip)
    return "\n".join(notice.what for notice in clip.notices)


def refusal(data: bytes, **options: object) -> str:
    with pytest.raises(FormatError) as error:
        frames(clip_of(data, **options))
    assert error.value.at is not None
    assert error.value.at.line is not None
    return str(error.value)


EXPECTED = [[0, 1.1, 0, 10, 20, 30, 1, 2, 3, 4, 5], [0.5, 1.1, 0, 11, 21, 31, 1.5, 2.5, 3.5, 4.5, 5.5]]


class TestBvh(FormatContract):
    name = "bvh"
    samples: ClassVar = {
        "basic": {"bvh": BASIC},
        "one frame": {"bvh": motion("Frames: 1\nFrame Time: .5\n0 1.1 0 10 20 30 1 2 3 4 5\n")},
        "no frame": {"bvh": motion("Frames: 0\nFrame Time: 0.1\n")},
        "numbers": {"bvh": motion(f"Frames: 1\nFrame Time: 1e-2\n{ODD_NUMBERS}\n")},
        "two roots": {
            "bvh": b"HIERARCHY\nROOT A\n{\nOFFSET 0 0 0\nCHANNELS 1 Xposition\n}\nROOT A\n{\nOFFSET 1 0 0\n}\n"
            b"MOTION\nFrames: 1\nFrame Time: 1\n5\n"
        },
        "korean": {"bvh": BASIC.replace(b"Hips", "골반".encode("cp949"))},
        "latin": {"bvh": BASIC.replace(b"Hips", "Hüfte".encode("latin-1"))},
        "unicode": {"bvh": BASIC.replace(b"Hips", "骨盤 é".encode())},
        "end sites": {
            "bvh": b"HIERARCHY\nROOT R\n{\nOFFSET 0 0 0\nEnd Site first\n{\nOFFSET 1 0 0\n}\n"
            b"JOINT End Site\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 0 0\n}\n}\n"
            b"End Site last one\n{\nOFFSET 0 0 1\n}\n}\nMOTION\nFrames: 1\nFrame Time: 1\n45\n"
        },
    }  # fmt: skip


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("Frames: 2", "Frames:\t2").replace("Frame Time: ", "Frame Time:\t"),
        lambda text: text.replace("Frames: 2", "frames :2").replace("Frame Time:", "FRAME TIME :"),
        lambda text: text.replace("Frames: 2", "Frames:2"),
        lambda text: text.replace("HIERARCHY", "hierarchy").replace("OFFSET", "Offset").replace("JOINT", "joint"),
        lambda text: text.replace("Xposition", "XPOSITION").replace("Zrotation", "zrotation").replace("ROOT", "Root"),
        lambda text: text.replace("\n", " \n").replace("Frames", "\n\nFrames"),
        lambda text: text.replace(" 20 ", "\n20 ").replace("11 21", "11\n\n21"),
        lambda text: text.replace("4 5\n", "4 5 ").replace(" 30 ", "\t\t30  "),
        lambda text: text.replace("ROOT Hips\n{", "ROOT Hips {").replace("Left Arm\n\t{", "Left Arm{"),
        lambda text: text.replace("ROOT Hips", "ROOT\n  Hips"),
        lambda text: text.replace("\n\t\t}", "}").replace("MOTION\n", "MOTION "),
    ],
)
def test_accepts_every_spelling(change) -> None:  # type: ignore[no-untyped-def]
    data = change(HEAD + MOTION).encode()
    assert values(data) == EXPECTED
    assert clip_of(data).head == clip_of(BASIC).head


def test_keeps_what_the_file_says() -> None:
    clip = clip_of(BASIC)
    root, left, right = clip.head.skeleton.joints
    assert [joint.source_name for joint in (root, left, right)] == ["Hips", "Left Arm", "b:Right.Arm-1"]
    assert (root.offset, root.channels) == (("0.00", "1.0", "0"), ("Tx", "Ty", "Tz", "Rz", "Rx", "Ry"))
    assert (root.rotation_order, left.rotation_order, right.rotation_order) == ("ZXY", "ZXY", "YX")
    assert (left.end_sites[0].offset, left.parent, right.parent) == (("0.5", "0", "0"), 0, 0)
    assert (clip.head.frame_time, clip.frames, clip.head.fields) == ("0.0333333", 2, {})
    assert [frame[0] for frame in frames(clip)] == [1, 2]


def test_numbers_keep_every_bit() -> None:
    found = np.array(values(motion(f"Frames: 1\nFrame Time: 1\n{ODD_NUMBERS}\n"))[0])
    expected = np.array([float(word) for word in ODD_NUMBERS.split()])
    assert found.view(np.int64).tolist() == expected.view(np.int64).tolist()


def test_the_source_style_is_written_again() -> None:
    data = motion(
        "Frames: 2\nFrame Time: 0.0083333\n"
        + "0.10 1.10 -0.00 10.00 20.00 30.00 1.00 2.00 3.00 4.00 5.00\n" * 2
    )  # fmt: skip
    clip = clip_of(data)
    assert clip.head.number_style == "fixed:2"
    assert written(FORMATS["bvh"], clip)["bvh"] == data


def test_a_value_that_the_style_would_change_is_written_in_full() -> None:
    data = motion(
        "Frames: 2\nFrame Time: 1\n0.12345 1.10 0.00 1.00 2.00 3.00 1.00 2.00 3.00 4.00 5.00\n"
        "0.10 1.10 0.00 1.00 2.00 3.00 1.00 2.00 3.00 4.00 1e-30\n"
    )
    clip = clip_of(data)
    assert clip.head.number_style == "fixed:2"
    last = written(FORMATS["bvh"], clip)["bvh"].splitlines()[-2:]
    assert last[0].startswith(b"0.12345 1.10 ")
    assert last[1].endswith(b"4.00 1e-30")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("OFFSET 0.00 1.0 0\n", "OFFSET 0.00 1.0\n"), "OFFSET of joint 'Hips' needs 3 numbers, found 2"),
        (("OFFSET 0.00 1.0 0\n", "OFFSET 0 1 2 3\n"), "expected OFFSET, CHANNELS, JOINT, End Site or }, found '3'"),
        (("OFFSET 1.5 0 0", "OFFSET 1,5 0 0"), "OFFSET of joint 'Left Arm': '1,5' uses a decimal comma"),
        (("OFFSET 1.5 0 0", "OFFSET nan 0 0"), "'nan' is not a finite number"),
        (("CHANNELS 6", "CHANNELS 5"), "5:11: joint 'Hips': CHANNELS says 5 but lists 6"),
        (("CHANNELS 6", "CHANNELS six"), "expected the number of channels of joint 'Hips', found 'six'"),
        (("CHANNELS 6 X", "CHANNELS 6 W"), "joint 'Hips': unknown channel 'Wposition'"),
        (("6 Xposition Yposition", "6 Xposition Xposition"), "channel 'Xposition' occurs twice"),
        (("JOINT Left Arm", "JIONT Left Arm"), "expected OFFSET, CHANNELS, JOINT, End Site or }, found 'JIONT'"),
        (("HIERARCHY", "HIERACHY"), "line 1:1: not a BVH file: expected HIERARCHY, found 'HIERACHY'"),
        (("ROOT Hips\n{", "ROOT\n{"), "ROOT has no name"),
        (("}\nMOTION", "MOTION"), "expected OFFSET, CHANNELS, JOINT, End Site or }, found 'MOTION'"),
        (("}\nMOTION", "}\n}\nMOTION"), "expected MOTION, found '}'"),
        (("\t\tOFFSET 1.5 0 0\n", ""), "joint 'Left Arm' opened at line 6 has no OFFSET"),
        (("Frames: 2", "Frames: -1"), "Frames: -1 is negative"),
        (("Frames: 2", "Frames: 2.5"), "Frames: '2.5' is not a whole number"),
        (("Frames: 2", "Frames: "), "Frames: has no value"),
        (("Frames: 2", "2"), "expected Frames:, found '2'"),
        (("0.0333333", "-0.1"), "Frame Time: -0.1 is negative"),
        (("0.0333333", "inf"), "Frame Time: 'inf' is not a finite number"),
        (("Frame Time", "Fps"), "expected Frame Time:, found 'Fps:'"),
        (("1.1 0 11 21", "1.1 0 abc 21"), "frame 2, value 4 (Hips Zrotation): 'abc' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 nan 21"), "'nan' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 inf 21"), "'inf' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 1e999 21"), "'1e999' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 1_1 21"), "'1_1' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 0x1F 21"), "'0x1F' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 [11] 21"), "'[11]' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 true 21"), "'true' is not a finite number"),
        (("1.1 0 11 21", "1.1 0 1,25 21"), "(Hips Zrotation): '1,25' uses a decimal comma"),
        (("1.1 0 11 21", "1.1 0 0.0-7.5094748 21"), "two numbers without a space: '0.0-7.5094748'"),
        ((" 3.5 4.5 5.5", " 3.5"), "MOTION declares 2 frames, data ends in frame 2, behind value 9 of 11 of 2"),
        (("Frames: 2", "Frames: 3000"), "MOTION declares 3000 frames, data ends behind frame 2 of 3000"),
    ],
)  # fmt: skip
def test_refuses(change: tuple[str, str], message: str) -> None:
    text = HEAD + MOTION
    assert change[0] in text
    assert message in refusal(text.replace(change[0], change[1], 1).encode())


def test_a_bad_number_is_found_in_its_line_and_column() -> None:
    with pytest.raises(FormatError) as error:
        frames(clip_of(BASIC.replace(b"31 1.5", b"31 1.5x")))
    assert error.value.at is not None
    assert (error.value.at.line, error.value.at.column) == (29, 20)


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r", " \n\n"])
@pytest.mark.parametrize("bom", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize(
    "change",
    [
        ("", ""),
        ("Left Arm", "b:Right.Arm-1"),
        ("Left Arm", "MOTION Frames"),
        ("JOINT Left Arm", "JOINT\nMOTION Frames"),
        ("MOTION\n", "MOTION "),
        ("Frames: 2", "Frames: x"),
        ("Frame Time", "Fps"),
        ("}\nMOTION", "MOTION"),
        ("31 1.5", "31 x"),
    ],
)
def test_a_hierarchy_read_before_says_the_same(
    change: tuple[str, str], bom: bytes, ends: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = bom + (HEAD + MOTION).replace(*change, 1).replace("\n", ends).encode()

    def said() -> tuple[object, ...]:
        try:
            clip = clip_of(data)
            read_in_full = frames(clip)
        except FormatError as error:
            return (str(error),)
        return clip.head, read_in_full, clip.notices

    first, again = said(), said()
    monkeypatch.setattr("mcml.formats.bvh.format.LONGEST_SHARED", 0)
    assert first == again == said()


def test_the_beginning_is_looked_at_as_if_it_were_alone() -> None:
    rows = "\n".join(" ".join(f"{frame + 0.5 * column:.3f}" for column in range(11)) for frame in range(600))
    whole = motion(f"Frames: 600\nFrame Time: .1\n{rows}")
    assert len(whole) < 1 << 16
    for tail in (b"", b"\n", b"\n" + b"0.125 " * 40_000):
        clip = clip_of(whole + tail)
        assert clip.head.number_style == "fixed:3"
        assert np.concatenate([block.values for block in clip.blocks()]).tolist() == [
            [float(word) for word in row.split()] for row in rows.split("\n")
        ]


def test_a_joint_that_is_not_closed_is_named() -> None:
    assert "joint 'Left Arm' opened at line 6 is not closed" in refusal(BASIC[: BASIC.index(b"End Site")])


def test_too_deep_or_too_large_is_refused() -> None:
    deep = b"HIERARCHY\nROOT j\n{\nOFFSET 0 0 0\n" + b"JOINT j\n{\nOFFSET 0 0 0\n" * 300
    with pytest.raises(LimitError, match="too deep"):
        clip_of(deep)
    with pytest.raises(LimitError, match="name is longer"):
        clip_of(BASIC.replace(b"Hips", b"H" * 1025))
    with pytest.raises(LimitError, match="frames, the limit"):
        clip_of(BASIC.replace(b"Frames: 2", b"Frames: 99999999999"))
    with pytest.raises(LimitError, match="values"):
        clip_of(BASIC, limits=Limits(values=10))
    with pytest.raises(FormatError, match="CHANNELS says"):
        clip_of(BASIC.replace(b"CHANNELS 6", b"CHANNELS " + b"9" * 100_000))
    with pytest.raises(LimitError, match="line is longer"):
        clip_of(b"HIERARCHY ROOT " + b"{ " * 4_000_000)


def test_surplus_is_counted_and_left_out() -> None:
    more = motion(MOTION + "1 2 3 4 5 6 7 8 9 10 11\n")
    assert values(more) == EXPECTED
    assert "MOTION declares 2 frames, the file holds 1 more: left out" in notices(more)
    assert "the file holds 2 more values" in notices(motion(MOTION + "1 2\n"))
    assert values(motion(MOTION + "end of file\n")) == EXPECTED


@pytest.mark.parametrize("text", ["", "Frame Time:\n", "Frame Time: 0\n"])
def test_an_unknown_frame_time_is_said(text: str) -> None:
    data = motion(MOTION.replace("Frame Time: 0.0333333\n", text))
    assert values(data) == EXPECTED
    assert "frame rate is unknown" in notices(data)
    clip = clip_of(data)
    assert clip.head.seconds_per_frame() is None
    again = written(FORMATS["bvh"], clip)["bvh"]
    assert clip_of(again).head == clip.head


def test_what_was_guessed_is_said() -> None:
    twice = BASIC.replace(b"b:Right.Arm-1", b"Left Arm")
    assert clip_of(twice).head.skeleton.names == ("Hips", "Left Arm", "Left Arm#2")
    assert "'Left Arm': names used more than once" in notices(twice)
    bare = BASIC.replace(b"\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0.5 0 0\n\t\t}\n", b"")
    assert "'Left Arm': no End Site" in notices(bare)
    assert "CP949" in notices(BASIC.replace(b"Hips", "골반".encode("cp949")))
    assert "Latin-1" in notices(BASIC.replace(b"Hips", b"H\xfcfte"))
    assert notices(BASIC.replace(b"OFFSET 0.00 1.0 0", b"OFFSET 0 0 0")) == ""


def test_the_encoding_that_was_given_is_used() -> None:
    data = BASIC.replace(b"Hips", "腰".encode("shift_jis"))
    clip = clip_of(data, encoding="shift_jis")
    assert clip.head.skeleton.joints[0].source_name == "腰"
    assert b"ROOT " + "腰".encode("shift_jis") in written(FORMATS["bvh"], clip)["bvh"]
    with pytest.raises(FormatError, match="is no encoding"):
        clip_of(data, encoding="utf-16")
    with pytest.raises(FormatError, match="is no encoding"):
        clip_of(data, encoding="no-such-codec")


def test_names_that_bvh_cannot_hold_are_changed_with_a_notice() -> None:
    from dataclasses import replace

    clip = clip_of(BASIC)
    joints = list(clip.head.skeleton.joints)
    joints[1] = replace(joints[1], source_name=" a\nb {")
    odd = clip.with_head(replace(clip.head, skeleton=replace(clip.head.skeleton, joints=tuple(joints))))
    again = clip_of(written(FORMATS["bvh"], odd)["bvh"])
    assert again.head.skeleton.joints[1].source_name == "a_b _"
    assert any("became _" in notice.what for notice in odd.notices)


def test_blocks_are_cut_anywhere() -> None:
    """A motion much longer than a block of text, rows broken over lines, doubled blanks: all frames are right."""
    rng = np.random.default_rng(3)
    table = rng.normal(size=(8000, 11)).round(5)
    text = "\n".join("  ".join(map(repr, row)) + " " for row in table.tolist()).replace("  0.1", "\n0.1")
    data = motion(f"Frames: {len(table)}\nFrame Time: 1\n{text}")
    assert len(data) > 1 << 19
    assert values(data) == table.tolist()
