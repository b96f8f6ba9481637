"""Which documents a list holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sqlalchemy import Select, func, select

from service.errors import QueryError
from service.storage.identifiers import stored_form
from service.storage.tables import content, document, project, property_, span

if TYPE_CHECKING:
    from service.storage.database import Transaction


@dataclass(frozen=True)
class DocumentFilter:
    """Which documents a list holds; every condition that is given must hold.

    name: all of it. id: how it begins. text: part of the name, any case. properties: (name, least, greatest, text):
    numbers within bounds, or equal text. deleted: only deleted documents; else none of them.
    """

    project: str | None = None
    name: str | None = None
    id: str | None = None
    text: str | None = None
    motion_name: str | None = None
    format: str | None = None
    skeleton: int | None = None
    properties: tuple[tuple[str, float | None, float | None, str | None], ...] = ()
    deleted: bool = False


def parse_condition(text: str) -> tuple[str, float | None, float | None, str | None]:
    """NAME:LEAST..GREATEST or NAME:TEXT, for `DocumentFilter.properties`. QueryError."""
    name, colon, value = text.partition(":")
    if not colon:
        raise QueryError(f"{text!r} is no condition on a property.", remedy="Write age:20..30 or take:calm.")
    low, dots, high = value.partition("..")
    if not dots:
        return name, None, None, value
    try:
        return name, float(low) if low else None, float(high) if high else None, None
    except ValueError:
        raise QueryError(
            f"{value!r} is not a range of numbers.", remedy="Write age:20..30, age:20.. or age:..30."
        ) from None


def filtered(query: Select[Any], wanted: DocumentFilter, tx: Transaction) -> Select[Any]:
    gone = document.c.deleted_commit <= tx.at
    query = query.where(gone if wanted.deleted else ~gone)
    if wanted.project is not None:
        query = query.where(project.c.name == stored_form(wanted.project))
    if wanted.id is not None:
        query = query.where(document.c.uuid.startswith(wanted.id.lower(), autoescape=True))
    if wanted.name is not None:
        query = query.where(document.c.name == stored_form(wanted.name))
    if wanted.text:
        # lower() of SQLite, and of PostgreSQL in collation C, knows ASCII only: other letters are found as written.
        said = stored_form(wanted.text)
        lower = func.lower(document.c.name).contains(said.lower(), autoescape=True)
        query = query.where(lower | document.c.name.contains(said, autoescape=True))
    if wanted.format is not None:
        query = query.where(document.c.format == wanted.format)
    if wanted.skeleton is not None:
        query = query.where(content.c.skeleton == wanted.skeleton)
    if wanted.motion_name is not None:
        named = select(span.c.document).where(span.c.name == stored_form(wanted.motion_name), tx.valid(span))
        query = query.where(document.c.id.in_(named))
    for name, least, greatest, text in wanted.properties:
        having = select(property_.c.document).where(property_.c.name == name)
        if text is not None:
            having = having.where(property_.c.text == text)
        if least is not None:
            having = having.where(property_.c.number >= least)
        if greatest is not None:
            having = having.where(property_.c.number <= greatest)
        query = query.where(document.c.id.in_(having))
    return query
