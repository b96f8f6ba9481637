"""Webhooks, which send events to other programs."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import CURSOR, PROJECT, TIME, shown
from mcml_schemas.request_body import RequestBody
from mcml_schemas.team.activity import ActivityKind

_URL = "https://hooks.example/mcml"
_WEBHOOK = {
    "number": 2,
    "project": PROJECT,
    "url": _URL,
    "kinds": ["document", "comment"],
    "author": "kim",
    "created": TIME,
}
_DELIVERY = {
    "number": 31,
    "message": "msg_01a1fd7e8c117d02b1f32f5f0a3c9d11",
    "type": "comment.add",
    "created": TIME,
    "state": "waiting",
    "attempts": 1,
    "status": 503,
    "problem": "answered 503",
}


class WebhookRequest(RequestBody):
    model_config = ConfigDict(
        json_schema_extra=shown({"url": _URL, "project": PROJECT, "kinds": ["document", "comment"]})
    )

    url: str = Field(min_length=8, max_length=2000, description="Where messages are sent, with https")
    project: str | None = Field(None, max_length=256, description="Tell of this one alone; default all")
    kinds: list[ActivityKind] = Field([], max_length=10, description="Tell of these kinds of events; default all")


class WebhookView(BaseModel):
    """ended: since when it wants no more, having answered 410."""

    model_config = ConfigDict(json_schema_extra=shown(_WEBHOOK))

    number: int
    url: str
    kinds: list[ActivityKind]
    author: str
    created: str
    project: str | None = None
    ended: str | None = None


class WebhookMade(WebhookView):
    model_config = ConfigDict(json_schema_extra=shown({**_WEBHOOK, "secret": "whsec_…"}))

    secret: str = Field(description="That messages are signed with; shown this once")


class WebhookList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_WEBHOOK]}))

    items: list[WebhookView]


class DeliveryView(BaseModel):
    """A message. status, problem: of the last attempt."""

    model_config = ConfigDict(json_schema_extra=shown(_DELIVERY))

    number: int
    message: str = Field(description="The same in all attempts: `webhook-id`")
    type: str
    created: str
    state: Literal["waiting", "sent", "failed"]
    attempts: int
    status: int | None = None
    problem: str | None = None


class DeliveryPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_DELIVERY], "next_cursor": CURSOR}))

    items: list[DeliveryView]
    next_cursor: str | None = None
