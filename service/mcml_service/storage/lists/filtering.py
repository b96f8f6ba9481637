"""Which documents a list holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from sqlalchemy import Float, Select, and_, case, cast, func, or_, select

from mcml.errors import QueryError
from mcml_service.storage.core.identifiers import normalise_name
from mcml_service.storage.core.sql_expressions import AsWritten, OneOf
from mcml_service.storage.core.tables import content, document, header, project, property_, span
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import AT, Commit, is_imported, valid
from mcml_service.storage.core.views import is_seen

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement


Range: TypeAlias = tuple[float | None, float | None]
"""Least and greatest, both included; None: no such end."""

DESCRIPTION, FILE, RATE = "description", "filename", "dataframe_rate"
"""Elements of headers."""

# A file name without its ending, which is a format: rtrim removes everything except dots.
_STEM = func.rtrim(header.c.text, func.replace(header.c.text, ".", ""))
IS_SAID = or_(header.c.tag == DESCRIPTION, header.c.tag == FILE)
SAID = case((and_(header.c.tag == FILE, header.c.text.contains(".")), _STEM), else_=header.c.text)
"""Elements of headers in which words are looked for, and in which part of their texts."""

SHORT = 256
"""Characters of properties in which words are looked for: longer ones are records of programs."""


@dataclass(frozen=True)
class DocumentFilter:
    """Which documents a list holds; every condition that is given must hold.

    name: all of it. id: how it begins. text: words, each of which occurs in name, description, name of the file, a
    property or a motion name, any case. properties: (name, least, greatest, text): numbers within bounds, or equal
    text. length: in seconds. rate: frames a second. among: only documents of these keys. deleted: only deleted
    documents; else none of them.
    """

    project: str | None = None
    name: str | None = None
    id: str | None = None
    text: str | None = None
    motion_name: str | None = None
    format: str | None = None
    skeleton: int | None = None
    properties: tuple[tuple[str, float | None, float | None, str | None], ...] = ()
    length: Range = (None, None)
    rate: Range = (None, None)
    among: tuple[int, ...] | None = None
    deleted: bool = False


def parse_condition(text: str) -> tuple[str, float | None, float | None, str | None]:
    """NAME:LEAST..GREATEST or NAME:TEXT, for `DocumentFilter.properties`. QueryError."""
    name, colon, value = text.partition(":")
    if not colon:
        raise QueryError(f"{text!r} is no condition on a property.", remedy="Write age:20..30 or take:calm.")
    if ".." not in value:
        return name, None, None, value
    return name, *parse_range(value), None


def parse_range(text: str) -> Range:
    """LEAST..GREATEST, where one of them may be missing. QueryError."""
    low, dots, high = text.partition("..")
    try:
        if not dots:
            raise ValueError
        return float(low) if low else None, float(high) if high else None
    except ValueError:
        raise QueryError(f"{text!r} is not a range of numbers.", remedy="Write 20..30, 20.. or ..30.") from None


def select_wanted(what: Any, wanted: DocumentFilter, tx: BaseTransaction) -> Select[Any]:
    """A statement that selects something of the documents that are wanted."""
    joined = document.join(project).join(content, and_(content.c.document == document.c.id, tx.valid(content)))
    return filter_documents(select(what).select_from(joined), wanted, tx).where(is_imported(tx.at), is_seen(tx.view))


def filter_documents(query: Select[Any], wanted: DocumentFilter, tx: BaseTransaction) -> Select[Any]:
    gone = document.c.deleted_commit <= tx.at
    query = query.where(gone if wanted.deleted else ~gone)
    if wanted.project is not None:
        query = query.where(project.c.name == normalise_name(wanted.project))
    if wanted.id is not None:
        query = query.where(document.c.uuid.startswith(wanted.id.lower(), autoescape=True))
    if wanted.name is not None:
        query = query.where(document.c.name == normalise_name(wanted.name))
    for word in (wanted.text or "").split():
        query = query.where(_has_word(word, tx))
    if wanted.format is not None:
        query = query.where(document.c.format == wanted.format)
    if wanted.skeleton is not None:
        query = query.where(content.c.skeleton == wanted.skeleton)
    if wanted.motion_name is not None:
        named = select(span.c.document).where(span.c.name == normalise_name(wanted.motion_name), tx.valid(span))
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
    if wanted.among is not None:
        query = query.where(OneOf(document.c.id, "among", list(wanted.among)))
    for bounds, value in ((wanted.length, content.c.frames * seconds(tx.at)), (wanted.rate, 1.0 / seconds(tx.at))):
        least, greatest = bounds
        if least is not None:
            query = query.where(value >= least)
        if greatest is not None:
            query = query.where(value <= greatest)
    return query


def _has_word(word: str, tx: BaseTransaction) -> ColumnElement[bool]:
    """Return the condition that a word occurs in the texts of a document: name, description, file, properties,
    motion names.
    """
    described = select(header.c.document).where(IS_SAID, _holds(SAID, word), tx.valid(header))
    having = select(property_.c.document).where(func.length(property_.c.text) <= SHORT, _holds(property_.c.text, word))
    named = select(span.c.document).where(_holds(span.c.name, word), tx.valid(span))
    elsewhere = [document.c.id.in_(query) for query in (described, having, named)]
    return or_(_holds(document.c.name, word), *elsewhere)


def _holds(column: Any, word: str) -> ColumnElement[bool]:
    lowered = func.lower(AsWritten(column))
    return or_(*(lowered.contains(form, autoescape=True) for form in forms_of(word)))


def forms_of(word: str) -> list[str]:
    """How a word may occur in a text whose ASCII letters are small ones."""
    # lower() of SQLite, and of PostgreSQL in collation C, knows ASCII only: other letters are found as written.
    name = normalise_name(word)
    return list(dict.fromkeys((fold(name), name.lower())))


def fold(text: str) -> str:
    """A text with small letters, of ASCII alone, as databases do it."""
    return text.lower() if text.isascii() else text.translate(_SMALL)


_SMALL = {capital: capital + 32 for capital in range(ord("A"), ord("Z") + 1)}


def seconds(at: Commit = AT) -> ColumnElement[float]:
    """Seconds a frame of a document whose content is selected, as a number; NULL where they are unknown."""
    rate = (
        select(_number(header.c.text))
        .where(header.c.document == document.c.id, header.c.tag == RATE, valid(header, at))
        .scalar_subquery()
    )
    return case((content.c.frame_time.is_not(None), _number(content.c.frame_time)), else_=1.0 / rate)


def _number(text: Any) -> ColumnElement[Any]:
    """Return a text as a number above 0; NULL for texts that databases might refuse to convert, and for numbers not
    above 0.
    """
    plain = and_(func.length(text) <= 64, or_(~text.ilike("%e%"), text.ilike("%e-_"), text.ilike("%e-__")))
    return case((plain, case((cast(text, Float) > 0, cast(text, Float)), else_=None)), else_=None)
