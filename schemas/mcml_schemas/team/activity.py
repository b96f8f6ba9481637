"""The activity log of the repository."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import CURSOR, DOCUMENT, PROJECT, TIME, shown

ActivityKind: TypeAlias = Literal[
    "document", "comment", "proposal", "project", "job", "member", "share", "webhook", "account", "token"
]

_EVENT = {
    "id": 4711,
    "time": TIME,
    "kind": "comment",
    "what": "add",
    "author": "sam",
    "origin": "192.0.2.7",
    "project": PROJECT,
    "document": DOCUMENT,
    "name": "walk",
    "revision": 3,
    "subject": "7",
}


class ActivityEvent(BaseModel):
    """Something that was done; the data of events `comment` and `proposal`."""

    model_config = ConfigDict(json_schema_extra=shown(_EVENT))

    id: int = Field(description="Counts up")
    time: str
    kind: ActivityKind
    what: str = Field(description="Of documents as their history has it, or purge; of others add, change, done …")
    author: str
    origin: str | None = Field(description="Address of the client, or `command line`; for owners of the project")
    project: str | None = Field(description="None for events of the whole repository")
    document: str | None
    name: str | None = Field(description="Current name of the document")
    revision: int | None
    subject: str = Field(
        description="Other object of the event: a person, token, link, job, or number of a comment or proposal"
    )


class ActivityPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [_EVENT], "next_cursor": CURSOR}))

    items: list[ActivityEvent]
    next_cursor: str | None = None
