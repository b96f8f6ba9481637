"""The API's description (OpenAPI): FastAPI's description of the endpoints, with corrected problems and examples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI
from pydantic.json_schema import models_json_schema

from mcml_schemas.problem import Problem
from mcml_service.api.authentication import COOKIE

REF = "#/components/schemas/{model}"
SECURITY = {
    "token": {"type": "http", "scheme": "bearer", "description": "As `mcml token add` made it"},
    "session": {
        "type": "apiKey",
        "in": "cookie",
        "name": COOKIE,
        "description": "Of a browser: POST /api/v1/session. By https its name begins with `__Host-`",
    },
}
_PROBLEM = {"application/problem+json": {"schema": {"$ref": REF.format(model="Problem")}}}


def install(app: FastAPI) -> None:
    """Let `/openapi.json` name the problems, and show the models' examples where requests and answers use them."""
    make = app.openapi

    def describe() -> dict[str, Any]:
        if app.openapi_schema is None:
            schema = make()
            schemas = schema["components"]["schemas"]
            schemas.update(models_json_schema([(Problem, "serialization")], ref_template=REF)[1]["$defs"])
            for operation in (item for path in schema["paths"].values() for item in path.values()):
                _name_problems(operation)
                for parameter in operation.get("parameters", []):
                    # The reference fills a form with these; in optional fields they would add unwanted conditions.
                    if parameter.get("required"):
                        _show(parameter, _first(parameter["schema"], schemas))
                for media in _contents(operation):
                    _show(media, _first(media.get("schema", {}), schemas))
            schema["servers"] = [{"url": "/", "description": "This server"}]
            schema["components"]["securitySchemes"] = SECURITY
            # A repository that one person alone uses, on the machine itself, needs neither.
            schema["security"] = [{"token": []}, {"session": []}, {}]
            for model in schemas.values():
                _say_binary(model)
            for name in ("HTTPValidationError", "ValidationError"):
                schemas.pop(name, None)
            app.openapi_schema = schema
        return app.openapi_schema

    app.openapi = describe  # type: ignore[method-assign]


def _say_binary(model: dict[str, Any]) -> None:
    """Describe files in forms also in the older form, for client generators: pydantic uses only the newer form."""
    for field in model.get("properties", {}).values():
        for kind in (field, field.get("items", {})):
            if kind.get("contentMediaType") == "application/octet-stream":
                kind["format"] = "binary"


def _name_problems(operation: dict[str, Any]) -> None:
    """Replace FastAPI's own form of errors, which is never sent; every refusal is a problem."""
    operation["responses"].pop("422", None)
    operation["responses"]["4XX"] = {"description": "A problem: what, where, remedy", "content": dict(_PROBLEM)}
    away = "Too many requests, or the store is unreachable: retry after `Retry-After` seconds"
    for status, reason in (("503", away), ("507", "The disk is full: nothing was written")):
        operation["responses"].setdefault(status, {"description": reason, "content": dict(_PROBLEM)})


def _contents(operation: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for part in (operation.get("requestBody", {}), *operation["responses"].values()):
        for name, media in part.get("content", {}).items():
            part["content"][name] = media = dict(media)
            yield media


def _show(place: dict[str, Any], example: Any) -> None:
    if example is not None and "example" not in place and "examples" not in place:
        place["example"] = example


def _first(schema: dict[str, Any], schemas: dict[str, Any]) -> Any:
    """The first example of a schema; of a form or an array, made from those of its parts. None where it has none."""
    if "$ref" in schema:
        schema = schemas[schema["$ref"].rpartition("/")[2]]
    if schema.get("examples"):
        return schema["examples"][0]
    if schema.get("type") == "array":
        item = _first(schema.get("items", {}), schemas)
        return None if item is None else [item]
    parts = {name: _first(part, schemas) for name, part in schema.get("properties", {}).items()}
    return {name: example for name, example in parts.items() if example is not None} or None
