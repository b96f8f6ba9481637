"""Reach motion from attributes: parameters of a fit, and the input and output of operations on a model.

Times of phases are measured from the first frame: in seconds, or in frames that have passed at the clip's rate, which
may be fractions. The first frame is at 0 and has position 1; the frame at time t (in frames) has position t + 1.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from mcml_schemas.examples import DOCUMENT, shown
from mcml_schemas.request_body import RequestBody
from mcml_schemas.revisions import FrameRange

_TIMES = {"t1": 6.4, "t2": 30.2, "end": 70}
_ATTRIBUTES = {"age": 23, "height": 175, "hbp": 355}
_WARNING = {"code": "in-gap", "what": "No example has an age near the requested one."}
_CLIP = {"document": DOCUMENT, "revision": 1, "name": "reach_01_001", "subject": "S01"}

_FOOT = {"joint": "left_toes", "contacts": [{"first": 1, "last": 70}], "slide_before": 0.031, "slide": 0.0}
_TARGET = [-0.26, 0.8, 0.12]
_TURN = [0.0, 0.7071, 0.0, 0.7071]

Coordinate = Annotated[FiniteFloat, Field(ge=-1000, le=1000)]
UnitPart = Annotated[FiniteFloat, Field(ge=-1.001, le=1.001)]
Fps = Annotated[float, Field(gt=0, le=1000)]


class ReachTimes(RequestBody):
    """Phase times of a clip in place of those found: frames that have passed at the clip's rate, 0 < t1 < t2 < end."""

    model_config = ConfigDict(json_schema_extra=shown(_TIMES))

    t1: FiniteFloat = Field(gt=0, description="The reach begins", examples=[6.4])
    t2: FiniteFloat = Field(gt=0, description="The reach ends", examples=[30.2])
    end: FiniteFloat = Field(gt=0, description="The last moment that counts, at most the last frame", examples=[70])


class ReachParameters(RequestBody):
    """Parameters of a model of reach motions. Defaults depend on the method."""

    model_config = ConfigDict(json_schema_extra=shown({"method": "robust", "attributes": ["age", "height", "hbp"]}))

    method: Literal["robust", "paper"] = Field(
        "robust", description="robust, or paper: as published, with its weak points", examples=["robust"]
    )
    attributes: list[Annotated[str, Field(min_length=1, max_length=256)]] = Field(
        ["age", "height", "hbp"],
        min_length=1,
        max_length=16,
        description="Names of the clips' properties, numbers all, that a motion is to be made for",
        examples=[["age", "height", "hbp"]],
    )
    subject: str | None = Field(
        "subject",
        max_length=256,
        description="Name of the property that tells people apart, for errors of people that the model has not seen; "
        "where no clip has it, single clips are left out",
        examples=["subject"],
    )
    phase_joint: str = Field(
        "right_up_arm",
        min_length=1,
        max_length=256,
        description="Joint whose angular speed tells the phases, by its MCML name or the source's",
        examples=["right_up_arm"],
    )
    hand_joint: str | None = Field(
        None,
        max_length=256,
        description="Joint whose place is compared; the hand at the end of the phase joint's limb if left out",
        examples=["right_hand"],
    )
    phase_method: Literal["robust", "paper"] | None = Field(
        None, description="How phases are found; as the method does if left out", examples=["robust"]
    )
    times: dict[str, ReachTimes] = Field(
        {},
        max_length=2000,
        description="Phase times set by a person, by document id",
        examples=[{DOCUMENT: _TIMES}],
    )
    on_bad_clip: Literal["exclude", "error"] = Field(
        "exclude",
        description="Clips without clear phases or with missing attributes: left out and listed, or the fit fails",
        examples=["exclude"],
    )
    joints: Literal["same", "intersection"] = Field(
        "same",
        description="same: all clips need equal joints; intersection: joints that all have below equal parents",
        examples=["same"],
    )
    base_fps: Fps = Field(30.0, description="Rate of the normalised samples and of made motions", examples=[30])
    knots: tuple[int, int, int] | None = Field(
        None,
        description="Numbers, from 0, of the samples at t1, t2 and the end; rounded means of the clips if left out "
        "(paper: 5, 28, 49)",
        examples=[[5, 28, 49]],
    )
    space: Literal["tangent", "eigenposes", "global"] | None = Field(
        None,
        description="Vectors of motions: rotations relative to each joint's mean (robust), each clip's own eigenposes "
        "(paper), or eigenposes of all clips",
        examples=["tangent"],
    )
    pose_components: int = Field(10, ge=1, le=100, description="Eigenposes kept: k", examples=[10])
    components: int = Field(10, ge=1, le=2000, description="Eigenmotions kept: K", examples=[10])
    variance: float | None = Field(
        None, gt=0, le=1, description="Instead, as many eigenmotions as hold this share of the variance", examples=[0.9]
    )
    sign_align: Literal["none", "max", "reference"] = Field(
        "max",
        description="Signs of eigenposes: as they come, the largest entry positive, or along those of the first clip",
        examples=["max"],
    )
    attribute_space: Literal["rotate", "zscore", "whiten"] | None = Field(
        None,
        description="Attributes as coordinates: principal axes in their own units (paper), each over its deviation, or "
        "principal axes over theirs (robust)",
        examples=["whiten"],
    )
    s: FiniteFloat | None = Field(
        None,
        gt=0,
        description="Width of the Gaussians in attribute space; by cross-validation if left out (paper: twice the "
        "least distance of two examples)",
        examples=[2.0],
    )
    lam: FiniteFloat | None = Field(
        None, ge=0, description="Ridge; by cross-validation if left out (paper: 0)", examples=[0.1]
    )
    choose_by: Literal["coefficients", "hand"] = Field(
        "coefficients",
        description="Error of left-out people that decides width and ridge: of the coefficients of whole motions, or "
        "of the place of the hand when the reach ends (t2)",
        examples=["hand"],
    )
    degree: Literal[0, 1] = Field(
        1, description="Degree of the polynomial that complements the Gaussians", examples=[1]
    )
    interpolate: bool = Field(False, description="Pass exactly through every example: the ridge is 0", examples=[False])
    duplicates: Literal["error", "mean", "keep"] | None = Field(
        None,
        description="Clips of equal attributes: refused (paper), averaged (where the ridge is stated as 0), or kept",
        examples=["mean"],
    )
    legacy_time_map: bool = Field(
        False, description="Play back by the printed time map, which leaps over two samples", examples=[False]
    )
    align: Literal["none", "start"] = Field(
        "none",
        description="Places of clips: as they are, or moved on the ground and turned about the vertical so that the "
        "root is above the origin, and faces as in the rest pose, when the reach begins. Use start for clips that were "
        "captured at different places",
        examples=["start"],
    )
    force: bool = Field(False, description="Take attributes outside the usual ranges as they are", examples=[False])


class ReachWish(RequestBody):
    """The motion that is wanted."""

    model_config = ConfigDict(json_schema_extra=shown({"attributes": _ATTRIBUTES}))

    attributes: dict[str, FiniteFloat] = Field(
        max_length=16,
        description="A number for each attribute of the model, in the model's units",
        examples=[_ATTRIBUTES],
    )
    fps: Fps | None = Field(None, description="Frames a second; the model's rate if left out", examples=[60])
    template: str | None = Field(
        None, description="Document whose body is used; the nearest clip's if left out", examples=[DOCUMENT]
    )
    extrapolate: bool = Field(
        True, description="Whether attributes outside those of the examples are answered", examples=[True]
    )
    clamp: bool = Field(
        False,
        description="Use the nearest attributes within those of the examples instead, and the nearest place that the "
        "hand can reach",
        examples=[False],
    )
    target: tuple[Coordinate, Coordinate, Coordinate] | None = Field(
        None,
        description="Place of the hand when the reach ends (t2): x, y, z in metres, in the world of the made motion, "
        "as an answer without target tells in hand_place. A model fitted with align=start begins its reaches above the "
        "origin, so there the target is relative to the body",
        examples=[_TARGET],
    )
    orientation: tuple[UnitPart, UnitPart, UnitPart, UnitPart] | None = Field(
        None,
        description="Orientation of the hand's joint at t2, with a target: a unit quaternion x, y, z, w in the world "
        "of the made motion, as an answer tells in hand_orientation. The wrist turns, and back as the place is left",
        examples=[_TURN],
    )
    method: Literal["blend", "arrive"] | None = Field(
        None,
        description="blend: the mixture of examples as it is; arrive: then arm, spine and pelvis bring the hand to the "
        "target. If left out, requests with a target arrive",
        examples=["arrive"],
    )
    force: bool = Field(False, description="Take attributes outside the usual ranges as they are", examples=[False])

    @model_validator(mode="after")
    def _is_unit(self) -> ReachWish:
        if self.orientation is not None and abs(sum(part**2 for part in self.orientation) - 1) > 0.01:
            raise ValueError("orientation: expected a unit quaternion x, y, z, w; its length is not 1")
        return self


class ReachClip(BaseModel):
    """A clip of the model."""

    model_config = ConfigDict(json_schema_extra=shown(_CLIP))

    document: str = Field(description="Its id", examples=[DOCUMENT])
    revision: int = Field(description="The revision that was used", examples=[1])
    name: str = Field(examples=["reach_01_001"], description="Its name when the model was fitted")
    subject: str = Field(description="Person who moves; the document's id if unknown", examples=["S01"])


class ReachWeight(BaseModel):
    """How much an example counts."""

    model_config = ConfigDict(json_schema_extra=shown({"clip": _CLIP, "weight": 0.31}))

    clip: ReachClip = Field(description="The example; the first of those with equal attributes")
    weight: float = Field(description="All weights sum to 1; some may be negative", examples=[0.31])


class ReachMoment(BaseModel):
    """A time of the made motion."""

    model_config = ConfigDict(json_schema_extra=shown({"seconds": 0.25, "frames": 7.5}))

    seconds: float = Field(description="Since the first frame", examples=[0.25])
    frames: float = Field(description="Frames that have passed, at the motion's rate", examples=[7.5])


class ReachWarning(BaseModel):
    """Something that the user should know."""

    model_config = ConfigDict(json_schema_extra=shown(_WARNING))

    code: str = Field(description="Its name", examples=["in-gap"])
    what: str = Field(description="One sentence", examples=[_WARNING["what"]])


class ReachMoves(BaseModel):
    """How far parts of the body moved so that the hand arrives, at the end of the reach."""

    model_config = ConfigDict(json_schema_extra=shown({"arm": 0.12, "spine": 0.03, "pelvis": 0.0}))

    arm: float = Field(description="Metres that the hand moved in the axes of the trunk", examples=[0.12])
    spine: float = Field(description="Metres that the shoulder moved in the axes of the pelvis", examples=[0.03])
    pelvis: float = Field(description="Metres that the pelvis moved", examples=[0.0])


class ReachFoot(BaseModel):
    """A foot that is held in place while it stands in the examples."""

    model_config = ConfigDict(json_schema_extra=shown(_FOOT))

    joint: str = Field(description="The joint that is held", examples=["left_toes"])
    contacts: list[FrameRange] = Field(description="Frames in which it stands", examples=[[{"first": 1, "last": 70}]])
    slide_before: float = Field(
        description="Metres that it slid over the ground during contacts, before it was held", examples=[0.031]
    )
    slide: float = Field(description="Metres that it slides afterwards", examples=[0.0])


class ReachMotion(BaseModel):
    """A synthesised motion, with measures of its reliability."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "attributes": _ATTRIBUTES,
                "used_attributes": _ATTRIBUTES,
                "fps": 30.0,
                "frames": 71,
                "t1": {"seconds": 0.25, "frames": 7.5},
                "t2": {"seconds": 0.99, "frames": 29.7},
                "end": {"seconds": 2.34, "frames": 70.2},
                "speed": [0.1, 0.12, 0.4],
                "support": "inside",
                "in_hull": True,
                "nn_ratio": 0.8,
                "in_gaps": [],
                "weights": [{"clip": _CLIP, "weight": 0.31}],
                "skeleton_source": _CLIP,
                "method": "arrive",
                "target": _TARGET,
                "hand_place": _TARGET,
                "hand_error": 0.0001,
                "moved": {"arm": 0.12, "spine": 0.03, "pelvis": 0.0},
                "feet": [_FOOT],
                "warnings": [],
            }
        )
    )

    attributes: dict[str, float] = Field(description="As requested", examples=[_ATTRIBUTES])
    used_attributes: dict[str, float] = Field(description="As used, after clamping", examples=[_ATTRIBUTES])
    fps: float = Field(description="Frames a second", examples=[30.0])
    frames: int = Field(description="How many frames the motion has", examples=[71])
    t1: ReachMoment = Field(description="The reach begins")
    t2: ReachMoment = Field(description="The reach ends")
    end: ReachMoment = Field(description="The motion ends")
    speed: list[float] = Field(
        description="Radians a second of the phase joint, a value a frame: since the frame before",
        examples=[[0.1, 0.4]],
    )
    support: Literal["inside", "gap", "outside"] = Field(
        description="Whether examples surround the attributes; gap: they do, but none is near in one attribute",
        examples=["inside"],
    )
    in_hull: bool = Field(description="Whether the used attributes are a mixture of the examples'", examples=[True])
    nn_ratio: float = Field(
        description="Distance to the nearest example over the examples' mean distance to theirs; above 2 is sparse",
        examples=[0.8],
    )
    in_gaps: list[str] = Field(description="Attributes in a gap between the examples", examples=[["age"]])
    weights: list[ReachWeight] = Field(description="The ten examples that count most")
    skeleton_source: ReachClip = Field(description="The clip whose body the motion has: height does not scale it")
    method: Literal["blend", "arrive"] = Field("blend", description="How it was made", examples=["arrive"])
    target: list[float] | None = Field(None, description="As requested", examples=[_TARGET])
    hand_place: list[float] | None = Field(
        None,
        description="Where the hand is in the frame nearest to t2: x, y, z in metres, in the world of the motion; null "
        "where the model knows no unit of length or no arm",
        examples=[_TARGET],
    )
    hand_error: float | None = Field(
        None, description="Metres from hand_place to the target; null without a target", examples=[0.0001]
    )
    hand_orientation: list[float] | None = Field(
        None, description="Orientation of the hand's joint there: x, y, z, w in the world", examples=[_TURN]
    )
    orientation_error: float | None = Field(
        None, description="Degrees from hand_orientation to the requested one; null if none is", examples=[0.0]
    )
    moved: ReachMoves | None = Field(
        None, description="Moves of arm, spine and pelvis that bring the hand there; null for a blend"
    )
    feet: list[ReachFoot] = Field(
        [], description="Feet that are held where the examples hold them; empty for a blend", examples=[[_FOOT]]
    )
    warnings: list[ReachWarning] = Field(
        description="sparse-region, in-gap, clamped, out-of-reach, attribute-not-modelled, …"
    )


class ReachClipChoice(RequestBody):
    """Which clip's phases."""

    model_config = ConfigDict(json_schema_extra=shown({"document": DOCUMENT}))

    document: str = Field(description="Id of a clip that the fit was given", examples=[DOCUMENT])


class ReachPhases(BaseModel):
    """Phases of a clip and the speed that they were found in."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "document": DOCUMENT,
                "name": "reach_01_001",
                "used": True,
                "fps": 30.0,
                "speed": [0.1, 0.12, 0.4],
                "components": [[-0.4, 0.1, 0.0]],
                "t1": {"seconds": 0.25, "frames": 7.5},
                "t2": {"seconds": 0.99, "frames": 29.7},
                "end": {"seconds": 2.33, "frames": 70.0},
                "flags": [],
            }
        )
    )

    document: str = Field(description="Its id", examples=[DOCUMENT])
    name: str = Field(description="Its name when the model was fitted", examples=["reach_01_001"])
    used: bool = Field(description="Whether the model uses it", examples=[True])
    reason: str | None = Field(None, description="Why not", examples=["peak-at-border"])
    fps: float = Field(description="Frames a second", examples=[30.0])
    speed: list[float] = Field(
        description="Radians a second of the phase joint, a value a frame: since the frame before",
        examples=[[0.1, 0.4]],
    )
    components: list[list[float]] = Field(
        description="Three principal components of the arm's rotations, a row a frame: only to look at",
        examples=[[[-0.4, 0.1, 0.0]]],
    )
    t1: ReachMoment | None = Field(None, description="The reach begins; null for a clip that is not used")
    t2: ReachMoment | None = Field(None, description="The reach ends")
    end: ReachMoment | None = Field(None, description="The last moment that counts")
    flags: list[str] = Field(description="Guessed values", examples=[["no-preparation"]])
