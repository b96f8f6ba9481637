"""The base of all JSON request bodies: unknown fields and values of another type are refused."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticKnownError
from pydantic_core.core_schema import no_info_before_validator_function


def _make_strict(part: Any) -> Any:
    """A part of the schema of a model that converts nothing. Models in it have seen to their own fields."""
    if isinstance(part, list):
        part[:] = [_make_strict(inner) for inner in part]
    elif isinstance(part, tuple):
        return tuple(_make_strict(inner) for inner in part)
    elif isinstance(part, dict) and part.get("type") != "model":
        for name, inner in part.items():
            if name not in ("metadata", "serialization"):
                part[name] = _make_strict(inner)
        if part.get("type") in ("bool", "float"):
            part["strict"] = True
        elif part.get("type") == "int":
            return no_info_before_validator_function(_whole, part)
    return part


def _whole(value: Any) -> Any:
    if isinstance(value, bool | str | bytes):
        raise PydanticKnownError("int_type")
    return value


class RequestBody(BaseModel):
    """A body of a request, or a part of one.

    JSON distinguishes numbers, texts and booleans, so nothing is converted: `0` is not a boolean, `false` and `"1"` are
    not numbers. An integer may be written as `1.0`, as in JSON Schema.
    """

    model_config = ConfigDict(extra="forbid")

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler, /) -> CoreSchema:
        made = handler(source)
        model: Any = handler.resolve_ref_schema(made)
        while model["type"] != "model":
            # Validators of the whole body wrap it.
            model = model["schema"]
        model["schema"] = _make_strict(model["schema"])
        return made
