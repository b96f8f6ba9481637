"""The API's description shows an example of every request and every answer, and the examples are true."""

from __future__ import annotations

import importlib
import pkgutil
from typing import Any

import pytest
from lxml import etree
from pydantic import BaseModel

import mcml_schemas
from mcml.language import dtd
from mcml_schemas import examples
from mcml_service.operations.analyses import make_operations
from tests.builders import description
from tests.conftest import StoreOf

DESCRIPTION = description()
OPERATIONS = [
    pytest.param(method, path, operation, id=operation["operationId"])
    for path, methods in DESCRIPTION["paths"].items()
    for method, operation in methods.items()
]
every_operation = pytest.mark.parametrize(("method", "path", "operation"), OPERATIONS)


def models() -> dict[str, type[BaseModel]]:
    """Every model of the wire by its name."""
    found: dict[str, type[BaseModel]] = {}
    for module in pkgutil.walk_packages(mcml_schemas.__path__, "mcml_schemas."):
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, type) and issubclass(value, BaseModel) and value.__module__ == module.name:
                found[name] = value
    return found


MADE = {operation.model.__name__: operation.model for operation in make_operations() if operation.model is not None}
"""Answers of operations, which are made from the catalogue of analyses."""


def resolved(schema: dict[str, Any]) -> dict[str, Any]:
    name = schema.get("$ref", "").rpartition("/")[2]
    return DESCRIPTION["components"]["schemas"][name] if name else schema


def has_example(place: dict[str, Any]) -> bool:
    return bool(place.get("example") is not None or place.get("examples"))


def says_its_values(schema: dict[str, Any]) -> bool:
    """Whether a schema lists all values that there are, so that an example would say nothing more."""
    kinds = [kind for kind in schema.get("anyOf", [schema]) if kind.get("type") != "null"]
    return all(kind.get("type") == "boolean" or "enum" in kind or "const" in kind for kind in kinds)


@every_operation
def test_parameters_have_examples(method: str, path: str, operation: dict[str, Any]) -> None:
    for parameter in operation.get("parameters", []):
        schema = parameter["schema"]
        assert has_example(parameter if parameter["required"] else schema) or says_its_values(schema), parameter["name"]


@every_operation
def test_requests_have_examples(method: str, path: str, operation: dict[str, Any]) -> None:
    for kind, media in operation.get("requestBody", {}).get("content", {}).items():
        assert has_example(media), kind
        if kind == "multipart/form-data":
            fields = resolved(media["schema"])["properties"]
            missing = [name for name, field in fields.items() if not has_example(field) and not says_its_values(field)]
            assert not missing


@every_operation
def test_answers_have_examples(method: str, path: str, operation: dict[str, Any]) -> None:
    good = {status: answer for status, answer in operation["responses"].items() if status.startswith("2")}
    assert good
    for status, answer in good.items():
        contents = answer.get("content", {})
        assert contents or status == "204"
        for kind, media in contents.items():
            told = kind != "application/json" and answer["description"] != "Successful Response"
            assert has_example(media) or told, kind


@every_operation
def test_problems_have_examples(method: str, path: str, operation: dict[str, Any]) -> None:
    assert has_example(operation["responses"]["4XX"]["content"]["application/problem+json"])


@every_operation
def test_answers_of_a_store_that_is_away_or_full_are_described(
    method: str, path: str, operation: dict[str, Any]
) -> None:
    assert {"4XX", "503", "507"} <= operation["responses"].keys()


@pytest.mark.parametrize("path", ["/api/v1/compose", "/api/v1/documents/{id}/retarget"])
def test_previews_are_described(path: str) -> None:
    responses = DESCRIPTION["paths"][path]["post"]["responses"]
    assert (
        responses["200"]["content"]["application/json"]["schema"]
        == (responses["201"]["content"]["application/json"]["schema"])
    )


SHOWN = [
    pytest.param(model, example, id=f"{name}-{number}")
    for name, model in models().items()
    for number, example in enumerate((model.model_config.get("json_schema_extra") or {}).get("examples", ()))
]


@pytest.mark.parametrize(("model", "example"), SHOWN)
def test_examples_fit_their_models(model: type[BaseModel], example: dict[str, Any]) -> None:
    """Every name and value of an example is read, and said again, by its model."""
    assert model.model_validate(example).model_dump(by_alias=True, exclude_unset=True) == example


@every_operation
def test_answers_show_the_example_of_their_model(method: str, path: str, operation: dict[str, Any]) -> None:
    for status, answer in operation["responses"].items():
        media = answer.get("content", {}).get("application/json")
        if media is not None and status.startswith("2"):
            name = media["schema"]["$ref"].rpartition("/")[2]
            (models() | MADE)[name].model_validate(media["example"])


@pytest.mark.slow
@every_operation
def test_requests_of_examples_are_understood(
    method: str, path: str, operation: dict[str, Any], store_of: StoreOf
) -> None:
    """Nothing of what the description shows is refused as malformed; that the document does not exist is no matter."""
    client, _ = store_of("sqlite", lambda _: None)
    query: dict[str, Any] = {}
    headers: dict[str, str] = {}
    for parameter in operation.get("parameters", []):
        example = next(iter(parameter["schema"].get("examples", ())), None)
        if parameter["in"] == "path":
            path = path.replace(f"{{{parameter['name']}}}", str(example))
        elif parameter["in"] == "header":
            headers[parameter["name"]] = example
        elif example is not None and parameter["name"] != "cursor":
            query[parameter["name"]] = example
    if "seconds" in query:
        query["seconds"] = 0  # Nobody waits for what does not happen.
    content = operation.get("requestBody", {}).get("content", {})
    form = dict(content.get("multipart/form-data", {}).get("example", {}))
    files = [("file", (name, b"HIERARCHY")) for name in form.pop("file", [])]
    answer = client.request(
        method,
        path,
        params=query,
        headers=headers,
        json=content.get("application/json", {}).get("example"),
        data=form or None,
        files=files or None,
    )
    assert answer.status_code < 500
    if not answer.is_success:
        assert answer.json()["type"] != "/docs/problems#invalid-request", answer.json()


def test_the_examples_of_documents_are_valid() -> None:
    assert dtd.violations(examples.MCML.encode()) == []
    results = etree.fromstring(examples.RESULTS.encode())
    assert [node.tag for node in results.iter()] == ["results", "result", "frame_bone"]
