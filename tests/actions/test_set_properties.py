"""Properties from a table: read right, written whole or not at all."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from mcml.errors import DocumentError
from mcml.language.elements import to_head
from mcml_service.actions.labelling.set_properties import parse_table, set_properties
from mcml_service.storage.database import Database
from tests.builders import bvh, store


def properties(database: Database, uuid: str) -> dict[str, tuple[str, str]]:
    with database.read() as tx:
        head = to_head(tx.heads.document(tx.documents.get(uuid)))
    return {name: (value, unit) for name, value, unit in head.properties}


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_units_of_headings_and_cells(delimiter: str) -> None:
    lines = [["name", "age (year)", "height [cm]", "take"], ["walk", "23", "1.72 m", ""], [], ["run", "", "", "x y"]]
    key, rows = parse_table("\r\n".join(delimiter.join(line) for line in lines).encode("utf-8-sig"))
    assert key == "name"
    assert [(row.line, row.document, row.properties) for row in rows] == [
        (2, "walk", (("age", "23", "year"), ("height", "1.72", "m"))),
        (4, "run", (("take", "x y", ""),)),
    ]


def test_what_the_table_does_not_say_stays(database: Database) -> None:
    uuids = [store(database, {f"{name}.bvh": bvh(3)})[0] for name in ("walk", "run")]
    with database.write() as tx:
        set_properties(tx, b"name,age (year),take\nwalk,23,calm\n")
    with database.write() as tx:
        changed = set_properties(tx, f"document,age (year)\n{uuids[0]},24\n{uuids[1]},\n".encode())
    assert [item.uuid for item in changed] == uuids[:1]
    assert properties(database, uuids[0]) == {"age": ("24", "year"), "take": ("calm", "")}
    assert properties(database, uuids[1]) == {}
    with database.read() as tx:
        assert tx.documents.get(uuids[0]).revision == 3


@pytest.mark.parametrize(
    ("table", "line"),
    [
        (b"", 1),
        (b"age\n23\n", 1),
        (b"name\nwalk\n", 1),
        (b"name,\nwalk,1\n", 1),
        (b"name,age\nwalk,1\nnobody,2\n", 3),
        (b"name,age\nwalk,1,2\n", 2),
        (b"name,age\nwalk,1\ntwin,2\n", 3),
    ],
)
def test_a_wrong_line_is_named_and_nothing_written(database: Database, table: bytes, line: int) -> None:
    uuid = store(database, {"walk.bvh": bvh(3)})[0]
    for seed in (1, 2):
        store(database, {"twin.bvh": bvh(3, seed)})
    with pytest.raises(DocumentError) as caught, database.write() as tx:
        set_properties(tx, table)
    assert caught.value.at is not None
    assert caught.value.at.line == line
    assert caught.value.remedy
    assert properties(database, uuid) == {}


def test_over_http(client: TestClient) -> None:
    uploaded = client.post("/api/v1/documents", files={"file": ("walk.bvh", bvh(3))}).json()["documents"][0]["id"]
    answer = client.post("/api/v1/properties", content="name,age (year)\nwalk,23\n")
    assert answer.status_code == 200
    assert answer.json() == {"items": [{"id": uploaded, "name": "walk", "revision": 2}]}
    found = client.get(f"/api/v1/documents/{uploaded}").json()["properties"]
    assert found == [{"name": "age", "value": "23", "unit": "year"}]
    assert client.get("/api/v1/documents", params={"property": "age:20..30"}).json()["total"] == 1
    refused = client.post("/api/v1/properties", content="name,age\nnobody,1\n")
    assert refused.status_code == 422
    assert refused.json()["where"] == {"line": 2}
