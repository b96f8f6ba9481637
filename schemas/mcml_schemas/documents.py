"""Documents, their receipts, labels and revisions."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import (
    CURSOR,
    DETAIL,
    DOCUMENT,
    LABEL,
    LABEL_REQUEST,
    PROBLEM,
    PROJECT,
    PROPERTY,
    RECEIPT,
    SUMMARY,
    TIME,
    shown,
)
from mcml_schemas.frame_time import FrameTime
from mcml_schemas.media import MediaInfo
from mcml_schemas.problem import Problem
from mcml_schemas.request_body import RequestBody
from mcml_schemas.revisions import FrameRange

_IMPORTED = {
    "id": DOCUMENT,
    "name": "walk",
    "file": "walk.bvh",
    "skipped": False,
    "receipt": RECEIPT,
    "calibration": f"/api/v1/documents/{DOCUMENT}/calibration",
}
_REFUSED = {"file": "broken.bvh", "problem": PROBLEM}
_REVISION = {
    "number": 2,
    "parent": 1,
    "operation": "change",
    "message": "changed name",
    "name": "walk",
    "project": PROJECT,
    "time": TIME,
    "author": "local",
}
_FRAME = {"frame": 1, "id": "1", "values": {"Root": {"Tx": 0.1886, "Ty": 92.5, "Tz": -3.25}, "Spine": {"Rz": 1.956}}}
_CARD = {
    **SUMMARY,
    "labels": [LABEL_REQUEST],
    "passport": {
        "unit": "cm",
        "metres": 0.01,
        "up": "Y",
        "rate": 120.00048,
        "joints": 31,
        "markers": False,
        "guessed": ["unit", "up"],
    },
}
_CLIP = {
    "files": ["walk.bvh"],
    "header": {"filename": "walk.bvh"},
    "joints": [{"name": "Root", "source_name": "Hips", "parent": -1}],
    "receipt": RECEIPT,
}


class Property(RequestBody):
    """An attribute of the clip, such as the age of the actor."""

    model_config = ConfigDict(json_schema_extra=shown(PROPERTY))

    name: str = Field(min_length=1, max_length=256)
    value: str = Field(max_length=262_144)
    unit: str = Field("", max_length=64)


class Fact(BaseModel):
    """A value, whether the file states it, and why."""

    value: str | None = None
    stated: bool
    why: str


class Rate(BaseModel):
    seconds: float | None = Field(None, description="Seconds a frame")
    frames_per_second: float | None = None
    stated: bool
    why: str


class KeptName(BaseModel):
    """A joint that keeps its own name, and why."""

    source: str
    name: str
    why: str


class RecognisedJoint(BaseModel):
    """A joint that got a name of MCML's, how sure that is, and by what."""

    source: str
    name: str
    confidence: float = Field(description="0 to 1; a name below 0.7 is a guess")
    how: Literal["word", "tree", "rest pose", "alias"]


class Naming(BaseModel):
    """How joints got their MCML names."""

    rig: str = Field(description="Kind of skeleton: person, part of a person, not a person, unknown, mcml, markers")
    mapped: dict[str, str] = Field(description="Source name to MCML name")
    joints: list[RecognisedJoint] = Field([], description="How each mapped joint was recognised")
    landmarks: dict[str, str] = Field({}, description="Marker to the landmark of a body that it stands on")
    unmapped: list[KeptName] = Field(description="Joints without a name of MCML's, and markers on no known landmark")


class NoticeLine(BaseModel):
    kind: Literal["guess", "repair", "warning", "note"]
    what: str
    at: str | None = None


class Receipt(BaseModel):
    """The findings, guesses and repairs of an import."""

    model_config = ConfigDict(json_schema_extra=shown(RECEIPT))

    format: str
    frames: int
    joints: int
    channels: int
    naming: Naming | None = None
    unit: Fact
    frame_rate: Rate
    up_axis: Fact
    rotation_orders: dict[str, int] = Field(description="Joints by rotation order")
    conventions: list[str]
    translation: list[str] = Field(description="Whether position channels replace offsets (absolute) or add to them")
    encoding: dict[str, str] = Field(description="Text encoding of each source file")
    number_style: str
    markers: bool = False
    notices: list[NoticeLine]
    twins: list[str] = Field(description="Documents made from equal files")


class StoredFile(BaseModel):
    """A kept source file."""

    part: str
    name: str
    bytes: int
    sha256: str


class DocumentSummary(BaseModel):
    """A document as lists show it."""

    model_config = ConfigDict(json_schema_extra=shown(SUMMARY))

    id: str
    name: str
    project: str
    format: str
    frames: int
    seconds_per_frame: float | None = Field(None, description="None where neither file nor user stated a rate")
    duration: float | None = Field(None, description="Seconds: frames times seconds_per_frame")
    skeleton: int = Field(description="Number of the skeleton, shared by documents with equal ones")
    revision: int
    created: str
    modified: str


class Bone(BaseModel):
    """A joint of the skeleton, root first, parents before children."""

    name: str
    source_name: str
    parent: str | None = None
    mapped: bool | None = Field(None, description="Whether the name is one of MCML's own")
    role: str | None = Field(
        None, description="Purpose of a joint without a name of MCML's: jaw, left_eye, left_finger_one_2, twist, prop"
    )
    channels: list[str]
    rotation_order: str
    convention: str


class Label(BaseModel):
    """A motion name on frames first to last: positions from 1, both ends included."""

    model_config = ConfigDict(json_schema_extra=shown(LABEL))

    id: int
    name: str
    first: int
    last: int
    rank: int = Field(description="Orders the motion_name elements of one frame")


class DocumentDetail(DocumentSummary):
    """Everything about a document but its frames."""

    model_config = ConfigDict(json_schema_extra=shown(DETAIL))

    description: str
    properties: list[Property]
    unit: str | None = Field(None, description="Length unit, where one is stated")
    up: str | None = Field(None, description="Axis that points up, where one is stated")
    header: dict[str, str] = Field(description="Header values as the source wrote them")
    bones: list[Bone]
    labels: list[Label]
    files: list[StoredFile] = Field(description="Kept source files")
    original: bool = Field(description="Whether an export in the source's format returns the original bytes")
    receipt: Receipt
    media: MediaInfo | None = Field(None, description="Video or audio that it carries for reference")
    links: dict[str, str]


class ImportedDocument(BaseModel):
    id: str
    name: str
    file: str = Field(description="File with the motion, as problems name it: in archives with its folders")
    skipped: bool = Field(False, description="It was stored already (on_duplicate=skip)")
    movements: int | None = Field(None, description="Suggested labels that were accepted, if requested")
    receipt: Receipt
    calibration: str = Field(
        description="Address of unit, up axis, floor and leg as the body shows them, which is known after the import"
    )


class FileProblem(BaseModel):
    file: str
    problem: Problem


class UploadResult(BaseModel):
    """Each document is stored whole or not at all; one bad file stops no other."""

    model_config = ConfigDict(json_schema_extra=shown({"documents": [_IMPORTED], "problems": [_REFUSED]}))

    documents: list[ImportedDocument]
    problems: list[FileProblem]


class Span(BaseModel):
    """A motion name on frames first to last: positions from 1, both ends included."""

    name: str
    first: int
    last: int


class Passport(BaseModel):
    """The facts needed to interpret the numbers of a document, and the list of those that are not stated."""

    unit: str | None = Field(None, description="Of length")
    metres: float | None = Field(None, description="Of the unit")
    up: str | None = Field(None, description="Axis that points up")
    rate: float | None = Field(None, description="Frames a second")
    joints: int
    markers: bool = Field(False, description="Whether joints are labelled points")
    guessed: list[Literal["unit", "up", "rate"]] = Field(description="Facts that nobody has stated")


class Card(DocumentSummary):
    """A document in a list, with the requested details; others are null."""

    model_config = ConfigDict(json_schema_extra=shown(_CARD))

    thumbnail: str | None = Field(None, description="A moving picture: MT1, as base64")
    labels: list[Span] | None = None
    passport: Passport | None = None


class DocumentPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_CARD], "next_cursor": CURSOR, "total": 240}))

    items: list[Card]
    next_cursor: str | None = None
    total: int = Field(description="Documents that match, on all pages")


class DocumentChange(RequestBody):
    """Values to change; omitted values do not change. An empty text removes description, unit or up axis."""

    model_config = ConfigDict(
        json_schema_extra=shown({"name": "walk, second take", "unit": "cm", "up": "Y", "properties": [PROPERTY]}),
    )

    name: Annotated[str, Field(min_length=1, max_length=1024)] | None = None
    project: Annotated[str, Field(min_length=1, max_length=256)] | None = None
    description: Annotated[str, Field(max_length=100_000)] | None = None
    properties: list[Property] | None = None
    unit: str | None = None
    up: str | None = None
    frame_time: FrameTime | None = Field(None, description="Seconds a frame: a number, or a text such as 1/120")
    message: str = Field("", max_length=4096, description="Why, for the history")


class LabelRequest(RequestBody):
    model_config = ConfigDict(json_schema_extra=shown(LABEL_REQUEST))

    name: str = Field(min_length=1, max_length=1024)
    first: int = Field(ge=1)
    last: int = Field(ge=1)


class LabelPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [LABEL], "next_cursor": None}))

    items: list[Label]
    next_cursor: str | None = None


class Revision(BaseModel):
    number: int
    parent: int | None = None
    operation: str
    message: str
    name: str = Field(description="Of the document, as this revision left it")
    project: str = Field(description="Of the document, as this revision left it")
    time: str
    author: str
    touched: list[FrameRange] | None = Field(
        None, description="Frames whose samples or labels changed, after the change, if requested"
    )


class RevisionPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_REVISION], "next_cursor": None}))

    items: list[Revision]
    next_cursor: str | None = None


class FrameRow(BaseModel):
    """One frame: its position, its id, and values[bone][channel]; a missing sample is absent."""

    frame: int
    id: str
    values: dict[str, dict[str, float]]


class FramePage(BaseModel):
    """Frames as JSON; `format=npy` answers one array instead."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [_FRAME], "next_cursor": CURSOR}))

    items: list[FrameRow]
    next_cursor: str | None = None


class InspectResult(BaseModel):
    """The result that an upload would have; nothing is stored."""

    model_config = ConfigDict(json_schema_extra=shown({"clips": [_CLIP], "problems": []}))

    clips: list[dict[str, Any]]
    problems: list[FileProblem]


class ChangedDocument(BaseModel):
    """A document that a request for many has changed, and the revision it is now at."""

    id: str
    name: str
    revision: int


class ChangedDocuments(BaseModel):
    """The documents that a bulk request has changed."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [{"id": DOCUMENT, "name": "walk", "revision": 2}]}))

    items: list[ChangedDocument]
