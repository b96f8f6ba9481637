"""New documents from frames of others."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcml_schemas.examples import DOCUMENT, MOTION_NAME, PROJECT, shown
from mcml_schemas.frames import PreviewMotion
from mcml_schemas.request_body import RequestBody
from mcml_schemas.retarget import WantedMapping

Style = Literal["bridge", "crossfade", "inertial"]


class Layer(RequestBody):
    """Bones that move as in another clip, frame by frame from frame `at` of the segment on."""

    document: str
    first: int = Field(1, ge=1)
    last: int | None = Field(None, ge=1)
    at: int = Field(1, ge=1, le=2**31 - 1, description="Frame of the segment, from 1, where it begins")
    bones: list[str] = Field(min_length=1, max_length=10_000, description="By MCML name")
    strength: float = Field(1.0, ge=0, le=1, description="1: wholly as in the other clip")
    ease: int = Field(0, ge=0, le=100_000, description="Frames over which the layer comes and goes")
    mapping: WantedMapping = None


class Place(RequestBody):
    """Where a segment is placed: turned about the up axis through the origin, then shifted, in the document's unit."""

    degrees: float = Field(0.0, ge=-1e6, le=1e6)
    shift: Annotated[list[Annotated[float, Field(ge=-1e12, le=1e12)]], Field(min_length=3, max_length=3)]


class Segment(RequestBody):
    """Frames of a document, or the runs of frames that an XPath expression finds, in order."""

    document: str | None = Field(None, description="Document; with `xpath`: look only there", examples=[DOCUMENT])
    revision: int | None = Field(None, ge=1)
    first: int = Field(1, ge=1)
    last: int | None = Field(None, ge=1, description="Last frame, included; default the last one")
    xpath: str | None = Field(None, max_length=10_000, examples=[f"//frame[motion_name='{MOTION_NAME}']"])
    project: str | None = Field(None, description="With `xpath`: look only there")
    layers: list[Layer] = Field([], max_length=100)
    mapping: WantedMapping = None
    speed: float = Field(1.0, ge=0.05, le=20, description="2: twice as fast")
    mirror: bool = Field(False, description="With left and right exchanged")
    transition: int | None = Field(
        None, ge=0, le=2000, description="Frames of the transition before it; default the request's"
    )
    style: Style | None = Field(None, description="Of that transition; default the request's")
    place: Place | None = Field(
        None, description="Where it is placed, as `degrees` and `shift` of a seam; default by `align`"
    )

    @model_validator(mode="after")
    def _names_something(self) -> Segment:
        if self.document is None and self.xpath is None:
            raise ValueError("a segment names a document or an xpath")
        if self.xpath is not None and (self.revision is not None or self.last is not None or self.first != 1):
            raise ValueError("an xpath says itself which frames: leave first, last and revision out")
        return self


class ComposeRequest(RequestBody):
    """A new document of segments, one after the other."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "segments": [
                    {"document": DOCUMENT, "first": 1, "last": 120},
                    {"xpath": f"//frame[motion_name='{MOTION_NAME}']", "project": PROJECT},
                ],
                "seconds": 0.3,
                "name": "walk and kick",
                "project": PROJECT,
            }
        ),
    )

    segments: list[Segment] = Field(min_length=1, max_length=1000)
    header: str | None = Field(None, description="Document whose header is used; default the first segment's")
    skeleton: str | None = Field(None, description="Document whose skeleton is used; default the first segment's")
    rate: float | None = Field(None, gt=0, le=100_000, description="Frames a second; default the first segment's")
    transition: int | None = Field(
        None, ge=0, le=2000, description="Frames between segments that do not follow one another; default by `seconds`"
    )
    seconds: float = Field(0.3, ge=0, le=60, description="Length of transitions, at any frame rate")
    style: Style = Field(
        "bridge",
        description="bridge: new frames between segments; crossfade: frames of both blended; inertial: the difference "
        "at the seam decays over the first frames of the next segment",
    )
    lengthen: bool = Field(True, description="Longer transitions where the motion would jump")
    align: bool = Field(True, description="Turn and shift each segment on the ground so that the body goes on")
    match_phase: bool = Field(
        False,
        description="Where both sides of a seam walk: leave out up to 1.2 s of each to meet in the same phase",
    )
    lock_feet: bool = Field(True, description="Feet that stand at a seam stay in place during its transition")
    labels: bool = Field(True, description="Copy the labels")
    name: str = Field("composed", min_length=1, max_length=1024)
    project: str = Field("default", min_length=1, max_length=256)
    preview: bool = Field(False, description="Preview the result without storing it")


class ComposedSeam(BaseModel):
    """The start of a segment: its first frame or its transition, positions from 1.

    degrees, shift: rotation of the segment about the up axis, and its shift. root_step, angle_step: the largest step at
    the seam, relative to the largest inside the segments. jerk: the largest of a joint over the seam, relative to the
    99th percentile inside the segments. slide: mean speed over the ground of the foot that moves least, in leg lengths
    a second. locked: feet held in place. left_out: frames at the end of the segment before and at the beginning of this
    one, by `match_phase`.
    """

    segment: int
    first: int
    transition: int
    degrees: float
    shift: list[float]
    root_step: float
    angle_step: float
    jerk: float
    slide: float | None = Field(None, description="None without legs")
    locked: list[Literal["left", "right"]]
    left_out: tuple[int, int] = (0, 0)


class ComposedSegment(BaseModel):
    """Frames of the new document that are those of a source. segment: from 1."""

    segment: int
    first: int
    last: int
    document: str
    revision: int
    source_first: int


class Composed(BaseModel):
    """The new document, with its segments and seams."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "document": DOCUMENT,
                "frames": 175,
                "seconds_per_frame": 0.0083333,
                "segments": [
                    {
                        "segment": 1,
                        "first": 1,
                        "last": 120,
                        "document": DOCUMENT,
                        "revision": 1,
                        "source_first": 1,
                    }
                ],
                "seams": [],
                "notices": [],
            }
        )
    )

    document: str | None = Field(None, description="Id of the new document; none in a preview")
    frames: int
    seconds_per_frame: float
    segments: list[ComposedSegment]
    seams: list[ComposedSeam]
    notices: list[str]
    motion: PreviewMotion | None = Field(None, description="Positions, if requested")


class SplitRequest(RequestBody):
    """Where a document is cut: before some frames, around the frames of a motion name, or around one range."""

    model_config = ConfigDict(
        json_schema_extra=shown({"at": [101, 241]}, {"label": MOTION_NAME}, {"first": 101, "last": 240, "name": "turn"})
    )

    at: list[Annotated[int, Field(ge=2)]] = Field([], max_length=1000, description="First frames of parts; 1 is one")
    label: str | None = Field(None, min_length=1, max_length=1024, description="Every range of this name is a part")
    first: int | None = Field(None, ge=1, description="Extract only one part: from this frame, default 1")
    last: int | None = Field(None, ge=1, description="Extract only one part: to this frame, included; default the last")
    name: str | None = Field(
        None, min_length=1, max_length=1024, description="Of the only part; of several, the beginning of their names"
    )
    project: str | None = Field(None, min_length=1, max_length=256, description="Of the parts; default the document's")

    @model_validator(mode="after")
    def _says_where(self) -> SplitRequest:
        if bool(self.at) + (self.label is not None) + self.is_range != 1:
            raise ValueError("give one of these: frames `at` which to cut, a `label`, or `first` and `last`")
        return self

    @property
    def is_range(self) -> bool:
        """Whether only one part is wanted."""
        return self.first is not None or self.last is not None


class SplitPart(BaseModel):
    """A new document, and which frames of the old one it has."""

    document: str
    name: str
    first: int
    last: int


class SplitParts(BaseModel):
    """The new documents, in order. The split document does not change."""

    model_config = ConfigDict(
        json_schema_extra=shown({"items": [{"document": DOCUMENT, "name": "walk 1-100", "first": 1, "last": 100}]})
    )

    items: list[SplitPart]


class SkeletonsRequest(RequestBody):
    """Which people of a marker trial get a skeleton, and where its documents go."""

    model_config = ConfigDict(json_schema_extra=shown({"people": ["Anna"], "project": PROJECT}))

    people: list[Annotated[str, Field(max_length=256)]] | None = Field(
        None, min_length=1, max_length=100, description="Prefixes of their markers; default all of the trial"
    )
    name: str | None = Field(
        None,
        min_length=1,
        max_length=1024,
        description="Of the new document; of several, the beginning of their names. Default made from the trial's",
    )
    project: str | None = Field(None, min_length=1, max_length=256, description="Of the documents; default the trial's")
    preview: bool = Field(False, description="Preview the quality without storing anything")


class JointMiss(BaseModel):
    """How far a joint is from the centre that markers tell, in metres if the unit is known, else in the trial's unit.

    Bones keep one length, markers on skin do not.
    """

    joint: str
    rms: float | None = Field(description="Root mean square over the frames; null without any")
    most: float | None = Field(description="In the worst frame")
    unknown: int = Field(description="Frames without the joint, as a marker is missing that it needs")


class MadeSkeleton(BaseModel):
    """A person of a trial with a skeleton."""

    document: str | None = Field(description="Id of the new document; null in a preview")
    name: str
    person: str = Field(description="Prefix of the markers; empty if they have none")
    frames: int
    joints: list[JointMiss]
    notices: list[str]


class MadeSkeletons(BaseModel):
    """A document for each person, in the order of their markers. The trial does not change."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "items": [
                    {
                        "document": DOCUMENT,
                        "name": "trial Anna",
                        "person": "Anna",
                        "frames": 300,
                        "joints": [{"joint": "left_foot", "rms": 0.008, "most": 0.019, "unknown": 0}],
                        "notices": [],
                    }
                ]
            }
        )
    )

    items: list[MadeSkeleton]
