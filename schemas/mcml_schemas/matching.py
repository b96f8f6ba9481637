"""Motion matching: a body that follows a path by frames of many clips."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.compose import Composed, Segment
from mcml_schemas.examples import DOCUMENT, PROJECT, example_of, shown
from mcml_schemas.jobs import Selection
from mcml_schemas.request_body import RequestBody

FARTHEST = 10_000.0
"""Metres from the origin."""

Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
GroundPoint = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]


class MatchingSelection(RequestBody):
    """The clips whose frames are used. Those of another skeleton are left out."""

    model_config = ConfigDict(json_schema_extra=shown({"selection": {"project": PROJECT, "motion_name": "walk"}}))

    selection: Selection
    skeleton: str | None = Field(
        None,
        description="Document whose skeleton is used; default the skeleton with the most motion",
        examples=[DOCUMENT],
    )


class FollowRequest(MatchingSelection):
    """A path on the ground, and the clips whose frames follow it."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "selection": {"project": PROJECT, "motion_name": "walk"},
                "path": [[0, 0], [4, 0], [4, 4]],
                "name": "walk round the corner",
                "project": PROJECT,
            }
        )
    )

    path: list[GroundPoint] = Field(
        min_length=2,
        max_length=10_000,
        description="Points in metres, joined by lines: x and z where Y points up, x and y where Z does, y and z for X",
    )
    speed: float | None = Field(
        None, ge=0.05, le=20, description="Metres a second; default the usual one of the clips", examples=[1.2]
    )
    facing: float = Field(
        0.0, ge=-180, le=180, description="Degrees to the left of the course of the path to which the body faces"
    )
    steering: float = Field(
        10.0, ge=0, le=45, description="Degrees by which the body is turned towards the path at each cut, at most"
    )
    seconds: float = Field(0.3, ge=0, le=2, description="Time over which the differences at a cut decay")
    lock_feet: bool = Field(True, description="Feet that stand at a cut stay in place during its transition")
    labels: bool = Field(True, description="Copy the labels")
    name: str = Field("path", min_length=1, max_length=1024)
    project: str = Field("default", min_length=1, max_length=256)
    preview: bool = Field(False, description="Preview the result without storing it")


class LeftOut(BaseModel):
    """A selected document that is not used."""

    document: str
    name: str
    reason: str


class PathDistance(BaseModel):
    """Metres from the body to the path."""

    mean: float
    percentile_90: float
    largest: float


class PathFollowed(Composed):
    """The composed document, and how well it follows the path."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            example_of(Composed)
            | {
                "metres": 7.9,
                "complete": True,
                "speed": 1.05,
                "distance": {"mean": 0.05, "percentile_90": 0.11, "largest": 0.18},
                "composition": [
                    {"document": DOCUMENT, "first": 1, "last": 60, "place": {"degrees": 90, "shift": [0, 0, 1]}}
                ],
                "left_out": [],
            }
        )
    )

    metres: float = Field(description="Length of the path that was covered")
    complete: bool = Field(description="Whether the end of the path was reached")
    speed: float = Field(description="Metres a second that were asked for")
    distance: PathDistance
    composition: list[Segment] = Field(description="The segments with their places, as `POST /compose` takes them")
    left_out: list[LeftOut]


class MatchingClip(BaseModel):
    """Rows first to last (from 0, both included) of a library are of this document.

    Row k is k / rate seconds after frame `skipped` + 1. metres: of a unit of its lengths.
    """

    document: str
    revision: int
    name: str
    first: int
    last: int
    frames: int
    seconds_per_frame: float
    skipped: int
    metres: float


class MatchingFacts(BaseModel):
    """How rows of a library of motion matching are to be read, and which clips they are of.

    up: the axis that points up. axes: the level axes of places, right-handed. scales: by which features in metres and
    seconds were multiplied. ahead: rows at which the way is looked at. speed: the usual one, metres a second.
    """

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "rate": 30.0,
                "rows": 120,
                "up": "Y",
                "axes": "ZX",
                "scales": [1.0] * 27,
                "ahead": [10, 20, 30],
                "speed": 1.05,
                "clips": [
                    {
                        "document": DOCUMENT,
                        "revision": 1,
                        "name": "walk",
                        "first": 0,
                        "last": 119,
                        "frames": 480,
                        "seconds_per_frame": 0.0083333,
                        "skipped": 0,
                        "metres": 0.01,
                    }
                ],
                "left_out": [],
            }
        )
    )

    rate: float
    rows: int
    up: str
    axes: str
    scales: list[float]
    ahead: list[int]
    speed: float
    clips: list[MatchingClip]
    left_out: list[LeftOut]
