"""The motion names that a project agrees on: kept, checked and changed by who knows the present version."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from tests.builders import one_kind

ADDRESS = "/api/v1/vocabulary"
GAIT = {"project": "gait"}
WORDS = [
    {"name": "walk", "description": "on both feet", "colour": 3},
    {"name": "left-arm-abduction", "description": ""},
]


def test_a_project_agrees_on_names(client: TestClient) -> None:
    none = {"project": "gait", "version": 0, "author": "", "changed": "", "items": []}
    assert client.get(ADDRESS, params=GAIT).json() == none
    typed = [WORDS[0], {"name": "Left arm_abduction"}]
    made = client.put(ADDRESS, params=GAIT, json={"items": typed})
    assert (made.status_code, made.headers["etag"], made.json()["items"]) == (201, '"1"', WORDS)
    assert client.put(ADDRESS, params=GAIT, json={"items": WORDS[:1]}).status_code == 428
    match = {"if-match": '"1"'}
    changed = client.put(ADDRESS, params=GAIT, json={"items": WORDS[:1]}, headers=match)
    assert (changed.status_code, changed.json()["version"]) == (200, 2)
    assert client.put(ADDRESS, params=GAIT, json={"items": WORDS}, headers=match).status_code == 412
    assert client.get(ADDRESS, params=GAIT).json() == changed.json()
    assert client.get(ADDRESS).json()["items"] == [], "of another project"
    assert client.delete(ADDRESS, params=GAIT, headers=match).status_code == 412
    assert client.delete(ADDRESS, params=GAIT, headers={"if-match": "*"}).status_code == 204
    assert client.get(ADDRESS, params=GAIT).json() == none
    assert client.delete(ADDRESS, params=GAIT, headers={"if-match": "*"}).status_code == 404


@pytest.mark.parametrize(
    ("items", "what"),
    [
        ([{"name": "left-shoulder-abduction"}], "left-arm-abduction"),
        ([{"name": "walk"}, {"name": " walk "}], "there twice"),
        ([{"name": "left-arm-front"}, {"name": "left-arm-flexion"}], "there twice"),
        ([{"name": "walk", "colour": 8}], "less than or equal to 7"),
        ([], "at least 1"),
    ],
)
@one_kind
def test_names_that_cannot_be_are_refused(client: TestClient, items: list[dict[str, object]], what: str) -> None:
    answer = client.put(ADDRESS, json={"items": items})
    assert answer.status_code == 422
    assert what in f"{answer.json()['detail']} {answer.json().get('remedy')}"
    assert client.get(ADDRESS).json()["version"] == 0
