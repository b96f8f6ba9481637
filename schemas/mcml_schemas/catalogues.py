"""Catalogues of the repository: formats, joint names, motion names, skeletons, projects, the demo library, health."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import HASH, MOTION_NAME, PROJECT, shown
from mcml_schemas.request_body import RequestBody

_BVH = {
    "name": "bvh",
    "title": "Biovision BVH",
    "label": "BVH",
    "parts": [{"name": "bvh", "title": "Skeleton and motion", "extensions": [".bvh"]}],
    "convention": "listed",
    "bodies": True,
    "markers": False,
    "needs": ["frame_time"],
    "assumes": "",
    "reads": True,
    "writes": True,
}
_PRESET = {
    "name": "blender",
    "title": "Blender",
    "bodies": {"format": "bvh", "unit": "m", "up": "Y"},
    "markers": {"format": "glb", "unit": "m", "up": "Y"},
    "why": "Blender imports BVH as an armature with Y up and takes its numbers as metres; markers arrive by glTF.",
}
_JOINT_NAME = {"number": 6, "name": "left_up_arm", "reconstructed": False, "aliases": {"asf": ["lhumerus"]}}
_LEG = {"part": "leg", "sided": True, "joints": ["*_up_leg"], "movements": ["flexion", "extension"]}


_PROJECT = {
    "name": PROJECT,
    "documents": 217,
    "bytes": 91342000,
    "archived": None,
    "most_documents": 1000,
    "most_bytes": None,
    "review_required": False,
}


class FormatPart(BaseModel):
    name: str
    title: str
    extensions: list[str]


class FormatInfo(BaseModel):
    name: str
    title: str
    label: str = Field(description="A short title, for menus")
    parts: list[FormatPart]
    convention: str
    bodies: bool = Field(description="Whether it can hold bodies; others hold their joints as points")
    markers: bool = Field(description="Whether it can hold markers; others hold the skeleton that they make")
    needs: list[str] = Field(
        description="Facts that a document must state to be exported: frame_time, unit, force_plates, blend_shapes"
    )
    assumes: str = Field(
        description="Unit that programs take its numbers for where the document states none; empty: they take none"
    )
    states: list[str] = Field(
        [],
        description="Facts that its files hold: frame_time, unit, up, force_plates, blend_shapes; empty if not read",
    )
    reads: bool = Field(True, description="Whether it can be uploaded")
    takes: bool = Field(False, description="Whether one of its files may hold several clips")
    extensions: list[str] = Field([], description="How files end that are read; a file is recognised by its content")
    beside: list[str] = Field(
        [], description="How further files of a clip end that are sent with it: buffers of glTF, forces of TRC"
    )
    states_beside: list[str] = Field([], description="Facts that these further files hold: force_plates")
    skins: bool = Field(False, description="Whether it can hold a body with a skin: `character` of an export")
    writes: bool = Field(True, description="Whether it can be exported: USD where the server has the extra `usd`")


class UnsupportedFormat(BaseModel):
    name: str
    why: str


class PresetShape(BaseModel):
    format: str
    unit: str | None = Field(None, description="Unit of its numbers; null: that of the document")
    up: str | None = Field(None, description="Axis that points up; null: that of the document")
    fps: float | None = Field(None, description="Frames a second; null: those of the document")


class PresetInfo(BaseModel):
    """A program that documents are exported for, with `for`."""

    name: str
    title: str
    bodies: PresetShape = Field(description="How clips of joints leave")
    markers: PresetShape = Field(description="How clips of markers leave")
    why: str = Field(description="The reason")


class FormatList(BaseModel):
    model_config = ConfigDict(
        json_schema_extra=shown(
            {"items": [_BVH], "presets": [_PRESET], "unsupported": [{"name": "c3d", "why": "comes later"}]}
        )
    )

    items: list[FormatInfo]
    presets: list[PresetInfo]
    unsupported: list[UnsupportedFormat]


class JointName(BaseModel):
    """A row of the table of joint names."""

    model_config = ConfigDict(json_schema_extra=shown(_JOINT_NAME))

    number: int
    name: str
    reconstructed: bool = Field(description="The founding paper's page lacks this row; it was reconstructed")
    aliases: dict[str, list[str]] = Field(description="Names in each naming convention")


class JointNameList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_JOINT_NAME]}))

    items: list[JointName]


class MotionNameInUse(BaseModel):
    name: str
    documents: int
    frames: int


class BodyPart(BaseModel):
    part: str
    sided: bool = Field(description="Whether its names begin with left-, right- or both-")
    joints: list[str] = Field(description="MCML joints; * means either side")
    movements: list[str]


class MotionNameList(BaseModel):
    """Names in use, and the vocabulary of movements that bodies can perform."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"items": [{"name": MOTION_NAME, "documents": 12, "frames": 1430}], "vocabulary": [_LEG]}
        )
    )

    items: list[MotionNameInUse]
    vocabulary: list[BodyPart]


class SkeletonInfo(BaseModel):
    id: int
    hash: str
    joints: int
    documents: int


class RestPose(BaseModel):
    """A skeleton in its rest pose. parents: of each joint, -1 at the root. positions: x, y, z in the source's units."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"joints": ["Root", "waist"], "parents": [-1, 0], "positions": [[0.0, 92.1, 0.0], [0.0, 102.4, -1.2]]}
        )
    )

    joints: list[str]
    parents: list[int]
    positions: list[list[float]]


class SkeletonPage(BaseModel):
    model_config = ConfigDict(
        json_schema_extra=shown(
            {"items": [{"id": 3, "hash": HASH, "joints": 31, "documents": 12}], "next_cursor": None}
        )
    )

    items: list[SkeletonInfo]
    next_cursor: str | None = None


class ProjectList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": ["default", PROJECT]}))

    items: list[str]


class ProjectView(BaseModel):
    """A project.

    archived: time since which it is read-only. documents: number of documents. bytes: of uploaded files and media,
    including deleted documents. most_documents, most_bytes: quotas, none: no limit. review_required: whether documents
    change by approved proposals only.
    """

    model_config = ConfigDict(json_schema_extra=shown(_PROJECT))

    name: str
    documents: int
    bytes: int
    archived: str | None = None
    most_documents: int | None = None
    most_bytes: int | None = None
    review_required: bool = False


class ProjectChange(RequestBody):
    """Values to change; omitted values do not change."""

    model_config = ConfigDict(json_schema_extra=shown({"archived": True}))

    archived: bool | None = Field(None, description="Nothing in an archived project changes")
    most_documents: int | None = Field(
        None, ge=0, le=10**15, description="0: no bound; owners of the repository set it"
    )
    most_bytes: int | None = Field(None, ge=0, le=10**18, description="0: no bound; owners of the repository set it")
    review_required: bool | None = Field(
        None, description="Documents change by proposals only, which another editor than the author has approved"
    )


class ProjectImported(BaseModel):
    """project: its name here. documents: how many it has, deleted ones too."""

    model_config = ConfigDict(json_schema_extra=shown({"project": PROJECT, "documents": 217}))

    project: str
    documents: int


DemoPart: TypeAlias = Literal["people", "reaches", "dances", "walks", "faces"]
"""A part of the demo library: clips for one purpose."""

_DEMO_PART = {"part": "walks", "project": "demo-walk", "stored": 7, "existing": 0}


class DemoPartLoaded(BaseModel):
    """One part of the demo library, after it was loaded."""

    model_config = ConfigDict(json_schema_extra=shown(_DEMO_PART))

    part: DemoPart
    project: str = Field(description="Project that has the clips")
    stored: int = Field(description="New clips")
    existing: int = Field(description="Clips that the project had already; they are skipped")


class DemoLoaded(BaseModel):
    """The loaded parts of the demo library, with totals of their clips."""

    model_config = ConfigDict(json_schema_extra=shown({"stored": 7, "existing": 0, "parts": [_DEMO_PART]}))

    stored: int = Field(description="New clips")
    existing: int = Field(description="Clips that were stored already; they are skipped")
    parts: list[DemoPartLoaded]


class Health(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"status": "ok", "database": "sqlite"}))

    status: str
    database: str | None = None
