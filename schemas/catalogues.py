"""What the repository knows: formats, joint names, motion names, skeletons, projects, health."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class FormatPart(BaseModel):
    name: str
    title: str
    extensions: list[str]


class FormatInfo(BaseModel):
    name: str
    title: str
    parts: list[FormatPart]
    convention: str
    reads: bool = True
    writes: bool = True


class UnsupportedFormat(BaseModel):
    name: str
    why: str


class FormatList(BaseModel):
    items: list[FormatInfo]
    unsupported: list[UnsupportedFormat]


class JointName(BaseModel):
    """A row of the table of joint names."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"number": 6, "name": "left_up_arm", "reconstructed": False, "aliases": {"asf": ["lhumerus"]}}]
        }
    )

    number: int
    name: str
    reconstructed: bool = Field(description="The founding paper's page lacks this row; it was reconstructed")
    aliases: dict[str, list[str]] = Field(description="Names in each naming convention")


class JointNameList(BaseModel):
    items: list[JointName]


class MotionNameInUse(BaseModel):
    name: str
    documents: int
    frames: int


class BodyPart(BaseModel):
    part: str
    sided: bool = Field(description="Whether its names begin with left-, right- or both-")
    joints: list[str] = Field(description="MCML joints; * stands for the side")
    movements: list[str]


class MotionNameList(BaseModel):
    """Names in use, and the vocabulary of movements that bodies can perform."""

    items: list[MotionNameInUse]
    vocabulary: list[BodyPart]


class SkeletonInfo(BaseModel):
    id: int
    hash: str
    joints: int
    documents: int


class SkeletonPage(BaseModel):
    items: list[SkeletonInfo]
    next_cursor: str | None = None


class ProjectList(BaseModel):
    items: list[str]


class Health(BaseModel):
    status: str
    database: str | None = None
