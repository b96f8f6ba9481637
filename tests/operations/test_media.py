"""Reference video and audio: kept as it came, served in ranges, gone with its document."""

from __future__ import annotations

import numpy as np
import pytest
from fastapi.testclient import TestClient
from httpx import Response
from sqlalchemy import text

from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.storage.database import Database
from tests.builders import bvh, store

pytestmark = pytest.mark.above_store

API = "/api/v1/documents"
MP4 = b"\x00\x00\x00\x20ftypisom" + np.random.default_rng(0).bytes(20 << 17)


@pytest.fixture
def uuid(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(3)})[0]


def uploads(database: Database) -> int:
    with database.read() as tx:
        return int(tx.connection.execute(text("SELECT COUNT(*) FROM upload")).scalar_one())


def put(client: TestClient, uuid: str, content: bytes = MP4, **form: object) -> dict[str, object]:
    answer = client.put(f"{API}/{uuid}/media", files={"file": ("take 3.mp4", content)}, data=form)
    assert answer.status_code == 200, answer.text
    found: dict[str, object] = answer.json()
    return found


def test_it_is_served_in_ranges(client: TestClient, database: Database, uuid: str) -> None:
    said = put(client, uuid, offset=1.25)
    assert (said["media_type"], said["bytes"], said["offset"]) == ("video/mp4", len(MP4), 1.25)
    assert client.get(f"{API}/{uuid}").json()["media"] == said
    whole = client.get(f"{API}/{uuid}/media")
    assert (whole.content, whole.headers["content-type"], whole.headers["accept-ranges"]) == (MP4, "video/mp4", "bytes")
    assert "content-encoding" not in whole.headers
    block = 1 << 20
    for first, last in ((0, 0), (5, 99), (block - 1, block), (block, block + 9), (2 * block + 7, len(MP4) - 1)):
        part = client.get(f"{API}/{uuid}/media", headers={"range": f"bytes={first}-{last}"})
        assert (part.status_code, part.content) == (206, MP4[first : last + 1])
        assert part.headers["content-range"] == f"bytes {first}-{last}/{len(MP4)}"
    tail = client.get(f"{API}/{uuid}/media", headers={"range": "bytes=-10"})
    assert tail.content == MP4[-10:]
    known = {"if-none-match": whole.headers["etag"]}
    assert client.get(f"{API}/{uuid}/media", headers=known).status_code == 304
    assert database.check() == []


def test_a_range_reads_no_more_than_it_needs(client: TestClient, database: Database, uuid: str) -> None:
    put(client, uuid)
    with database.write() as tx:
        tx.connection.execute(
            text("DELETE FROM upload_block WHERE number = 0 AND upload = (SELECT MAX(id) FROM upload)")
        )
    part = client.get(f"{API}/{uuid}/media", headers={"range": f"bytes={1 << 20}-{(1 << 20) + 9}"})
    assert part.content == MP4[1 << 20 : (1 << 20) + 10]


def test_it_is_moved_replaced_and_taken_away(client: TestClient, database: Database, uuid: str) -> None:
    assert client.get(f"{API}/{uuid}/media").status_code == 404
    before = uploads(database)
    put(client, uuid)
    moved = client.patch(f"{API}/{uuid}/media", json={"offset": -0.5})
    assert (moved.status_code, moved.json()["offset"]) == (200, -0.5)
    assert client.get(f"{API}/{uuid}/media").content == MP4
    put(client, uuid, b"RIFF0000WAVE" + bytes(100))
    assert client.get(f"{API}/{uuid}").json()["media"]["media_type"] == "audio/wav"
    assert uploads(database) == before + 1, "what nobody carries is gone"
    assert client.delete(f"{API}/{uuid}/media").status_code == 204
    assert uploads(database) == before
    assert client.get(f"{API}/{uuid}").json()["media"] is None
    assert client.get(f"{API}/{uuid}").json()["revision"] == 1


def test_it_goes_with_its_document(client: TestClient, database: Database, uuid: str) -> None:
    other = store(database, {"other.bvh": bvh(3, seed=1)})[0]
    put(client, uuid)
    put(client, other)
    purge_documents(database, [uuid])
    assert client.get(f"{API}/{other}/media").content == MP4
    purge_documents(database, [other])
    assert uploads(database) == 0
    assert database.check() == []


@pytest.mark.parametrize("content", [b"", b"<html>", b"GIF89a", b"\x00\x00"])
def test_other_files_are_refused(client: TestClient, uuid: str, content: bytes) -> None:
    answer = client.put(f"{API}/{uuid}/media", files={"file": ("a.mp4", content)})
    assert (answer.status_code, "MP4" in answer.json()["remedy"]) == (415, True)
    wrong = client.put(f"{API}/{uuid}/media", files={"file": ("a.mp4", MP4)}, data={"offset": "1e9"})
    assert wrong.status_code == 422
    assert client.put(f"{API}/none/media", files={"file": ("a.mp4", MP4[:99])}).status_code == 404


def test_who_has_the_document_hears_of_it(client: TestClient, uuid: str) -> None:
    """It makes no revision, yet the answer is another one: its tag has to tell them apart."""
    tags = [client.get(f"{API}/{uuid}").headers["etag"]]
    put(client, uuid)
    tags.append(client.get(f"{API}/{uuid}", headers={"if-none-match": tags[0]}).headers["etag"])
    client.patch(f"{API}/{uuid}/media", json={"offset": 2.5})
    answer = client.get(f"{API}/{uuid}", headers={"if-none-match": tags[1]})
    assert (answer.status_code, answer.json()["media"]["offset"]) == (200, 2.5)
    tags.append(answer.headers["etag"])
    assert len(set(tags)) == 3
    assert client.patch(f"{API}/{uuid}", json={"name": "run"}, headers={"if-match": tags[2]}).status_code == 200


def test_edits_that_put_frames_elsewhere_leave_it_in_step(client: TestClient, database: Database) -> None:
    """The first frame that was there before stays at its moment, also in undone and restored revisions."""
    uuid = store(database, {"walk.bvh": bvh(40)})[0]
    put(client, uuid, offset=2.0)
    frame_time = float(client.get(f"{API}/{uuid}").json()["seconds_per_frame"])
    random = np.random.default_rng(7)
    frames = list(range(40))
    past, offset, new = [frames], 2.0, 40

    def check(now: list[int], answer: Response) -> None:
        nonlocal offset, frames
        assert answer.status_code == 200, answer.text
        anchor = next((frame for frame in now if frame in frames), None)
        if anchor is not None:
            offset += (frames.index(anchor) - now.index(anchor)) * frame_time
        frames = now
        past.append(now)
        found = client.get(f"{API}/{uuid}").json()
        assert (found["revision"], found["frames"]) == (len(past), len(now))
        assert found["media"]["offset"] == pytest.approx(offset, abs=1e-9)

    def send(path: str, body: object = None, **query: object) -> Response:
        match = {"If-Match": f'"{len(past)}"'}
        return client.post(f"{API}/{uuid}/{path}", json=body, params=query, headers=match)

    for turn in range(30):
        quarter = len(frames) // 4
        kind = ("delete", "keep", "insert", "undo", "restore")[turn % 5]
        first = int(random.integers(1, quarter + 2))
        last = first + int(random.integers(2 * quarter, 3 * quarter) if kind == "keep" else random.integers(quarter))
        part = frames[first - 1 : last]
        rest = frames[: first - 1] + frames[last:]
        if kind == "undo":
            check(past[-2], send("undo", revision=len(past)))
        elif kind == "restore":
            number = int(random.integers(1, len(past) + 1))
            check(past[number - 1], send("restore", revision=number))
        elif kind == "insert":
            copies = list(range(new, new + len(part)))
            new += len(part)
            edit = {"do": "insert", "at": 1, "first": first, "last": last}
            check(copies + frames, send("frames", {"edits": [edit]}))
        else:
            check(
                part if kind == "keep" else rest,
                send("frames", {"edits": [{"do": kind, "first": first, "last": last}]}),
            )
    assert len(past) > 20
    assert database.check() == []
