"""Whole answers as streams, variables, completion, and queries whose client leaves."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

import pytest
from fastapi.testclient import TestClient
from lxml import etree

from mcml_schemas.querying.queries import QueryRequest
from mcml_service.xpath.answer.writing import STREAMS
from mcml_service.xpath.finding import addresses
from mcml_service.xpath.queries import Queries
from tests.builders import HTR, MCML, bvh, upload
from tests.conftest import StoreOf

pytestmark = pytest.mark.above_store

API = "/api/v1"
FIELDS = ("document", "revision", "kind", "address", "value")
EXPRESSIONS = [
    "//frame[motion_name='walk']",
    "//frame_bone[@Rx > 20]/@Rx",
    "//bone/name | //@id | //comment",
    "/mcml",
    "/ | /mcml/motion",
    "//motion_name/text()",
    "//nothing",
    "(//frame)[3]",
    "//frame[position() < 4]",
]


@pytest.fixture
def library(kind: str, store_of: StoreOf) -> TestClient:
    """For tests that only read."""
    return store_of(kind, filled)[0]


@pytest.fixture
def own_library(client: TestClient) -> TestClient:
    """For one that writes."""
    filled(client)
    return client


def filled(client: TestClient) -> None:
    upload(client, {"a_long.bvh": bvh(2500)}, label="walk")
    upload(client, {"b_hand.mcml": MCML, "c_two.htr": HTR})


def pages(client: TestClient, text: str) -> list[dict[str, Any]]:
    items, cursor = [], None
    while True:
        parameters = {"q": text, "limit": 997} | ({"cursor": cursor} if cursor else {})
        page = client.get(f"{API}/xpath", params=parameters).json()
        items += page["items"]
        cursor = page.get("next_cursor")
        if cursor is None:
            return items


def content(result: etree._Element) -> bytes | str:
    return etree.tostring(result[0], method="c14n", with_tail=False) if len(result) else result.text or ""


def canonical(item: dict[str, Any]) -> bytes | str:
    value: str = item["value"]
    is_xml = item["kind"] in {"element", "document"}
    return etree.tostring(etree.fromstring(value), method="c14n") if is_xml else value


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_streams_hold_what_pages_hold(library: TestClient, text: str) -> None:
    wanted = pages(library, text)
    lines = library.get(f"{API}/xpath", params={"q": text, "as": "ndjson"})
    assert lines.headers["content-type"].startswith("application/x-ndjson")
    assert lines.headers["x-total-count"] == str(len(wanted))
    assert [json.loads(line) for line in lines.text.splitlines()] == wanted
    table = library.get(f"{API}/xpath", params={"q": text, "as": "csv"}).text
    csv.field_size_limit(1 << 30)
    rows = list(csv.DictReader(io.StringIO(table, newline="")))
    assert [row | {"revision": int(row["revision"])} for row in rows] == wanted
    assert table.partition("\r\n")[0] == ",".join(FIELDS)
    results = etree.fromstring(library.get(f"{API}/xpath", params={"q": text, "as": "xml"}).content)
    assert [(found.get("document"), found.get("address"), content(found)) for found in results] == [
        (item["document"], item["address"], canonical(item)) for item in wanted
    ]
    queries: Queries = library.app.state.repository.queries  # type: ignore[attr-defined]
    assert addresses(queries, QueryRequest(q=text)) == [item["address"] for item in wanted]


def test_frames_without_samples_are_shown(client: TestClient) -> None:
    frames = b"".join(b'<frame id="%d"><frame_bone name="Root"/></frame>' % number for number in range(1, 300))
    start, end = MCML.index(b"<motion>"), MCML.index(b"</motion>")
    motion = b"<motion><frames>299</frames><frametime>0.1</frametime>" + frames
    upload(client, {"still.mcml": MCML[:start] + motion + MCML[end:]})
    for text, count in (("//frame", 299), ("//frame[position() > 290]", 9)):
        wanted = pages(client, text)
        assert [item["value"] for item in wanted[:1]] == [
            f'<frame id="{300 - count}"><frame_bone name="Root"/></frame>'
        ]
        results = etree.fromstring(client.get(f"{API}/xpath", params={"q": text, "as": "xml"}).content)
        assert [content(found) for found in results] == [canonical(item) for item in wanted]
        assert len(wanted) == count


@pytest.mark.parametrize("form", ["xml", "ndjson", "csv"])
@pytest.mark.parametrize("text", ["/mcml", "/mcml/motion"])
def test_a_document_is_written_while_it_is_read(own_library: TestClient, form: str, text: str) -> None:
    """Frames are read piece after piece, all as they were when the question was asked."""
    (document,) = (item for item in own_library.get(f"{API}/documents").json()["items"] if item["name"] == "a_long")
    asked = {"q": text, "as": form, "document": document["id"]}
    before = own_library.get(f"{API}/xpath", params=asked).content
    queries: Queries = own_library.app.state.repository.queries  # type: ignore[attr-defined]
    content = STREAMS[form][0](queries.stream(QueryRequest(q=text, document=[document["id"]])))
    read = [next(content) for _ in range(3)]
    changed = own_library.patch(
        f"{API}/documents/{document['id']}/elements",
        params={"xpath": "/mcml/motion/frame[2500]/frame_bone[2]"},
        json={"attributes": {"Rx": "1234.5"}},
        headers={"if-match": "*"},
    )
    assert changed.is_success
    assert b"".join([*read, *content]) == before
    after = own_library.get(f"{API}/xpath", params=asked).content
    assert b"1234.5" in after
    assert b"1234.5" not in before


def test_a_stream_stops_at_its_limit(library: TestClient) -> None:
    parameters = {"q": "//frame_bone", "as": "ndjson", "limit": 7}
    assert len(library.get(f"{API}/xpath", params=parameters).text.splitlines()) == 7


def test_an_error_comes_before_the_first_byte(library: TestClient) -> None:
    refused = library.get(f"{API}/xpath", params={"q": "count(//frame)", "as": "csv"})
    assert refused.status_code == 422
    assert refused.headers["content-type"] == "application/problem+json"


def test_variables_are_bound(library: TestClient) -> None:
    question = {"q": "count(//frame[motion_name=$name][@id > $least])", "variables": {"name": "walk", "least": 2000}}
    assert library.post(f"{API}/xpath", json=question).json()["value"] == 500
    quoted = {"q": "count(//frame[motion_name=$name])", "variables": {"name": 'it\'s "so"'}}
    assert library.post(f"{API}/xpath", json=quoted).json()["value"] == 0
    refused = library.post(f"{API}/xpath", json={"q": "//frame[motion_name=$other]", "variables": {"name": "walk"}})
    assert refused.status_code == 422
    assert refused.json()["where"] == {"column": 21}


def test_completion(library: TestClient) -> None:
    found = library.get(f"{API}/xpath/complete", params={"q": "//frame[motion_name='wa"}).json()
    assert found["first"] == 21
    assert {"text": "walk", "kind": "motion name", "detail": "", "documents": 2} in found["items"]
    roles = library.get(f"{API}/xpath/complete", params={"q": "//bone[@role='left_e"}).json()["items"]
    assert [item["text"] for item in roles] == ["left_eye"]
    assert library.get(f"{API}/xpath/complete", params={"q": "//frame", "at": 4}).json()["items"][0]["text"] == "frame"


def test_names_that_reach_nothing_are_answered_with_a_hint(library: TestClient) -> None:
    answer = library.get(f"{API}/xpath", params={"q": "//frame/@Rx"}).json()
    assert answer["items"] == []
    assert answer["warnings"] == ["frame has no attribute @Rx; it is one of frame_bone"]
