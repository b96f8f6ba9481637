"""Paths through a space of expressions: making, refining and playing them."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from mcml_schemas.analyses.expression import ExpressionFrame, ExpressionWarning, Key
from mcml_schemas.examples import DOCUMENT, shown
from mcml_schemas.request_body import RequestBody

_FRAME = {"document": DOCUMENT, "frame": 120}
_OTHER = {"document": DOCUMENT, "frame": 183}
_STEP = {**_FRAME, "position_mm": 0.0, "key": True}
_OFFER = {**_OTHER, "segment": 0, "position_mm": 151.4, "apart_mm": 4.8, "accepted": True}
_SAMPLE = {"frame_a": _FRAME, "frame_b": _OTHER, "alpha": 0.25, "position_mm": 77.1}


class ExpressionPathWish(RequestBody):
    """A path over key frames."""

    model_config = ConfigDict(json_schema_extra=shown({"level": 0, "keys": [3, 4]}))

    level: int = Field(0, ge=0, le=20, description="Whose candidates the keys are", examples=[0])
    keys: list[Key] = Field(
        max_length=1000,
        description="Candidates in the order of the path, each linked to the next: their ids, or frames",
        examples=[[3, 4]],
    )
    auto_route: bool = Field(
        False, description="Put the candidates between two keys in where these are not linked", examples=[False]
    )


class ExpressionStep(ExpressionFrame):
    """A frame of a walk."""

    model_config = ConfigDict(json_schema_extra=shown(_STEP))

    position_mm: float = Field(description="How far from the start", examples=[0.0])
    key: bool = Field(description="Whether it is a key frame", examples=[True])


class ExpressionOffer(ExpressionFrame):
    """A candidate that the path may lead over."""

    model_config = ConfigDict(json_schema_extra=shown(_OFFER))

    segment: int = Field(description="Number of the key before it, from 0", examples=[0])
    position_mm: float = Field(description="Where along the walk", examples=[151.4])
    apart_mm: float = Field(
        description="How far it is from the walk on the map (paper), or how much longer the way over it is (robust)",
        examples=[4.8],
    )
    accepted: bool = Field(description="Whether it is a key of the refined path", examples=[True])


class ExpressionPath(BaseModel):
    """A path, and the walk of captured frames that it is."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"version": 1, "level": 0, "keys": [_FRAME, _OTHER], "walk": [_STEP], "length_mm": 310.2,
             "largest_hop_mm": 152.0, "bridges": 0, "offered": [_OFFER], "warnings": []}
        )
    )  # fmt: skip

    version: int = Field(description="1 for a new path, one more with every refinement", examples=[1])
    level: int = Field(description="Level of the keys that were added last", examples=[0])
    keys: list[ExpressionFrame] = Field(description="In the order of the path")
    walk: list[ExpressionStep] = Field(description="All frames of the walk; each is near enough to the next")
    length_mm: float = Field(description="Sum of its steps", examples=[310.2])
    largest_hop_mm: float = Field(description="Its longest step", examples=[152.0])
    bridges: int = Field(description="Steps over edges that were added to join parts", examples=[0])
    offered: list[ExpressionOffer] = Field(description="Candidates that the path may lead over, in its order")
    warnings: list[ExpressionWarning] = Field(description="bridge-crossed, keys-lost")


class ExpressionRefinement(RequestBody):
    """Parameters for refining a path. With neither keys nor auto nothing is stored: the answer lists the options."""

    model_config = ConfigDict(json_schema_extra=shown({"level": 3, "auto": True}))

    level: int = Field(ge=0, le=20, description="Whose candidates are offered", examples=[3])
    keys: list[Key] = Field(
        [],
        max_length=1000,
        description="Candidates of the level to lead over too, ids or frames; each is put where it costs least",
        examples=[[_OTHER]],
    )
    auto: bool = Field(False, description="Take those of small detour", examples=[True])
    rule: Literal["robust", "paper"] | None = Field(
        None,
        description="Offered are candidates near the walk on the map (paper) or of small detour (robust); as the space "
        "was built if left out",
        examples=["robust"],
    )
    delta: FiniteFloat = Field(
        0.1, ge=0, le=10, description="auto: share by which the path may grow; robust: also of a detour", examples=[0.1]
    )
    radius_mm: FiniteFloat | None = Field(
        None,
        ge=0,
        description="paper: how near on the map; the median distance of the level's candidates to the nearest if left "
        "out",
        examples=[40.0],
    )


class ExpressionPlayback(RequestBody):
    """How a path is played."""

    model_config = ConfigDict(json_schema_extra=shown({"fps": 60}))

    fps: FiniteFloat = Field(60.0, gt=0, le=1000, description="Frames a second", examples=[60])
    speed_mm_s: FiniteFloat | None = Field(
        None,
        gt=0,
        description="Along the path; three quarters of the captured frames are slower than the speed used if left out",
        examples=[300.0],
    )
    duration_s: FiniteFloat | None = Field(
        None, gt=0, le=86_400, description="Seconds of one way, in place of a speed", examples=[4.0]
    )
    loop: bool = Field(False, description="Append the way back", examples=[False])
    smooth: bool = Field(False, description="Smooth the markers over 2 frames, the ends fixed", examples=[False])
    most_samples: int = Field(1000, ge=0, le=36_000, description="Maximum number of samples", examples=[1000])


class ExpressionSample(BaseModel):
    """A frame of the playback: (1 - alpha) of one captured frame and alpha of another."""

    model_config = ConfigDict(json_schema_extra=shown(_SAMPLE))

    frame_a: ExpressionFrame = Field(description="The one")
    frame_b: ExpressionFrame = Field(description="The other")
    alpha: float = Field(description="0 at the one, 1 at the other", examples=[0.25])
    position_mm: float = Field(description="How far from the start", examples=[77.1])


class ExpressionMotion(BaseModel):
    """A path as a motion of markers."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"frames": 241, "fps": 60.0, "duration_s": 4.0, "speed_mm_s": 77.6, "length_mm": 310.2,
             "samples": [_SAMPLE], "missing": 0}
        )
    )  # fmt: skip

    frames: int = Field(description="How many frames the motion has", examples=[241])
    fps: float = Field(description="Frames a second", examples=[60.0])
    duration_s: float = Field(description="From the first frame to the last", examples=[4.0])
    speed_mm_s: float = Field(
        description="Along the path, as used: a whole number of frames has to fit", examples=[77.6]
    )
    length_mm: float = Field(description="Of one way", examples=[310.2])
    samples: list[ExpressionSample] = Field(description="The first samples, up to the requested number")
    missing: int = Field(description="Samples of markers that neither captured frame has", examples=[0])
