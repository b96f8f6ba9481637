"""Comments on documents."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcml_schemas.examples import CURSOR, TIME, shown
from mcml_schemas.request_body import RequestBody

Text: TypeAlias = Annotated[
    str,
    # No control characters but tabs and line feeds, which not every database holds.
    Field(
        min_length=1, max_length=4000, pattern=r"^[^\x00-\x08\x0b-\x1f\x7f]*$", description="@name mentions a person"
    ),
]
_PLACE = {"first": 100, "last": 142, "bone": "left_foot"}
_TEXT = "@kim the foot slides here"
_COMMENT = {
    "id": 7,
    "revision": 3,
    **_PLACE,
    "first_now": 80,
    "last_now": 122,
    "author": "sam",
    "created": TIME,
    "text": _TEXT,
    "mentions": ["kim"],
}


class CommentRequest(RequestBody):
    """About the document as a whole, or some of its frames, or one joint, or one joint in some frames."""

    model_config = ConfigDict(json_schema_extra=shown({"text": _TEXT, **_PLACE}))

    text: Text
    first: int | None = Field(None, ge=1, le=2**31 - 1, description="First frame, a position from 1")
    last: int | None = Field(None, ge=1, le=2**31 - 1, description="Last frame, included; default the first one")
    bone: str | None = Field(None, min_length=1, max_length=1024, description="Name of a joint")
    revision: int | None = Field(None, ge=1, le=2**31 - 1, description="That was looked at; default the current one")
    proposal: int | None = Field(None, ge=1, le=2**31 - 1, description="Number of the proposal that it is about")

    @model_validator(mode="after")
    def _in_order(self) -> CommentRequest:
        if self.last is not None and (self.first is None or self.first > self.last):
            raise ValueError("the last frame is before the first one")
        return self


class CommentChange(RequestBody):
    model_config = ConfigDict(json_schema_extra=shown({"text": _TEXT}))

    text: Text


class CommentView(BaseModel):
    """revision: that was looked at; first, last: frames there, None for all. first_now, last_now: the smallest range of
    the current revision with these frames; None if no frame is left, or if that revision is no longer kept. proposal:
    number of the proposal that it is about, None for the document itself. edited, resolved: when, None for never.
    mentions: people of the project whom the text names.
    """

    model_config = ConfigDict(json_schema_extra=shown(_COMMENT))

    id: int
    revision: int
    author: str
    created: str
    text: str
    mentions: list[str]
    first: int | None = None
    last: int | None = None
    first_now: int | None = None
    last_now: int | None = None
    bone: str | None = None
    proposal: int | None = None
    edited: str | None = None
    resolved: str | None = None


class CommentPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_COMMENT], "next_cursor": CURSOR}))

    items: list[CommentView]
    next_cursor: str | None = None
