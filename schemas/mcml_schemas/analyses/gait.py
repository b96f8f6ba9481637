"""Gait of many trials: the parameters of the analysis."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict, Field

from mcml_schemas.examples import shown
from mcml_schemas.request_body import RequestBody


class GaitParameters(RequestBody):
    """How the gait of trials is measured, and whose trials count together."""

    model_config = ConfigDict(json_schema_extra=shown({"events": "auto", "subject": "subject"}))

    events: Literal["auto", "labels", "positions"] = Field(
        "auto",
        description="Where strikes and offs come from: labels before force plates and positions, or one alone",
        examples=["auto"],
    )
    subject: str = Field(
        "subject",
        min_length=1,
        max_length=256,
        description="Name of the property that tells people apart; a clip without it counts as a person of its own",
        examples=["subject"],
    )
