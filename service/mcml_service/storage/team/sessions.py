"""Sessions of browsers, and one-time links. Their rows are temporary, so they have no checksum."""

from __future__ import annotations

import secrets
from datetime import timedelta
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import (
    bindparam,
    delete,
    func,
    insert,
    or_,
    select,
)

from mcml_service.storage.core.identifiers import digest_of, now
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import token
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.team.accounts import Account
from mcml_service.storage.team.entries import Entry, entry_of
from mcml_service.storage.team.shares import Shares
from mcml_service.storage.team.tables import account, grant, granted_project, session

if TYPE_CHECKING:
    from mcml_service.storage.team.shares import Share

_PERSON = func.coalesce(session.c.account, grant.c.account)
_VISITING = Prepared(
    select(
        session.c.author,
        session.c.token,
        _PERSON.label("person"),
        token.c.expires.label("until"),
        grant.c.scope,
        account.c.name.label("account"),
        account.c.role,
        account.c.closed,
        granted_project.c.project,
    )
    .select_from(session)
    .outerjoin(token, session.c.token == token.c.id)
    .outerjoin(grant, token.c.id == grant.c.token)
    .outerjoin(account, account.c.id == _PERSON)
    .outerjoin(granted_project, granted_project.c.token == token.c.id)
    .where(
        session.c.sha256 == bindparam("digest"),
        session.c.kind == bindparam("of"),
        session.c.expires >= bindparam("at"),
    )
)


class _Visit(NamedTuple):
    """A row of `_VISITING`."""

    author: str
    token: int | None
    person: int | None
    until: str | None
    scope: str | None
    account: str | None
    role: str | None
    closed: str | None
    project: int | None


SESSION_HOURS, LINK_MINUTES = 12, 15


class Sessions:
    """Sessions: 32 random bytes, of which only the SHA-256 is kept."""

    def __init__(self, tx: BaseTransaction, shares: Shares) -> None:
        self._tx = tx
        self._shares = shares

    def open(self, author: str, token_name: str | None = None) -> str:
        """A new session of an author; its secret. token_name: of the token that it was exchanged for."""
        key = None
        if token_name is not None:
            key = self._tx.fetch_value(select(token.c.id).where(token.c.name == token_name))
        return self._add("session", author, timedelta(hours=SESSION_HOURS), token=key)

    def open_for(self, person: Account) -> str:
        """Open a session for an account; return its secret."""
        return self._add("session", person.name, timedelta(hours=SESSION_HOURS), account=person.key)

    def link(self, author: str) -> str:
        """The secret of a link that opens one session, soon."""
        return self._add("link", author, timedelta(minutes=LINK_MINUTES))

    def follow(self, secret: str) -> str | None:
        """Use up a sign-in link; return its author, None if it does not exist."""
        entry = self._find("link", secret)
        used = delete(session).where(session.c.sha256 == digest_of(secret))
        # Of two that come at once one finds nothing to delete.
        if entry is None or not self._tx.run(used):
            return None
        return entry.author

    def entry(self, secret: str) -> Entry | None:
        """Return the user of a session, None if it does not exist or has ended."""
        return self._find("session", secret)

    def open_share(self, shown: Share) -> str:
        """Open a session for a visitor with a share link; return its secret."""
        return self._add("share", f"link {shown.name}", timedelta(hours=SESSION_HOURS), share=shown.number)

    def share_entry(self, secret: str) -> Entry | None:
        """Return the visitor of a share link, None if it has ended."""
        its = (session.c.sha256 == digest_of(secret), session.c.kind == "share", session.c.expires >= now())
        row = self._tx.fetch_one(select(session.c.share, session.c.author).where(*its))
        shown = None if row is None or row.share is None else self._shares.find_by_number(row.share)
        if row is None or shown is None:
            return None
        return Entry(row.author, self._shares.view(shown), share=shown)

    def close(self, secret: str) -> None:
        """End a session."""
        self._tx.run(delete(session).where(session.c.sha256 == digest_of(secret)))

    def end_all(self, account_key: int) -> None:
        """End all sessions of an account, including those of its tokens."""
        its_tokens = select(grant.c.token).where(grant.c.account == account_key)
        its_own = or_(session.c.account == account_key, session.c.token.in_(its_tokens))
        self._tx.run(delete(session).where(its_own))

    def _add(self, kind: str, author: str, lasts: timedelta, **whose: int | None) -> str:
        self._tx.run(delete(session).where(session.c.expires < now()))
        secret = secrets.token_urlsafe(32)
        row = {"sha256": digest_of(secret), "kind": kind, "author": author, **whose}
        self._tx.run(insert(session).values(**row, created=now(), expires=now(lasts)))
        return secret

    def _find(self, kind: str, secret: str) -> Entry | None:
        values = {"digest": digest_of(secret), "of": kind, "at": now()}
        rows = [_Visit(*row) for row in self._tx.fetch_all(_VISITING, values)]
        if not rows or (rows[0].until is not None and rows[0].until < values["at"]):
            return None
        row = rows[0]
        # A token without its rights, or without an existing account, gives no access.
        if (row.token is not None and row.scope is None) or (row.person is not None and row.account is None):
            return None
        return entry_of(self._tx, row.author, rows)
