"""Tables that spreadsheets open: no cell is a formula unless it is asked for, and numbers stay numbers."""

from __future__ import annotations

import csv
import io
import zipfile
from typing import Any

import pytest
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st

from mcml_service.cells import read_cell, safe_cell
from tests.api.asked import API
from tests.builders import bvh, one_kind, upload

BAD = ("=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\tx", "\rx", "\nx", "-", "=", "'=1", "-1-1", "+1 =2")
GOOD = ("", "walk", "-1", "+2.5", "-1e-5", "-.5", "1-1", "-1 0.5 +3", "-INF", "a=b", "'quoted", "<x>=1</x>")


def test_formulas_have_an_apostrophe_and_numbers_none() -> None:
    assert [safe_cell(text) for text in BAD] == [f"'{text}" for text in BAD]
    assert [safe_cell(text) for text in GOOD] == list(GOOD)


@given(st.text(alphabet="'=+-@\t\r\na1 .e", max_size=6))
def test_what_is_written_is_read_again(text: str) -> None:
    assert read_cell(safe_cell(text)) == text


def rows(answer: Any) -> list[list[str]]:
    assert answer.status_code == 200, answer.text
    return list(csv.reader(io.StringIO(answer.text, newline="")))


@pytest.fixture
def document(client: TestClient) -> str:
    """With a joint, a label and a property that are formulas."""
    made: Any = upload(client, {"a.bvh": bvh(3, names=("=Hips", "-Spine", "Head"))})
    uuid = str(made["documents"][0]["id"])
    change = {"if-match": "*"}
    label = [{"name": "=1+1", "first": 1, "last": 2}]
    assert client.post(f"{API}/documents/{uuid}/labels", json=label, headers=change).status_code == 201
    said = {"properties": [{"name": "note", "value": "@SUM(A1)"}, {"name": "shift", "value": "-3.5"}]}
    assert client.patch(f"{API}/documents/{uuid}", json=said, headers=change).status_code == 200
    return uuid


@one_kind
def test_every_table_of_the_api(client: TestClient, document: str) -> None:
    here = f"{API}/documents/{document}"
    for path, least in (
        (f"{here}/frames?format=csv", 3),
        (f"{here}/export?format=csv", 3),
        (f"{API}/labels?document={document}", 1),
        (f"{API}/xpath?as=csv&q=//property/@value", 2),
        (f"{API}/xpath?as=csv&q=//motion_name", 1),
    ):
        safe = rows(client.get(path))
        raw = rows(client.get(f"{path}&raw=true"))
        cells = [cell for row in safe for cell in row]
        assert len(safe) > least
        assert [cell for cell in cells if safe_cell(cell) != cell and not cell.startswith("'")] == []
        assert [[read_cell(cell) for cell in row] for row in safe] == raw
        assert safe != raw or "motion_name" in path, path
    asked = client.post(f"{API}/xpath", json={"q": "//property/@value", "as": "csv"})
    assert {row[4] for row in rows(asked)[1:]} == {"'@SUM(A1)", "-3.5"}
    exported = client.post(f"{API}/exports", json={"selection": {"documents": [document]}, "format": "csv"})
    with zipfile.ZipFile(io.BytesIO(exported.content)) as packed:
        assert "'-Spine.Rx" in packed.read(packed.namelist()[0]).decode()


@one_kind
def test_tables_go_out_and_come_back(client: TestClient, document: str) -> None:
    table = client.get(f"{API}/labels?document={document}").text
    assert "'=1+1" in table
    sent = {"content-type": "text/csv"}
    back = client.put(f"{API}/labels?replace=true", content=table, headers=sent)
    assert back.status_code == 200, back.text
    names = [item["name"] for item in client.get(f"{API}/documents/{document}/labels").json()["items"]]
    assert names == ["=1+1"]
    properties = f"document,note\n{document},'=2\n"
    answer = client.post(f"{API}/properties", content=properties, headers=sent)
    assert answer.status_code == 200, answer.text
    held = client.get(f"{API}/documents/{document}").json()["properties"]
    assert {one["name"]: one["value"] for one in held}["note"] == "=2"
