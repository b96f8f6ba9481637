"""Presence: people who view or edit a document now. Rows are temporary: no history, no checksum."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from sqlalchemy import ColumnElement, and_, delete, insert, select

from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.team.accounts import Accounts
from mcml_service.storage.team.tables import account, presence

if TYPE_CHECKING:
    from mcml_service.storage.documents.documents import StoredDocument

LASTS: Final = 90.0
"""Seconds without a report after which a person counts as gone; browsers let hidden pages send once a minute."""


@dataclass(frozen=True)
class Present:
    """doing: viewing or editing. since: when they began to."""

    name: str
    doing: str
    since: str


class Presence:
    """Every method takes a document that is seen. at: seconds since 1970; now by default."""

    def __init__(self, tx: BaseTransaction, accounts: Accounts) -> None:
        self._tx = tx
        self._accounts = accounts

    def of(self, stored: StoredDocument, but: str | None = None, at: float | None = None) -> list[Present]:
        """Return the people at a document, by name; editing in one window overrides viewing in another.

        but: a person to leave out.
        """
        its = (presence.c.document == stored.key, presence.c.expires > _time(at), account.c.closed.is_(None))
        query = select(account.c.name, presence.c.doing, presence.c.since).join(account).where(*its)
        present: dict[str, Present] = {}
        for row in self._tx.fetch_all(query.order_by(presence.c.doing, presence.c.since, presence.c.id)):
            present.setdefault(row.name, Present(*row))
        return sorted((person for person in present.values() if person.name != but), key=lambda person: person.name)

    def keep(self, stored: StoredDocument, name: str, tab: str, doing: str, at: float | None = None) -> None:
        """Record the presence of a person's window, for LASTS seconds from now."""
        key = self._accounts.get(name).key
        its_own = _own(stored, key, tab)
        same = and_(its_own, presence.c.doing == doing, presence.c.expires > _time(at))
        since = self._tx.fetch_value(select(presence.c.since).where(same))
        self._tx.run(delete(presence).where(its_own | (presence.c.expires <= _time(at))))
        row = {"document": stored.key, "account": key, "tab": tab, "doing": doing, "since": since or now()}
        self._tx.run(insert(presence).values(**row, expires=_time(at) + LASTS))

    def end(self, stored: StoredDocument, name: str, tab: str) -> None:
        """End the presence of a person's window."""
        self._tx.run(delete(presence).where(_own(stored, self._accounts.get(name).key, tab)))


def _own(stored: StoredDocument, account_key: int, tab: str) -> ColumnElement[bool]:
    its = (presence.c.document == stored.key, presence.c.account == account_key, presence.c.tab == tab)
    return and_(*its)


def _time(at: float | None) -> float:
    return time.time() if at is None else at
