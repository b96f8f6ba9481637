"""Requests about many documents at once."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.documents import DocumentChange
from mcml_schemas.examples import DOCUMENT, MOTION_NAME, PROJECT, shown
from mcml_schemas.jobs import Selection
from mcml_schemas.request_body import RequestBody


class ManyDocuments(RequestBody):
    """Documents by their ids."""

    model_config = ConfigDict(json_schema_extra=shown({"documents": [DOCUMENT]}))

    documents: list[str] = Field(min_length=1, max_length=100_000)


class ManyLabel(RequestBody):
    """A motion name on frames of each; without `last`, to its end."""

    name: str = Field(min_length=1, max_length=1024)
    first: int = Field(1, ge=1)
    last: int | None = Field(None, ge=1)


class ManyChanges(RequestBody):
    """Changes for each of the documents, except their names."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "selection": {"project": PROJECT},
                "change": {"unit": "cm", "up": "Y"},
                "labels": [{"name": MOTION_NAME, "first": 1}],
            }
        ),
    )

    selection: Selection
    change: DocumentChange = Field(default_factory=lambda: DocumentChange(message=""))
    labels: list[ManyLabel] = Field(default_factory=list, max_length=1000)


class ManyCopies(RequestBody):
    """project: where the copies go; a new one is made."""

    model_config = ConfigDict(json_schema_extra=shown({"selection": {"documents": [DOCUMENT]}, "project": PROJECT}))

    selection: Selection
    project: str = Field(min_length=1, max_length=256)


class CopiedDocuments(BaseModel):
    """Ids of the copies, in the order of the ids of the originals."""

    model_config = ConfigDict(json_schema_extra=shown({"documents": [DOCUMENT]}))

    documents: list[str]
