"""Uploads as people send them: archives in archives, files of other programs, names in every way."""

from __future__ import annotations

import gzip
import io
import struct
import tarfile
import zipfile
import zlib
from typing import Any

import py7zr
import pytest
from fastapi.testclient import TestClient

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF, TRC, amc, bvh, one_kind, served

pytestmark = pytest.mark.above_store

API = "/api/v1"


def send(client: TestClient, name: str, content: bytes) -> Any:
    return client.post(f"{API}/documents", files=[("file", (name, content))])


def zipped(files: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def tarred(files: dict[str, bytes], **options: Any) -> bytes:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", **options) as archive:
        for name, content in files.items():
            info = tarfile.TarInfo(name)
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
        archive.addfile(_link())
    return buffer.getvalue()


def packed_7z(files: dict[str, bytes], password: str | None = None, **options: Any) -> bytes:
    buffer = io.BytesIO()
    with py7zr.SevenZipFile(buffer, "w", password=password, **options) as archive:
        for name, content in files.items():
            archive.writestr(content, name)
    return buffer.getvalue()


def _link() -> tarfile.TarInfo:
    info = tarfile.TarInfo("passwd.bvh")
    info.type, info.linkname = tarfile.SYMTYPE, "/etc/passwd"
    return info


TWO = {"one/leg.asf": ASF, "one/leg.amc": amc(2), "two/leg.asf": ASF, "two/leg.amc": amc(3)}


@pytest.mark.parametrize(
    ("name", "content", "names"),
    [
        ("walk.bvh.gz", gzip.compress(bvh(2)), ["walk"]),
        ("walk.gz", gzip.compress(bvh(2)), ["walk"]),
        ("all.tar", tarred({"./a.bvh": bvh(2), "b/c.bvh": bvh(3)}), ["a", "c"]),
        ("all.tar.gz", gzip.compress(tarred({"a.bvh": bvh(2), "b.bvh": bvh(3)})), ["a", "b"]),
        ("all.tgz", gzip.compress(tarred({"a.bvh": bvh(2)})), ["a"]),
        ("all.zip", zipped({"in.zip": zipped({"a.bvh": bvh(2)}), "b.bvh": bvh(3)}), ["a", "b"]),
        ("all.zip", zipped({"a.bvh.gz": gzip.compress(bvh(2))}), ["a"]),
        ("all.zip", zipped({"one.zip": zipped(dict(list(TWO.items())[:2])), "two.zip": zipped(TWO)}), ["leg"] * 3),
        ("all.7z", packed_7z({"a.bvh": bvh(2), "걷기.bvh": bvh(3), "b/.DS_Store": b"x"}), ["a", "걷기"]),
        ("all", packed_7z({"a.bvh": bvh(2)}, filters=[{"id": py7zr.FILTER_PPMD, "order": 6, "mem": 24}]), ["a"]),
        ("legs.7z", packed_7z(TWO), ["leg", "leg"]),
        ("in.zip", zipped({"one.7z": packed_7z(dict(list(TWO.items())[:2])), "b.bvh": bvh(3)}), ["b", "leg"]),
        ("legs.tar.gz", gzip.compress(tarred(TWO)), ["leg", "leg"]),
        ("korean.tar", tarred({"걷기.bvh": bvh(2)}, encoding="cp949", format=tarfile.GNU_FORMAT), ["걷기"]),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@one_kind
def test_archives_are_read(client: TestClient, name: str, content: bytes, names: list[str]) -> None:
    answer = send(client, name, content)
    assert answer.status_code == 201, answer.text
    assert sorted(item["name"] for item in answer.json()["documents"]) == names
    assert answer.json()["problems"] == []


@pytest.mark.parametrize("files", [{"walk.bvh": bvh(2)}, {"leg.asf": ASF, "leg.amc": amc(2)}, {"hand.trc": TRC}])
@pytest.mark.parametrize("name", ["all.zip", "all"])
@one_kind
def test_archives_that_are_not_compressed_are_read(client: TestClient, name: str, files: dict[str, bytes]) -> None:
    """The text of their first file stands near the beginning, where formats are recognised."""
    answer = send(client, name, zipped(files, zipfile.ZIP_STORED))
    assert answer.status_code == 201, answer.text
    assert answer.json()["problems"] == []
    assert [item["name"] for item in answer.json()["documents"]] == [list(files)[-1].partition(".")[0]]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.zip", zipped({})),
        ("litter.zip", zipped({"__MACOSX/._a.bvh": b"x", ".DS_Store": b"x"})),
        ("folder.zip", zipped({"a/": b""})),
        ("empty.tar", tarred({})),
        ("in.zip", zipped({"in.zip": zipped({})})),
        ("cut.gz", gzip.compress(bvh(2))[:-20]),
        ("cut.tar.gz", gzip.compress(tarred({"a.bvh": bvh(900)})[:4000])),
        ("cut.zip", zipped({"a.bvh": bvh(2)})[:-30]),
        ("cut.7z", packed_7z({"a.bvh": bvh(900)})[:-30]),
        ("head.7z", b"7z\xbc\xaf\x27\x1c\0\4"),
        ("broken.7z", packed_7z({"a.bvh": bvh(900)}).replace(b"\x5d", b"\x5c")),
        ("empty.7z", packed_7z({})),
        ("litter.7z", packed_7z({".DS_Store": b"x"})),
    ],
)
@one_kind
def test_archives_without_files_are_refused(client: TestClient, name: str, content: bytes) -> None:
    answer = send(client, name, content)
    assert answer.status_code == 422, answer.text
    assert answer.json()["remedy"]


@one_kind
@pytest.mark.parametrize("names", [False, True])
def test_encrypted_7z_is_refused(client: TestClient, names: bool) -> None:
    answer = send(client, "a.7z", packed_7z({"a.bvh": bvh(2)}, password="secret", header_encryption=names))
    assert answer.status_code == 422
    assert answer.json()["detail"] == "The 7z archive is encrypted."
    assert "without a password" in answer.json()["remedy"]


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (packed_7z({"a.bvh": bytes(40 << 20)}), "unpacks to more"),
        (packed_7z({f"{number}.bvh": b"" for number in range(30)}), "holds 30 files"),
        (packed_7z({"a.bvh": bytes(40 << 20)}, filters=[{"id": py7zr.FILTER_ZSTD, "level": 3}]), "unpacks to more"),
    ],
)
@one_kind
def test_7z_is_bounded(database: Database, content: bytes, word: str) -> None:
    settings = Settings(max_zip_ratio=20, max_zip_files=20)
    with served(database, settings) as client:
        answer = send(client, "bomb.7z", content)
    assert answer.status_code == 422, answer.text
    assert word in answer.json()["detail"]


@one_kind
def test_the_memory_of_7z_is_bounded(client: TestClient) -> None:
    """A dictionary of 3 GiB is refused before it is filled."""
    filters = [{"id": py7zr.FILTER_LZMA2, "dict_size": 1 << 20}]
    content = packed_7z({"a.bvh": bvh(2)}, filters=filters)
    answer = send(client, "large.7z", _with_dictionary(content, 39))
    assert answer.status_code == 422, answer.text
    assert "MiB of memory" in answer.json()["detail"]


def _with_dictionary(content: bytes, size: int) -> bytes:
    """The archive with another size of its dictionary. size: as LZMA2 codes it."""
    (start,) = struct.unpack("<Q", content[12:20])
    with py7zr.SevenZipFile(io.BytesIO(content)) as archive:
        archive.header.main_streams.unpackinfo.folders[0].coders[0]["properties"] = bytes([size])
        written = io.BytesIO()
        written.write(content[: 32 + start])
        written.seek(0, io.SEEK_END)
        archive.header.write(written, 32, encoded=False)
    header = written.getvalue()[32 + start :]
    facts = struct.pack("<QQI", start, len(header), zlib.crc32(header))
    return content[:8] + struct.pack("<I", zlib.crc32(facts)) + facts + content[32 : 32 + start] + header


@one_kind
def test_without_py7zr_the_remedy_installs_it(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcml.files.members_7z.find_spec", lambda name: None)
    answer = send(client, "a.7z", packed_7z({"a.bvh": bvh(2)}))
    assert answer.status_code == 415
    assert "pip install 'mcml-repository[7z]'" in answer.json()["remedy"]


@one_kind
def test_archives_within_each_other_are_bounded(client: TestClient) -> None:
    content = bvh(2)
    for _ in range(3):
        content = zipped({"in.zip" if content[:2] == b"PK" else "a.bvh": content})
    assert send(client, "deep.zip", content).status_code == 201
    for _ in range(2):
        content = zipped({"in.zip": content})
    answer = send(client, "deep.zip", content)
    assert answer.status_code == 422
    assert "deep" in answer.json()["detail"]


@pytest.mark.slow
@pytest.mark.parametrize("pack", ["gz", "tar.gz", "zip in zip", "gz in gz"])
@one_kind
def test_bombs_are_refused(client: TestClient, pack: str) -> None:
    zeros = bytes(80 << 20)
    inner = gzip.compress(zeros)
    content = {
        "gz": lambda: inner,
        "tar.gz": lambda: gzip.compress(tarred({"a.bvh": zeros})),
        "zip in zip": lambda: zipped({"in.zip": zipped({"a.bvh": zeros})}),
        "gz in gz": lambda: gzip.compress(inner),
    }[pack]()
    answer = send(client, "a.bvh.gz" if "gz" in pack else "a.zip", content)
    assert answer.status_code == 422, answer.text
    assert "limits allow" in answer.json()["detail"]


@one_kind
def test_many_files_in_many_archives_are_counted_together(database: Database) -> None:
    few = Settings(max_zip_files=5)
    content = zipped({f"{number}.zip": zipped({"a.bvh": bvh(1), "b.bvh": bvh(1)}) for number in range(3)})
    with served(database, few) as client:
        answer = send(client, "a.zip", content)
        said = [answer.json()["detail"]] if answer.status_code != 201 else [str(answer.json()["problems"])]
        assert "the limit is 5" in said[0]


@pytest.mark.parametrize(
    ("disposition", "name"),
    [
        (b"filename*=UTF-8''%EA%B1%B7%EA%B8%B0.bvh", "걷기"),
        (b"filename*=utf-8'ko'%EA%B1%B7%EA%B8%B0.bvh", "걷기"),
        (b"filename*=EUC-KR''%B0%C8%B1%E2.bvh", "걷기"),
        (b"filename*=\"UTF-8''%EA%B1%B7%EA%B8%B0.bvh\"", "걷기"),
        (b"filename=\"walk.bvh\"; filename*=UTF-8''%EA%B1%B7%EA%B8%B0.bvh", "walk"),
        ('filename="걷기.bvh"'.encode(), "걷기"),
        ("filename=걷기.bvh".encode(), "걷기"),
        ('filename="걷기.bvh"'.encode("cp949"), "걷기"),
        ('filename="Hüfte.bvh"'.encode("latin-1"), "Hüfte"),
        (b"filename*=no-such''%EA%B1%B7%EA%B8%B0.bvh", "걷기"),
    ],
)
def test_names_of_files(client: TestClient, disposition: bytes, name: str) -> None:
    head = b'--B\r\nContent-Disposition: form-data; name="file"; ' + disposition
    body = head + b"\r\nContent-Type: application/octet-stream\r\n\r\n" + bvh(2) + b"\r\n--B--\r\n"
    form = {"content-type": "multipart/form-data; boundary=B"}
    answer = client.post(f"{API}/documents", content=body, headers=form)
    assert answer.status_code == 201, answer.text
    assert answer.json()["documents"][0]["name"] == name


@pytest.mark.parametrize(
    ("content", "title", "remedy"),
    [
        (b"Vocaloid Motion Data 0002\0\0", "VMD", "MMD Tools"),
        (b'<?xml version="1.0"?><!-- x --><COLLADA xmlns="a">', "COLLADA", "Blender"),
        (b"Rar!\x1a\x07\1\0", "RAR", "Unpack"),
        (b"\x89PNG\r\n\x1a\n\0\0", "image", "the motion file itself"),
        (b"\x89PNG\r\n\x1a\n" + bytes(600), "image", "the motion file itself"),
        (b"<!DOCTYPE html>\n<html><head>", "web page", "Download"),
        (b"\n <!-- saved -->\n<HTML lang='ko'>", "web page", "Download"),
        (b"<!doctype HTML PUBLIC 'x'><p>", "web page", "Download"),
        (b"\xef\xbb\xbf<html>", "web page", "Download"),
    ],
)
@pytest.mark.parametrize("name", ["walk.bvh", "walk", "walk.zip"])
@one_kind
def test_files_of_other_programs_are_named(
    client: TestClient, name: str, content: bytes, title: str, remedy: str
) -> None:
    answer = send(client, name, content)
    assert answer.status_code in (415, 422), answer.text
    assert title in answer.json()["detail"]
    assert remedy in answer.json()["remedy"]


@pytest.mark.parametrize(
    ("content", "title"),
    [
        (b"Kaydara FBX Binary  \0\x1a\0", "FBX"),
        (b"; FBX 7.4.0 project file\n", "FBX"),
        (b'<?xml version="1.0"?>\n<mvnx version="4">', "MVNX"),
        (b'{"asset": {"version": "2.0"}}', "glTF"),
        (b"glTF\2\0\0\0", "GLB"),
        (b"PXR-USDC\0\0", "USD"),
    ],
)
@pytest.mark.parametrize("name", ["walk.bvh", "walk", "walk.zip"])
@one_kind
def test_damaged_files_are_named_by_their_content(client: TestClient, name: str, content: bytes, title: str) -> None:
    answer = send(client, name, content)
    assert answer.status_code == 422, answer.text
    assert title in answer.json()["detail"]
    assert answer.json()["remedy"]
