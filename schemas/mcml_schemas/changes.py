"""All changes of a draft in one request."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Base64Bytes, BaseModel, ConfigDict, Field, model_validator

from mcml_schemas.documents import DocumentChange, LabelRequest
from mcml_schemas.elements import Edit
from mcml_schemas.examples import FRAME_BONE, LABEL_REQUEST, shown
from mcml_schemas.request_body import RequestBody

_CHANGES = {
    "frames": [{"first": 100, "columns": ["left_up_leg.Rx"], "values": [[45.2], [None], [45.9]]}],
    "elements": [{"do": "replace", "xpath": "/mcml/motion/frame[7]/frame_bone[3]", "fragment": FRAME_BONE}],
    "labels": [LABEL_REQUEST],
    "document": {"unit": "cm"},
    "message": "smoothed the knee",
}
_CONFLICT = {
    "kind": "frames",
    "address": "left_up_leg.Rx",
    "first": 100,
    "last": 101,
    "base": [44.0, 44.1],
    "theirs": [43.0, 43.1],
    "mine": [45.2, 45.4],
}


class FrameBlock(RequestBody):
    """Samples of consecutive frames: `values`, rows of numbers; or `data`, the same as little-endian doubles, row after
    row, as base64. null, or NaN, keeps a sample.
    """

    first: int = Field(ge=1, le=2**31 - 1, description="Frame of the first row")
    columns: list[str] = Field(min_length=1, max_length=100_000, description="BONE.CHANNEL of each column")
    values: list[list[float | None]] | None = None
    data: Base64Bytes | None = None

    @model_validator(mode="after")
    def _one_form(self) -> FrameBlock:
        if (self.values is None) == (self.data is None):
            raise ValueError("give values or data")
        return self


class ChangeSet(RequestBody):
    """Changes of a document; everything refers to the document before the changes.

    labels: the complete new list; if omitted, labels do not change.
    """

    model_config = ConfigDict(json_schema_extra=shown(_CHANGES))

    frames: list[FrameBlock] = Field(default_factory=list, max_length=10_000)
    elements: list[Edit] = Field(default_factory=list, max_length=10_000)
    many: bool = Field(False, description="Expressions may select several elements; each is edited so")
    renumber: bool = Field(True, description="Ids of frames that counted up by one do so again")
    labels: Annotated[list[LabelRequest], Field(max_length=100_000)] | None = None
    document: DocumentChange | None = Field(None, description="Name, project, description, properties, unit …")
    message: str = Field("", max_length=4096, description="Why, for the history")


class Conflict(BaseModel):
    """A conflict with a change by somebody else: the old, the current and the requested value."""

    kind: Literal["element", "frames", "label", "fact"]
    address: str = Field(description="Of the element; else the channel, motion name or fact")
    first: int | None = Field(None, description="First frame, as it is now")
    last: int | None = None
    base: Any = None
    theirs: Any = None
    mine: Any = None


class Fault(BaseModel):
    """Why a part of the changes cannot be made."""

    part: Literal["elements", "frames", "labels", "document", "all"]
    number: int | None = Field(None, description="Which of the part, from 0")
    what: str
    line: int | None = Field(None, description="In the fragment, from 1")
    column: int | None = None
    address: str | None = Field(None, description="Of the element in the document")
    remedy: str | None = None


class ChangesMade(BaseModel):
    """The result of changes. revision: the new revision, or the current one if nothing changed."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"revision": 3, "frames": 1197, "merged": False, "faults": [], "conflicts": [], "mergeable": []},
            {
                "revision": 3,
                "frames": 1197,
                "merged": True,
                "faults": [],
                "conflicts": [_CONFLICT],
                "mergeable": ["unit"],
            },
        )
    )

    revision: int
    frames: int
    merged: bool = Field(False, description="They were made for an older revision")
    faults: list[Fault] = Field(default_factory=list, description="Of a dry run")
    conflicts: list[Conflict] = Field(default_factory=list, description="Of a dry run")
    mergeable: list[str] = Field(default_factory=list, description="Dry run: changes that can be applied")
