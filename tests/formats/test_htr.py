"""HTR and HTR2: the contract, and every quirk of real files."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from mcml.errors import FormatError, LimitError, UnsupportedError
from mcml.formats import FORMATS
from mcml.formats.format import Limits, ReadOptions
from mcml.motion.clip import ClipStream
from mcml.testing import FormatContract, frames, read, written
from tests.builders import HTR
from tests.builders import HTR_HEAD as HEAD
from tests.builders import HTR_V1 as V1
from tests.builders import HTR_V2 as V2

HEAD2 = HEAD.replace("FileVersion 1", "FileVersion 2")
NAME = "htr"


def clip_of(text: str = HEAD + V1, **options: object) -> ClipStream:
    return read(FORMATS[NAME], {"htr": text.encode()}, ReadOptions(**options))  # type: ignore[arg-type]


def notices(text: str) -> str:
    clip = clip_of(text)
    frames(clip)
    return "\n".join(notice.what for notice in clip.notices)


class TestHtr(FormatContract):
    name = NAME
    samples: ClassVar = {
        "version 1": {"htr": (HEAD + V1).encode()},
        "version 2": {"htr": (HEAD2 + V2).encode()},
        "missing 1": {
            "htr": (HEAD + V1).replace("1\t0\t0\t0\t4", "1\t9999999.0\t9999999.0\t9999999.0\t4").encode()
        },
        "missing 2": {"htr": (HEAD2 + V2).replace("0 0 0 4 5 6 1", " ".join(["-9999999"] * 7)).encode()},
        "no frame": {
            "htr": (HEAD + "[m:Hand]\n[m:Arm]\n[Hips]\n[EndOfFile]\n").replace("NumFrames 2", "NumFrames 0").encode()
        },
        "two roots": {
            "htr": HEAD.replace("m:Arm\tHips", "m:Arm\tglobal").encode() + V1.replace("0.5", "0.25").encode()
        },
        "korean": {"htr": (HEAD + V1).replace("m:Hand", "손").encode("cp949")},
        "unknown keywords": {
            "htr": (HEAD + V1).replace("FileType htr", "FILETYPE HTR\nMotionId a b\nMotionId2 7").encode()
        },
    }  # fmt: skip


def test_keeps_what_the_file_says() -> None:
    clip = clip_of()
    hips, arm, hand = clip.head.skeleton.joints
    assert [joint.source_name for joint in (hips, arm, hand)] == ["Hips", "m:Arm", "m:Hand"]
    assert clip.head.skeleton.declared == (2, 1, 0)
    assert (hips.offset, hips.axis) == (("0.902781", "1023.85", "1740.59"), ("-45.1", "-87.2", "-45.0"))
    assert (hips.length, hips.rotation_order, hips.axis_order) == ("3.937008", "ZYX", "ZYX")
    assert clip.head.fields == {
        "filetype": "htr", "datatype": "HTRS", "version": "1", "num_segments": "3", "num_frames": "2",
        "dataframe_rate": "30", "euler_rotation_order": "ZYX", "calibration_unit": "mm", "units_angle": "Degrees",
        "global_axis_of_gravity": "Y", "bone_length_axis": "Y", "scale_factor": "1.00",
    }  # fmt: skip
    source = clip.head.sources[0]
    assert source.keywords[:3] == ("FileType", "DataType", "FileVersion")
    assert source.comments[:2] == ("# made by hand", "# Header keywords are followed by a single value")
    assert clip.head.frame_time is None
    assert clip.head.seconds_per_frame() == 1 / 30
    assert [frame_id for frame_id, _ in frames(clip)] == [0, 1]


def test_both_versions_hold_the_same_motion() -> None:
    one, two = clip_of(), clip_of(HEAD2 + V2)
    assert frames(one) == frames(two)
    assert b"[m:Hand]" in written(FORMATS[NAME], one)["htr"]
    assert b"Frame 1:\nm:Hand\t" in written(FORMATS[NAME], two)["htr"]


def test_comments_among_the_frames_of_version_2_are_told_of() -> None:
    said = notices(HEAD2 + V2.replace("Frame 1:", "# second\nFrame 1: # here"))
    assert "2 comments among the frames" in said
    assert "comments" not in notices(HEAD2 + V2)


def test_numbers_keep_every_bit() -> None:
    block = next(iter(clip_of().blocks()))
    arm = block.values[0, 7:14]
    assert np.signbit(arm[3:5]).all()
    assert arm[5] == 1e-11


def test_missing_samples_are_no_numbers() -> None:
    text = (HEAD + V1).replace("1\t0\t0\t0\t4\t5\t6\t1", "1\t" + "\t".join(["9999999.000"] * 7))
    clip = clip_of(text)
    block = next(iter(clip.blocks()))
    assert np.isnan(block.values[1, 7:14]).all()
    assert np.isfinite(block.values[0]).all()
    assert block.shapes[int(block.shape_of[1])][1] == (1, 0)  # type: ignore[index]
    assert clip.head.sources[0].missing == "9999999.000"
    assert "9999999.000 say that a sample is missing" in notices(text)
    assert b"1\t" + b"\t".join([b"9999999.000"] * 7) in written(FORMATS[NAME], clip)["htr"]
    assert "missing" not in notices((HEAD + V1).replace("\t20\t30", "\t999998\t0.9999999"))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\t", " ").replace("mm", "mm # millimetres"),
        lambda text: text.replace("[Header]", "[HEADER]\t").replace("[BasePosition]", "[baseposition]"),
        lambda text: text.replace("GlobalAxisofGravity", "GlobalAxisOfGravity").replace(
            "\n[Hips]", "\n\n # x\n  [Hips]"
        ),
        lambda text: text.replace("FileType htr", "FileType htr\nFileType htr"),
        lambda text: text.replace("Hips\tGLOBAL", "Hips\tglobal"),
        lambda text: text.replace("0\t10\t20\t30", "0\t10\t20\t30 ").replace("9\t1\n", "9\t1 # comment\n"),
    ],
)
def test_accepts_every_spelling(change) -> None:  # type: ignore[no-untyped-def]
    assert frames(clip_of(change(HEAD + V1))) == frames(clip_of())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[EndOfFile]\n", ""), "no [EndOfFile]"),
        (("[EndOfFile]", "#second\n[m:Hand]\n0 1 1 1 1 1 1 1\n[EndOfFile]"), "1 segments occur again"),
        (("ScaleFactor 1.00", "ScaleFactor 2"), "ScaleFactor is 2"),
        (("EulerRotationOrder ZYX\n", ""), "states no EulerRotationOrder: ZYX"),
        (("DataFrameRate 30\n", ""), "states no frame rate"),
        (("DataType HTRS", "MotionId 7"), "header keyword 'MotionId' is kept"),
        (("0\t10\t20\t30", "5\t10\t20\t30"), "segment 'Hips' numbers its frames otherwise than 'm:Hand'"),
    ],
)
def test_says_what_it_guessed(change: tuple[str, str], message: str) -> None:
    assert change[0] in HEAD + V1
    assert message in notices((HEAD + V1).replace(change[0], change[1], 1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[Header]", "[Heading]"), "HTR section [Header] is missing"),
        (("[Header]", "Header"), "HTR section [Header] is missing, found 'Header'"),
        (("[SegmentNames&Hierarchy]", "[Segments]"), "HTR section [SegmentNames&Hierarchy] is missing"),
        (("[BasePosition]", "[Base]"), "HTR section [BasePosition] is missing"),
        (("NumSegments 3", "NumSegments 4"), "NumSegments says 4, the hierarchy lists 3"),
        (("NumSegments 3", "NumSegments three"), "NumSegments 'three' is not a count"),
        (("NumFrames 2", "NumFrames 3"), "segment 'm:Hand' has 2 rows, NumFrames says 3"),
        (("NumFrames 2", "NumFrames 1"), "segment 'm:Hand' has 2 rows, NumFrames says 1"),
        (("NumFrames 2\n", ""), "header: NumFrames is missing"),
        (("Order ZYX", "Order ZZX"), "EulerRotationOrder 'ZZX' is not a permutation of XYZ"),
        (("Hips\t0.902781", "Hips\t0\t0.902781"), "BasePosition of 'Hips' has 9 fields, expected 8"),
        (("Hips\t0.902781", "Hips\tx"), "BasePosition of 'Hips': 'x' is not a finite number"),
        (("m:Hand 0 200", "m:Foot 0 200"), "BasePosition: segment 'm:Foot' is not in the hierarchy"),
        (("m:Hand 0 200 0 0 0 0 80\n", ""), "BasePosition: segment 'm:Hand' is missing"),
        (("m:Arm\tHips", "m:Arm\tPelvis"), "segment 'm:Arm': parent 'Pelvis' is unknown"),
        (("Hips\tGLOBAL", "Hips\tHips"), "no segment has the parent GLOBAL"),
        (("m:Arm\tHips", "m:Arm\tm:Hand"), "hierarchy: cycle at 'm:Hand'"),
        (("m:Hand\tm:Arm", "m:Hand\tm:Arm\tx"), "expected a segment and its parent, found 3 words"),
        (("m:Hand\tm:Arm", "m:Arm\tHips"), "segment 'm:Arm' occurs twice in the hierarchy"),
        (("[m:Arm]\n0", "[m:Leg]\n0"), "segment 'm:Arm' has no motion"),
        (("4\t5\t6\t1\n", "4\t5\t6\n"), "segment 'm:Arm', row 2 has 7 fields, expected 8"),
        (("4\t5\t6\t1\n", "4\t5\tsix\t1\n"), "segment 'm:Arm', row 2: 'six' is not a finite number"),
        (("4\t5\t6\t1\n", "4\t5\t6,5\t1\n"), "'6,5' uses a decimal comma"),
        (("FileType htr", "FileType trc"), "FileType is 'trc', expected htr"),
        (("FileType htr", "FileType htr\nFileType HTR2"), "header: FileType is first 'htr', then 'HTR2'"),
        (("FileType htr", "FileType"), "header: FileType has no value"),
        (("Rate 30", "Rate fast"), "DataFrameRate: 'fast' is not a finite number"),
        (("Gravity Y", "Gravity up"), "GlobalAxisofGravity 'up' is not X, Y or Z"),
        (("Units Degrees", "Units Grad"), "RotationUnits 'Grad' are not Degrees or Radians"),
    ],
)
def test_refuses(change: tuple[str, str], message: str) -> None:
    assert change[0] in HEAD + V1
    with pytest.raises(FormatError) as error:
        frames(clip_of((HEAD + V1).replace(change[0], change[1], 1)))
    assert message in str(error.value)
    assert error.value.at is not None
    assert error.value.at.file == "clip.htr"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("NumFrames 2", "NumFrames 3"), "the file has 2 frames, NumFrames says 3"),
        (("NumFrames 2", "NumFrames 1"), "the file has more than 1 frames, NumFrames says 1"),
        (("m:Arm 0 0 0 4 5 6 1\n", ""), "frame 1 has 2 rows, NumSegments says 3"),
        (("m:Arm 0 0 0 4 5 6 1", "m:Arm 0 0 0 4 5 6"), "frame 1: bone 'm:Arm' has 6 values, hierarchy rows have 7"),
        (("m:Arm 0 0 0 4", "m:Leg 0 0 0 4"), "frame 1: bone 'm:Leg' is not in the hierarchy"),
    ],
)
def test_refuses_in_version_2(change: tuple[str, str], message: str) -> None:
    assert change[0] in HEAD2 + V2
    with pytest.raises(FormatError) as error:
        frames(clip_of((HEAD2 + V2).replace(change[0], change[1], 1)))
    assert message in str(error.value)


def test_gtr_and_unknown_versions_are_not_read() -> None:
    with pytest.raises(UnsupportedError, match="GTR"):
        clip_of((HEAD + V1).replace("FileType htr", "FileType gtr"))
    with pytest.raises(UnsupportedError, match="GTR"):
        clip_of((HEAD + V1).replace("HTRS", "GTRS"))
    with pytest.raises(UnsupportedError, match="FileVersion '3'"):
        clip_of((HEAD + V1).replace("FileVersion 1", "FileVersion 3"))


def test_the_line_of_a_bad_row_is_named() -> None:
    with pytest.raises(FormatError) as error:
        frames(clip_of((HEAD + V1).replace("4\t5\t6\t1\n", "4\t5\t6\n")))
    assert error.value.at is not None
    assert error.value.at.line == (HEAD + V1).splitlines().index("1\t0\t0\t0\t4\t5\t6\t1") + 1


def test_limits() -> None:
    with pytest.raises(LimitError, match="more than 2 segments"):
        clip_of(limits=Limits(joints=2))
    with pytest.raises(LimitError, match="too deep"):
        clip_of(limits=Limits(depth=2))
    with pytest.raises(LimitError, match="values"):
        clip_of((HEAD + V1).replace("NumFrames 2", "NumFrames 40000000"), limits=Limits(values=1000))


def test_long_motion_is_read_through_cursors() -> None:
    """Many more frames than a block holds: every value is where it belongs, in both versions."""
    rng = np.random.default_rng(7)
    table = rng.normal(size=(60_000, 3, 7)).round(3)
    names = ("m:Hand", "m:Arm", "Hips")
    parts = [HEAD.replace("NumFrames 2", f"NumFrames {len(table)}")]
    for place, name in enumerate(names):
        parts.append(f"[{name}]\n")
        rows = table[:, place].tolist()
        parts += [f"{number} {' '.join(map(repr, row))}\n" for number, row in enumerate(rows, 1)]
    clip = clip_of("".join(parts) + "[EndOfFile]\n")
    blocks = list(clip.blocks())
    assert len(blocks) > 2
    found = np.concatenate([block.values for block in blocks]).reshape(-1, 3, 7)
    assert np.array_equal(found, table)
    assert np.concatenate([np.asarray(block.ids) for block in blocks]).tolist() == list(range(1, len(table) + 1))


def test_rotation_units_that_are_not_stated_are_a_guess() -> None:
    clip = read(FORMATS["htr"], {"htr": HTR.replace(b"RotationUnits Degrees\n", b"")})
    assert any("states no RotationUnits: Degrees" in notice.what for notice in clip.notices)
    assert not any("RotationUnits" in notice.what for notice in read(FORMATS["htr"], {"htr": HTR}).notices)
