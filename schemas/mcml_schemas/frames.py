"""Changes of ranges of frames."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, shown
from mcml_schemas.request_body import RequestBody
from mcml_schemas.revisions import FrameRange, KeptFrames

FrameForm: TypeAlias = Literal["json", "npy", "npz", "block", "arrow", "parquet", "csv"]
"""How frames are written as numbers."""

Position = Annotated[int, Field(ge=1, le=2**31 - 1)]


class _Range(RequestBody):
    first: Position = Field(description="First frame, a position from 1")
    last: Position = Field(description="Last frame, included")


class DeleteFrames(_Range):
    """Take frames out; later ones move up."""

    do: Literal["delete"]


class KeepFrames(_Range):
    """Keep these frames alone."""

    do: Literal["keep"]


class ReverseFrames(_Range):
    """Let frames run backwards; their ids and motion names stay where they are."""

    do: Literal["reverse"]


class MoveFrames(_Range):
    """Take frames out and put them before the frame that is at position `to` now."""

    do: Literal["move"]
    to: Position = Field(description="Before this frame; one more than there are frames: at the end")


class InsertFrames(_Range):
    """Put frames of this or another document before the frame at position `at`, motion names included."""

    do: Literal["insert"]
    at: Position = Field(description="Before this frame; one more than there are frames: at the end")
    document: str | None = Field(None, description="Where the frames are; default this document", examples=[DOCUMENT])


class MirrorFrames(_Range):
    """Exchange left and right, at the upright plane of the body in the first of these frames."""

    do: Literal["mirror"]


Bones = Annotated[list[str], Field(max_length=10_000, description="Bones by MCML name; default all")]
Ease = Annotated[int, Field(ge=0, le=100_000, description="Frames at either end over which the edit comes and goes")]


class SmoothFrames(_Range):
    """Smooth by a Gaussian: rotations as such, not their angles."""

    do: Literal["smooth"]
    seconds: float = Field(0.05, gt=0, le=10, description="Standard deviation")
    bones: Bones = Field([])
    ease: Ease = 0


class AdjustFrames(_Range):
    """Multiply channels, then add to them."""

    do: Literal["adjust"]
    channels: list[Literal["Tx", "Ty", "Tz", "Rx", "Ry", "Rz", "SF", "residual", "weight"]] = Field(min_length=1)
    factor: float = Field(1.0, ge=-1e9, le=1e9)
    offset: float = Field(0.0, ge=-1e12, le=1e12, description="In the channel's own unit")
    bones: Bones = Field([])
    ease: Ease = 0


class ResampleFrames(RequestBody):
    """Bring the whole document to another frame rate; rotations on the shortest way between two frames."""

    do: Literal["resample"]
    rate: float = Field(gt=0, le=100_000, description="Frames a second")


class FillFrames(_Range):
    """Fill gaps between known samples: short ones by a spline, longer ones of markers by other markers."""

    do: Literal["fill"]
    seconds: float = Field(0.1, ge=0, le=10, description="Longest gap of a marker that a spline bridges")
    longest: float = Field(1.0, ge=0, le=60, description="Longest gap in seconds that is filled; longer ones stay")
    bones: Bones = Field([])


class LowPassFrames(_Range):
    """Filter out fast noise without lag: a Butterworth filter of order 4, forwards and backwards."""

    do: Literal["low-pass"]
    hertz: float | None = Field(
        None, gt=0, le=50_000, description="Cut-off; default by residual analysis (Winter 2009), which the answer tells"
    )
    bones: Bones = Field([])
    ease: Ease = 0


class DespikeFrames(_Range):
    """Replace spikes, samples far from the place that the frames around them tell, by splines (Hampel identifier)."""

    do: Literal["despike"]
    deviations: float = Field(
        4.0,
        gt=0,
        le=1000,
        description="Scaled median absolute deviations from the median, beyond which it is a spike",
    )
    window: int = Field(7, ge=3, le=301, description="Frames of the median, an odd number")
    bones: Bones = Field([])


class UnrollFrames(RequestBody):
    """Give Euler angles of the whole document no leaps: the same rotations, each angle near to that of the frame
    before."""

    do: Literal["unroll"]
    bones: Bones = Field([])


class LockFrames(_Range):
    """Lock feet in place while they stand: legs bend, and the body is lowered a little where a leg is too short."""

    do: Literal["lock-feet"]
    sides: list[Literal["left", "right"]] = Field(["left", "right"], min_length=1)


Handle: TypeAlias = Literal["hips", "head", "left_hand", "right_hand", "left_foot", "right_foot"]
Vector: TypeAlias = tuple[
    Annotated[float, Field(ge=-1e9, le=1e9)],
    Annotated[float, Field(ge=-1e9, le=1e9)],
    Annotated[float, Field(ge=-1e9, le=1e9)],
]


class MovedHandle(RequestBody):
    """A part of the body, how far it is moved and how it is turned, in the axes of the document."""

    handle: Handle
    move: Vector = Field((0.0, 0.0, 0.0), description="x, y, z, in the document's unit of length")
    turn: Vector = Field((0.0, 0.0, 0.0), description="Rotation vector: its axis, with the angle in degrees as length")


class PoseFrames(_Range):
    """Move hands, feet, head and hips on top of the motion, by inverse kinematics; ends keep their orientation."""

    do: Literal["pose"]
    handles: list[MovedHandle] = Field(min_length=1, max_length=6, description="Each handle at most once")
    hold: list[Handle] = Field(
        ["left_foot", "right_foot"], max_length=6, description="Handles that stay in place while others move"
    )
    ease: Ease = 0


class SpeedFrames(_Range):
    """Play frames faster or slower, at the same frame rate: there are fewer or more of them afterwards."""

    do: Literal["speed"]
    factors: list[Annotated[float, Field(ge=0.05, le=20)]] = Field(
        min_length=1,
        max_length=1000,
        description="2: twice as fast; several are at even distances over the range, and linear between them",
    )


class InPlaceFrames(_Range):
    """Keep the body over the place where it is in the first of these frames; later frames go on from there."""

    do: Literal["in-place"]


class LoopFrames(_Range):
    """Make a loop: cut the range where poses are most alike, and lead its end to its beginning. Other frames go."""

    do: Literal["loop"]
    seconds: float = Field(0.3, ge=0, le=60, description="Length of the end that is changed")
    search: float = Field(
        0.4, ge=0, le=0.5, description="Part of the range at either end in which the cut is; 0: keep all of the range"
    )
    lock_feet: bool = Field(True, description="Standing feet stay in place at the end")
    in_place: bool = Field(False, description="The body does not travel from round to round")


FrameEdit = Annotated[
    DeleteFrames
    | KeepFrames
    | ReverseFrames
    | MoveFrames
    | InsertFrames
    | MirrorFrames
    | SmoothFrames
    | AdjustFrames
    | ResampleFrames
    | FillFrames
    | LowPassFrames
    | DespikeFrames
    | UnrollFrames
    | LockFrames
    | PoseFrames
    | SpeedFrames
    | InPlaceFrames
    | LoopFrames,
    Field(discriminator="do"),
]


class FrameEdits(RequestBody):
    """Changes, one after the other, as one revision: all or none."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"edits": [{"do": "keep", "first": 100, "last": 400}, {"do": "reverse", "first": 1, "last": 301}]}
        ),
    )

    edits: list[FrameEdit] = Field(min_length=1, max_length=1000)
    renumber: bool = Field(True, description="Ids that counted up by one do so again; else frames keep theirs")
    message: str = Field("", max_length=4096, description="Why, for the history")


class FrameValues(RequestBody):
    """Rows of numbers, a row a frame, a column for each bone and channel."""

    model_config = ConfigDict(json_schema_extra=shown({"columns": ["left_up_leg.Rx"], "values": [[45.2], [45.9]]}))

    columns: list[str] = Field(min_length=1, max_length=100_000, description="BONE.CHANNEL of each column")
    values: list[list[float]] = Field(min_length=1)


class MotionHead(BaseModel):
    """The layout of positions of a motion that is not stored: joints, then the ends of chains, frame after frame,
    point after point, x y z, relative to the origin, the position of the first joint in frame 1.
    """

    first: int
    shape: list[int] = Field(description="Frames, points, 3")
    bones: list[str]
    parents: list[int] = Field(description="Of each point the joint above, -1 at a root")
    origin: list[float]
    seconds_per_frame: float | None = None
    up: str = Field(description="Axis that points up: stated, or likely")
    metres: float | None = Field(None, description="Of the motion's unit of length, where it is known")


class PreviewMotion(MotionHead):
    """Positions of a motion that is not stored. data: little-endian f4, base64."""

    data: str


class CurveSamples(BaseModel):
    """A curve for drawing: the least and the greatest sample of successive frame ranges, null without samples."""

    first: int = Field(description="Position of the first frame")
    step: int = Field(description="Frames in each range; 1: every frame, and both lists are the samples")
    minimum: list[float | None]
    maximum: list[float | None]


class EditedCurve(BaseModel):
    """A channel or a quantity before and after an edit."""

    name: str = Field(description="BONE.CHANNEL, or the quantity as it was requested")
    unit: str = Field(description="Unit of a quantity; empty for channels, which are in the units of the document")
    before: CurveSamples
    after: CurveSamples


class ReplacedSamples(BaseModel):
    """Frames in which a bone or marker has new samples after `fill` or `despike`."""

    bone: str
    channels: list[str] = Field(description="Channels with new samples, the most changed first")
    frames: int = Field(description="Number of frames")
    ranges: list[FrameRange] = Field(description="Positions at the time of the edit; at most 2,000 of all bones")


class FramesEdited(BaseModel):
    """The revision that was made, and how many frames the document now has."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "revision": 2,
                "frames": 301,
                "notes": ["spikes replaced: 1 (Root 1)", "first in frame 31, last in frame 31"],
                "replaced": [{"bone": "Root", "channels": ["Tx"], "frames": 1, "ranges": [{"first": 31, "last": 31}]}],
                "first_kept": None,
                "motion": None,
                "kept": [],
                "curves": [
                    {
                        "name": "Root.Tx",
                        "unit": "",
                        "before": {"first": 30, "step": 1, "minimum": [4.0, 504.2, 4.3], "maximum": [4.0, 504.2, 4.3]},
                        "after": {"first": 30, "step": 1, "minimum": [4.0, 4.1, 4.3], "maximum": [4.0, 4.1, 4.3]},
                    }
                ],
            }
        )
    )

    revision: int
    frames: int
    notes: list[str] = Field([], description="Numbers of filled samples by method, remaining gaps, and chosen cut-offs")
    curves: list[EditedCurve] = Field([], description="With `dry_run`: requested curves before and after the edits")
    replaced: list[ReplacedSamples] = Field([], description="New samples of `fill` and `despike`, most frames first")
    first_kept: int | None = Field(
        None, description="After a single `keep` or `loop`: the former position of the frame that is now the first"
    )
    motion: PreviewMotion | None = Field(None, description="With `dry_run` and `positions`: the edited motion")
    kept: list[KeptFrames] = Field(
        [], description="With `dry_run`: frames that the document has before and after, edited or not"
    )
