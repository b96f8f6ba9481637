"""Measurements of the file of a document beside the motion: angles and moments of its model, channels of devices."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import shown

_KNEE = {
    "function": "quantity", "name": "LKneeAngles", "axes": ["x", "y", "z"], "unit": "deg", "group": "ANGLES",
    "rate": None, "known": True, "reason": "", "notes": [],
}  # fmt: skip


class MeasurementFacts(BaseModel):
    """One measurement; `mo:quantity('LKneeAngles', 'x')` asks for it in XPath, `quantity:LKneeAngles,x` elsewhere."""

    function: str = Field(description="The function that asks for it, without `mo:`")
    name: str = Field(description="Its first argument, as the file writes it")
    axes: list[str] = Field(description="Values of its second argument; none where it takes one argument")
    unit: str = Field(description="Empty where the file does not state it")
    group: str = Field(description="The group of the file, such as ANGLES")
    rate: float | None = Field(None, description="Samples a second; null for one a frame")
    known: bool = Field(description="Whether frames of the document have values; `reason` is why not")
    reason: str = ""
    notes: list[str] = Field(default_factory=list, description="Assumptions where the file states too little")


class MeasurementList(BaseModel):
    """The measurements of one document, in the order of the file."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [_KNEE]}))

    items: list[MeasurementFacts]
