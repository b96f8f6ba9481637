"""Files that depart from their format as programs write them, and the repairs of those that must not be guessed."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import FormatError
from mcml.formats import FORMATS, find_format
from mcml.formats.format import ReadOptions, SourceFile
from mcml.formats.repairs import offers, repaired
from mcml.motion.clip import ClipStream
from mcml.testing import read
from tests.builders import ASF, HTR, TRC, amc, bvh

BVH = bvh(3)


def notices(clip: ClipStream) -> str:
    return " ".join(notice.what for notice in clip.notices)


def values(clip: ClipStream) -> np.ndarray:
    return np.concatenate([block.values for block in clip.blocks()])


@pytest.mark.parametrize(
    ("written", "name"),
    [
        (b"End Site4", "Site4"),
        (b"End l_toe_End", "l_toe_End"),
        (b"EndSite", ""),
        (b"EndSite 7", "7"),
        (b"End site", ""),
        (b"End Site tip", "tip"),
        (b"END SITE", ""),
        (b"End", None),
    ],
)
def test_end_sites_of_bvh(written: bytes, name: str | None) -> None:
    data = BVH.replace(b"End Site", written)
    if name is None:
        name = ""
    clip = read(FORMATS["bvh"], {"bvh": data}, ReadOptions())
    assert [site.name for joint in clip.head.skeleton.joints for site in joint.end_sites] == [name]
    assert np.array_equal(values(clip), values(read(FORMATS["bvh"], {"bvh": BVH}, ReadOptions())))


def test_comment_lines_of_bvh() -> None:
    data = b"# made by hand\n\n// and more\n" + BVH.replace(b"OFFSET", b"# a comment\nOFFSET", 2)
    lines = data.splitlines(keepends=True)
    data = b"".join([*lines[:-2], b"  # between frames\n", *lines[-2:], b"// at the end"])
    format_, part = find_format("a.bvh", data)
    assert (format_.name, part) == ("bvh", "bvh")
    clip = read(FORMATS["bvh"], {"bvh": data}, ReadOptions())
    assert np.array_equal(values(clip), values(read(FORMATS["bvh"], {"bvh": BVH}, ReadOptions())))
    assert "comment lines" in notices(clip)
    spoilt = data[:-40] + b" x" + data[-40:]
    with pytest.raises(FormatError) as caught:
        values(read(FORMATS["bvh"], {"bvh": spoilt}, ReadOptions()))
    assert caught.value.at is not None
    assert caught.value.at.line is not None
    assert b" x" in spoilt.splitlines()[caught.value.at.line - 1]


def test_frame_time_in_one_word() -> None:
    clip = read(FORMATS["bvh"], {"bvh": BVH.replace(b"Frame Time:", b"FrameTime:")}, ReadOptions())
    assert clip.head.frame_time == "0.0083333"
    assert len(values(clip)) == 3


def test_a_bvh_of_a_skeleton_alone() -> None:
    clip = read(FORMATS["bvh"], {"bvh": BVH[: BVH.index(b"MOTION")]}, ReadOptions())
    assert len(clip.head.skeleton) == 3
    assert clip.frames == 0
    assert list(clip.blocks()) == []
    assert "skeleton alone" in notices(clip)


def test_head_of_htr() -> None:
    data = HTR.replace(b"[Header]", b"[Head]")
    assert find_format("a.htr", data)[0].name == "htr"
    assert len(values(read(FORMATS["htr"], {"htr": data}, ReadOptions()))) == 2


def test_a_segment_of_htr_may_be_called_head() -> None:
    for data in (HTR, HTR.replace(b"[Header]", b"[Head]", 1)):
        clip = read(FORMATS["htr"], {"htr": data.replace(b"m:Hand", b"Head")}, ReadOptions())
        assert "Head" in clip.head.skeleton.names
        assert len(values(clip)) == 2


@pytest.mark.parametrize("separate", [lambda text: text.replace(b"\t", b","), lambda text: _semicolons(text)])
def test_trc_between_commas(separate: Callable[[bytes], bytes]) -> None:
    wanted = read(FORMATS["trc"], {"trc": TRC}, ReadOptions())
    data = separate(TRC)
    assert find_format("a.trc", data)[0].name == "trc"
    clip = read(FORMATS["trc"], {"trc": data}, ReadOptions())
    assert clip.head.skeleton.names == wanted.head.skeleton.names
    assert clip.head.fields["calibration_unit"] == "mm"
    assert np.array_equal(values(clip), values(wanted), equal_nan=True)
    assert "commas" in notices(clip)


def _semicolons(text: bytes) -> bytes:
    first, _, rest = text.partition(b"\n")
    return first.replace(b"\t", b";") + b"\n" + rest.replace(b".", b",").replace(b"\t", b";")


def mended(files: dict[str, bytes], *names: str) -> ClipStream:
    sources = {part: SourceFile(f"a.{part}", io.BytesIO(data)) for part, data in files.items()}
    found, told = repaired(sources, names)
    assert told
    return FORMATS["bvh" if "bvh" in files else "asf-amc"].read(found, ReadOptions())


def offered(files: dict[str, bytes]) -> list[str]:
    return offers({part: SourceFile(f"a.{part}", io.BytesIO(data)) for part, data in files.items()})


def test_decimal_commas() -> None:
    data = BVH.replace(b".", b",")
    with pytest.raises(FormatError, match="decimal comma"):
        values(read(FORMATS["bvh"], {"bvh": data}, ReadOptions()))
    assert offered({"bvh": data}) == ["decimal-commas"]
    clip = mended({"bvh": data}, "decimal-commas")
    assert clip.head.frame_time == "0.0083333"
    assert np.array_equal(values(clip), values(read(FORMATS["bvh"], {"bvh": BVH}, ReadOptions())))


@pytest.mark.parametrize("word", [b"nan", b"-NaN", b"1.#QNAN", b"-1.#IND00", b"inf"])
def test_what_is_no_number_is_missing_when_asked(word: bytes) -> None:
    lines = BVH.splitlines()
    words = lines[-2].split()
    words[1], words[-1] = word, word
    data = b"\n".join([*lines[:-2], b" ".join(words), lines[-1], b""])
    with pytest.raises(FormatError):
        values(read(FORMATS["bvh"], {"bvh": data}, ReadOptions()))
    assert offered({"bvh": data}) == ["missing-samples"]
    clip = mended({"bvh": data}, "missing-samples")
    wanted = values(read(FORMATS["bvh"], {"bvh": BVH}, ReadOptions()))
    wanted[1, 1] = wanted[1, -1] = np.nan
    assert np.array_equal(values(clip), wanted, equal_nan=True)
    [block] = list(clip.blocks())
    assert len(block.shapes) == 2


def test_whole_frames_are_offered_where_they_keep_some() -> None:
    assert offered({"bvh": bvh(9)[:-30]}) == ["whole-frames"]
    assert offered({"bvh": bvh(1)[:-30]}) == []


ZEROS = amc(3).replace(b"lfemur", b"lhipjoint 0 0.0 -0\nlfemur")


def test_zeros_of_bones_without_dof_are_no_fault() -> None:
    clip = read(FORMATS["asf-amc"], {"asf": ASF, "amc": ZEROS}, ReadOptions())
    assert np.array_equal(values(clip), values(read(FORMATS["asf-amc"], {"asf": ASF, "amc": amc(3)}, ReadOptions())))
    assert "zeros of bones without degrees of freedom" in notices(clip)
    with pytest.raises(FormatError) as caught:
        values(read(FORMATS["asf-amc"], {"asf": ASF, "amc": ZEROS.replace(b" 0.0 ", b" 0.1 ")}, ReadOptions()))
    assert "FORCE-ALL-JOINTS-BE-3DOF" in (caught.value.remedy or "")


def test_three_values_of_each_bone_are_meant_in_two_ways() -> None:
    rows = amc(3).splitlines()
    three = b"\n".join(row + b" 0.5 0.25" if row.startswith(b"ltibia") else row for row in rows) + b"\n"
    files = {"asf": ASF, "amc": three}
    with pytest.raises(FormatError, match="3 values") as caught:
        values(read(FORMATS["asf-amc"], files, ReadOptions()))
    assert "FORCE-ALL-JOINTS-BE-3DOF" in (caught.value.remedy or "")
    assert offered(files) == ["stated-dof", "three-dof"]
    plain = values(read(FORMATS["asf-amc"], {"asf": ASF, "amc": amc(3)}, ReadOptions()))
    assert np.array_equal(values(mended(files, "stated-dof")), plain)
    clip = mended(files, "three-dof")
    shin = next(joint for joint in clip.head.skeleton.joints if joint.source_name == "ltibia")
    assert shin.channels == ("Rx", "Ry", "Rz")
    assert values(clip)[:, -2:].tolist() == [[0.5, 0.25]] * 3


def test_a_real_export_with_three_values(shared: Path) -> None:
    folder = shared / "asfamc" / "cmu16"
    files = {"asf": (folder / "16.asf").read_bytes(), "amc": (folder / "16_11.amc").read_bytes()}
    with pytest.raises(FormatError, match="3 values"):
        values(read(FORMATS["asf-amc"], files, ReadOptions()))
    assert offered(files) == ["stated-dof", "three-dof"]
    assert values(mended(files, "stated-dof")).shape == (250, 62)
    assert len(values(mended(files, "three-dof"))) == 250
