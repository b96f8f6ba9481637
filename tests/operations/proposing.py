"""Proposals over HTTP, for tests."""

from __future__ import annotations

from typing import Any

from fastapi.testclient import TestClient

API = "/api/v1"
FRAMES = 40
SMOOTH = {"edits": {"edits": [{"do": "smooth", "first": 5, "last": 30}]}}
NAMED = {"changes": {"labels": [{"name": "hop", "first": 3, "last": 9}]}}


def propose(client: TestClient, uuid: str, request: dict[str, Any] = SMOOTH, match: str = "*") -> dict[str, Any]:
    answer = client.post(f"{API}/documents/{uuid}/proposals", json=request, headers={"if-match": match})
    assert answer.status_code == 201, answer.text
    made: dict[str, Any] = answer.json()
    return made


def do(client: TestClient, uuid: str, number: int, what: str, **asked: Any) -> Any:
    method, path = ("PUT", "approval") if what == "approve" else ("POST", what)
    return client.request(method, f"{API}/documents/{uuid}/proposals/{number}/{path}", params=asked)


def mcml(client: TestClient, uuid: str) -> bytes:
    return client.get(f"{API}/documents/{uuid}/mcml").content
