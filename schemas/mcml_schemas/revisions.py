"""Differences of two revisions of a document."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import MOTION_NAME, shown


class FrameRange(BaseModel):
    """Frames first to last, positions from 1."""

    first: int
    last: int


class LabelDifference(BaseModel):
    """A motion name and the frames that carried it."""

    name: str
    first: int
    last: int


class KeptFrames(BaseModel):
    """Consecutive frames that both revisions have: the first one's position in each, and how many."""

    before: int
    after: int
    count: int


class ElementDifference(BaseModel):
    """An element of header, root or skeleton: its attributes and text before and after; null if it does not exist."""

    address: str
    before: str | None = None
    after: str | None = None


class BoneDifference(BaseModel):
    """Samples of one bone that changed, in frames that both revisions have.

    first, last: positions in the later revision. frames: how many changed. channels: greatest difference of each; 0
    where a sample came or went. angle: greatest angle between the two rotations, degrees.
    """

    bone: str
    first: int
    last: int
    frames: int
    channels: dict[str, float]
    angle: float | None = None


class Difference(BaseModel):
    """The differences between two revisions."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "before": 1,
                "after": 3,
                "elements": [{"address": "/mcml/header/calibration_unit", "after": "cm"}],
                "frames_before": 1197,
                "frames_after": 1187,
                "frames_removed": [{"first": 1, "last": 10}],
                "frames_added": [],
                "frames_kept": [{"before": 11, "after": 1, "count": 1187}],
                "frames_moved": False,
                "labels_removed": [],
                "labels_added": [{"name": MOTION_NAME, "first": 100, "last": 142}],
                "bones": [
                    {
                        "bone": "left_up_leg",
                        "first": 100,
                        "last": 100,
                        "frames": 1,
                        "channels": {"Rx": 0.75},
                        "angle": 0.75,
                    }
                ],
            }
        )
    )

    before: int
    after: int
    elements: list[ElementDifference] = Field(description="Of header, root and skeleton")
    frames_before: int
    frames_after: int
    frames_removed: list[FrameRange] = Field(description="Positions in the earlier revision")
    frames_added: list[FrameRange] = Field(description="Positions in the later revision")
    frames_kept: list[KeptFrames] = Field(description="Frames that both have, in the order of the later revision")
    frames_moved: bool = Field(description="Whether frames in both have another order")
    labels_removed: list[LabelDifference]
    labels_added: list[LabelDifference]
    bones: list[BoneDifference] = Field(description="Samples that changed, a bone at a time")


class LargestChange(BaseModel):
    """The number that differs most, in the unit of the document."""

    bone: str
    channel: str
    frame: int
    before: float
    after: float


class SkeletonReplaced(BaseModel):
    """How the skeleton and the frame rate of a new file differ from the document's."""

    added: list[str] = Field(description="Joints that only the file has")
    removed: list[str] = Field(description="Joints that only the document has")
    changed: list[str] = Field(description="Joints with another parent, rest pose or list of channels")
    rate_before: float | None = Field(description="Frames a second of the document")
    rate: float | None = Field(description="Frames a second of the file")


class FileReplaced(BaseModel):
    """How a new file differs from the document whose frames it replaces."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "revision": 3,
                "frames": 301,
                "frames_before": 300,
                "first": 120,
                "last": 301,
                "joints": ["left_hand"],
                "largest": {"bone": "left_hand", "channel": "Rx", "frame": 130, "before": 45.2, "after": 51.0},
            }
        )
    )

    revision: int = Field(description="The current revision: the new one, unless nothing differs or `dry_run` is true")
    frames: int
    frames_before: int
    first: int | None = Field(None, description="First frame that differs, from 1")
    last: int | None = Field(None, description="Last frame that differs")
    joints: list[str] = Field([], description="Joints whose numbers differ in frames that both have")
    largest: LargestChange | None = None
    skeleton: SkeletonReplaced | None = Field(None, description="With `replace_skeleton`, where the skeletons differ")
