"""Search for similar poses and motions."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcml_schemas.examples import DOCUMENT, PROJECT, shown
from mcml_schemas.request_body import RequestBody

MOST_HITS = 1_000
MOST_FRAMES = 2_000
"""Limit of frames of a searched motion."""
MOST_POINTS = 100

_ASKED = {"document": DOCUMENT, "first": 100, "last": 160, "limit": 5}
_HIT = {"document": DOCUMENT, "name": "walk", "revision": 1, "first": 412, "last": 470, "distance": 0.0831}
_ANSWER = {"frames": 61, "joints": ["neck1", "Head", "left_hand"], "hits": [_HIT], "warnings": []}

Coordinate: TypeAlias = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]
Point: TypeAlias = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Frame: TypeAlias = Annotated[list[Point | None], Field(max_length=MOST_POINTS)]


class SearchRequest(RequestBody):
    """A pose or a motion: frames of a stored document, or joints with their positions."""

    model_config = ConfigDict(json_schema_extra=shown(_ASKED))

    document: str | None = Field(None, description="A document: its id", examples=[DOCUMENT])
    revision: int | None = Field(None, ge=1, le=2**31 - 1, description="Of this document; default the newest")
    first: int = Field(1, ge=1, le=2**31 - 1, description="Its frame, a position from 1")
    last: int | None = Field(
        None, ge=1, le=2**31 - 1, description="The motion from `first` to here; without it the pose in `first`"
    )
    joints: list[str] | None = Field(
        None, max_length=MOST_POINTS, description="MCML's names of joints", examples=[["Root", "Head", "left_hand"]]
    )
    positions: list[Frame] | None = Field(
        None,
        min_length=1,
        max_length=MOST_FRAMES,
        description="Of each frame, of each of `joints`: x, y, z in any unit, or null; one frame is a pose",
    )
    seconds_per_frame: float | None = Field(None, gt=0, le=1e6, description="Of `positions` of several frames")
    up: str | None = Field(None, max_length=2, description="The axis of `positions` that points up; default guessed")
    within: list[str] = Field(default_factory=list, description="Look in these documents; default in all")
    project: str | None = Field(None, description="Look in this project only", examples=[PROJECT])
    limit: int = Field(20, ge=1, le=MOST_HITS, description="Most hits")
    apart: float | None = Field(
        None,
        ge=0,
        le=1e6,
        description="Minimum seconds between hits in one document; default 1, or the duration of the motion",
    )

    @model_validator(mode="after")
    def _one_thing(self) -> SearchRequest:
        if (self.document is None) == (self.positions is None):
            raise ValueError("say either `document` (with `first` and `last`) or `positions` (with `joints`)")
        if self.positions is not None:
            joints = self.joints or []
            if any(len(frame) != len(joints) for frame in self.positions):
                raise ValueError(f"each frame of `positions` has a point or null for each of the {len(joints)} joints")
            if len(self.positions) > 1 and self.seconds_per_frame is None:
                raise ValueError("`positions` of several frames need `seconds_per_frame`")
        return self


class SearchHit(BaseModel):
    """A pose (`first` is `last`), or the frame range that is most similar to the motion."""

    model_config = ConfigDict(json_schema_extra=shown(_HIT))

    document: str
    name: str
    revision: int
    first: int
    last: int
    distance: float = Field(description="Root mean square over joints, in leg lengths; of a motion on the average")


class SearchAnswer(BaseModel):
    """hits: the most alike first."""

    model_config = ConfigDict(json_schema_extra=shown(_ANSWER))

    frames: int = Field(description="Number of frames of the example; 1 is a pose")
    joints: list[str] = Field(description="By which joints poses are compared, where others have them")
    hits: list[SearchHit]
    warnings: list[str] = Field(default_factory=list)
