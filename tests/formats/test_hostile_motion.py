"""Files made to exhaust a reader: refused, or read, quickly and within bounds."""

from __future__ import annotations

import io
import tracemalloc

import pytest

from mcml.errors import McmlError
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile

BVH = b"HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xposition\n}\nMOTION\nFrames: 1000000\nFrame Time: 1\n"
BODY = b"{\nOFFSET 0 0 0\n}\n"
ASF = b":root\norder TX\n:bonedata\n"
LEG = ASF + b"begin\nname a\nlength 1\ndirection 0 1 0\ndof rx\nend\n:hierarchy\nroot a\n"
HTR = (
    b"[Header]\nFileType htr\nNumSegments 1\nNumFrames 1000000\n[SegmentNames&Hierarchy]\na GLOBAL\n"
    b"[BasePosition]\na 0 0 0 0 0 0 0\n"
)

REFUSED = {
    "one number of a million digits": ("bvh", {"bvh": BVH + b"1" * 3_000_000}),
    "one word of signs": ("bvh", {"bvh": BVH + b"1-" * 1_000_000}),
    "nothing but blanks": ("bvh", {"bvh": BVH + b" " * 5_000_000}),
    "blanks in place of a name": ("bvh", {"bvh": b"HIERARCHY\nROOT " + b" " * 900_000 + b"x" + b"{" * 90_000}),
    "braces without end": ("bvh", {"bvh": b"HIERARCHY\nROOT " + b"x {" * 300_000}),
    "more end sites than joints": (
        "bvh",
        {"bvh": b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\n" + b"End Site\n{\nOFFSET 1 1 1\n}\n" * 12_000},
    ),
    "more roots than joints": ("bvh", {"bvh": b"HIERARCHY\n" + (b"ROOT a\n" + BODY) * 10_001}),
    "comments without end": ("asf-amc", {"asf": b"#x\n" * 100_000}),
    "sections without end": ("asf-amc", {"asf": b":x\n" * 100_000}),
    "limits without end": ("asf-amc", {"asf": ASF + b"begin\nname a\nlimits " + b"1 2 \n" * 100_000}),
    "a hierarchy without end": ("asf-amc", {"asf": ASF + b":hierarchy\n" + b"a b\n" * 50_000}),
    "unknown fields without end": ("asf-amc", {"asf": ASF + b"begin\n" + b"colour red\n" * 25_000}),
    "a frame without end": ("asf-amc", {"asf": LEG, "amc": b"1\n" + b"x" * 18_000_000}),
    "segments without end": ("htr", {"htr": HTR + b"".join(b"[a%d]\n" % i for i in range(50_000))}),
    "the same segment again and again": ("htr", {"htr": HTR + b"[a]\n" * 40_000}),
    "a line without end": ("htr", {"htr": HTR + b"[a]\n" + b"1 " * 2_000_000}),
    "keywords without end": ("htr", {"htr": b"[Header]\n" + b"x y\n" * 200_000}),
}


@pytest.mark.slow
@pytest.mark.timeout(20)
@pytest.mark.parametrize("title", REFUSED)
def test_refused_in_time_and_memory(title: str) -> None:
    name, files = REFUSED[title]
    tracemalloc.start()
    with pytest.raises(McmlError) as error:
        _read(name, files)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(str(error.value)) < 400
    assert peak < 60_000_000


@pytest.mark.timeout(20)
def test_ten_thousand_equal_names_are_read() -> None:
    joint = b"JOINT same\n{\nOFFSET 1 0 0\nCHANNELS 1 Xposition\n}\n"
    data = (
        b"HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\n"
        + joint * 9_999
        + b"}\nMOTION\nFrames: 2\nFrame Time: 1\n"
        + b"1 " * 19_998
    )
    assert _read("bvh", {"bvh": data}) == 2


@pytest.mark.timeout(20)
def test_frames_without_channels_need_no_memory() -> None:
    still = b"HIERARCHY\nROOT r\n" + BODY + b"MOTION\nFrames: 50000000\nFrame Time: 1\n"
    assert _read("bvh", {"bvh": still}) == 50_000_000


def _read(name: str, files: dict[str, bytes]) -> int:
    sources = {part: SourceFile(part, io.BytesIO(data)) for part, data in files.items()}
    clip = FORMATS[name].read(sources, ReadOptions())
    return sum(len(block) for block in clip.blocks())
