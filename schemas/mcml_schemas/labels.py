"""Labels changed one by one and by query."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import MOTION_NAME, PROJECT, QUERY, shown
from mcml_schemas.querying.queries import MOST_DOCUMENTS
from mcml_schemas.request_body import RequestBody


class LabelChange(RequestBody):
    """A change of a label; omitted values do not change."""

    model_config = ConfigDict(json_schema_extra=shown({"name": MOTION_NAME, "last": 150}))

    name: str | None = Field(None, min_length=1, max_length=1024)
    first: int | None = Field(None, ge=1)
    last: int | None = Field(None, ge=1)
    split: int | None = Field(None, ge=2, description="Make two of it; the second begins with this frame")


class LabelQuery(RequestBody):
    """A motion name for every frame that an expression selects, or in which it selects something."""

    model_config = ConfigDict(json_schema_extra=shown({"name": "raised", "xpath": QUERY, "project": PROJECT}))

    name: str = Field(min_length=1, max_length=1024)
    xpath: str = Field(min_length=1, max_length=10_000)
    document: list[str] = Field([], max_length=MOST_DOCUMENTS, description="Documents to look in; default all")
    project: str | None = None
    remove: bool = Field(False, description="Take the name off these frames instead")
    instead_of: str | None = Field(
        None, min_length=1, max_length=1024, description="Take this name off the same frames: so names are changed"
    )
    strict: bool = Field(False, description="Refuse names that are no anatomical movement")


_SUGGESTED = {"name": "turn left", "first": 100, "last": 142, "degrees": 91.5, "steps": None, "confidence": 0.82}


class SuggestedLabel(BaseModel):
    """An activity or an anatomical movement that the motion seems to be: frames first to last, positions from 1.

    degrees: of a turn of the body, or how far a joint goes. steps: of a walk or a run. confidence: of an activity 0.5
    to 1, by how far it is from not being one; of a movement 0 to 1, of how much of the joint's motion is this movement,
    and how large it is.
    """

    model_config = ConfigDict(json_schema_extra=shown(_SUGGESTED))

    name: str
    first: int
    last: int
    degrees: float | None = None
    steps: int | None = None
    confidence: float


class SuggestedLabels(BaseModel):
    """To be accepted by `POST /documents/{id}/labels`, all or some. warnings: unrecognised activities, and why."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [_SUGGESTED], "warnings": []}))

    items: list[SuggestedLabel]
    warnings: list[str] = Field(default_factory=list)
