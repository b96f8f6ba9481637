"""Sort orders of lists, and positions in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from sqlalchemy import Select, and_, func, or_, select

from mcml_service.storage.core.sql_expressions import AsWritten
from mcml_service.storage.core.tables import content, document, project, revision
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.lists.filtering import seconds

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement


Value: TypeAlias = str | int | float | None

TYPES: dict[str, type[str | int | float]] = {
    "name": str,
    "project": str,
    "format": str,
    "frames": int,
    "duration": float,
    "rate": float,
    "skeleton": int,
    "revision": int,
    "created": int,
    "modified": int,
    "key": int,
}
"""Sort orders of documents, and the types of their values. Times are commits, which never decrease."""

UNKNOWN = ("duration", "rate")
"""Columns that documents may lack: those without come last, in both directions."""


@dataclass(frozen=True)
class Order:
    """By a column; those with equal values by name, then by key, in both directions."""

    column: str = "name"
    descending: bool = False


NEWEST = Order("key", descending=True)


class Place(NamedTuple):
    """The position of a document in an order. value: of the column, None without one."""

    value: Value
    name: str
    key: int


def parse_order(text: str) -> Order:
    """A column, with - before it for descending order, or `newest`."""
    return NEWEST if text == "newest" else Order(text.removeprefix("-"), text.startswith("-"))


def value_in(column: str, tx: BaseTransaction) -> ColumnElement[Any]:
    """The value of a column that is ordered by, of documents that `filtering.chosen` selects."""
    its_own = (revision.c.document == document.c.id, revision.c.commit <= tx.at)
    values: dict[str, Any] = {
        "name": lambda: document.c.name,
        "project": lambda: project.c.name,
        "format": lambda: AsWritten(document.c.format),
        "frames": lambda: content.c.frames,
        "duration": lambda: content.c.frames * seconds(tx.at),
        "rate": lambda: 1.0 / seconds(tx.at),
        "skeleton": lambda: content.c.skeleton,
        "revision": lambda: select(func.max(revision.c.number)).where(*its_own).scalar_subquery(),
        "created": lambda: document.c.created_commit,
        "modified": lambda: select(func.max(revision.c.commit)).where(*its_own).scalar_subquery(),
        "key": lambda: document.c.id,
    }
    value: ColumnElement[Any] = values[column]()
    return value


def order_rows(query: Select[Any], value: ColumnElement[Any], order: Order, after: Place | None) -> Select[Any]:
    """The statement with its rows in an order, those behind a place. value: of the column that is ordered by."""
    directed = value.desc() if order.descending else value.asc()
    unknown = [value.is_(None)] if order.column in UNKNOWN else []
    if order.column == "key":
        query = query.order_by(directed)
    else:
        named = [] if order.column == "name" else [document.c.name]
        query = query.order_by(*unknown, directed, *named, document.c.id)
    return query if after is None else query.where(_behind(value, order, after))


def _behind(value: ColumnElement[Any], order: Order, after: Place) -> ColumnElement[bool]:
    if order.column == "key":
        return document.c.id < after.key if order.descending else document.c.id > after.key
    later = or_(document.c.name > after.name, and_(document.c.name == after.name, document.c.id > after.key))
    if order.column == "name":
        # Repeated, because an index can use a bound alone.
        bound = document.c.name <= after.name if order.descending else document.c.name >= after.name
        return and_(bound, or_(document.c.name != after.name, document.c.id > after.key))
    if after.value is None:
        return and_(value.is_(None), later)
    beyond = value < after.value if order.descending else value > after.value
    condition = or_(beyond, and_(value == after.value, later))
    return or_(condition, value.is_(None)) if order.column in UNKNOWN else condition
