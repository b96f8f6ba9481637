"""Proposed changes of documents, which others review."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcml_schemas.changes import ChangeSet
from mcml_schemas.examples import CURSOR, TIME, shown
from mcml_schemas.frames import FrameEdits
from mcml_schemas.request_body import RequestBody

ProposalState: TypeAlias = Literal["open", "approved", "applied", "closed"]
ProposalKind: TypeAlias = Literal["frames", "changes"]
"""frames: edits of frame ranges. changes: values, labels, elements and fields."""

_EDITS = {"edits": [{"do": "smooth", "first": 100, "last": 142}], "message": "smoothed the turn"}
_PROPOSAL = {
    "number": 3,
    "state": "approved",
    "kind": "frames",
    "summary": "smooth 100-142",
    "message": "smoothed the turn",
    "author": "rea",
    "created": TIME,
    "revision": 4,
    "outdated": False,
    "comments": 2,
    "reviewer": "ed",
    "reviewed": TIME,
    "closer": None,
    "closed": None,
    "applied": None,
}


class ProposalRequest(RequestBody):
    """A change of a document: `edits` of frame ranges, or `changes` of values, labels, elements and fields."""

    model_config = ConfigDict(json_schema_extra=shown({"edits": _EDITS}))

    edits: FrameEdits | None = Field(None, description="As for `POST /documents/{id}/frames`")
    changes: ChangeSet | None = Field(None, description="As for `POST /documents/{id}/changes`")

    @model_validator(mode="after")
    def _one_kind(self) -> ProposalRequest:
        if (self.edits is None) == (self.changes is None):
            raise ValueError("give edits or changes")
        return self


class ProposalView(BaseModel):
    """A proposal. Null: not yet."""

    model_config = ConfigDict(json_schema_extra=shown(_PROPOSAL))

    number: int = Field(description="Counts up in each document")
    state: ProposalState
    kind: ProposalKind
    summary: str = Field(description="The change in words")
    message: str = Field(description="Why, for the history")
    author: str
    created: str
    revision: int = Field(description="Revision that the change was made for")
    outdated: bool = Field(description="Whether it needs a rebase: the document has another revision now")
    comments: int = Field(description="Number of comments on it")
    reviewer: str | None = Field(None, description="Person who approved it")
    reviewed: str | None = Field(None, description="Time of the approval")
    closer: str | None = Field(None, description="Person who applied or closed it")
    closed: str | None = None
    applied: int | None = Field(None, description="Revision that it became")


class ProposalPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_PROPOSAL], "next_cursor": CURSOR}))

    items: list[ProposalView]
    next_cursor: str | None = None


class ProposalDetail(ProposalView):
    """A proposal with its change."""

    model_config = ConfigDict(json_schema_extra=shown({**_PROPOSAL, "edits": _EDITS}))

    edits: FrameEdits | None = None
    changes: ChangeSet | None = None
