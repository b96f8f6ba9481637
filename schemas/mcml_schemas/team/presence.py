"""People who view or edit a document now."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import TIME, shown
from mcml_schemas.request_body import RequestBody

_PRESENT = {"name": "kim", "doing": "editing", "since": TIME}


class PresenceRequest(RequestBody):
    """A report of presence. tab: distinguishes several windows of one person; each reports its own activity."""

    model_config = ConfigDict(json_schema_extra=shown({"doing": "editing", "tab": "t1"}))

    doing: Literal["viewing", "editing"] = "viewing"
    tab: str = Field("", max_length=36, pattern="^[0-9a-zA-Z-]*$")


class Present(BaseModel):
    """doing: in any of their windows; since: when they began to."""

    model_config = ConfigDict(json_schema_extra=shown(_PRESENT))

    name: str
    doing: Literal["viewing", "editing"]
    since: str


class PresentList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_PRESENT]}))

    items: list[Present]
