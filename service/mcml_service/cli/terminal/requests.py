"""Requests from the options of commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import typer
from pydantic import BaseModel, ValidationError

Request = TypeVar("Request", bound=BaseModel)


def request_of(model: type[Request], values: Mapping[str, Any]) -> Request:
    """Return a request. Raises typer.BadParameter with the option or the part of the request that does not fit."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        fault = error.errors()[0]
        names = [part.replace("_", "-") for part in fault["loc"] if isinstance(part, str) and part.isidentifier()]
        raise typer.BadParameter(": ".join([*names[-1:], fault["msg"].removeprefix("Value error, ")])) from None
