"""What clients stand on: sessions, ranges, links to the next page, keys of requests, tables, zips, other origins."""

from __future__ import annotations

import io
import re
import zipfile
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fastapi.testclient import TestClient

from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF, SECRET, amc, bvh, mcml_of, one_kind, served, upload

pytestmark = pytest.mark.above_store

API = "/api/v1"
HOME = "http://127.0.0.1:8000"


@pytest.fixture
def token(database: Database) -> str:
    with database.write() as tx:
        return tx.tokens.add("lab")


def browser(database: Database, **settings: Any) -> TestClient:
    """Somebody without a token, elsewhere."""
    app = create_app(Settings(**settings), database, lambda: SECRET)
    return TestClient(app, base_url=HOME, client=("10.0.0.7", 50_000))


# -- sessions ----------------------------------------------------------------------------------------------------------


def test_a_token_becomes_a_cookie(database: Database, token: str) -> None:
    with browser(database) as client:
        assert client.get(f"{API}/documents").status_code == 401
        opened = client.post(f"{API}/session", json={"token": token})
        assert (opened.status_code, opened.json()["author"]) == (201, "lab")
        cookie = opened.headers["set-cookie"].lower()
        assert {"httponly", "samesite=strict", "path=/"} <= set(re.split(r"; ?", cookie))
        assert "max-age=43200" in cookie
        assert "secure" not in cookie
        assert client.get(f"{API}/documents").status_code == 200
        files = {"file": ("walk.bvh", bvh(3))}
        assert client.post(f"{API}/documents", files=files).status_code == 403
        foreign = {"origin": "http://evil.example"}
        assert client.post(f"{API}/documents", files=files, headers=foreign).status_code == 403
        made = client.post(f"{API}/documents", files=files, headers={"origin": HOME})
        assert made.status_code == 201
        history = client.get(f"{made.headers['location']}/revisions").json()["items"]
        assert [item["author"] for item in history] == ["lab"]
        assert client.delete(f"{API}/session", headers={"origin": HOME}).status_code == 204
        assert client.get(f"{API}/documents").status_code == 401


@one_kind
def test_a_session_ends_with_its_token_and_over_https_is_secure(database: Database, token: str) -> None:
    app = create_app(Settings(), database, lambda: SECRET)
    with TestClient(app, base_url="https://lab.example", client=("10.0.0.7", 1)) as client:
        opened = client.post(f"{API}/session", headers={"authorization": f"Bearer {token}"})
        assert "secure" in opened.headers["set-cookie"].lower()
        assert client.get(f"{API}/documents").status_code == 200
        with database.write() as tx:
            tx.tokens.remove("lab")
        assert client.get(f"{API}/documents").status_code == 401


def test_a_wrong_token_opens_nothing(database: Database, token: str) -> None:
    with browser(database) as client:
        for asked in ({"token": "mcml_wrong"}, {"link": "x"}, {}):
            refused = client.post(f"{API}/session", json=asked)
            assert refused.status_code == 403
            assert "set-cookie" not in refused.headers
        client.cookies.set("mcml_session", "made-up")
        assert client.get(f"{API}/documents").status_code == 401


def test_a_link_opens_once(database: Database, token: str) -> None:
    with database.write() as tx:
        link = tx.sessions.link("local")
    with browser(database) as client:
        shown = client.get("/login", params={"link": link})
        assert (shown.status_code, link in shown.text) == (200, True)
        assert client.post("/login", data={"link": link}, follow_redirects=False).status_code == 303
        assert client.get("/").status_code == 200
    with browser(database) as other:
        assert other.post("/login", data={"link": link}).status_code == 403


@one_kind
def test_people_are_asked_for_a_token_and_programs_told(database: Database, token: str) -> None:
    with browser(database) as client:
        page = client.get("/docs", headers={"accept": "text/html,*/*"})
        assert (page.status_code, page.headers["content-type"]) == (401, "text/html; charset=utf-8")
        assert 'name="token"' in page.text
        assert "form-action 'self'" in page.headers["content-security-policy"]
        assert client.get("/docs").headers["content-type"] == "application/problem+json"
        then = client.post("/login", data={"token": token, "then": "/docs"}, follow_redirects=False)
        assert (then.status_code, then.headers["location"]) == (303, "/docs")
        for bad in ("//evil.example", "https://evil.example", "/\\evil.example"):
            again = client.post("/login", data={"token": token, "then": bad}, follow_redirects=False)
            assert again.headers["location"] == "/"


# -- other origins -----------------------------------------------------------------------------------------------------


@one_kind
def test_pages_of_named_origins_may_ask(database: Database, token: str) -> None:
    friend = {"origin": "https://lab.example"}
    bearer = {"authorization": f"Bearer {token}"}
    asked = {"access-control-request-method": "PATCH", "access-control-request-headers": "authorization,if-match"}
    with browser(database, cors_origins="https://lab.example, https://other.example/") as client:
        before = client.options(f"{API}/documents", headers=friend | asked)
        assert (before.status_code, before.headers["access-control-allow-origin"]) == (200, "https://lab.example")
        answer = client.post(f"{API}/documents", files={"file": ("a.bvh", bvh(3))}, headers=friend | bearer)
        assert (answer.status_code, answer.headers["access-control-allow-origin"]) == (201, "https://lab.example")
        evil = {"origin": "https://evil.example"}
        assert (
            client.post(f"{API}/documents", files={"file": ("a.bvh", bvh(3))}, headers=evil | bearer).status_code == 403
        )
        assert "access-control-allow-origin" not in client.get(f"{API}/documents", headers=evil | bearer).headers
    with browser(database) as client:
        assert client.post(f"{API}/session", json={"token": token}, headers=friend).status_code == 403


# -- pages and ranges --------------------------------------------------------------------------------------------------


def test_links_lead_through_all_pages(client: TestClient) -> None:
    for number in range(5):
        upload(client, {f"clip{number}.bvh": bvh(3, seed=number)}, project="a b&c")
    address, names = f"{API}/documents?project=a%20b%26c&limit=2", []
    while address:
        answer = client.get(address)
        names += [item["name"] for item in answer.json()["items"]]
        found = re.fullmatch(r'<(.*)>; rel="next"', answer.headers.get("link", ""))
        address = found[1] if found else ""
    assert names == [f"clip{number}" for number in range(5)]


def test_ranges_of_kept_files(client: TestClient) -> None:
    content = bvh(200)
    uuid = upload(client, {"walk.bvh": content})["documents"][0]["id"]  # type: ignore[index]
    url = f"{API}/documents/{uuid}/export?format=bvh"
    whole = client.get(url, headers={"accept-encoding": "identity"})
    assert (whole.headers["accept-ranges"], whole.content) == ("bytes", content)
    size = len(content)
    for asked, first, last in (
        ("0-9", 0, 9),
        (f"{size - 5}-", size - 5, size - 1),
        ("-7", size - 7, size - 1),
        ("100-99999999", 100, size - 1),
    ):
        part = client.get(url, headers={"range": f"bytes={asked}"})
        assert (part.status_code, part.content) == (206, content[first : last + 1])
        assert part.headers["content-range"] == f"bytes {first}-{last}/{size}"
        assert "content-encoding" not in part.headers
    beyond = client.get(url, headers={"range": f"bytes={size}-"})
    assert (beyond.status_code, beyond.headers["content-range"]) == (416, f"bytes */{size}")
    for ignored in ("bytes=5-2,7-9", "lines=1-2", "bytes=x-"):
        assert client.get(url, headers={"range": ignored}).content == content
    tag = whole.headers["etag"]
    assert client.get(url, headers={"range": "bytes=0-1", "if-range": tag}).status_code == 206
    assert client.get(url, headers={"range": "bytes=0-1", "if-range": '"9-bvh"'}).status_code == 200


# -- keys of requests --------------------------------------------------------------------------------------------------


def test_a_request_with_a_key_is_done_once(client: TestClient) -> None:
    def send(key: str, frames: int = 3) -> Any:
        files = {"file": ("walk.bvh", bvh(frames))}
        return client.post(f"{API}/documents", files=files, headers={"idempotency-key": key})

    first, again = send("a"), send("a")
    assert (first.status_code, again.status_code, again.content) == (201, 201, first.content)
    assert (again.headers["idempotency-replayed"], again.headers["location"]) == ("true", first.headers["location"])
    assert client.get(f"{API}/documents").json()["total"] == 1
    assert send("a", 4).status_code == 422
    assert send("b").json()["documents"][0]["id"] != first.json()["documents"][0]["id"]
    assert client.get(f"{API}/documents").json()["total"] == 2


def test_what_failed_may_be_sent_again_with_its_key(client: TestClient) -> None:
    headers = {"idempotency-key": "k"}
    bad = client.post(f"{API}/documents", files={"file": ("walk.bvh", b"HIERARCHY")}, headers=headers)
    assert bad.status_code == 422
    assert client.post(f"{API}/documents", files={"file": ("walk.bvh", bvh(3))}, headers=headers).status_code == 201


def test_a_request_whose_end_nobody_knows_is_not_done_again(client: TestClient, database: Database) -> None:
    headers = {"idempotency-key": "k"}
    files = {"file": ("walk.bvh", bvh(3))}
    assert client.post(f"{API}/documents", files=files, headers=headers).status_code == 201
    with database.write() as tx:
        # As a server that died between the two leaves it.
        tx.requests.end("local", "k", None, None, None)  # type: ignore[arg-type]
    again = client.post(f"{API}/documents", files=files, headers=headers)
    assert (again.status_code, "Idempotency-Key" in again.json()["detail"]) == (409, True)
    assert client.get(f"{API}/documents").json()["total"] == 1


# -- tables and zips ---------------------------------------------------------------------------------------------------


@pytest.fixture
def walk(client: TestClient) -> str:
    upload(client, {"leg.asf": ASF, "leg.amc": amc(4)}, project="legs")
    uuid: str = upload(client, {"walk.bvh": bvh(700)}, label="walk:5-9")["documents"][0]["id"]  # type: ignore[index]
    return uuid


def table(content: bytes, form: str) -> Any:
    return pa.ipc.open_stream(content).read_all() if form == "arrow" else pq.read_table(io.BytesIO(content))


@one_kind
def test_frames_with_their_columns(client: TestClient, walk: str) -> None:
    url = f"{API}/documents/{walk}/frames"
    plain = np.load(io.BytesIO(client.get(url, params={"format": "npy"}).content))
    found = np.load(io.BytesIO(client.get(url, params={"format": "npz"}).content))
    np.testing.assert_array_equal(found["values"], plain)
    assert found["columns"].tolist()[:2] == ["Root.Tx", "Root.Ty"]
    assert (found["ids"].tolist()[:2], len(found["ids"])) == (["1", "2"], 700)
    np.testing.assert_allclose(found["times"][:2], [0, 0.0083333])
    for form in ("arrow", "parquet"):
        rows = table(client.get(url, params={"format": form, "first": 3, "step": 2}).content, form)
        assert rows.column_names[:4] == ["frame", "id", "time", "Root.Tx"]
        assert rows["frame"].to_pylist()[:2] == [3, 5]
        np.testing.assert_array_equal(rows["Root.Tx"].to_numpy(), plain[2::2, 0])
        places = table(client.get(url, params={"format": form, "space": "positions", "bone": "Head"}).content, form)
        assert places.column_names[3:] == ["Head.x", "Head.y", "Head.z"]


@one_kind
@pytest.mark.parametrize("form", ["csv", "arrow", "parquet"])
def test_a_document_without_frames_is_a_table_without_rows(client: TestClient, form: str) -> None:
    uuid = upload(client, {"none.mcml": mcml_of([])})["documents"][0]["id"]  # type: ignore[index]
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": form})
    assert answer.status_code == 200, answer.text
    if form == "csv":
        (head,) = answer.text.splitlines()
        assert head.startswith("frame,id,time,")
    else:
        read = pq.read_table if form == "parquet" else lambda file: pa.ipc.open_stream(file).read_all()
        table = read(io.BytesIO(answer.content))
        assert (table.num_rows, table.column_names[:3]) == (0, ["frame", "id", "time"])


def test_names_of_columns_stand_in_a_header_where_they_are_short(client: TestClient) -> None:
    many = upload(client, {"leg.asf": ASF, "leg.amc": amc(4)})["documents"][0]["id"]  # type: ignore[index]
    few = client.get(f"{API}/documents/{many}/frames", params={"format": "npy"})
    assert "x-mcml-columns" in few.headers
    names = [f"joint number {number} of a rig with long names, 관절" for number in range(80)]
    joints = "".join(f"JOINT {name}\n{{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n" for name in names)
    text = (
        f"HIERARCHY\nROOT Hips\n{{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n{joints}End Site\n{{\n"
        f"OFFSET 0 1 0\n}}\n{'}' * 81}\nMOTION\nFrames: 1\nFrame Time: 0.01\n{'0 ' * 243}\n"
    )
    uuid = upload(client, {"long.bvh": text.encode()})["documents"][0]["id"]  # type: ignore[index]
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy"})
    assert (answer.status_code, "x-mcml-columns" in answer.headers) == (200, False)
    npz = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npz"})
    assert len(np.load(io.BytesIO(npz.content))["columns"]) == 243


@one_kind
@pytest.mark.parametrize("form", ["arrow", "parquet"])
def test_answers_and_labels_as_columns(client: TestClient, walk: str, form: str) -> None:
    question = {"q": "//frame[position() < 4]/frame_bone[@name='Root']/@Tx", "as": form, "document": walk}
    rows = table(client.get(f"{API}/xpath", params=question).content, form)
    assert rows.column_names == ["document", "revision", "kind", "address", "value", "number"]
    assert [float(text) for text in rows["value"].to_pylist()] == rows["number"].to_pylist()
    assert len(rows) == 3
    nothing = table(client.get(f"{API}/xpath", params={"q": "//nothing", "as": form}).content, form)
    assert (len(nothing), nothing.column_names) == (0, rows.column_names)
    labels = table(client.get(f"{API}/labels", params={"format": form}).content, form)
    assert labels.to_pylist() == [{"document": walk, "label": "walk", "first": 5, "last": 9}]


@one_kind
def test_a_selection_as_one_zip(client: TestClient, walk: str) -> None:
    upload(client, {"walk.bvh": bvh(3, seed=5)})
    answer = client.post(f"{API}/exports", json={"selection": {"xpath": "//frame"}, "format": "bvh"})
    with zipfile.ZipFile(io.BytesIO(answer.content)) as found:
        assert found.testzip() is None
        # BVH needs a frame rate, which AMC does not have.
        names = found.namelist()
        assert len(names) == 3
        assert {"refused.txt", "walk.bvh"} < set(names)
        assert {found.read(name) for name in names if name.startswith("walk")} == {bvh(700), bvh(3, seed=5)}
    pair = client.post(f"{API}/exports", json={"selection": {"project": "legs"}, "format": "asf-amc"})
    with zipfile.ZipFile(io.BytesIO(pair.content)) as found:
        assert found.namelist() == ["leg.asf", "leg.amc"]
    refused = client.post(f"{API}/exports", json={"selection": {"project": "legs"}, "format": "bvh", "unit": "mm"})
    with zipfile.ZipFile(io.BytesIO(refused.content)) as found:
        assert found.namelist() == ["refused.txt"]
        assert "unit" in found.read("refused.txt").decode()
    assert client.post(f"{API}/exports", json={"selection": {"project": "legs"}, "format": "mp3"}).status_code == 415


def test_nothing_is_kept_of_a_stream_that_nobody_reads(database: Database) -> None:
    with served(database) as client:
        uuid = upload(client, {"walk.bvh": bvh(3000)})["documents"][0]["id"]  # type: ignore[index]
        for _ in range(20):
            with client.stream("GET", f"{API}/documents/{uuid}/frames?format=npz"):
                pass
        assert client.get(f"{API}/documents/{uuid}").status_code == 200
