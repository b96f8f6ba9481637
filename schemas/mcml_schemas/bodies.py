"""Calibrations of clips, which turn their numbers into metres and heights."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import shown
from mcml_schemas.request_body import RequestBody

_VIEW = {
    "unit": {"value": "cm", "metres": 0.01, "origin": "stated", "reason": "cm"},
    "up": {"value": "Y", "origin": "guessed", "reason": "the body is upright along Y"},
    "floor": {
        "value": 4.25,
        "metres": 0.0425,
        "origin": "guessed",
        "reason": "the toes are above it nearly always",
    },
    "leg": {"value": 80.07, "metres": 0.8007, "origin": "measured", "reason": "from hip to knee to ankle"},
    "height": {
        "value": 162.7,
        "metres": 1.627,
        "origin": "measured",
        "reason": "bones of a leg, the trunk and the head in one line",
    },
    "reference": {"value": "rest", "origin": "measured", "reason": "the rest pose can be an upright body"},
    "leaps": {"value": False, "origin": "measured", "reason": ""},
    "step": 0.01,
    "kept": True,
}


class CalibrationValue(BaseModel):
    """origin: stated by the file, measured on its skeleton and frames, guessed from them, set by people, or unknown."""

    value: float | str | bool | None
    metres: float | None = Field(None, description="The same in metres, where it is a length and the unit is known")
    origin: Literal["stated", "measured", "guessed", "set", "unknown"]
    reason: str = ""


class Calibration(BaseModel):
    """The values that queries about motion depend on; lengths are in the source's unit."""

    model_config = ConfigDict(json_schema_extra=shown(_VIEW))

    unit: CalibrationValue = Field(description="`metres`: of one unit")
    up: CalibrationValue = Field(description="The axis that points up")
    floor: CalibrationValue = Field(description="Its height along that axis")
    leg: CalibrationValue = Field(description="From hip to knee to ankle")
    height: CalibrationValue = Field(description="Of the standing body, by its bones; cannot be set")
    reference: CalibrationValue = Field(description='The frame of the upright body, or "rest"')
    leaps: CalibrationValue = Field(description="Whether frame 1 is a pose before the motion, which queries exclude")
    step: float = Field(description="To which positions of joints are rounded: 0.1 mm, or a 10,000th of the leg")
    kept: bool = Field(description="Whether the body is stored; otherwise each query derives it (`mcml db derive`)")


class CalibrationChange(RequestBody):
    """Values to set; omitted values do not change, null returns to the value from the file."""

    model_config = ConfigDict(
        coerce_numbers_to_str=True,
        json_schema_extra=shown({"unit": "cm", "floor": 0.0, "reference": "24"}),
    )

    unit: str | None = None
    up: Literal["X", "Y", "Z"] | None = None
    floor: float | None = Field(None, allow_inf_nan=False)
    leg: float | None = Field(None, gt=0, allow_inf_nan=False)
    reference: str | None = Field(None, pattern="^(rest|[1-9][0-9]{0,9})$", description='A frame, from 1, or "rest"')
    leaps: bool | None = None
