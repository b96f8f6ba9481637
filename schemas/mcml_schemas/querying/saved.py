"""Saved items of projects: queries, collections of documents, colours of motion names, vocabularies."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcml_schemas.examples import CURSOR, DOCUMENT, MOTION_NAME, PROJECT, QUERY, TIME, shown
from mcml_schemas.request_body import RequestBody

_QUERY = {"q": QUERY, "description": "Frames in which the leg is bent."}
_COLLECTION = {"documents": [DOCUMENT], "description": "The calm takes."}
_KEPT = {"project": PROJECT, "name": "bent legs", "version": 1, "author": "kim", "changed": TIME}
_COLOURS = {"items": {MOTION_NAME: "sky", "walk": "#CE5A04"}}

_WORDS = {"items": [{"name": MOTION_NAME, "description": "away from the body", "colour": 2}]}

_SHORT = Field(None, max_length=1024)


class QueryToSave(RequestBody):
    """A saved XPath query."""

    model_config = ConfigDict(json_schema_extra=shown(_QUERY))

    q: str = Field(min_length=1, max_length=10_000)
    variables: dict[str, str | float | bool] = Field(default_factory=dict, max_length=100)
    description: str = Field("", max_length=4096)


class Conditions(RequestBody):
    """Conditions, as the list of documents has them."""

    project: str | None = _SHORT
    q: str | None = _SHORT
    motion_name: str | None = _SHORT
    format: str | None = _SHORT
    skeleton: int | None = Field(None, ge=0, le=2**31 - 1)
    property: Annotated[list[str], Field(max_length=100)] | None = None
    length: str | None = _SHORT
    rate: str | None = Field(None, max_length=1024, description="LEAST..GREATEST")


class LibraryView(RequestBody):
    """How a collection of conditions is shown: order and form of the list, and the property of its folders."""

    sort: str | None = Field(None, max_length=64, pattern=r"^(newest|-?[a-z]+)$", examples=["-duration"])
    layout: Literal["grid", "list"] | None = None
    folders: str | None = _SHORT


class CollectionToSave(RequestBody):
    """Ids of documents; or conditions, so that the collection always has the documents that currently match."""

    model_config = ConfigDict(json_schema_extra=shown(_COLLECTION, {"where": {"project": PROJECT}}))

    documents: Annotated[list[str], Field(max_length=100_000)] | None = None
    where: Conditions | None = None
    view: LibraryView | None = Field(None, description="How the studio shows it; with `where`")
    description: str = Field("", max_length=4096)

    @model_validator(mode="after")
    def _one_kind(self) -> CollectionToSave:
        if (self.documents is None) == (self.where is None):
            raise ValueError("give documents or where")
        if self.view is not None and self.where is None:
            raise ValueError("view needs where")
        return self


class _Kept(BaseModel):
    project: str
    name: str
    version: int = Field(description="Counts the changes from 1")
    author: str
    changed: str


class SavedQuery(_Kept):
    model_config = ConfigDict(json_schema_extra=shown({**_KEPT, **_QUERY}))

    q: str
    variables: dict[str, str | float | bool] = Field(default_factory=dict)
    description: str = ""


class SavedQueryPage(BaseModel):
    model_config = ConfigDict(json_schema_extra=shown({"items": [{**_KEPT, **_QUERY}], "next_cursor": CURSOR}))

    items: list[SavedQuery]
    next_cursor: str | None = None


class Collection(_Kept):
    """documents: its current documents; only in answers about a single collection."""

    model_config = ConfigDict(json_schema_extra=shown({**_KEPT, **_COLLECTION, "total": 1}))

    documents: list[str] | None = None
    where: Conditions | None = None
    view: LibraryView | None = None
    description: str = ""
    total: int | None = Field(None, description="Documents that are in it now")


class CollectionPage(BaseModel):
    model_config = ConfigDict(
        json_schema_extra=shown({"items": [{**_KEPT, "description": "The calm takes."}], "next_cursor": CURSOR})
    )

    items: list[Collection]
    next_cursor: str | None = None


Colour = Annotated[str, Field(pattern=r"^(#[0-9A-Fa-f]{6}|[a-z][a-z0-9-]{0,31})$")]


class ColoursToSave(RequestBody):
    """Colours of motion names: #RRGGBB, or a name that a palette has."""

    model_config = ConfigDict(json_schema_extra=shown(_COLOURS))

    items: dict[str, Colour] = Field(max_length=10_000)


class Colours(ColoursToSave):
    """version: number of changes, 0 without any."""

    model_config = ConfigDict(
        json_schema_extra=shown({**_COLOURS, "project": PROJECT, "version": 2, "author": "kim", "changed": TIME})
    )

    project: str
    version: int
    author: str
    changed: str


class VocabularyWord(RequestBody):
    """A motion name that a project agrees on.

    description: its meaning in the project. colour: one of the studio's eight colours.
    """

    model_config = ConfigDict(json_schema_extra=shown(_WORDS["items"][0]))

    name: str = Field(min_length=1, max_length=1024)
    description: str = Field("", max_length=4096)
    colour: int | None = Field(None, ge=0, le=7)


class VocabularyToSave(RequestBody):
    """All motion names that a project agrees on, in the order in which they are offered."""

    model_config = ConfigDict(json_schema_extra=shown(_WORDS))

    items: list[VocabularyWord] = Field(min_length=1, max_length=10_000)


class Vocabulary(BaseModel):
    """version: number of changes, 0 without any. author, changed: of the last one."""

    model_config = ConfigDict(
        json_schema_extra=shown({**_WORDS, "project": PROJECT, "version": 2, "author": "kim", "changed": TIME})
    )

    project: str
    version: int
    author: str
    changed: str
    items: list[VocabularyWord]
