"""Accounts of people, invitations, and tokens of programs."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import TIME, shown
from mcml_schemas.request_body import RequestBody

Role: TypeAlias = Literal["member", "reader", "editor", "owner"]
"""In the repository: of all its projects; a member has a role in some of them alone."""

ProjectRole: TypeAlias = Literal["reader", "editor", "owner"]
Scope: TypeAlias = Literal["read", "edit", "operate"]

_BELONGS = {"project": "dance", "role": "editor"}
_MEMBER = {"name": "kim", "role": "editor", "everywhere": False}
_ME = {"name": "kim", "role": "member", "scope": "edit", "rights": ["edit", "read"], "projects": [_BELONGS]}
_ACCOUNT = {"name": "kim", "role": "editor", "created": TIME, "closed": None}
_INVITATION = {"number": 3, "role": "editor", "project": None, "author": "lee", "created": TIME, "expires": TIME}
_TOKEN = {
    "name": "render-farm",
    "hint": "mcml_Xq2",
    "scope": "read",
    "projects": ["dance"],
    "account": "kim",
    "created": TIME,
    "expires": TIME,
    "used": TIME,
}


class Belonging(BaseModel):
    """A project, and the role of a person in it."""

    model_config = ConfigDict(json_schema_extra=shown(_BELONGS))

    project: str
    role: ProjectRole


class Me(BaseModel):
    """The current user.

    name: the name in revisions. role: None without an account. scope: the highest scope in any project. projects: those
    with another role than in the repository; for a token of some projects, only these.
    """

    model_config = ConfigDict(json_schema_extra=shown(_ME))

    name: str
    role: Role | None = None
    scope: Literal["read", "edit", "own", "operate"]
    rights: list[str] = Field(description="Permissions: read, edit, own (manage a project), operate")
    projects: list[Belonging] = []


class AccountView(BaseModel):
    """closed: since when it opens nothing."""

    model_config = ConfigDict(json_schema_extra=shown(_ACCOUNT))

    name: str
    role: Role
    created: str
    closed: str | None = None


class AccountList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_ACCOUNT]}))

    items: list[AccountView]


class OwnerRequest(RequestBody):
    """The first account, which owns the repository."""

    model_config = ConfigDict(json_schema_extra=shown({"name": "kim", "password": "four words in a row"}))

    name: str = Field(min_length=1, max_length=64, description="Sign-in name; revisions record it")
    password: str = Field(max_length=256, description="Ten characters or more")


class AccountChange(RequestBody):
    """Values to change; omitted values do not change."""

    model_config = ConfigDict(json_schema_extra=shown({"role": "reader"}))

    role: Role | None = None
    closed: bool | None = Field(None, description="Closed accounts open nothing; their tokens and sessions end")


class PasswordChange(RequestBody):
    model_config = ConfigDict(
        json_schema_extra=shown({"current": "four words in a row", "new": "five other words in a row"})
    )

    current: str = Field(max_length=256)
    new: str = Field(max_length=256)


class InvitationRequest(RequestBody):
    model_config = ConfigDict(json_schema_extra=shown({"role": "editor", "hours": 72}))

    role: Role = "editor"
    project: str | None = Field(None, min_length=1, max_length=256, description="Where alone the role is given")
    hours: int = Field(72, ge=1, le=24 * 30, description="How long it can be accepted")


class InvitationMade(BaseModel):
    """code: shown this once; /login?invitation=CODE lets one person make an account."""

    model_config = ConfigDict(json_schema_extra=shown({"code": "Jx0…", "path": "/login?invitation=Jx0…", "hours": 72}))

    code: str
    path: str
    hours: int


class InvitationView(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown(_INVITATION))

    number: int
    role: Role
    project: str | None = None
    author: str
    created: str
    expires: str


class InvitationList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_INVITATION]}))

    items: list[InvitationView]


class TokenRequest(RequestBody):
    model_config = ConfigDict(json_schema_extra=shown({"name": "render-farm", "scope": "read"}))

    name: str = Field(min_length=1, max_length=256, description="Program that uses it")
    scope: Scope = Field("read", description="Permissions; no more than its creator's")
    projects: list[Annotated[str, Field(min_length=1, max_length=256)]] = Field(
        [], max_length=100, description="Where alone it opens something; all projects, if none is named"
    )
    days: int = Field(90, ge=0, le=3650, description="Until it expires; 0: never")


class TokenMade(BaseModel):
    """token: shown this once."""

    model_config = ConfigDict(json_schema_extra=shown({"name": "render-farm", "token": "mcml_…"}))

    name: str
    token: str


class TokenView(BaseModel):
    """hint: its first characters. account: its owner. used: approximate time of the last use."""

    model_config = ConfigDict(json_schema_extra=shown(_TOKEN))

    name: str
    hint: str
    scope: Scope
    projects: list[str] = []
    account: str | None = None
    created: str
    expires: str | None = None
    used: str | None = None


class TokenList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_TOKEN]}))

    items: list[TokenView]


class MemberView(BaseModel):
    """A member of a project. role: in the project. everywhere: whether the role comes from the whole repository."""

    model_config = ConfigDict(json_schema_extra=shown(_MEMBER))

    name: str
    role: ProjectRole
    everywhere: bool


class MemberList(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_MEMBER]}))

    items: list[MemberView]


class MemberChange(RequestBody):
    model_config = ConfigDict(json_schema_extra=shown({"role": "editor"}))

    role: ProjectRole
