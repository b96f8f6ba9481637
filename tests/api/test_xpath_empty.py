"""XPath over documents whose frames were all taken away."""

from __future__ import annotations

from typing import Any

from fastapi.testclient import TestClient

from tests.builders import bvh, upload


def test_documents_without_frames_are_asked(client: TestClient) -> None:
    """Their tracks are kept as history; no slot of them is a frame's."""
    emptied, full = (str(document["id"]) for name in "ab" for document in _stored(client, name))
    done = client.delete(
        f"/api/v1/documents/{emptied}/elements",
        params={"xpath": "//frame", "many": True},
        headers={"if-match": "*"},
    )
    assert done.status_code == 200

    def ask(query: str, *documents: str) -> dict[str, Any]:
        answer = client.get("/api/v1/xpath", params={"q": query, "document": documents})
        assert answer.status_code == 200, answer.text
        found: dict[str, Any] = answer.json()
        return found

    for query in ("//frame_bone/@Rx", "//frame_bone[@Rx > 3]", "//frame[frame_bone/@Rx > 3]"):
        assert ask(query, emptied)["items"] == [], query
        assert ask(query, emptied, full) == ask(query, full)
    for query in ("count(//@Rx)", "sum(//@Rx)"):
        assert ask(query, emptied)["value"] == 0, query
    for query in ("avg(//@Rx)", "min(//@Rx)", "max(//@Rx)", "sum(//@Rx)", "count(//@Rx)"):
        assert ask(query, emptied, full)["value"] == ask(query, full)["value"], query
        assert "value" not in ask(query, emptied) or query.startswith(("sum", "count"))


def _stored(client: TestClient, name: str) -> list[dict[str, Any]]:
    done: Any = upload(client, {f"{name}.bvh": bvh(30)})
    found: list[dict[str, Any]] = done["documents"]
    return found
