"""Errors as problem details (RFC 9457)."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import PROBLEM, shown


class Where(BaseModel):
    """The place in the input; parts that do not apply are omitted."""

    file: str | None = None
    line: int | None = Field(None, description="From 1")
    column: int | None = Field(None, description="From 1")
    element: str | None = Field(None, description="Address of an element")


class Problem(BaseModel):
    """An error: the problem, the place and the remedy."""

    model_config = ConfigDict(json_schema_extra=shown(PROBLEM))

    type: str
    title: str
    status: int
    detail: str
    where: Where | None = None
    remedy: str | None = None
    code: str | None = Field(None, description="The name of the fault, where it has one")
    details: dict[str, Any] | None = Field(
        None, description="Details, such as the document, conflicts, repairs, or a suggestion"
    )
    request: str | None = Field(None, description="Id of the request, as the log of the server has it")
    errors: list[dict[str, Any]] | None = None
    problems: list[dict[str, Any]] | None = Field(
        None, description="Errors of each file, for an upload that stored nothing"
    )
