"""Sessions of browsers."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from schemas.examples import shown


class SessionRequest(BaseModel):
    """What a session is opened with: one of both."""

    model_config = ConfigDict(extra="forbid", json_schema_extra=shown({"token": "mcml_…"}))

    token: str | None = Field(None, max_length=256, description="As `mcml token add` made it")
    link: str | None = Field(None, max_length=256, description="The code of a link that `mcml serve` printed")


class SessionOpened(BaseModel):
    """author: in whose name the session works. hours: how long it lasts."""

    model_config = ConfigDict(json_schema_extra=shown({"author": "lab", "hours": 12}))

    author: str
    hours: int
