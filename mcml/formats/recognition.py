"""Recognise the format of a file, and choose the error for unsupported files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from mcml.errors import FormatError, McmlError, Place, UnsupportedError
from mcml.formats.format import Reader
from mcml.formats.other_formats import TO_BVH, other_format
from mcml.formats.text.lines import utf16_codec

UNSUPPORTED: Final[Mapping[str, str]] = {
    "aoa": "Adaptive Optics: a tracker's raw points with no public grammar and no files to be found",
    "bva": "Biovision: global positions and angles of bones without hierarchy; every known file also exists as BVH",
    "ask-sdl": "Biovision/Alias: an Alias scene beside BVA, of a program that is no longer made",
    "skl-mot": "Acclaim-Motion Analysis: never published; the makers themselves moved to HTR",
    "brd": "LambSoft Magnetic: binary output of a magnetic tracker, layout not published",
    "dat": "Polhemus: a tracker's raw sensor records, different for every device setting",
    "asc": "Ascension: a tracker's raw sensor records, different for every device setting",
    "gtr": "Motion Analysis: HTR with global data and no hierarchy; the skeleton cannot be known",
}
"""Formats that the founding paper names in its section 3 (and GTR) and that are not read, with the reason."""

_EXTENSIONS = {
    ".bva": "bva",
    ".ask": "ask-sdl",
    ".sdl": "ask-sdl",
    ".skl": "skl-mot",
    ".mot": "skl-mot",
    ".brd": "brd",
    ".gtr": "gtr",
}
_LFS: Final = b"version https://git-lfs.github.com/spec/"
_WRITTEN: Final = ((rb"(?s).*\ninDegrees=(yes|no)\s", "OpenSim's MOT and STO"),)
"""How files begin that are written and not read."""
_TITLES = {"ask-sdl": "ASK/SDL", "skl-mot": "SKL/MOT"}
_READ: Final = "Send FBX, glTF, VRM, USD, AMASS npz, MVNX, ARKit CSV, BVH, ASF with AMC, HTR, C3D, TRC or MCML."


def recognise(formats: Mapping[str, Reader], file_name: str, first_bytes: bytes) -> tuple[Reader, str]:
    """(format, part) of a file; see `mcml.formats.find_format`."""
    at = Place(file=file_name)
    if not first_bytes.strip(b" \t\r\n\v\f\xef\xbb\xbf"):
        raise FormatError("the file is empty", at=at, remedy="Send the motion file itself.")
    if utf16_codec(first_bytes) is not None:
        raise FormatError("the file is UTF-16 text", at=at, remedy="Save it as UTF-8.")
    if first_bytes.startswith(_LFS):
        raise FormatError(
            "this is a git-lfs pointer, not the motion file", at=at, remedy="Run `git lfs pull` and send the file."
        )
    known = _unsupported_content(first_bytes)
    if known is not None:
        raise _not_read(known, at)
    other = other_format(first_bytes)
    for format in formats.values():
        part = format.sniff(file_name, first_bytes)
        # The mark of C3D is one byte, which a PNG has in its place.
        if part is not None and (other is None or format.name != "c3d"):
            return format, part
    if other is not None:
        title, remedy = other
        raise UnsupportedError(f"{title} files are not read", at=at, remedy=remedy)
    for beginning, title in _WRITTEN:
        if re.match(beginning, first_bytes):
            raise UnsupportedError(f"{title} files are written, not read", at=at, remedy=TO_BVH)
    if b"\0" in first_bytes:
        raise _binary(file_name, first_bytes, at)
    for extension, name in _EXTENSIONS.items():
        if file_name.lower().endswith(extension):
            raise _not_read(name, at)
    raise _unknown(formats, file_name, first_bytes, at)


def _unsupported_content(first_bytes: bytes) -> str | None:
    if re.search(rb"(?im)^[ \t]*FileType[ \t]+gtr\b", first_bytes):
        return "gtr"
    return None


def _not_read(name: str, at: Place) -> McmlError:
    title = _TITLES.get(name, name.upper())
    return UnsupportedError(f"{title} files are not read: {UNSUPPORTED[name]}", at=at, remedy=_READ)


def _binary(file_name: str, first_bytes: bytes, at: Place) -> McmlError:
    for extension, name in _EXTENSIONS.items():
        if file_name.lower().endswith(extension):
            return _not_read(name, at)
    return FormatError("the file is binary, no motion format is recognised", at=at, remedy=_READ)


def _unknown(formats: Mapping[str, Reader], file_name: str, first_bytes: bytes, at: Place) -> McmlError:
    """Return the error for an unrecognised file: from the reader of the format that its name suggests, if any."""
    line = next((line.strip() for line in re.split(rb"[\r\n]+", first_bytes) if line.strip()), b"")
    shown = line[:40].decode("utf-8", errors="replace")
    expected = {
        ".bvh": "not a BVH file: expected HIERARCHY",
        ".asf": "ASF section :bonedata is missing: expected sections such as :root",
        ".amc": "not an AMC file: expected a frame number or flags such as :DEGREES",
        ".htr": "HTR section [Header] is missing",
        ".htr2": "HTR section [Header] is missing",
        ".trc": "not a TRC file: expected PathFileType",
    }
    for extension, what in expected.items():
        if file_name.lower().endswith(extension):
            return FormatError(f"{what}, found {shown!r}", at=Place(file=at.file, line=1), remedy="Check the file.")
    names = ", ".join(format.title for format in formats.values())
    return UnsupportedError(
        f"the file has none of the supported formats ({names}); it begins with {shown!r}", at=at, remedy=_READ
    )
