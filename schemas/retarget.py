"""Motion onto another skeleton."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from schemas.examples import DOCUMENT, PROJECT, shown


class JointPair(BaseModel):
    """A joint of the source and the one of the target that moves as it does, by their MCML names."""

    model_config = ConfigDict(extra="forbid")

    source: str
    target: str


class RetargetRequest(BaseModel):
    """Whose skeleton, and which joint is which."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra=shown(
            {"skeleton": DOCUMENT, "clean_feet": True, "name": "walk of the robot", "project": PROJECT}
        ),
    )

    skeleton: str = Field(description="Document whose skeleton the motion is brought to")
    mapping: list[JointPair] | None = Field(
        None, max_length=10_000, description="All pairs; if left out those that are suggested. Ask with `preview` first"
    )
    clean_feet: bool = Field(False, description="Hold feet where they stand")
    name: str | None = Field(
        None, min_length=1, max_length=1024, description="Of the new document; default the source's"
    )
    project: str | None = Field(None, min_length=1, max_length=256, description="Default the source's")
    preview: bool = Field(False, description="Say what would be mapped, and how well; store nothing")


class JointMatch(JointPair):
    """confidence: 0 to 1. reason: why the two belong together."""

    confidence: float
    reason: str


class BoneError(BaseModel):
    """Degrees between a bone's directions in the source and in the result, over all frames.

    bone, end: the joints it goes from and to. leads: whether the joint is turned so that this bone points as it should;
    where bones branch only one can.
    """

    bone: str
    end: str
    leads: bool
    mean: float
    largest: float


class FootSliding(BaseModel):
    """How far a joint of a foot slides over the ground while it stands, all stances together, in the result's unit."""

    foot: str
    stances: int
    before: float
    after: float


class Retargeted(BaseModel):
    """What was made, and how well it fits."""

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
                        "reason": "both are called so in MCML",
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
    notices: list[str]
