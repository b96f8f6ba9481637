"""Names in zips that do not say how they are encoded."""

from __future__ import annotations

import io
import struct
import unicodedata
import zipfile
import zlib

import pytest

from mcml.files.gather_files import gathered
from mcml.files.limits import FileLimits
from mcml.formats.format import SourceFile
from tests.builders import bvh


def zip_of(names: list[bytes], flag: int = 0, extra: bytes = b"") -> bytes:
    """A zip whose names are these bytes, with or without the flag of UTF-8."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for number, name in enumerate(names):
            info = zipfile.ZipInfo("x" * (len(name) - 1) + str(number))
            info.extra = extra
            archive.writestr(info, bvh(2, seed=number))
    data = bytearray(buffer.getvalue())
    for number, name in enumerate(names):
        placeholder = b"x" * (len(name) - 1) + str(number).encode()
        place = -1
        for head, at in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
            place = data.find(placeholder, place + 1)
            start = data.rfind(head, 0, place)
            data[start + at + 1] |= flag
            data[place : place + len(name)] = name
    return bytes(data)


def names_of(data: bytes) -> tuple[list[str], str]:
    with gathered([SourceFile("all.zip", io.BytesIO(data))], FileLimits()) as found:
        assert not found.problems
        files = [file for clip in found.clips for file in clip.files.values()]
        said = {notice.what for file in files for notice in file.notices}
        return [file.name for file in files], "".join(said)


@pytest.mark.parametrize(
    ("codec", "names"),
    [
        ("cp949", ["걷기.bvh", "춤/춤추는 사람.bvh"]),
        ("cp949", ["걷기.bvh"]),
        ("cp932", ["歩行.bvh", "踊り/ダンス.bvh"]),
        ("cp950", ["走路.bvh", "跳舞/左腳.bvh"]),
        ("gb18030", ["走路.bvh", "头部.bvh"]),
        ("utf-8", ["걷기.bvh", "歩行.bvh", "Hüfte.bvh"]),
        ("cp437", ["Hüfte.bvh", "Bär.bvh"]),
    ],
)
def test_names_without_the_flag(codec: str, names: list[str]) -> None:
    found, said = names_of(zip_of([name.encode(codec) for name in names]))
    assert found == names
    for tried in ("UTF-8", "CP949", "Shift-JIS", "Big5", "CP437", "most plausible as"):
        assert tried in said


def test_names_with_the_flag_and_of_ascii_are_not_guessed() -> None:
    assert names_of(zip_of(["걷기.bvh".encode()], flag=8)) == (["걷기.bvh"], "")
    assert names_of(zip_of([b"walk.bvh", b"a\\b.bvh"])) == (["walk.bvh", "a/b.bvh"], "")


def test_names_of_macos_are_composed() -> None:
    assert names_of(zip_of([unicodedata.normalize("NFD", "걷기 é.bvh").encode()]))[0] == ["걷기 é.bvh"]


def test_the_extra_field_of_unicode_counts() -> None:
    raw = b"____.bvh"
    path = "걷기.bvh".encode()
    content = b"\1" + struct.pack("<I", zlib.crc32(raw)) + path
    extra = struct.pack("<HH", 0x7075, len(content)) + content
    assert names_of(zip_of([raw], extra=extra)) == (["걷기.bvh"], "")
    assert names_of(zip_of([b"other.bv"], extra=extra))[0] == ["other.bv"]
