"""Sort documents of the columns, and find the start of a page; `storage.orders` does the same in SQL."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np

from mcml_service.listing.columns import Column, Columns, Numbers
from mcml_service.listing.vocabulary import Mask, Numbering
from mcml_service.storage.lists.orders import UNKNOWN, Order, Place, Value


def places_of(columns: Columns, among: Mask, order: Order, after: Place | None, limit: int, offset: int) -> list[Place]:
    """Return the first documents in an order after a position and an offset."""
    arranged: Numbers = columns.once(order, lambda: _arrange(columns, order))
    chosen = arranged if among.all() else arranged[among[arranged]]
    first = (0 if after is None else _behind(columns, chosen, order, after)) + offset
    rows = chosen[first : first + limit]
    values = columns.once(("value", order.column), lambda: _values(columns, order.column))[rows]
    named = zip(columns["names"][rows], columns["keys"][rows].tolist(), strict=True)
    if order.column == "name":
        return [Place(name, name, key) for name, key in named]
    return [Place(_decode(columns, order.column, value), *at) for value, at in zip(values.tolist(), named, strict=True)]


def _arrange(columns: Columns, order: Order) -> Numbers:
    """Return the indices of documents in the columns, sorted. Equal values keep their order by name and key."""
    return np.argsort(_direct(columns, order), kind="stable")


def _direct(columns: Columns, order: Order) -> Column:
    values: Column = columns.once(("value", order.column), lambda: _values(columns, order.column))
    return -values if order.descending else values


def _values(columns: Columns, column: str) -> Column:
    """Return sortable numbers for the values of a column; NaN, which is last, for unknown values."""
    if column == "name":
        names = columns["names"]
        return np.cumsum(np.concatenate([np.zeros(1), names[1:] != names[:-1]])[: len(names)])
    if column in ("project", "format"):
        vocabulary, codes = _encode(columns, column)
        return _ranks(columns, vocabulary)[codes]
    if column == "duration":
        return np.asarray(columns["frames"] * columns["seconds"])
    return np.asarray(1.0 / columns["seconds"]) if column == "rate" else columns[_HELD[column]]


_HELD = {
    "frames": "frames",
    "skeleton": "skeletons",
    "revision": "revisions",
    "created": "created",
    "modified": "modified",
    "key": "keys",
}
"""Columns that are used unchanged."""


def _encode(columns: Columns, column: str) -> tuple[Numbering[str], Column]:
    name = f"{column}s"
    return getattr(columns.words, name), columns[name]


def _sort(columns: Columns, vocabulary: Numbering[str]) -> list[str]:
    texts: list[str] = columns.once(("sorted", id(vocabulary)), lambda: sorted(vocabulary.values))
    return texts


def _ranks(columns: Columns, vocabulary: Numbering[str]) -> Numbers:
    ranks = {value: rank for rank, value in enumerate(_sort(columns, vocabulary))}
    return np.array([ranks.get(value, 0) for value in vocabulary.values], np.int64)


def _decode(columns: Columns, column: str, value: int | float) -> Value:
    """Return the value that a number represents."""
    if column in ("project", "format"):
        return _sort(columns, _encode(columns, column)[0])[int(value)]
    return None if value != value else value  # NaN


def _behind(columns: Columns, chosen: Numbers, order: Order, after: Place) -> int:
    """Return the number of the chosen, sorted documents up to a position."""
    values = _direct(columns, order)[chosen]
    number = _number(columns, order.column, after)
    if number is None:
        first, last = int(np.searchsorted(values, np.nan)), len(values)
    else:
        directed = -number if order.descending else number
        first, last = (int(np.searchsorted(values, directed, side)) for side in ("left", "right"))
        if order.column == "key":
            # No two have one; the document may have another name by now.
            return last
    return first + int(np.searchsorted(chosen[first:last], columns.place_behind(after.name, after.key)))


def _number(columns: Columns, column: str, after: Place) -> float | None:
    """Return the number for the value of a position; between two others if no document has this value now."""
    if column == "key":
        return after.key
    if column == "name":
        ranks = columns.once(("value", column), lambda: _values(columns, column))
        at = columns.place_behind(after.name, -1)
        if at == len(columns):
            return float(ranks[-1] + 1) if len(columns) else 0.0
        return float(ranks[at]) - (0.0 if columns["names"][at] == after.name else 0.5)
    if column in ("project", "format"):
        known = _sort(columns, _encode(columns, column)[0])
        at = bisect_left(known, str(after.value))
        return at if known[at : at + 1] == [after.value] else at - 0.5
    if column in UNKNOWN and after.value is None:
        return None
    return float(after.value or 0)
