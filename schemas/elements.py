"""Edits of single elements."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from schemas.examples import ADDRESS, shown


class ElementChange(BaseModel):
    """New values of an element: attributes (null removes one) and the text of a leaf; what is left out stays."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra=shown({"attributes": {"Rx": "45.25", "SF": None}, "message": "a spike"}),
    )

    attributes: dict[str, str | None] = Field(default_factory=dict)
    text: str | None = None
    message: str = Field("", max_length=4096, description="Why, for the history")


class ElementEdited(BaseModel):
    """What an edit did: the address of the element, and the revision that it made."""

    model_config = ConfigDict(json_schema_extra=shown({"address": ADDRESS, "revision": 2}))

    address: str
    revision: int
