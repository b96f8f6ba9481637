"""Sessions of browsers."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import shown
from mcml_schemas.request_body import RequestBody


class SessionRequest(RequestBody):
    """The credentials of a new session: a token; name and password; or the code of a link or of an invitation, with
    the name and password of the new account.
    """

    model_config = ConfigDict(json_schema_extra=shown({"name": "kim", "password": "four words in a row"}))

    token: str | None = Field(None, max_length=256, description="As `mcml token add` made it")
    name: str | None = Field(None, max_length=256, description="Of an account")
    password: str | None = Field(None, max_length=256, description="Of this account")
    link: str | None = Field(None, max_length=256, description="The code of a link that `mcml serve` printed")
    invitation: str | None = Field(None, max_length=256, description="The code of an invitation")


class SessionOpened(BaseModel):
    """author: in whose name the session works. hours: how long it lasts."""

    model_config = ConfigDict(json_schema_extra=shown({"author": "lab", "hours": 12}))

    author: str
    hours: int
