"""Gait of a document: events, strides, spatio-temporal parameters and cycles."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, shown
from mcml_schemas.jobs import Selection
from mcml_schemas.request_body import RequestBody

Side: TypeAlias = Literal["left", "right"]
FootOption: TypeAlias = Literal["flat", "as it stands"]
"""How a standing trial takes the foot: flat sets the heel to the height of the toe first."""

_EVENT = {"side": "left", "kind": "strike", "time": 0.752, "frame": 76, "source": "label", "within": None}
_STRIDE = {
    "side": "left",
    "begin": 0.752,
    "end": 1.79,
    "off": 1.406,
    "other_off": 0.859,
    "other_strike": 1.299,
    "values": {"stride_time": 1.038, "stride_length": 1.185},
    "rejected": "",
}
_SUMMARY = {"mean": 1.185, "sd": 0.021, "n": 4}
_PARAMETER = {
    "name": "stride_length",
    "unit": "m",
    "how": "level distance of the toes at both strikes",
    "left": _SUMMARY,
    "right": {"mean": 1.222, "sd": 0.018, "n": 4},
    "symmetry": -3.08,
}
_CYCLE = {
    "quantity": "angle:left-knee-flexion",
    "unit": "deg",
    "side": "left",
    "n": 2,
    "gaps": 0,
    "mean": [7.2, 8.1],
    "sd": [0.4, 0.5],
}
_GAIT = {
    "frame_rate": 100.0,
    "clinical": True,
    "running": False,
    "duty_factor": 0.612,
    "belt": {"is_belt": False, "speed": -0.004, "sd": 0.002, "n": 3},
    "points": {"left_heel": ["LHEE"], "right_heel": ["RHEE"], "left_toe": ["LTOE"], "right_toe": ["RTOE"]},
    "events": [_EVENT],
    "strides": [_STRIDE],
    "incomplete": {"left": 0, "right": 0},
    "parameters": [_PARAMETER],
    "cycles": [_CYCLE],
    "warnings": [],
}


_TRIAL = {
    "id": DOCUMENT,
    "name": "walk",
    "measured": True,
    "strides": {"left": 4, "right": 4},
    "event_sources": ["label"],
    "warnings": [],
}
_GROUP = {"trials": [_TRIAL], "parameters": [_PARAMETER], "cycles": [_CYCLE]}
_CURVE = {
    "title": "Knee flexion",
    "left": "angle:left-knee-flexion",
    "right": "angle:right-knee-flexion",
    "positive": "flexion",
    "negative": "extension",
}


class GaitEventItem(BaseModel):
    """A foot that strikes the ground or leaves it."""

    model_config = ConfigDict(json_schema_extra=shown(_EVENT))

    side: Side
    kind: Literal["strike", "off"]
    time: float = Field(description="Seconds from the first frame; events may be between frames")
    frame: int = Field(description="The nearest frame, a position from 1")
    source: Literal["label", "plate", "positions"] = Field(
        description="A label of the document, a force plate, or the positions of feet and pelvis"
    )
    within: float | None = Field(
        None,
        description="Seconds within which 95 % of such events are right; null for labels and plates, taken as given",
    )


class GaitStride(BaseModel):
    """A stride from a strike of a foot to its next one; times are seconds from the first frame."""

    model_config = ConfigDict(json_schema_extra=shown(_STRIDE))

    side: Side
    begin: float
    end: float
    off: float
    other_off: float = Field(description="When the other foot leaves the ground")
    other_strike: float = Field(description="When the other foot strikes the ground")
    values: dict[str, float | None] = Field(description="Each parameter by its name; null where it was not measured")
    rejected: str = Field(description="The rule that leaves it out of means and cycles; empty for none")


class GaitSummary(BaseModel):
    """A parameter of a side over its strides; null where it was not measured."""

    model_config = ConfigDict(json_schema_extra=shown(_SUMMARY))

    mean: float | None
    sd: float | None = Field(description="Standard deviation (n - 1); null for fewer than two strides")
    n: int = Field(description="Number of strides")


class GaitParameter(BaseModel):
    """A spatio-temporal parameter of both sides."""

    model_config = ConfigDict(json_schema_extra=shown(_PARAMETER))

    name: str
    unit: str
    how: str = Field(description="How it was computed")
    left: GaitSummary
    right: GaitSummary
    symmetry: float | None = Field(description="Percent: 100 (left - right) / mean of both (Robinson 1987)")


class GaitCycle(BaseModel):
    """A quantity over the cycle of a side, from strike to strike: 101 values, 0 to 100 %."""

    model_config = ConfigDict(json_schema_extra=shown(_CYCLE))

    quantity: str
    unit: str
    side: Side
    n: int = Field(description="Number of strides in the mean")
    gaps: int = Field(description="Number of strides that are left out, because a sample is missing")
    mean: list[float | None]
    sd: list[float | None]


class GaitBelt(BaseModel):
    """How fast planted feet move backwards: the speed of a belt, nearly 0 on the ground."""

    is_belt: bool = Field(description="Whether lengths and speeds are those on a belt")
    speed: float | None = Field(description="Metres a second; null where the unit or the feet are unknown")
    sd: float | None = Field(None, description="Standard deviation (n - 1) from stance to stance")
    n: int = Field(description="Number of stances")


class GaitMeasures(BaseModel):
    """The gait of a document, and how sure it is."""

    model_config = ConfigDict(json_schema_extra=shown(_GAIT))

    frame_rate: float = Field(description="Frames a second")
    clinical: bool = Field(description="False below 50 frames a second, which is too few for clinical use")
    running: bool | None = Field(description="Whether feet are down for under 0.45 of a stride; null without a stride")
    duty_factor: float | None = Field(description="Median share of a stride in which its foot is on the ground")
    belt: GaitBelt
    points: dict[str, list[str]] = Field(description="Markers or joints that heels, toes and hips are the means of")
    events: list[GaitEventItem]
    strides: list[GaitStride]
    incomplete: dict[Side, int] = Field(description="Number of strides that are left out, because an event is missing")
    parameters: list[GaitParameter]
    cycles: list[GaitCycle] = Field(description="Of the requested quantities, by side")
    warnings: list[str] = Field(description="Reasons why values are less sure, or missing")


class GaitTrial(BaseModel):
    """A trial of a comparison."""

    model_config = ConfigDict(json_schema_extra=shown(_TRIAL))

    id: str
    name: str
    measured: bool = Field(description="False if its gait could not be measured; the warnings say why")
    strides: dict[Side, int] = Field(description="Number of strides in the means")
    event_sources: list[Literal["label", "plate", "positions"]]
    warnings: list[str]


class GaitGroup(BaseModel):
    """Trials whose strides count alike, with their parameters and cycles."""

    model_config = ConfigDict(json_schema_extra=shown(_GROUP))

    trials: list[GaitTrial]
    parameters: list[GaitParameter]
    cycles: list[GaitCycle]


class GaitCurve(BaseModel):
    """A curve of the report, and the quantities that it shows; empty for a side without one."""

    model_config = ConfigDict(json_schema_extra=shown(_CURVE))

    title: str
    left: str
    right: str
    positive: str = Field(description="Direction of positive values; empty if unknown")
    negative: str


class GaitComparison(BaseModel):
    """The gait of several trials together, beside other trials and a normal band."""

    model_config = ConfigDict(json_schema_extra=shown({"curves": [_CURVE], "own": _GROUP}))

    curves: list[GaitCurve]
    own: GaitGroup
    compare: GaitGroup | None = Field(None, description="The other trials, such as those of another session")
    reference: GaitGroup | None = Field(None, description="The trials of the normal band")


_MEASURE = {"name": "LThighRotation", "value": -0.01857, "unit": "rad", "source": "alignment device"}


class StandingMeasure(BaseModel):
    """name: of Plug-in Gait. source: stated by the file or by properties, or how the standing trial tells it."""

    model_config = ConfigDict(json_schema_extra=shown(_MEASURE))

    name: str
    value: float
    unit: Literal["mm", "rad", "kg"]
    source: Literal[
        "stated", "markers", "alignment device", "medial knee marker", "medial ankle marker", "heel and toe"
    ]


_VIRTUAL = {"name": "LKneeMedial", "carriers": ["LTH1", "LTH2", "LTH3", "LKNE"]}


class VirtualMarker(BaseModel):
    """A marker that walking trials may lack, and the labels of those that carry it."""

    model_config = ConfigDict(json_schema_extra=shown(_VIRTUAL))

    name: str
    carriers: list[str]


class StandingTrial(BaseModel):
    """Measures, virtual markers and assumptions of a standing trial, for walking trials of the same person."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"measures": [_MEASURE], "virtual": [_VIRTUAL], "notes": ["marker diameter not stated, 14 mm assumed"]}
        )
    )

    measures: list[StandingMeasure]
    virtual: list[VirtualMarker]
    notes: list[str]


class StandingTrialUse(RequestBody):
    """The walking trials that take the measures of a standing trial."""

    model_config = ConfigDict(json_schema_extra=shown({"selection": {"documents": [DOCUMENT]}, "foot": "flat"}))

    selection: Selection
    foot: FootOption | None = Field(
        None, description="How the foot is taken; default: as the offsets that the file states tell, else as it stands"
    )
    subject: str | None = Field(
        None, max_length=1024, description="Prefix of a person's markers, if there are several people"
    )


class CalibratedTrial(BaseModel):
    """A walking trial with the measures of a standing one. measures: that changed. notes: measures that stay."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"id": DOCUMENT, "name": "walk", "revision": 2, "measures": ["LThighRotation"], "notes": []}
        )
    )

    id: str
    name: str
    revision: int
    measures: list[str]
    notes: list[str]


class CalibratedTrials(BaseModel):
    """Walking trials that took the measures of a standing one, each as a revision."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"items": [{"id": DOCUMENT, "name": "walk", "revision": 2, "measures": ["LThighRotation"], "notes": []}]}
        )
    )

    items: list[CalibratedTrial]
