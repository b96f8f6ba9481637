"""Runs of an XPath answer with their totals and ranges; completions with how many documents have a name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from tests.builders import bvh, upload
from tests.conftest import StoreOf

API = "/api/v1"


def fill(client: TestClient) -> list[str]:
    names = {"a.bvh": bvh(700), "b.bvh": bvh(300, seed=1), "c.bvh": bvh(30, seed=2, names=("Root", "Tail"))}
    found = [str(upload(client, {name: content})["documents"][0]["id"]) for name, content in names.items()]  # type: ignore[index]
    for uuid in found[:2]:
        label = [{"name": "walk", "first": 3, "last": 9}, {"name": "turn", "first": 20, "last": 22}]
        client.post(f"{API}/documents/{uuid}/labels", json=label, headers={"if-match": "*"})
    return found


@pytest.fixture
def client(kind: str, store_of: StoreOf) -> TestClient:
    return store_of(kind, fill)[0]


def ask(client: TestClient, q: str, **more: object) -> dict[str, Any]:
    asked = {"q": q, "as": "runs", "with": "totals,range", **more}
    answer = client.get(f"{API}/xpath", params=asked)  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


SPINE = "//frame/frame_bone[@name='Spine'][@Rx > 5]"


@pytest.mark.parametrize("q", [SPINE, f"{SPINE}/@Rx", "//frame[frame_bone[@name='Spine']/@Rx > 5]"])
def test_totals_and_ranges(client: TestClient, q: str) -> None:
    whole = ask(client, q, limit=1000)
    items = whole["items"]
    assert whole["totals"] == {
        "frames": sum(item["frames"] for item in items),
        "runs": len(items),
        "documents": len({item["document"] for item in items}),
    }
    assert whole["range_of"] == "Spine.Rx"
    for item in items[:5]:
        asked = {"first": item["first"], "last": item["last"], "bone": "Spine", "limit": 1000}
        frames = client.get(f"{API}/documents/{item['document']}/frames", params=asked).json()["items"]
        values = np.array([frame["values"]["Spine"]["Rx"] for frame in frames])
        assert item["range"] == [values.min(), values.max()]
        assert item["mean"] == pytest.approx(values.mean(), rel=1e-12)
    first = ask(client, q, limit=2)
    assert (first["totals"], len(first["items"])) == (whole["totals"], 2)
    second = ask(client, q, limit=2, cursor=first["next_cursor"])
    assert second["items"] == items[2:4]


def test_runs_that_no_sample_decides_have_no_range(client: TestClient) -> None:
    found = ask(client, "//frame[motion_name='walk']")
    assert found["totals"] == {"frames": 14, "runs": 2, "documents": 2}
    assert "range_of" not in found
    assert all("range" not in item for item in found["items"])
    assert "totals" not in ask(client, SPINE, **{"with": "range"})
    assert client.get(f"{API}/xpath", params={"q": SPINE, "with": "everything"}).status_code == 422


def test_completions_count(client: TestClient) -> None:
    def counts(q: str) -> dict[str, int | None]:
        items = client.get(f"{API}/xpath/complete", params={"q": q}).json()["items"]
        return {item["text"]: item["documents"] for item in items}

    assert counts("//frame[motion_name='") == {"turn": 2, "walk": 2}
    assert counts("//frame_bone[@name='") == {"Head": 2, "Root": 3, "Spine": 2, "Tail": 1}
    assert counts("//fram")["frame"] is None
