"""How far roots travel: parameters."""

from __future__ import annotations

from pydantic import ConfigDict, Field

from mcml_schemas.examples import shown
from mcml_schemas.request_body import RequestBody


class TravelParameters(RequestBody):
    """How ways are measured."""

    model_config = ConfigDict(json_schema_extra=shown({"step": 1}))

    step: int = Field(1, ge=1, le=100, description="Every so many frames", examples=[1])
