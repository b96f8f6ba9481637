"""Motion onto another skeleton."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

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


class JointLimit(RequestBody):
    """Limits of a joint of the target about one of its own axes, in degrees."""

    model_config = ConfigDict(
        frozen=True, json_schema_extra=shown({"joint": "left_low_arm", "axis": "X", "low": 0, "high": 150})
    )

    joint: str = Field(description="Its MCML name")
    axis: Literal["X", "Y", "Z"] = Field(description="Axis of one of its rotation channels")
    low: float = Field(ge=-360, le=360, description="Least angle")
    high: float = Field(ge=-360, le=360, description="Greatest angle")

    @model_validator(mode="after")
    def _in_order(self) -> JointLimit:
        if self.low > self.high:
            raise ValueError(f"{self.joint} {self.axis}: low is above high")
        return self


Pairs = Annotated[list[JointPair], Field(min_length=1, max_length=10_000)]
WantedMapping = Annotated[
    Pairs | Annotated[str, Field(min_length=1, max_length=1024)] | None,
    Field(description="All pairs of joints, or the name of a saved mapping; if left out, pairs are suggested"),
]


RigName = Literal[
    "mixamo",
    "unreal5",
    "metahuman",
    "unity",
    "vrm",
    "rigify",
    "smplx",
    "character-creator",
    "daz9",
    "opensim",
]


class KnownRigInfo(BaseModel):
    """A rig that motions are brought to without a document of it. joints: how many it has."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"name": "unreal5", "title": "Unreal Engine 5 mannequin", "unit": "cm", "up": "Z", "joints": 80}
        )
    )

    name: RigName
    title: str
    unit: str = Field(description="Of length")
    up: str = Field(description="Axis that points up")
    joints: int


class KnownRigs(BaseModel):
    """Every known rig."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [example_of(KnownRigInfo)]}))

    items: list[KnownRigInfo]


class Retargeting(RequestBody):
    """Whose skeleton, and which joint is which."""

    skeleton: str | None = Field(
        None, description="Document whose skeleton the motion is brought to", examples=[DOCUMENT]
    )
    to: RigName | None = Field(None, description="Instead of `skeleton`: a known rig of `GET /rigs`, at 1.75 m")
    mapping: WantedMapping = None
    clean_feet: bool = Field(False, description="Lock feet on contact")
    match_rest: bool = Field(
        False, description="Joints turn from rest as their sources do; else bones point as those of the source"
    )
    scale: float | None = Field(
        None, gt=0, le=1e6, description="Of all places, in the units of both documents; default by the legs"
    )
    travel_scale: float | None = Field(
        None,
        gt=0,
        le=1e6,
        description="Distance travelled on the ground, relative to the source's in metres: 1 keeps distances. Default "
        "as `scale`, by the legs",
    )
    limits: Literal["file"] | Annotated[list[JointLimit], Field(min_length=1, max_length=3000)] | None = Field(
        None, description="Keep joints of the target inside their limits: `file`, as its file states them, or a table"
    )
    keep_hands: bool = Field(
        False, description="Keep hands where they touch each other, the head or a thigh, by bending the arms"
    )
    project: str | None = Field(
        None, min_length=1, max_length=256, description="Of the new document, and of the mapping; default the source's"
    )
    preview: bool = Field(False, description="Preview the mapping and its quality without storing anything")

    @model_validator(mode="after")
    def _one_target(self) -> Self:
        if (self.skeleton is None) == (self.to is None):
            raise ValueError("name either `skeleton`, a document, or `to`, a known rig")
        return self


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


class PartError(BaseModel):
    """Degrees by which a part of the body points elsewhere than in the source, over all frames.

    Of a limb and of the head, the bone that is farthest off on the mean; of hips and shoulders the line from right to
    left; of the trunk the line from the middle of the hips to the middle of the shoulders.
    """

    model_config = ConfigDict(
        json_schema_extra=shown({"part": "left arm", "joint": "left_up_arm", "mean": 0.2, "largest": 1.1, "frame": 37})
    )

    part: Literal["left arm", "right arm", "left leg", "right leg", "hips", "shoulders", "trunk", "head"]
    joint: str = Field(description="Joint of the target where it begins")
    mean: float
    largest: float
    frame: int = Field(description="Where it is largest")


class ClampedJoint(BaseModel):
    """A joint of the target that is kept inside its limits."""

    joint: str
    frames: int = Field(description="In how many frames it would be outside")
    largest: float = Field(description="Degrees by which it would be outside")
    spans: list[FrameSpan] = Field(description="These frames")


class HandContact(BaseModel):
    """A contact of a hand that was kept, in the result's unit."""

    hand: str = Field(description="Joint of the hand")
    other: str = Field(description="Joint that it touches; of a thigh the hip joint")
    first: int
    last: int
    before: float = Field(description="Greatest distance from its place relative to the other part, uncorrected")
    after: float = Field(description="The same after the arms were bent")


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
                "travel_scale": 0.93,
                "parts": [example_of(PartError)],
                "foot_slide": 1.2,
                "warnings": [],
                "notices": [],
            }
        )
    )

    document: str | None = Field(None, description="Id of the new document; none in a preview")
    frames: int
    scale: float = Field(description="Of the body's way through the room: the ratio of the lengths of the legs")
    travel_scale: float = Field(
        1.0, description="Of the distance travelled on the ground, in metres if both units are known"
    )
    matches: list[JointMatch]
    unmatched_source: list[str]
    unmatched_target: list[str]
    bones: list[BoneError]
    feet: list[FootSliding]
    parts: list[PartError] = Field(
        default_factory=list, description="Errors of limbs, hips, shoulders, trunk and head, where joints are matched"
    )
    foot_slide: float | None = Field(
        None,
        description="Centimetres a second that the worse foot slides while it is planted; null without unit or feet",
    )
    clamped: list[ClampedJoint] = Field(default_factory=list, description="Joints kept inside their limits")
    hands: list[HandContact] = Field(default_factory=list, description="Contacts of hands, with keep_hands")
    worst_frame: int | None = Field(None, description="Where a bone that leads points farthest elsewhere")
    warnings: list[str] = Field(default_factory=list, description="Those of the notices that need a look")
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


class RetargetRow(BaseModel):
    """One of many documents in the table of a retargeting: mean errors of parts in degrees, largest first."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "source": DOCUMENT,
                "name": "walk",
                "document": DOCUMENT,
                "limbs": 0.2,
                "hips": 0.0,
                "shoulders": 1.5,
                "trunk": 2.5,
                "head": 0.1,
                "foot_slide": 1.2,
                "deviation": 0.4,
                "warnings": [],
            }
        )
    )

    source: str
    name: str
    document: str | None = Field(None, description="The new document; none in a preview and after a problem")
    limbs: float | None = Field(None, description="Of the worst limb")
    hips: float | None = Field(None, description="Of the line through the hips")
    shoulders: float | None = Field(None, description="Of the line through the shoulders")
    trunk: float | None = None
    head: float | None = None
    foot_slide: float | None = Field(None, description="Centimetres a second of the worse planted foot")
    deviation: float | None = Field(
        None,
        description="Of the value that is farthest above the median of its column, in robust standard deviations (from "
        "the median absolute deviation, at least 1); rows are in this order",
    )
    warnings: list[str]
    problem: str | None = Field(None, description="Why there is no result")


class RetargetTable(BaseModel):
    """A row for each document: problems first, then outliers, then the others."""

    model_config = ConfigDict(json_schema_extra=shown({"rows": [example_of(RetargetRow)], "made": 1, "failed": 0}))

    rows: list[RetargetRow]
    made: int = Field(description="How many were retargeted")
    failed: int
