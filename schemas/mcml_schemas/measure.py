"""Measurements of many frame ranges: figures of each, and the mean curve of each group."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, PROJECT, shown
from mcml_schemas.jobs import Selection
from mcml_schemas.request_body import RequestBody

MeasureForm: TypeAlias = Literal["json", "csv", "arrow", "parquet", "npz"]
MeasureTable: TypeAlias = Literal["ranges", "curves", "groups"]
GroupKey: TypeAlias = Annotated[str, Field(pattern=r"^(clip|label|side|person|project|property:.{1,200})$")]
"""A property that ranges of a group share."""

_KNEE = "angle:left-knee-flexion"
_ROW = {
    "document": DOCUMENT, "name": "walk", "project": PROJECT, "revision": 1, "quantity": _KNEE, "unit": "deg",
    "label": "stride", "side": "left", "group": {"side": "left"}, "first": 100, "last": 208, "start": 0.99,
    "seconds": 1.08, "missing": 0, "minimum": 2.1, "maximum": 61.7, "mean": 22.4, "sd": 18.9, "range": 59.6,
    "max_frame": 178, "max_time": 1.77, "score": 0.8, "score_of": "maximum", "outlier": False,
}  # fmt: skip
_MEAN = {"mean": 60.2, "sd": 1.9}
_GROUP = {
    "quantity": _KNEE, "unit": "deg", "group": {"side": "left"}, "ranges": 24, "documents": 6, "outliers": 1,
    "minimum": {"mean": 1.8, "sd": 0.6}, "maximum": _MEAN, "mean": {"mean": 22.0, "sd": 0.9},
    "range": {"mean": 58.4, "sd": 2.0}, "mean_curve": [3.1, 3.4], "sd_curve": [0.9, 1.0], "count": [24, 24],
}  # fmt: skip


class MeasureRequest(RequestBody):
    """Frame ranges of clips, and the quantities that are measured in each.

    Ranges are the selected clips as a whole, the frame ranges of `query`, occurrences of labels, or strides.
    """

    model_config = ConfigDict(
        populate_by_name=True,
        json_schema_extra=shown({"selection": {"project": PROJECT}, "quantities": [_KNEE], "cycles": ["stride"]}),
    )

    selection: Selection | None = Field(None, description="Clips; with `query` default all")
    query: str | None = Field(
        None,
        min_length=1,
        max_length=10_000,
        description="An XPath expression; each frame range of its answer is measured",
        examples=["//frame[motion_name='reach']"],
    )
    quantities: list[str] = Field(
        min_length=1,
        max_length=40,
        description="NAME:JOINT,JOINT, angle:NAME or a measurement of the file, as for frames",
        examples=[[_KNEE, "speed:right_hand"]],
    )
    cycles: list[str] = Field(
        [],
        max_length=20,
        description="Labels whose occurrences are measured; labels of single frames, such as left-foot-strike, begin "
        "cycles that end at the next one",
        examples=[["stride"]],
    )
    strides: bool = Field(False, description="Measure strides of gait, from strike to strike; see `GET /gait`")
    by: list[GroupKey] = Field(
        ["side"], max_length=5, description="Groups of ranges: clip, label, side, person, project, property:NAME"
    )
    guesses: Literal["yes", "no"] = Field(
        "yes",
        description="no: leave out clips where a quantity depends on a guess: unit, up axis, floor, joint names",
    )
    curves: bool = Field(False, description="json: each row has its curve of 101 values")
    limit: int = Field(1000, ge=1, le=10_000, description="json: most rows, outliers first")
    as_: MeasureForm = Field(
        "json", alias="as", description="json; one table; or npz with all arrays. arrow and parquet need `arrow`"
    )
    table: MeasureTable = Field(
        "ranges", description="Rows of csv, arrow and parquet: ranges, points of their curves, or points of groups"
    )
    raw: bool = Field(False, description="csv: also texts that spreadsheets take for formulas as they are")


class MeasuredRange(BaseModel):
    """A quantity in one frame range, in its unit. Figures are of the known samples of frames first to last."""

    document: str
    name: str
    project: str
    revision: int
    quantity: str
    unit: str = Field(description="Empty where it is not stated")
    label: str = Field(description="Of `cycles`, else empty")
    side: str = Field(description="Of the stride, else of the joints of the quantity: left, right, or empty for both")
    group: dict[str, str] = Field(description="Value of each key of `by`")
    first: int = Field(description="First frame, a position from 1")
    last: int = Field(description="Last frame, included")
    start: float | None = Field(description="Seconds from the first frame of the clip; null if the rate is unknown")
    seconds: float | None = Field(description="Duration; null if the rate is unknown")
    missing: int = Field(description="Frames without a known sample")
    minimum: float
    maximum: float
    mean: float
    sd: float | None = Field(description="Standard deviation (n - 1) over frames; null for one frame")
    range: float = Field(description="Maximum minus minimum")
    max_frame: int = Field(description="Frame of the maximum")
    max_time: float | None = Field(description="Seconds from the first frame of the clip to the maximum")
    score: float | None = Field(
        description="Largest modified z-score of minimum, maximum, mean and range within the group; null for fewer "
        "than four ranges"
    )
    score_of: str = Field(description="The figure with this score")
    outlier: bool = Field(description="Whether the score is over 3.5 (Iglewicz and Hoaglin 1993)")
    curve: list[float | None] | None = Field(
        None, description="101 values, 0 to 100 % of the range, by linear interpolation; null at missing samples"
    )


class MeanOfRanges(BaseModel):
    """A figure over the ranges of a group. sd: n - 1; null for one range."""

    mean: float
    sd: float | None


class MeasuredGroup(BaseModel):
    """Ranges of one quantity with the same values of `by`."""

    quantity: str
    unit: str
    group: dict[str, str]
    ranges: int
    documents: int
    outliers: int
    minimum: MeanOfRanges
    maximum: MeanOfRanges
    mean: MeanOfRanges = Field(description="Of the means of the ranges")
    range: MeanOfRanges
    mean_curve: list[float | None] = Field(description="101 values, 0 to 100 % of the ranges")
    sd_curve: list[float | None] = Field(description="Of 101 values, n - 1; null for fewer than two ranges")
    count: list[int] = Field(description="Ranges with a known value at each of the 101 points")


class Measures(BaseModel):
    """Ranges, outliers first, then as in the clips; and their groups."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "ranges": [_ROW], "groups": [_GROUP], "total_ranges": 24, "total_groups": 2, "documents": 6,
                "warnings": ["Left out: no complete cycle of stride (1 of 7 clips: 'stand')."],
            }
        )
    )  # fmt: skip

    ranges: list[MeasuredRange] = Field(description="One for each frame range and quantity")
    groups: list[MeasuredGroup]
    total_ranges: int = Field(description="All, of which `ranges` are the first")
    total_groups: int = Field(description="All, of which `groups` are the first 500")
    documents: int = Field(description="Clips with measured ranges")
    warnings: list[str] = Field(description="Clips and quantities that were left out, with the reason; and guesses")
