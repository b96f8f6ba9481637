"""The columns of a library for the lifetime of a process, and lists from them; lists come from the store without
columns.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from mcml_service.listing.columns import Columns, no_columns
from mcml_service.listing.conditions import can_tell, fulfilling
from mcml_service.listing.counts import facets_of
from mcml_service.listing.orders import places_of
from mcml_service.listing.vocabulary import Mask
from mcml_service.storage.lists import facets
from mcml_service.storage.lists.facets import Facets
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.lists.list_rows import find_keys, read_list_rows
from mcml_service.storage.lists.orders import NEWEST, Order, Place
from mcml_service.storage.transaction import Transaction

MOST_CHARACTERS = 200_000_000
"""Of different texts: a library that has more is listed by the store, slowly."""

STALE = 3
"""Times as many values as when all was read: then all is read again, for many are of documents that are not so now."""


class Found(NamedTuple):
    """places: indices of documents on the page, and of one more if there is one.

    total: number of documents on all pages.
    """

    places: list[Place]
    total: int


class Register:
    """The register of documents for lists.

    Threads may share it. patience: number of lists that the store answers before everything is read: a single list need
    not wait for that.
    """

    def __init__(self, patience: int = 1) -> None:
        self.patience = patience
        self._last: Columns | None = None
        self._whole = 0
        self._is_too_large = False
        self._lock = threading.Lock()

    def page(
        self, tx: Transaction, wanted: DocumentFilter, order: Order, after: Place | None, limit: int, offset: int
    ) -> Found:
        """Documents in an order, those behind a place, without the first `offset`."""
        is_plain = wanted == DocumentFilter() and order in (Order(), NEWEST) and after is None and not offset
        columns = self.columns(tx, wanted, is_needed=not is_plain)
        if columns is None:
            return Found(tx.documents.places(wanted, order, after, limit, offset), tx.documents.count(wanted))
        among = _mark_seen(tx, columns, fulfilling(columns, wanted))
        return Found(places_of(columns, among, order, after, limit, offset), int(among.sum()))

    def facets(self, tx: Transaction, wanted: DocumentFilter, most: int, bins: int) -> Facets:
        """Of the documents that are wanted. most: values of each facet. bins: of each range of numbers."""
        columns = self.columns(tx, wanted)
        if columns is None:
            return facets.facets(tx, wanted, most, bins)
        return facets_of(columns, _mark_seen(tx, columns, fulfilling(columns, wanted)), tx.heads.joints, most, bins)

    def columns(self, tx: Transaction, wanted: DocumentFilter, *, is_needed: bool = True) -> Columns | None:
        """Return the library as the transaction sees it; None if the store should answer.

        is_needed: if false, missing columns are not read.
        """
        newest = tx.newest_commit()
        if tx.at < newest or not can_tell(wanted) or self._is_too_large:
            return None
        whole_since = tx.pruning.whole_since()
        last = self._last
        if last is not None and (last.commit, last.whole_since) == (newest, whole_since):
            return last
        if not is_needed:
            return None
        with self._lock:
            if self._last is None and self.patience > 0:
                self.patience -= 1
                return None
            return self._read(tx, newest, whole_since)

    def _read(self, tx: Transaction, newest: int, whole_since: int) -> Columns | None:
        last = self._last
        if last is not None and last.words.values() > STALE * self._whole:
            last = None
        if last is None:
            columns = no_columns().update(newest, whole_since, (), read_list_rows(tx))
            self._whole = columns.words.values() + 1000
        elif last.commit > newest:
            # An older state, which a transaction still reads.
            return None
        else:
            changed = tx.columns.changed_since(last.commit)
            gone = set(changed)
            if whole_since != last.whole_since:
                gone |= set(last["keys"].tolist()).difference(find_keys(tx))
            columns = last.update(newest, whole_since, sorted(gone), read_list_rows(tx, changed))
        self._is_too_large = columns.words.characters() > MOST_CHARACTERS
        self._last = None if self._is_too_large else columns
        return self._last


def _mark_seen(tx: Transaction, columns: Columns, among: Mask) -> Mask:
    """Those of projects that are seen."""
    if tx.view.is_whole:
        return among
    codes = (columns.words.projects.code(name) for name in tx.projects.names())
    return among & np.isin(columns["projects"], [code for code in codes if code is not None])
