"""Derived data of documents, stored by revision: find the data that is still valid for a later revision."""

from __future__ import annotations

from sqlalchemy import ColumnElement, Table, and_, literal_column, select

from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import revision
from mcml_service.storage.core.transaction import BaseTransaction

STILL = ("label", "unlabel", "delete")
"""Operations of revisions that move nothing. Undoing, restoring and editing elements may."""


def moves() -> ColumnElement[bool]:
    """Revisions that may move something."""
    return and_(*(revision.c.operation != literal_column(f"'{still}'") for still in STILL))


_MOVED = Prepared(select(revision.c.document, revision.c.number).where(OneOf(revision.c.document, "keys"), moves()))


class DerivedRows:
    """Of a table that has rows by document and revision."""

    def __init__(self, table: Table) -> None:
        query = select(table.c.document, table.c.revision).distinct()
        self._kept = Prepared(query.where(OneOf(table.c.document, "keys")))

    def of(self, tx: BaseTransaction, wanted: dict[int, int]) -> dict[int, int]:
        """By the keys of documents: of the revisions that the table has rows of, the newest that is not younger than
        the one that is wanted, where no revision since then moved anything. wanted: revisions by key."""
        numbers: dict[int, int] = {}
        for key, number in tx.fetch_all(self._kept, {"keys": list(wanted)}) if wanted else ():
            if numbers.get(key, 0) < number <= wanted[key]:
                numbers[key] = number
        older = [key for key, number in numbers.items() if number < wanted[key]]
        moved = tx.fetch_all(_MOVED, {"keys": older}) if older else []
        stale = {key for key, number in moved if numbers[key] < number <= wanted[key]}
        return {key: number for key, number in numbers.items() if key not in stale}
