"""What HTTP asks of every endpoint: HEAD, tags of compressed answers, addresses and numbers that make no sense."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, served, upload

pytestmark = pytest.mark.above_store

API = "/api/v1"


@pytest.fixture
def address(client: TestClient) -> str:
    done = upload(client, {"chain.bvh": bvh(300)})
    return f"{API}/documents/{done['documents'][0]['id']}"  # type: ignore[index]


def test_head_is_get_without_a_body(client: TestClient, address: str) -> None:
    for path in (address, f"{address}/mcml", f"{address}/export?format=bvh", f"{API}/documents", "/healthz"):
        got, head = client.get(path), client.head(path)
        assert (head.status_code, head.content) == (200, b"")
        for name in ("content-type", "etag", "content-disposition"):
            assert head.headers.get(name) == got.headers.get(name)
    assert client.head(f"{API}/documents/none").status_code == 404


def test_the_compressed_answer_has_a_tag_of_its_own(client: TestClient, address: str) -> None:
    path = f"{address}/export?format=bvh"
    plain = client.get(path, headers={"accept-encoding": "identity"}).headers["etag"]
    small = client.get(path, headers={"accept-encoding": "gzip"})
    assert (plain, small.headers["content-encoding"], small.headers["etag"]) == ('"1-bvh"', "gzip", '"1-bvh-gzip"')
    for tag in (plain, small.headers["etag"], "*", f'"x", W/{plain}'):
        assert client.get(path, headers={"if-none-match": tag}).status_code == 304
    assert client.get(path, headers={"if-none-match": '"2-bvh-gzip"'}).status_code == 200
    change = {"json": {"name": "other"}, "headers": {"if-match": small.headers["etag"]}}
    assert client.patch(address, **change).status_code == 200  # type: ignore[arg-type]


def test_a_wrong_method_says_which_are_allowed(client: TestClient, address: str) -> None:
    answer = client.put(address)
    assert answer.status_code == 405
    assert "GET" in answer.headers["allow"]


def nonsense() -> Iterator[str]:
    for number in (2**31, 2**63, 10**30, 10**400):
        for path in ("", "/mcml", "/export?format=bvh", "/frames", "/labels"):
            yield f"{{}}{path}{'&' if '?' in path else '?'}revision={number}"
        for name in ("first", "last", "step"):
            yield f"{{}}/frames?{name}={number}"
            yield f"{{}}/frames?format=npy&{name}={number}"
        yield f"{API}/documents?skeleton={number}"
    for parts in ([2**63], [2**64 - 1], [-1], [True], ["a", 2**63], ["a\0", 1], [1e30, 1, 1], [2**63, 0, 0], [1e999]):
        cursor = base64.urlsafe_b64encode(json.dumps(parts).encode()).decode().rstrip("=")
        for path in (f"{API}/documents", f"{API}/skeletons", "{}/revisions", "{}/labels", "{}/frames"):
            yield f"{path}?cursor={cursor}"
        yield f"{API}/xpath?q=//frame&cursor={cursor}"
    for path in ("/documents/%00", "/documents?project=%00", "/xpath?q=//a&document=%00", "/motion-names?project=%00"):
        yield API + path


def test_numbers_and_texts_that_no_store_holds_are_refused(client: TestClient, address: str) -> None:
    for path in nonsense():
        answer = client.get(path.format(address))
        assert answer.status_code in (200, 400, 404, 422), path
    wrong = client.post(f"{address}/restore?revision={2**63}", headers={"if-match": "*"})
    assert wrong.status_code == 422


@pytest.mark.parametrize("headers", [{"origin": "http://["}, {"origin": "null"}])
def test_broken_origins_are_refused(client: TestClient, address: str, headers: dict[str, str]) -> None:
    assert client.post(f"{address}/restore", headers=headers | {"if-match": "*"}).status_code == 403


def test_a_body_without_a_length_is_bounded(database: Database) -> None:
    with served(database, Settings(max_upload_bytes=100_000)) as client:
        edge = b"--x\r\ncontent-disposition: form-data; name=file; filename=a.bvh\r\n\r\n"
        answer = client.post(
            f"{API}/documents",
            content=iter([edge, *[b"0" * 10_000] * 20, b"\r\n--x--\r\n"]),
            headers={"content-type": "multipart/form-data; boundary=x"},
        )
    assert answer.status_code == 413
    assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.slow
def test_the_description_says_that_errors_are_problems(client: TestClient) -> None:
    schema = client.get("/openapi.json").json()
    assert "HTTPValidationError" not in str(schema)
    assert {"Problem", "Where"} <= set(schema["components"]["schemas"])
    for path, operations in schema["paths"].items():
        for operation in operations.values():
            assert operation["summary"], path
            assert operation["description"], path
            assert "application/problem+json" in operation["responses"]["4XX"]["content"], path


@one_kind
def test_bodies_of_another_kind_are_refused_in_words_of_ours(client: TestClient) -> None:
    json_type = {"content-type": "application/json"}
    undecodable = client.post(f"{API}/compose", content=b"\xac\xc2?", headers=json_type)
    assert (undecodable.status_code, undecodable.json()["detail"]) == (
        400,
        "The request body does not match its content type.",
    )
    assert "UTF-8" in undecodable.json()["remedy"]
    text = client.post(f"{API}/inspect", files={"file": (None, "a text")})
    assert (text.status_code, text.json()["detail"]) == (422, "body.file.0: A file is needed here, not a text.")
    said = client.post(f"{API}/compose", json={"segments": [{"first": 1}]}).json()["detail"]
    assert said.startswith("body.segments.0: a segment names a document")


@one_kind
def test_routes_are_made_once(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """Making them takes longer than most requests; FastAPI makes those of an included router when it is first asked."""
    with served(database) as client:
        assert client.get(f"{API}/documents").status_code == 200
    made: list[str] = []
    monkeypatch.setattr("fastapi.routing.request_response", lambda endpoint: made.append(endpoint.__name__))
    with served(database) as client:
        assert client.get(f"{API}/documents").status_code == 200
    assert made == []
