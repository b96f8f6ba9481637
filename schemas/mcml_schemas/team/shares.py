"""Share links, which show some documents to people without an account."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, PROJECT, TIME, shown
from mcml_schemas.request_body import RequestBody

_DOCUMENT = {"id": DOCUMENT, "revision": 3, "latest": True}
_SHARE = {
    "number": 2,
    "name": "for the client",
    "project": PROJECT,
    "documents": [_DOCUMENT],
    "formats": ["bvh"],
    "author": "kim",
    "created": TIME,
    "expires": TIME,
}
_MOTION = {"id": DOCUMENT, "name": "walk", "revision": 3, "frames": 1197, "seconds_per_frame": 0.0083333}


class ShareRequest(RequestBody):
    model_config = ConfigDict(
        json_schema_extra=shown({"name": "for the client", "documents": [DOCUMENT], "formats": ["bvh"], "days": 14}),
    )

    name: str = Field(min_length=1, max_length=256, description="Whom it is for")
    documents: list[Annotated[str, Field(max_length=64)]] = Field(min_length=1, max_length=100, description="Their ids")
    latest: bool = Field(True, description="Show later edits too; else what is current now")
    formats: list[Annotated[str, Field(max_length=64)]] = Field(
        [], max_length=100, description="Allowed export formats"
    )
    days: int = Field(14, ge=1, le=365, description="How long it opens them")


class SharedRevision(BaseModel):
    """revision: that was current when the link was made. latest: later ones are shown too."""

    model_config = ConfigDict(json_schema_extra=shown(_DOCUMENT))

    id: str
    revision: int
    latest: bool


class ShareView(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown(_SHARE))

    number: int
    name: str
    project: str
    documents: list[SharedRevision]
    formats: list[str]
    author: str
    created: str
    expires: str


class ShareMade(ShareView):
    """A new link. path: shown only once; the part after # never reaches a server's log."""

    model_config = ConfigDict(json_schema_extra=shown({**_SHARE, "path": "/shared#Jx0…"}))

    path: str


class ShareList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_SHARE]}))

    items: list[ShareView]


class SharedRequest(RequestBody):
    model_config = ConfigDict(json_schema_extra=shown({"secret": "Jx0…"}))

    secret: str = Field(max_length=256, description="The part after # in the link")


class SharedMotion(BaseModel):
    """revision: that is shown."""

    model_config = ConfigDict(json_schema_extra=shown(_MOTION))

    id: str
    name: str
    revision: int
    frames: int
    seconds_per_frame: float | None = None


class Shared(BaseModel):
    """The content of a link. formats: allowed export formats of its documents."""

    model_config = ConfigDict(
        json_schema_extra=shown({"name": "for the client", "expires": TIME, "formats": ["bvh"], "documents": [_MOTION]})
    )

    name: str
    expires: str
    formats: list[str]
    documents: list[SharedMotion]
