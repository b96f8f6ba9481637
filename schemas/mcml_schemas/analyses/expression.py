"""The space of facial expressions: its parameters, and the input and output of its operations; paths:
`expression_paths`.

A frame is named by the document it is in and its position there, from 1. Lengths are mm between faces: the paper's
distance of matrices of all marker distances.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from mcml_schemas.examples import DOCUMENT, shown
from mcml_schemas.request_body import RequestBody

_FRAME = {"document": DOCUMENT, "frame": 120}
_OTHER = {"document": DOCUMENT, "frame": 183}
_CANDIDATE = {**_FRAME, "id": 3, "x": 412.5, "y": -80.2, "size": 214}
_NEIGHBOUR = {**_OTHER, "id": 4, "x": 520.0, "y": 11.9, "size": 97, "length_mm": 310.2, "bridge": False}
_LINK = {"a": 3, "b": 4, "length_mm": 310.2, "bridge": False}
_TAKE = {"document": DOCUMENT, "name": "face_001_joy"}


class ExpressionParameters(RequestBody):
    """Parameters of a space of expressions. Defaults depend on the method."""

    model_config = ConfigDict(json_schema_extra=shown({"method": "robust"}))

    method: Literal["robust", "paper"] = Field(
        "robust", description="robust, or paper: as published, with its weak points", examples=["robust"]
    )
    markers: list[Annotated[str, Field(min_length=1, max_length=256)]] = Field(
        [],
        max_length=1000,
        description="Names of the markers that count; all that the takes have in common if left empty",
        examples=[["brow_1_1_l", "brow_1_1_r", "lip_3_1_l", "lip_3_1_r"]],
    )
    normalise_scale: bool = Field(
        False, description="Bring faces of several people to the size of the first", examples=[False]
    )
    smooth_s: FiniteFloat | None = Field(
        None,
        ge=0,
        le=1,
        description="Deviation of the Gaussian that markers are smoothed with in time, s; 1/30 (robust) or 0 (paper) "
        "if left out",
        examples=[0.0333],
    )
    tau_mm: FiniteFloat | None = Field(
        None,
        gt=0,
        description="Faces up to so many mm apart may follow each other; found by tau_rule if left out",
        examples=[230.0],
    )
    tau_rule: Literal["published", "best", "unbroken"] | None = Field(
        None,
        description="published: 2.3 mm for each marker (paper); best: where map and geodesics correlate most; "
        "unbroken: with a margin, the smallest at which near faces are near on the graph (robust)",
        examples=["unbroken"],
    )
    tau_count: int = Field(
        12,
        ge=0,
        le=50,
        description="Thresholds tried for the curve; at least 24 where the rule unbroken decides",
        examples=[12],
    )
    on_disconnected: Literal["bridge", "largest", "error"] | None = Field(
        None,
        description="Where the graph falls into parts: join them by their closest frames (robust), keep the largest "
        "(paper), or fail",
        examples=["bridge"],
    )
    scale: Literal["auto", "full", "landmark"] = Field(
        "auto",
        description="full: all distances; landmark: distances to landmarks, for up to 100,000 frames; auto: landmark "
        "above 5,000 frames",
        examples=["auto"],
    )
    first_level: int = Field(11, ge=2, le=1000, description="Candidates of the coarsest level", examples=[11])
    grouping: Literal["fcm", "fps"] | None = Field(
        None,
        description="Candidates by fuzzy c-means, or farthest points: then each level has those of the coarser ones",
        examples=["fcm"],
    )
    cluster_dimensions: int | None = Field(
        None,
        ge=2,
        le=10,
        description="Dimensions of the map in which frames are grouped; 10 (robust) or 2 (paper) if left out",
        examples=[10],
    )
    fuzziness: FiniteFloat = Field(2.0, gt=1, le=10, description="Exponent of the memberships", examples=[2.0])
    iterations: int = Field(100, ge=1, le=1000, description="Most iterations of fuzzy c-means", examples=[100])
    links: Literal["voronoi", "paper"] | None = Field(
        None,
        description="voronoi: candidates whose regions touch (robust); paper: those between whose shortest path no "
        "third one is near",
        examples=["voronoi"],
    )
    rho_mm: FiniteFloat | None = Field(
        None,
        ge=0,
        description="How near on the map the paper's links take as near; half the median distance of candidates if "
        "left out",
        examples=[40.0],
    )
    neighbours: int = Field(
        12, ge=2, le=100, description="Frames of the space that an added one is joined to", examples=[12]
    )
    landmarks: int = Field(300, ge=20, le=2000, description="Landmarks of a large space", examples=[300])
    seed: int = Field(0, ge=0, le=2**31 - 1, description="Seed of the random start of the paper", examples=[0])


class ExpressionFrame(BaseModel):
    """A captured frame."""

    model_config = ConfigDict(json_schema_extra=shown(_FRAME))

    document: str = Field(description="Id of the take", examples=[DOCUMENT])
    frame: int = Field(ge=1, description="Position in the take, from 1", examples=[120])


class ExpressionTake(BaseModel):
    """A take of the space."""

    model_config = ConfigDict(json_schema_extra=shown(_TAKE))

    document: str = Field(description="Its id", examples=[DOCUMENT])
    name: str = Field(description="Its name when the space was built", examples=["face_001_joy"])


class ExpressionWarning(BaseModel):
    """Something that the user should know."""

    model_config = ConfigDict(json_schema_extra=shown({"code": "bridge-crossed", "what": "The path crosses a bridge."}))

    code: str = Field(description="Its name", examples=["bridge-crossed"])
    what: str = Field(description="One sentence", examples=["The path crosses a bridge."])


class ExpressionStride(RequestBody):
    """Which frames' places on the map."""

    model_config = ConfigDict(json_schema_extra=shown({"stride": 4}))

    stride: int = Field(1, ge=1, le=100_000, description="Every so many frames", examples=[4])


class ExpressionPoints(BaseModel):
    """Places of frames on the map, a column each."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"total": 2400, "stride": 1200, "take": [0, 0], "frame": [1, 1201], "x": [1.5, 7.0], "y": [0.1, 2.4],
             "takes": [_TAKE]}
        )
    )  # fmt: skip

    total: int = Field(description="Frames of the space", examples=[2400])
    stride: int = Field(description="As requested", examples=[4])
    take: list[int] = Field(description="Place of each frame's take in `takes`, from 0", examples=[[0, 0]])
    frame: list[int] = Field(description="Position of each frame in its take, from 1", examples=[[1, 5]])
    x: list[float] = Field(description="mm on the map", examples=[[1.5, 7.0]])
    y: list[float] = Field(description="mm on the map", examples=[[0.1, 2.4]])
    takes: list[ExpressionTake] = Field(description="All takes of the space")


class ExpressionLevelChoice(RequestBody):
    """Which level."""

    model_config = ConfigDict(json_schema_extra=shown({"level": 0}))

    level: int = Field(0, ge=0, le=20, description="0 is the coarsest", examples=[0])
    most_links: int = Field(
        2000, ge=0, le=20_000, description="Maximum number of links, the shortest first", examples=[2000]
    )


class ExpressionCandidate(ExpressionFrame):
    """A frame that represents others at a level."""

    model_config = ConfigDict(json_schema_extra=shown(_CANDIDATE))

    id: int = Field(description="Its number at the level, from 0", examples=[3])
    x: float = Field(description="mm on the map", examples=[412.5])
    y: float = Field(description="mm on the map", examples=[-80.2])
    size: int = Field(description="Frames to which it is the nearest candidate", examples=[214])


class ExpressionLink(BaseModel):
    """A link between two candidates of a level."""

    model_config = ConfigDict(json_schema_extra=shown(_LINK))

    a: int = Field(description="Id of a candidate of the level", examples=[3])
    b: int = Field(description="Id of the other", examples=[4])
    length_mm: float = Field(description="Length of the way", examples=[310.2])
    bridge: bool = Field(description="Whether it leads over an edge that was added to join parts", examples=[False])


class ExpressionLevel(BaseModel):
    """Candidates of a level and the links between them."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"level": 0, "levels": 9, "candidates": [_CANDIDATE], "links": [_LINK], "links_total": 26, "components": 1,
             "unique": 11, "coverage_mm": 396.6}
        )
    )  # fmt: skip

    level: int = Field(description="As requested", examples=[0])
    levels: int = Field(description="How many levels the space has", examples=[9])
    candidates: list[ExpressionCandidate] = Field(description="In the order of their ids")
    links: list[ExpressionLink] = Field(description="The shortest first")
    links_total: int = Field(description="How many links the level has", examples=[26])
    components: int = Field(description="Parts that the links fall into", examples=[1])
    unique: int = Field(description="Candidates that are nearest to a centre; others fill up", examples=[11])
    coverage_mm: float = Field(description="No frame is farther from its candidate on the map", examples=[396.6])


class ExpressionKey(RequestBody, ExpressionFrame):
    """A captured frame that is a candidate."""

    model_config = ConfigDict(json_schema_extra=shown(_FRAME))


Key = Annotated[int, Field(ge=0, description="Its id, as `level` shows it")] | ExpressionKey
"""A candidate of a level, by its id there or by the frame that it is."""


class ExpressionCandidateChoice(RequestBody):
    """Which candidate's neighbours: by its id, or by the frame that it is."""

    model_config = ConfigDict(json_schema_extra=shown({"level": 0, "id": 3}))

    level: int = Field(0, ge=0, le=20, description="0 is the coarsest", examples=[0])
    id: int | None = Field(None, ge=0, description="Its id, as `level` shows it", examples=[3])
    document: str | None = Field(None, description="Id of the take, in place of the id", examples=[DOCUMENT])
    frame: int | None = Field(None, ge=1, description="Position in the take, from 1", examples=[120])

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if (self.id is None) == (self.document is None) or (self.document is None) != (self.frame is None):
            raise ValueError("give the id of a candidate, or document and frame")
        return self

    @property
    def key(self) -> Key:
        if self.document is None or self.frame is None:
            return self.id or 0
        return ExpressionKey(document=self.document, frame=self.frame)


class ExpressionNeighbour(ExpressionCandidate):
    """A candidate linked to another."""

    model_config = ConfigDict(json_schema_extra=shown(_NEIGHBOUR))

    length_mm: float = Field(description="Length of the way", examples=[310.2])
    bridge: bool = Field(description="Whether it leads over an edge that was added to join parts", examples=[False])


class ExpressionNeighbours(BaseModel):
    """The linked candidates of a candidate."""

    model_config = ConfigDict(json_schema_extra=shown({"candidate": _CANDIDATE, "neighbours": [_NEIGHBOUR]}))

    candidate: ExpressionCandidate = Field(description="As requested")
    neighbours: list[ExpressionNeighbour] = Field(description="The nearest first")
