"""Running queries."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import TIME, shown

_RUNNING = {"id": 17, "q": "//frame[mo:speed('right_hand') > 2]", "author": "kim", "began": TIME, "seconds": 3.2}


class RunningQuery(BaseModel):
    """A running query. seconds: its running time so far."""

    model_config = ConfigDict(json_schema_extra=shown(_RUNNING))

    id: int = Field(description="Its number, while it runs")
    q: str = Field(description="The expression")
    author: str = Field(description="Account or token that sent the query")
    began: str
    seconds: float


class RunningQueries(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_RUNNING]}))

    items: list[RunningQuery]
