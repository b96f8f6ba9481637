"""What a file is told to be, and what is said of one that is not read."""

from __future__ import annotations

import pytest

from mcml.errors import FormatError, UnsupportedError
from mcml.formats import NEEDED, READERS, UNSUPPORTED, WRITERS, find_format

LFS = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("a.bvh", b"HIERARCHY\nROOT Hips\n", ("bvh", "bvh")),
        ("a.txt", b"\n\n  hierarchy\r\nROOT Hips\n", ("bvh", "bvh")),
        ("a.amc", b"HIERARCHY\n", ("bvh", "bvh")),
        ("a.bvh", b"\xef\xbb\xbfHIERARCHY\n", ("bvh", "bvh")),
        ("a.asf", b"# only a comment\n:version 1.10\n", ("asf-amc", "asf")),
        ("a.txt", b":bonedata\n", ("asf-amc", "asf")),
        ("a.AMC", b"#!OML:ASF x.asf\n:FULLY-SPECIFIED\n1\n", ("asf-amc", "amc")),
        ("a.amc", b"1\nroot 1 2 3\n", ("asf-amc", "amc")),
        ("a.amc", b"# only a comment\n", ("asf-amc", "amc")),
        ("a.htr", b"# x\n[Header]\n", ("htr", "htr")),
        ("a.data", b"[HEADER] # x\nFileType htr\n", ("htr", "htr")),
        ("a.htr2", b"# a very long comment only", ("htr", "htr")),
    ],
)
def test_content_first_name_second(name: str, content: bytes, expected: tuple[str, str]) -> None:
    found, part = find_format(name, content)
    assert (found.name, part) == expected


@pytest.mark.parametrize(
    ("name", "content", "kind", "message"),
    [
        ("a.bvh", b"", FormatError, "the file is empty"),
        ("a.bvh", b" \n\t\n", FormatError, "the file is empty"),
        ("a.bvh", LFS, FormatError, "git-lfs pointer"),
        ("a.bvh", b"\x00\x01\x02HIERARCHY", FormatError, "binary"),
        *(
            (f"a.{kind}", text.encode(codec), FormatError, "UTF-16")
            for codec in ("utf-16", "utf-16-le", "utf-16-be")
            for kind, text in (("bvh", "HIERARCHY\n"), ("amc", "# OML\n:DEGREES"), ("trc", "PathFileType\t4"))
        ),
        ("a.bvh", b"MOTION\n", FormatError, "expected HIERARCHY, found 'MOTION'"),
        ("a.htr", b"[Base]\n", FormatError, "HTR section [Header] is missing"),
        ("a.asf", b"bones\n", FormatError, "ASF section"),
        ("a.amc", b"walk\n", FormatError, "expected a frame number"),
        ("a.trc", b"Frame#\tTime\n", FormatError, "expected PathFileType"),
        ("a.gtr", b"[Header]\nFileType gtr\n", UnsupportedError, "GTR"),
        ("a.bva", b"Segment: Hips\n", UnsupportedError, "BVA"),
        ("a.mot", b"x\n", UnsupportedError, "SKL/MOT"),
        ("a.mot", b"walk\nversion=1\nnRows=2\ninDegrees=yes\nendheader\n", UnsupportedError, "OpenSim's .* not read"),
        ("a.xyz", b"1;2;3\n", UnsupportedError, "none of the supported formats"),
        ("a.csv", b"1\n2\n", UnsupportedError, "none of the supported formats"),
    ],
)
def test_says_what_a_file_is_instead(name: str, content: bytes, kind: type[Exception], message: str) -> None:
    with pytest.raises(kind, match=message.replace("[", r"\[")) as error:
        find_format(name, content)
    assert error.value.at.file == name  # type: ignore[attr-defined]


def test_the_catalogue_is_named_by_its_keys() -> None:
    assert all(name == format.name for name, format in READERS.items())
    assert all(name == format.name for name, format in WRITERS.items())
    assert not set(WRITERS) & set(UNSUPPORTED)
    assert set(NEEDED) <= set(WRITERS)


def test_no_two_ways_out_share_an_extension() -> None:
    extensions = [extension for format in WRITERS.values() for part in format.parts for extension in part.extensions]
    assert len(set(extensions)) == len(extensions)


def test_every_format_of_the_paper_is_read_or_refused_with_a_reason() -> None:
    """Section 3 names: AOA, C3D, TRC; BVH, BVA, ASK/SDL, HTR, ASF/AMC, SKL/MOT, BRD, DAT, ASC."""
    named = {"aoa", "c3d", "trc", "bvh", "bva", "ask-sdl", "htr", "asf-amc", "skl-mot", "brd", "dat", "asc"}
    assert named <= set(READERS) | set(UNSUPPORTED)
    assert all(reason for reason in UNSUPPORTED.values())
