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

    JSON tells numbers from texts and truth values, so nothing is converted: `0` is no boolean, `false` and `"1"` are no
    numbers. A whole number may be written as `1.0`, as JSON Schema has it.
    """

    model_config = ConfigDict(extra="forbid")

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler, /) -> CoreSchema:
        made = handler(source)
        model: Any = handler.resolve_ref_schema(made)
        while model["type"] != "model":
            # Functions that look at the whole body stand around it.
            model = model["schema"]
        model["schema"] = _make_strict(model["schema"])
        return made
