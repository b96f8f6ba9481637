"""Motion onto another skeleton."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, MOTION_NAME, PROJECT, TIME, example_of, shown
from mcml_schemas.frames import PreviewMotion
from mcml_schemas.jobs import Selection
from mcml_schemas.problem import Problem
from mcml_schemas.request_body import RequestBody


class JointPair(RequestBody):
    """A joint of the source and the one of the target that moves as it does, by their MCML names."""

    model_config = ConfigDict(frozen=True)

    source: str
    target: str


Pairs = Annotated[list[JointPair], Field(min_length=1, max_length=10_000)]
WantedMapping = Annotated[
    Pairs | Annotated[str, Field(min_length=1, max_length=1024)] | None,
    Field(description="All pairs of joints, or the name of a saved mapping; if left out, pairs are suggested"),
]


class Retargeting(RequestBody):
    """Whose skeleton, and which joint is which."""

    skeleton: str = Field(description="Document whose skeleton the motion is brought to", examples=[DOCUMENT])
    mapping: WantedMapping = None
    clean_feet: bool = Field(False, description="Lock feet on contact")
    match_rest: bool = Field(
        False, description="Joints turn from rest as their sources do; else bones point as those of the source"
    )
    scale: float | None = Field(None, gt=0, le=1e6, description="Of the way through the room; default by the legs")
    project: str | None = Field(
        None, min_length=1, max_length=256, description="Of the new document, and of the mapping; default the source's"
    )
    preview: bool = Field(False, description="Preview the mapping and its quality without storing anything")


class RetargetRequest(Retargeting):
    """A motion, and the skeleton that it is brought to."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"skeleton": DOCUMENT, "clean_feet": True, "name": "walk of the robot", "project": PROJECT}
        )
    )

    name: str | None = Field(
        None, min_length=1, max_length=1024, description="Of the new document; default the source's"
    )


class RetargetMany(Retargeting):
    """Motions of many documents, and the skeleton that they are brought to."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"selection": {"project": PROJECT, "motion_name": MOTION_NAME}, "skeleton": DOCUMENT, "project": "robot"}
        )
    )

    selection: Selection = Field(description="Which documents; the one with the skeleton is left out")


class SavedMapping(RequestBody):
    """Which joint is which, under a name, for the documents of a project."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"pairs": [{"source": "left_up_leg", "target": "left_hip"}, {"source": "torso7", "target": "waist"}]}
        ),
    )

    pairs: Pairs


class Mapping(SavedMapping):
    """version: counts the changes from 1. author, changed: of the last one."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "name": "cmu to robot",
                "project": PROJECT,
                "version": 2,
                "author": "local",
                "changed": TIME,
                "pairs": [{"source": "left_up_leg", "target": "left_hip"}],
            }
        )
    )

    name: str
    project: str
    version: int
    author: str
    changed: str


class MappingPage(BaseModel):
    """Saved mappings, by project and name."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [example_of(Mapping)]}))

    items: list[Mapping]
    next_cursor: str | None = None


class JointMatch(JointPair):
    """confidence: 0 to 1. reason: why the two belong together."""

    confidence: float
    reason: str


class BoneError(BaseModel):
    """Degrees between a bone's directions in the source and in the result, over all frames.

    bone, end: the joints at its ends. leads: whether the rotation of the joint follows this bone; where bones branch
    only one can.
    """

    bone: str
    end: str
    leads: bool
    mean: float
    largest: float
    frame: int = Field(1, description="Where it is largest")


class FrameSpan(BaseModel):
    """Frames first to last, positions from 1."""

    first: int
    last: int


class FootSliding(BaseModel):
    """The distance that a joint of a foot slides over the ground while it is planted, over all contacts, in the
    result's unit.
    """

    foot: str
    stances: int
    before: float
    after: float
    contacts: list[FrameSpan] = Field(default_factory=list, description="Frames of its contacts")


class Retargeted(BaseModel):
    """The retargeted motion, and the quality of the match."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "document": DOCUMENT,
                "frames": 1197,
                "scale": 0.93,
                "matches": [
                    {
                        "source": "left_up_leg",
                        "target": "left_up_leg",
                        "confidence": 1.0,
                        "reason": "both have this name in MCML",
                    }
                ],
                "unmatched_source": [],
                "unmatched_target": ["left_thumb"],
                "bones": [{"bone": "left_up_leg", "end": "left_low_leg", "leads": True, "mean": 0.0, "largest": 0.0}],
                "feet": [],
                "notices": [],
            }
        )
    )

    document: str | None = Field(None, description="Id of the new document; none in a preview")
    frames: int
    scale: float = Field(description="Of the body's way through the room: the ratio of the lengths of the legs")
    matches: list[JointMatch]
    unmatched_source: list[str]
    unmatched_target: list[str]
    bones: list[BoneError]
    feet: list[FootSliding]
    worst_frame: int | None = Field(None, description="Where a bone that leads points farthest elsewhere")
    notices: list[str]
    motion: PreviewMotion | None = Field(None, description="Positions, if requested")


class RetargetedOne(BaseModel):
    """The result for one of many documents: the new document, or the problem."""

    model_config = ConfigDict(
        json_schema_extra=shown({"source": DOCUMENT, "name": "walk", "made": example_of(Retargeted)})
    )

    source: str
    name: str
    made: Retargeted | None = None
    problem: Problem | None = None
