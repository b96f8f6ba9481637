"""Export of many documents as one file."""

from __future__ import annotations

from pydantic import ConfigDict, Field

from mcml_schemas.examples import PROJECT, shown
from mcml_schemas.frame_time import FrameTime
from mcml_schemas.jobs import Selection
from mcml_schemas.request_body import RequestBody


class ExportRequest(RequestBody):
    """Which documents, and as what."""

    model_config = ConfigDict(json_schema_extra=shown({"selection": {"project": PROJECT}, "format": "bvh"}))

    selection: Selection = Field(description="Which documents")
    format: str | None = Field(
        None,
        description="A format that `GET /formats` lists as written, a part of one (asf, amc), or csv; if it is "
        "missing, `for` decides, else bvh",
    )
    for_: str | None = Field(
        None,
        alias="for",
        description="The program that reads the files, a preset of `GET /formats`; it decides format, unit and axes",
    )
    names: str | None = Field(None, description="Joint names: mcml, bvh1, bvh2, asf or htr; default the source's")
    unit: str | None = Field(None, description="Scale lengths to this unit; the documents must state their own")
    up: str | None = Field(None, description="Turn so that this axis points up")
    frame_time: FrameTime | None = Field(None, description="Seconds a frame, for documents that do not say")
    fps: float | None = Field(None, gt=0, le=10_000, description="Frames a second of the results")
    scale: float | None = Field(None, gt=0, le=1e9, description="Factor of all lengths")
    height: float | None = Field(
        None, gt=0, le=100, description="Scale each so that its body stands this many metres tall"
    )
    in_place: bool = Field(False, description="Keep bodies over one place: without their way over the ground")
    guesses: bool = Field(
        True, description="Guess the unit and the up axis that glTF and USD need, where a document states none"
    )
    character: str | None = Field(
        None,
        description="glb and usd: bodies with a skin instead of bones: `own`, of clips of a person; or the id of a "
        "document with a character, on whose skeleton the motions are retargeted",
    )
    raw: bool = Field(False, description="csv: also texts that spreadsheets take for formulas as they are")
