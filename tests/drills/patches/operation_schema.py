"""The document with the most frames."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, shown


class Longest(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"id": DOCUMENT, "frames": 1197}))

    id: str
    frames: int = Field(description="How many it has")
