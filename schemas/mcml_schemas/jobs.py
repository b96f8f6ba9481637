"""Analyses, the jobs that run them, and their results."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.analyses.dance import Music
from mcml_schemas.examples import CURSOR, DOCUMENT, JOB, PROJECT, RESULT, TIME, shown
from mcml_schemas.problem import Problem
from mcml_schemas.request_body import RequestBody

_SELECTION = {"project": PROJECT, "property": ["age:20..30"]}
_INPUT = {"document": DOCUMENT, "revision": 1}
_JOB = {
    "id": JOB,
    "analysis": "beats",
    "name": "beats of gait",
    "project": PROJECT,
    "owner": "local",
    "state": "running",
    "stage": "beats of walk",
    "share": 0.4,
    "attempt": 1,
    "inputs": [_INPUT],
    "parameters": {},
    "created": TIME,
    "started": TIME,
}
_PART = {"kind": "table", "data": {"beats": [1.25, 1.78]}, "arrays": {"speed": {"dtype": "<f8", "shape": [1197]}}}
_RESULT = {
    "id": RESULT,
    "analysis": "beats",
    "name": "beats of gait",
    "project": PROJECT,
    "owner": "local",
    "inputs": [_INPUT],
    "parameters": {},
    "made_with": {"numpy": "2.4.1", "scipy": "1.17.0", "rule tempo": "2 (of the motion itself)"},
    "created": TIME,
}
_ANALYSIS = {
    "name": "beats",
    "subject": "dance",
    "verb": "beats",
    "title": "Beats of a motion",
    "description": "Where the body pauses in rhythm.",
    "parameters": {"properties": {"smooth": {"default": 0.04, "type": "number"}}, "type": "object"},
    "parts": {"speed": {"kind": "curve", "description": "Mean speed of the joints"}},
    "operations": {},
    "fewest": 1,
    "most": 2000,
}


class Selection(RequestBody):
    """The documents that an analysis reads: those that match all given conditions, at least one."""

    model_config = ConfigDict(json_schema_extra=shown(_SELECTION))

    documents: list[str] = Field([], max_length=10_000, description="Ids of documents")
    project: str | None = Field(None, description="All of this project", examples=[PROJECT])
    motion_name: str | None = Field(None, description="Documents with a frame of this name", examples=["reach"])
    property: list[str] = Field([], description="age:20..30 or take:calm", examples=[["age:20..30"]])
    xpath: str | None = Field(
        None,
        max_length=10_000,
        description="Documents in which this expression finds something",
        examples=["//frame[motion_name='reach']"],
    )
    include_made: bool = Field(
        False,
        description="Also clips that an analysis made, which are left out where documents are not named by their ids",
        examples=[False],
    )


class JobInput(BaseModel):
    """A document, and the revision of it that is read."""

    document: str
    revision: int


class Job(BaseModel):
    """Long work, and how far it is. share: of the whole, 0 to 1. result: once it is done."""

    model_config = ConfigDict(json_schema_extra=shown(_JOB))

    id: str
    analysis: str
    name: str
    project: str
    owner: str
    state: Literal["waiting", "running", "done", "failed", "cancelled"]
    stage: str = Field(description="Current stage")
    share: float = Field(ge=0, le=1, description="Of the work, how much is done")
    attempt: int = Field(description="How often it was begun; more than once where a server or worker died")
    inputs: list[JobInput]
    left_out: int = Field(0, description="Selected clips that an analysis had made, which it does not read")
    parameters: dict[str, Any]
    created: str
    started: str | None = None
    ended: str | None = None
    problem: Problem | None = Field(None, description="Why it failed")
    result: str | None = Field(None, description="Id of its result")


class JobPage(BaseModel):
    """Jobs, the newest first."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [_JOB], "next_cursor": CURSOR}))

    items: list[Job]
    next_cursor: str | None = None


class ArrayInfo(BaseModel):
    """Type (as NumPy writes it) and shape of an array."""

    dtype: str
    shape: list[int]


class PartSummary(BaseModel):
    """A part of a result: `data` are plain values; `arrays` can be fetched one by one."""

    model_config = ConfigDict(json_schema_extra=shown(_PART))

    kind: Literal["clip", "curve", "points", "graph", "table", "model"]
    data: dict[str, Any] = {}
    arrays: dict[str, ArrayInfo] = {}
    document: str | None = Field(None, description="Of a clip: the document that holds it")


class Result(BaseModel):
    """The output of an analysis, with all data to reproduce it."""

    model_config = ConfigDict(json_schema_extra=shown(_RESULT | {"parts": {"beats": _PART}, "operations": []}))

    id: str
    analysis: str
    name: str
    project: str
    owner: str
    parent: str | None = Field(None, description="The result from which an operation made this one")
    inputs: list[JobInput]
    parameters: dict[str, Any]
    made_with: dict[str, str] = Field(
        description="Versions of the libraries that computed it, and as `rule NAME` those of the analysis's rules: "
        "compare them with its `rules`; a result without them was made by older ones"
    )
    created: str
    parts: dict[str, PartSummary] = {}
    operations: list[str] = Field([], description="Actions: POST /results/{id}/{operation}")


class ResultPage(BaseModel):
    """Results, the newest first, without their parts."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [_RESULT], "next_cursor": CURSOR}))

    items: list[Result]
    next_cursor: str | None = None


class ArrayValues(BaseModel):
    """Rows of an array as JSON; missing numbers are null."""

    model_config = ConfigDict(
        json_schema_extra=shown({"dtype": "<f8", "shape": [1197], "first": 0, "values": [0.12, 0.17]})
    )

    dtype: str
    shape: list[int] = Field(description="Of the whole array")
    first: int = Field(description="Row that comes first, from 0")
    values: list[Any]


class PartKind(BaseModel):
    """A part that results of an analysis may have."""

    kind: str
    description: str


class OperationInfo(BaseModel):
    """Something to do with a finished result. parameters, answer: JSON schemas."""

    description: str
    parameters: dict[str, Any]
    answer: dict[str, Any]


class AnalysisInfo(BaseModel):
    """An analysis of the catalogue. parameters: a JSON schema with defaults, limits and descriptions."""

    model_config = ConfigDict(json_schema_extra=shown(_ANALYSIS))

    name: str
    subject: str
    verb: str = Field(description="On the command line: mcml analyse SUBJECT VERB")
    title: str
    description: str
    parameters: dict[str, Any]
    parts: dict[str, PartKind]
    operations: dict[str, OperationInfo]
    pictures: dict[str, str] = Field({}, description="Plots of a result: name and content")
    rules: dict[str, str] = Field({}, description="Versions of its rules, by name, as new results record them")
    fewest: int
    most: int


class AnalysisList(BaseModel):
    """Every analysis."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [_ANALYSIS]}))

    items: list[AnalysisInfo]


class Saving(RequestBody):
    """Whether the clip that an operation makes becomes a document, and under which name."""

    save: bool = Field(False, description="Store the clip as a document")
    name: str | None = Field(
        None, max_length=1024, description="Name of the document", examples=["reach of a 40-year-old"]
    )
    project: str | None = Field(None, max_length=256, description="Project of the document; default the result's")


class ClipMotion(BaseModel):
    """A clip that an operation made. parents: of each joint, -1 at a root."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"name": "reach", "frames": 60, "seconds_per_frame": 0.03333, "joints": ["Root"], "parents": [-1]}
        )
    )

    name: str
    frames: int
    seconds_per_frame: float
    joints: list[str]
    parents: list[int]
    positions: list[list[list[float]]] | None = Field(None, description="Of every joint in every frame, if requested")


class ResultUsed(BaseModel):
    """The output of an operation. document, result: ids of stored output."""

    value: Any = Field(description="Its content depends on the operation")
    clip: ClipMotion | None = Field(None, description="The clip that was made")
    document: str | None = Field(None, description="Where the clip was stored")
    result: str | None = Field(None, description="Link to the stored result")


class TempoRival(BaseModel):
    """A tempo that music may have."""

    bpm: float
    ratio: str = Field(description="To the tempo that was found first", examples=["2", "1/2", "3/2"])
    strength: float = Field(description="How well its beats fit what is heard, 0 to 1")


class MusicMeter(BaseModel):
    """Beats that the bars of music may have."""

    beats_per_bar: int
    strength: float = Field(description="How regularly accents come again after so many beats, 0 to 1")


class MusicBeats(BaseModel):
    """The beats of a piece of music. Correct `music` and give it to the analysis `dance`."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "music": {"beats": [0.5, 1.0, 1.5, 2.0, 2.5]},
                "bpm": 120.0,
                "even": True,
                "residual_seconds": 0.004,
                "bars": 1,
                "clear": True,
                "rivals": [
                    {"bpm": 120.0, "ratio": "1", "strength": 0.86},
                    {"bpm": 60.0, "ratio": "1/2", "strength": 0.5},
                ],
                "meters": [{"beats_per_bar": 4, "strength": 0.6}, {"beats_per_bar": 3, "strength": 0.1}],
            }
        )
    )

    music: Music = Field(description="As the parameter `music` of the analysis takes it")
    bpm: float = Field(description="Beats a minute, of the line through the beats")
    even: bool = Field(description="Whether the line replaces the beats: the dance then follows it exactly")
    residual_seconds: float = Field(description="How far the beats are from the line, root mean square")
    bars: int = Field(description="Whole bars")
    clear: bool = Field(
        description="Whether this tempo fits clearly better than its rivals, or was given; else it is ambiguous"
    )
    rivals: list[TempoRival] = Field(
        description="Possible tempi of the music: the detected one, half, double, three beats for two or one. The "
        "chosen one is first; send `bpm` to choose another"
    )
    meters: list[MusicMeter] = Field(
        description="Beats per bar, the most likely first; `music` has the first one, or the one that was sent"
    )
