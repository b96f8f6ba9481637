"""Bodies of requests convert nothing: each leaf of each example, as another type, is refused."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from typing import Any, get_args, get_origin

import pytest
from fastapi.testclient import TestClient
from pydantic import BaseModel, TypeAdapter, ValidationError

from mcml_schemas.examples import example_of
from mcml_schemas.request_body import RequestBody
from mcml_service.operations import all_operations
from tests.api.asked import API
from tests.builders import bvh, one_kind, upload


def bodies() -> dict[str, Any]:
    """The types of JSON bodies, by the name of the operation."""
    found: dict[str, Any] = {}
    for operation in all_operations():
        for argument in operation.arguments:
            if argument.place == "body":
                found[operation.name] = argument.plain
            elif argument.body is not None and argument.body.model is not None:
                found[operation.name] = argument.body.model
    return found


BODIES = bodies()


def models_in(kind: Any, found: set[type[BaseModel]]) -> set[type[BaseModel]]:
    """The models of a type, and of their fields."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        if kind not in found:
            found.add(kind)
            for field in kind.model_fields.values():
                models_in(field.annotation, found)
    elif get_origin(kind) is not None:
        for inner in get_args(kind):
            models_in(inner, found)
    return found


@pytest.mark.parametrize("name", BODIES)
def test_every_model_in_a_body_is_one(name: str) -> None:
    assert [model.__name__ for model in models_in(BODIES[name], set()) if not issubclass(model, RequestBody)] == []


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(inner, (*path, key))
    else:
        yield path, value


def with_leaf(value: Any, path: tuple[Any, ...], leaf: Any) -> Any:
    changed = deepcopy(value)
    place = changed
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = leaf
    return changed


def others(leaf: Any) -> list[Any]:
    """Values of other types that a lax reader would take for this one."""
    if isinstance(leaf, bool):
        return [int(leaf), str(leaf).lower(), float(leaf)]
    if isinstance(leaf, int | float):
        return [True, False]
    return [1, True] if isinstance(leaf, str) else []


TAKES_NUMBERS = {"change_calibration": ("unit", "reference"), "change_document": ("frame_time",)}
"""Texts that may be written as numbers."""


def test_values_of_another_type_are_refused() -> None:
    tried = 0
    for name, kind in BODIES.items():
        model = get_args(kind)[0] if get_origin(kind) is list else kind
        example, adapter = example_of(model), TypeAdapter(model)
        adapter.validate_python(example)
        for path, leaf in leaves(example):
            for other in others(leaf):
                if path[-1] in TAKES_NUMBERS.get(name, ()) and not isinstance(other, bool):
                    continue
                tried += 1
                with pytest.raises(ValidationError):
                    print(name, path, other, adapter.validate_python(with_leaf(example, path, other)))
    assert tried > 100


@one_kind
def test_the_api_answers_422_and_reads_texts_in_queries(client: TestClient) -> None:
    uuid = upload(client, {"a.bvh": bvh(5)})["documents"][0]["id"]  # type: ignore[index]
    for operation, body in (
        ("POST xpath", {"q": "//frame", "explain": 0}),
        ("POST xpath", {"q": "//frame", "explain": "true"}),
        ("POST xpath", {"q": "//frame", "limit": True}),
        ("POST xpath", {"q": "//frame", "limit": "3"}),
        (f"POST documents/{uuid}/frames", {"edits": [{"do": "delete", "first": True, "last": 1}]}),
        (f"PUT documents/{uuid}/frames", {"columns": ["Hips.Xrotation"], "values": [[False]]}),
        (f"PATCH documents/{uuid}/calibration", {"floor": False}),
        (f"POST documents/{uuid}/labels", [{"name": "walk", "first": True, "last": 2}]),
    ):
        method, path = operation.split()
        answer = client.request(method, f"{API}/{path}", json=body, headers={"if-match": "*"})
        assert answer.status_code == 422, (operation, body, answer.text)
    asked = client.get(f"{API}/xpath", params={"q": "//frame", "explain": "1", "limit": "2"})
    assert asked.status_code == 200, asked.text
    assert len(asked.json()["items"]) == 2
    assert client.post(f"{API}/xpath", json={"q": "//frame", "limit": 2.0}).status_code == 200
