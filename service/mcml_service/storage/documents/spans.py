"""Motion names as spans of frames, indexed by name, which makes `//frame[motion_name='…']` cheap."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from sqlalchemy import BigInteger, bindparam, func, select, update

from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import closing, verify
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import document, project, span
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import DOCUMENT, of_document, there, valid
from mcml_service.storage.core.views import is_seen


@dataclass(frozen=True, order=True)
class StoredSpan:
    """Frames `first` to `last` (positions from 1, inclusive) carry a motion_name.

    rank: orders the motion_names of one frame. key: the row's number, new with every change.
    """

    first: int
    last: int
    rank: int
    name: str
    key: int = 0


_VISIBLE = (
    select(span.c.document, span.c.first, span.c.last)
    .join(document, document.c.id == span.c.document)
    .where(valid(span), there())
    .order_by(span.c.document, span.c.first)
)
_NAMED = verify(_VISIBLE.where(span.c.name.in_(bindparam("names", expanding=True))), span)
_NAMED_IN = _NAMED.where(span.c.document.in_(bindparam("documents", expanding=True)))
_OF_ONE_NAME = Prepared(_VISIBLE.where(span.c.name == bindparam("name")), span, remember=True)
_OF_ONE_NAME_IN_ONE = _OF_ONE_NAME.where(span.c.document == DOCUMENT)
_TOUCHING = Prepared(
    select(span.c.first, span.c.last, span.c.rank, span.c.name, span.c.id)
    .where(of_document(span))
    .where(span.c.last >= bindparam("first", type_=BigInteger), span.c.first <= bindparam("last", type_=BigInteger))
    .order_by(span.c.first, span.c.rank, span.c.id),
    span,
)
"""Prepared once: in the shortest queries, building statements takes as long as running them."""


class Spans:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def of(self, document_key: int, first: int = 1, last: int | None = None) -> list[StoredSpan]:
        """Spans of a document that touch the frames first to last, in order of their first frame and rank."""
        values = {
            "document": document_key,
            "at": self._tx.at,
            "first": first,
            "last": CURRENT if last is None else last,
        }
        return [StoredSpan(*row) for row in self._tx.fetch_all(_TOUCHING, values)]

    def of_many(self, documents: list[int]) -> dict[int, list[tuple[int, int, str]]]:
        """(first, last, name) of the spans of each document that has some, in order of first frame and rank."""
        columns = (span.c.document, span.c.first, span.c.last, span.c.name)
        query = select(*columns).where(span.c.document.in_(documents), self._tx.valid(span))
        spans: dict[int, list[tuple[int, int, str]]] = {}
        for key, *row in self._tx.fetch_all(verify(query.order_by(span.c.first, span.c.rank, span.c.id), span)):
            spans.setdefault(key, []).append((row[0], row[1], row[2]))
        return spans

    def named(self, names: list[str], documents: list[int] | None = None) -> dict[int, list[tuple[int, int]]]:
        """Ranges (first, last) of frames that carry one of the names, by document key.

        Ranges are ascending and neither overlap nor touch. documents: their keys, None for all.
        """
        ranges: dict[int, list[tuple[int, int]]] = {}
        for key, first, last in self._find_named(names, documents):
            own = ranges.setdefault(key, [])
            if own and first <= own[-1][1] + 1:
                own[-1] = (own[-1][0], max(own[-1][1], last))
            else:
                own.append((first, last))
        return ranges

    def _find_named(self, names: list[str], documents: list[int] | None) -> Iterable[Any]:
        # The most frequent query is for one name, in all documents or one.
        if len(names) == 1 and documents is None:
            return self._tx.fetch_all(_OF_ONE_NAME, {"name": names[0], "at": self._tx.at})
        if len(names) == 1 and documents is not None and len(documents) == 1:
            values = {"name": names[0], "document": documents[0], "at": self._tx.at}
            return self._tx.fetch_all(_OF_ONE_NAME_IN_ONE, values)
        query = _NAMED if documents is None else _NAMED_IN
        narrowed = {} if documents is None else {"documents": documents}
        return self._tx.fetch_all(query, {"names": names, "at": self._tx.at, **narrowed})

    def write(self, document_key: int, rows: list[dict[str, Any]], from_commit: int) -> None:
        """Add spans ({name, first, last, rank}) that hold from a commit on."""
        self._tx.insert_rows(
            span,
            [row | {"document": document_key, "from_commit": from_commit, "to_commit": CURRENT} for row in rows],
        )

    def add(self, document_key: int, name: str, first: int, last: int) -> StoredSpan:
        """A new span, ranked behind all that it overlaps, from this transaction's commit on."""
        overlapping = self.of(document_key, first, last)
        rank = max((other.rank for other in overlapping), default=-1) + 1
        row = {
            "document": document_key,
            "from_commit": self._tx.commit,
            "to_commit": CURRENT,
            "name": name,
            "first": first,
            "last": last,
            "rank": rank,
        }
        return StoredSpan(first, last, rank, name, self._tx.insert_row(span, **row))

    def close(self, keys: list[int]) -> None:
        """End spans with this transaction's commit."""
        if keys:
            self._tx.run(update(span).where(span.c.id.in_(keys)).values(closing(span, self._tx.commit)))

    def counts(self, project_name: str | None = None) -> list[tuple[str, int, int]]:
        """(motion name, documents, frames) of every name in use."""
        query = (
            select(
                span.c.name,
                func.count(span.c.document.distinct()),
                func.sum(span.c.last - span.c.first + 1),
            )
            .join(document, document.c.id == span.c.document)
            .where(valid(span, self._tx.at), there(self._tx.at), is_seen(self._tx.view))
            .group_by(span.c.name)
            .order_by(span.c.name)
        )
        if project_name is not None:
            query = query.join(project, project.c.id == document.c.project).where(project.c.name == project_name)
        return [(name, int(documents), int(frames)) for name, documents, frames in self._tx.fetch_all(query)]
