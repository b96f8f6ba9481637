"""Edits of single elements."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class ElementChange(BaseModel):
    """New values of an element: attributes (null removes one) and the text of a leaf; what is left out stays."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"attributes": {"Rx": "45.25"}}]})

    attributes: dict[str, str | None] = Field(default_factory=dict)
    text: str | None = None
    message: str = Field("", max_length=4096, description="Why, for the history")


class ElementEdited(BaseModel):
    """What an edit did: the address of the element, and the revision that it made."""

    address: str
    revision: int
