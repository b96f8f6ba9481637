"""Bad input over HTTP: a problem that says what, where and how to mend it; nothing stored; bounded."""

from __future__ import annotations

import io
import random
import zipfile

import pytest
from fastapi.testclient import TestClient

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF, HTR, MCML, amc, bvh, served

pytestmark = pytest.mark.above_store

API = "/api/v1"

BOMB = b"""<?xml version="1.0"?><!DOCTYPE mcml [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]><mcml version="1.0"><header><filename>&c;</filename></header></mcml>"""
EXTERNAL = b"""<?xml version="1.0"?><!DOCTYPE mcml [<!ENTITY x SYSTEM "file:///etc/passwd">]>
<mcml version="1.0"><header><filename>&x;</filename></header><skeleton/><motion><frames>0</frames></motion></mcml>"""
OTHER_DTD = MCML.replace(b'"mcml.dtd"', b'"http://evil.example/mcml.dtd"')

REFUSED = {
    "lfs.bvh": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12\n",
    "empty.bvh": b"",
    "zeros.bvh": b"\0" * 4096,
    "picture.bvh": b"\x89PNG\r\n\x1a\n" + bytes(range(256)),
    "frames.bvh": bvh(3).replace(b"Frames: 3", b"Frames: 99999999999"),
    "negative.bvh": bvh(3).replace(b"Frames: 3", b"Frames: -1"),
    "nan.bvh": bvh(3)[:-20] + b" nan nan\n",
    "inf.bvh": bvh(1, names=("Hips",)).rsplit(b"\n", 2)[0] + b"\ninf 0 0 0 0 0\n",
    "comma.bvh": bvh(1, names=("Hips",)).rsplit(b"\n", 2)[0] + b"\n0,5 0 0 0 0 0\n",
    "deep.bvh": b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n" + b"JOINT b\n{\nOFFSET 0 0 0\nCHANNELS 0\n" * 5000,
    "wide.bvh": b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n"
    + b"JOINT b\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\n" * 20000,
    "name.bvh": bvh(2).replace(b"Spine", b"Sp\x07ne"),
    "long_name.bvh": bvh(2).replace(b"Spine", b"S" * 100_000),
    "alone.amc": amc(),
    "broken.asf": ASF.replace(b":hierarchy", b":nothing"),
    "order.htr": HTR.replace(b"ZYX", b"ZZX"),
    "global.htr": HTR.replace(b"FileType htr", b"FileType gtr"),
    "bomb.mcml": BOMB,
    "external.mcml": EXTERNAL,
    "dtd.mcml": OTHER_DTD,
    "nan.mcml": MCML.replace(b'Rx="10"', b'Rx="NaN"'),
    "bone.mcml": MCML.replace(b'<frame_bone name="Root"', b'<frame_bone name="tail"', 1),
    "count.mcml": MCML.replace(b"<frames>3<", b"<frames>4<"),
    "cut.mcml": MCML[:-30],
    "page.mcml": b"<!doctype html><html><body>no</body></html>",
    "text.txt": b"just words",
    "points.trc": b"PathFileType\t4\t(X/Y/Z)\tx.trc\n",
}


def assert_refused(client: TestClient, name: str, content: bytes) -> dict[str, object]:
    answer = client.post(f"{API}/documents", files=[("file", (name, content))])
    assert answer.status_code in (413, 415, 422), (name, answer.text)
    assert answer.headers["content-type"] == "application/problem+json"
    problem: dict[str, object] = answer.json()
    assert problem["detail"]
    assert "Traceback" not in answer.text
    assert client.get(f"{API}/documents").json()["total"] == 0
    return problem


@pytest.mark.slow
def test_refused_with_a_reason(client: TestClient) -> None:
    for name, content in REFUSED.items():
        problem = assert_refused(client, name, content)
        assert problem["where"]["file"] == name  # type: ignore[index]
        assert "root:" not in str(problem), name


def test_random_bytes(client: TestClient) -> None:
    chance = random.Random(5)
    for number in range(30):
        head = chance.choice(
            [b"", b"HIERARCHY\n", b"# x\n[Header]\n", b":version 1\n", b"<mcml", b"PK\x03\x04", b"\xff\xfe<"]
        )
        assert_refused(client, f"{number}.bin", head + chance.randbytes(chance.randint(0, 3000)))


@pytest.mark.slow
def test_truncation_anywhere_stores_nothing_or_a_valid_document(client: TestClient) -> None:
    chance = random.Random(6)
    for whole in (bvh(2), HTR, MCML):
        for cut in sorted(chance.sample(range(len(whole)), 25)):
            answer = client.post(f"{API}/documents", files=[("file", ("cut", whole[:cut]))])
            assert answer.status_code in (201, 415, 422), answer.text
            if answer.status_code == 201:
                uuid = answer.json()["documents"][0]["id"]
                assert client.get(f"{API}/documents/{uuid}/mcml").status_code == 200


def packed(members: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return buffer.getvalue()


@pytest.mark.slow
def test_zip_bombs_are_refused(database: Database) -> None:
    settings = Settings(max_upload_bytes=30_000_000, max_zip_files=50, max_zip_ratio=100)
    with served(database, settings) as client:
        for name, content in {
            "ratio.zip": packed({"zeros.bvh": b"\0" * 20_000_000}),
            "sum.zip": packed({f"{n}.bvh": random.Random(n).randbytes(50_000) * 40 for n in range(20)}),
            "count.zip": packed({f"{n}.txt": b"x" for n in range(60)}),
            "cut.zip": packed({"a.bvh": bvh(3)})[:200],
            "nested.zip": packed({"a.zip": packed({"b.zip": packed({"c.zip": packed({"a.bvh": bvh(3)})})})}),
        }.items():
            assert_refused(client, name, content)


def test_names_of_files_cannot_leave_their_place(client: TestClient) -> None:
    for name in ("../../etc/passwd.bvh", "..\\x.bvh", "a\nb.bvh", 'q"uote.bvh', "x" * 500 + ".bvh"):
        answer = client.post(f"{API}/documents", files=[("file", (name, bvh(2)))])
        assert answer.status_code == 201, answer.text
        uuid = answer.json()["documents"][0]["id"]
        disposition = client.get(f"{API}/documents/{uuid}/export?format=mcml").headers["content-disposition"]
        assert "/" not in disposition.partition("filename=")[2].partition(";")[0]
        assert "\n" not in disposition
