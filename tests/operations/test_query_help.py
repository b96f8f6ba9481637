"""Examples of queries that find frames in the library, ranges of quantities for thresholds, figures of runs."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, store
from tests.motion.bodies.made import person

pytestmark = one_kind
API = "/api/v1"


def examples(client: TestClient, **query: Any) -> Any:
    answer = client.get(f"{API}/xpath/examples", params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()


def label(client: TestClient, document: str, name: str) -> None:
    labels = [{"name": name, "first": 5, "last": 30}]
    made = client.post(f"{API}/documents/{document}/labels", json=labels, headers={"if-match": "*"})
    assert made.status_code == 201, made.text


def values_of(client: TestClient, document: str, quantity: str) -> Any:
    asked = {"quantity": quantity, "format": "npz"}
    answer = client.get(f"{API}/documents/{document}/frames", params=asked)
    assert answer.status_code == 200, answer.text
    return np.load(io.BytesIO(answer.content))["values"][:, 0]


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is found does not depend on how busy the machine is."""
    monkeypatch.setattr("mcml_service.operations.query_help._SECONDS", 60.0)


@pytest.fixture
def people(client: TestClient, database: Database) -> list[str]:
    found = store(database, {f"person_{seed}.bvh": person(seed, 90) for seed in range(3)})
    label(client, found[0], """it's a "hop\"""")
    return found


@pytest.mark.slow
def test_eight_examples_find_frames_and_six_are_about_bodies(client: TestClient, people: list[str]) -> None:
    found = examples(client)
    assert found["document"] in people
    assert len(found["items"]) == 8
    assert sum("mo:" in each["q"] for each in found["items"]) == 6
    assert len({each["kind"] for each in found["items"]}) == 8
    for each in found["items"]:
        answer = client.get(f"{API}/xpath", params={"q": each["q"], "as": "runs", "limit": 1})
        assert answer.status_code == 200, answer.text
        assert answer.json()["items"], each["q"]
        numbers = [f"{value:g}" for value in each["values"].values() if isinstance(value, float)]
        assert all(number in each["q"] for number in numbers), each


def test_no_example_is_unchecked_when_the_time_is_up(
    client: TestClient, people: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mcml_service.operations.query_help._SECONDS", 0.0)
    assert examples(client) == {"items": [], "document": None}
    monkeypatch.undo()
    assert examples(client)["items"]


@pytest.mark.slow
def test_examples_follow_the_library(client: TestClient, people: list[str]) -> None:
    before = examples(client)
    assert examples(client) == before
    for document in people:
        client.delete(f"{API}/documents/{document}", headers={"if-match": "*"})
    assert examples(client) == {"items": [], "document": None}


def test_a_library_without_bodies_has_examples_of_elements_only(client: TestClient, database: Database) -> None:
    store(database, {"stick.bvh": bvh(40, names=("box", "lid"))})
    found = examples(client)
    assert [each["kind"] for each in found["items"]] == ["begin", "every"]


@pytest.mark.slow
def test_a_project_has_examples_of_its_own(client: TestClient, people: list[str]) -> None:
    answer = client.post(f"{API}/documents", files={"file": ("other.bvh", person(8, 60))}, data={"project": "others"})
    (other,) = [each["id"] for each in answer.json()["documents"]]
    label(client, other, "only here")
    found = examples(client, project="others")
    assert found["document"] == other
    assert [each["values"] for each in found["items"] if each["kind"] == "label"] == [{"name": "only here"}]
    assert client.get(f"{API}/xpath/examples", params={"project": "nowhere"}).status_code == 404


@pytest.mark.parametrize(
    "quantity", ["speed:left_hand", "height:Head", "angle:left-knee-flexion", "angle:left-wrist-flexion"]
)
def test_the_range_of_a_quantity_is_that_of_its_frames(client: TestClient, people: list[str], quantity: str) -> None:
    found = client.get(f"{API}/quantities/range", params={"quantity": quantity}).json()
    values = np.concatenate([values_of(client, document, quantity) for document in people])
    values = values[~np.isnan(values)]
    assert found["clips"] == len(people)
    for name, share in {"least": 0, "low": 0.05, "middle": 0.5, "high": 0.95, "most": 1}.items():
        assert found[name] == pytest.approx(np.quantile(values, share), rel=1e-9)


def test_a_quantity_that_no_clip_has_is_without_a_range(client: TestClient, people: list[str]) -> None:
    found = client.get(f"{API}/quantities/range", params={"quantity": "speed:tail"}).json()
    assert (found["clips"], found["least"], found["most"]) == (0, None, None)
    assert client.get(f"{API}/quantities/range", params={"quantity": "zeal:tail"}).status_code == 422


@pytest.mark.parametrize(
    ("condition", "quantity", "written"),
    [
        ("mo:speed('left_hand') > 1", "speed:left_hand", "mo:speed('left_hand')"),
        (
            "not(mo:contact('left_toes')) and mo:angle('left-knee-flexion') > 5",
            "angle:left-knee-flexion",
            "mo:angle('left-knee-flexion')",
        ),
        ("not(mo:height('Head') < 1) and mo:speed('Head') > 0", "height:Head", "mo:height('Head')"),
        ("mo:angle('left-wrist-flexion') < 20", "angle:left-wrist-flexion", "mo:angle('left-wrist-flexion')"),
    ],
)
def test_runs_have_the_figures_of_the_first_quantity(
    client: TestClient, people: list[str], condition: str, quantity: str, written: str
) -> None:
    asked = {"q": f"//frame[{condition}]", "as": "runs", "with": "range", "limit": 40}
    answer = client.get(f"{API}/xpath", params=asked).json()
    assert answer["range_of"] == written
    assert answer["items"]
    for run in answer["items"]:
        values = values_of(client, run["document"], quantity)[run["first"] - 1 : run["last"]]
        assert run["range"] == [values.min(), values.max()]
        assert run["mean"] == pytest.approx(values.mean(), rel=1e-9)


def test_runs_of_a_query_without_a_number_have_no_figures(client: TestClient, people: list[str]) -> None:
    asked = {"q": "//frame[not(mo:contact('left_toes'))]", "as": "runs", "with": "range"}
    answer = client.get(f"{API}/xpath", params=asked).json()
    assert "range_of" not in answer
    assert "mean" not in answer["items"][0]
