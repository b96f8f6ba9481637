"""Lists narrowed by words, length, rate and questions; and what they can be narrowed by, counted."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.lists.facets import make_bins
from tests.builders import TRC, bvh, upload
from tests.conftest import StoreOf

API = "/api/v1"


def fill(client: TestClient) -> None:
    more: dict[str, Any] = {"description": "Reaching for the shelf.", "project": "reach"}
    upload(client, {"reach_14_064.bvh": bvh(120)}, label="left-arm-abduction:1-9", property=["age=14 year"], **more)
    upload(client, {"reach_15_001.bvh": bvh(240, seed=1)}, property=["age=64 year", "take=calm"], **more)
    upload(client, {"hand.trc": TRC}, project="hands", label="wave")
    slow = bvh(30, seed=2).replace(b"Frame Time: 0.0083333", b"Frame Time: 0.0333333")
    upload(client, {"slow.bvh": slow}, property=["age=20 year"])


@pytest.fixture
def client(kind: str, store_of: StoreOf) -> TestClient:
    return store_of(kind, fill)[0]


def names(client: TestClient, **asked: object) -> list[str]:
    answer = client.get(f"{API}/documents", params=asked)  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    found = [item["name"] for item in answer.json()["items"]]
    assert answer.json()["total"] == len(found)
    counted = client.get(f"{API}/facets", params=asked).json()  # type: ignore[arg-type]
    assert counted["total"] == len(found), "facets count within the filter"
    return found


REACHES = ["reach_14_064", "reach_15_001"]


@pytest.mark.parametrize(
    ("asked", "wanted"),
    [
        ({"q": "reach 14"}, REACHES[:1]),
        ({"q": "14 REACH"}, REACHES[:1]),
        ({"q": "shelf"}, REACHES),
        ({"q": "calm 15"}, REACHES[1:]),
        ({"q": "abduction reach"}, REACHES[:1]),
        ({"q": "reach wave"}, []),
        ({"q": "100%"}, []),
        ({"q": "bvh"}, []),
        ({"q": "  "}, ["hand", *REACHES, "slow"]),
        ({"length": "0.9..1.1"}, ["reach_14_064", "slow"]),
        ({"length": "..0.5"}, ["hand"]),
        ({"length": "1.5.."}, ["reach_15_001"]),
        ({"rate": "30"}, ["slow"]),
        ({"rate": "120"}, ["hand", *REACHES]),
        ({"rate": "29..31"}, ["slow"]),
        ({"xpath": "//frame[motion_name='wave']"}, ["hand"]),
        ({"xpath": "count(//frame) > 100"}, REACHES),
        ({"xpath": "true()", "rate": "30"}, ["slow"]),
        ({"xpath": "false()"}, []),
        ({"xpath": "//frame[motion_name='wave']", "project": "reach"}, []),
    ],
)
def test_lists_are_narrowed(client: TestClient, asked: dict[str, str], wanted: list[str]) -> None:
    assert names(client, **asked) == wanted


@pytest.mark.parametrize("asked", [{"length": "2"}, {"length": "a..b"}, {"rate": "fast"}, {"xpath": "//["}])
def test_conditions_that_are_none_are_refused(client: TestClient, asked: dict[str, str]) -> None:
    for path in ("documents", "facets"):
        answer = client.get(f"{API}/{path}", params=asked)
        assert answer.status_code == 422
        assert answer.json()["remedy"] or answer.json()["detail"]


def test_facets_of_a_library(client: TestClient) -> None:
    found = client.get(f"{API}/facets", params={"bins": 2}).json()
    assert found["total"] == 4
    assert found["projects"] == [
        {"value": name, "documents": count} for name, count in (("reach", 2), ("default", 1), ("hands", 1))
    ]
    assert found["formats"] == [{"value": "bvh", "documents": 3}, {"value": "trc", "documents": 1}]
    assert {item["joints"] for item in found["skeletons"]} == {3}
    assert sum(item["documents"] for item in found["skeletons"]) == 4
    assert found["motion_names"] == [
        {"value": "left-arm-abduction", "documents": 1}, {"value": "wave", "documents": 1},
    ]  # fmt: skip
    assert found["rates"] == [{"value": 120, "documents": 3}, {"value": 30, "documents": 1}]
    assert sum(found["lengths"]["counts"]) == 4
    age, take = found["properties"]
    assert (age["name"], age["documents"], age["numbers"]) == ("age", 3, {"edges": [14, 39, 64], "counts": [2, 1]})
    assert (take["name"], take["numbers"], take["texts"]) == ("take", None, [{"value": "calm", "documents": 1}])
    narrow = client.get(f"{API}/facets", params={"project": "hands"}).json()
    assert (narrow["total"], narrow["properties"]) == (1, [])
    assert client.get(f"{API}/facets", params={"q": "nothing at all"}).json()["lengths"] is None


def test_bins() -> None:
    found = make_bins([1.0, 2.0, 9.0], 4)
    assert found is not None
    assert (found.edges, found.counts) == ([1, 3, 5, 7, 9], [2, 0, 0, 1])
    far = make_bins([0.0, 1.0, 2.0, 5.0, 30.0, 1000.0], 3)
    assert far is not None
    assert far.edges == pytest.approx([0, 10, 100, 1000])
    assert far.counts == [4, 1, 1], "a ratio over 50: tenfold steps, zero in the first"
    assert (far.edges[0], far.edges[-1]) == (0, 1000)
    near = make_bins([1.0, 2.0, 50.0], 2)
    assert near is not None
    assert near.edges == [1, 25.5, 50]
    minus = make_bins([-1.0, 0.001, 1000.0], 2)
    assert minus is not None
    assert minus.edges == [-1, 499.5, 1000], "numbers below 0 have no ratio"
    assert sum((make_bins([5e-324, 1e308], 7) or far).counts) == 2
    one = make_bins([3.0, 3.0], 4)
    assert one is not None
    assert (one.edges, one.counts) == ([3, 3], [2])
    assert make_bins([-1e308, 1e308], 2) is not None
