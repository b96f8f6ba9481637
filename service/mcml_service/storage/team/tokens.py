"""The tokens that open a server to programs and other machines."""

from __future__ import annotations

import secrets
from collections.abc import Collection
from dataclasses import dataclass
from datetime import timedelta
from typing import NamedTuple

from sqlalchemy import bindparam, delete, insert, select, update

from mcml.errors import ConflictError, NotFoundError
from mcml_service.storage.core.identifiers import digest_of, now
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import project, token
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import SCOPES
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.team.accounts import Account
from mcml_service.storage.team.entries import Entry, entry_of, is_taken
from mcml_service.storage.team.tables import account, grant, granted_project, session

_ANY = Prepared(select(token.c.name).limit(1))
_GRANTED = token.join(grant).outerjoin(account, grant.c.account == account.c.id)
_COMING = Prepared(
    select(
        token.c.id.label("token"),
        token.c.name,
        token.c.expires,
        grant.c.scope,
        grant.c.used,
        account.c.id.label("person"),
        account.c.name.label("account"),
        account.c.role,
        account.c.closed,
        granted_project.c.project,
    )
    .select_from(_GRANTED.outerjoin(granted_project, granted_project.c.token == token.c.id))
    .where(token.c.sha256 == bindparam("digest"))
)


class _Coming(NamedTuple):
    """A row of `_COMING`."""

    token: int
    name: str
    expires: str | None
    scope: str
    used: str | None
    person: int | None
    account: str | None
    role: str | None
    closed: str | None
    project: int | None


USED_HOURS = 1
"""Precision of the time of a token's last use: reads should not write."""


@dataclass(frozen=True)
class TokenSummary:
    """A token in a list.

    hint: its first characters; the token itself is not stored. account: its owner. used: approximate time of the last
    use. projects: the only projects that it gives access to, () for all.
    """

    name: str
    hint: str
    created: str
    expires: str | None
    scope: str
    account: str | None
    used: str | None
    projects: tuple[str, ...] = ()


class Tokens:
    """Access tokens: `mcml_` and 32 random bytes, of which only the SHA-256 is kept."""

    def __init__(self, tx: BaseTransaction, activity: Activity) -> None:
        self._tx = tx
        self._activity = activity

    def add(
        self,
        name: str,
        expires: str | None = None,
        *,
        scope: str = SCOPES[-1],
        owner: Account | None = None,
        projects: Collection[int] = (),
    ) -> str:
        """A new token, in clear for the only time. projects: keys of those where alone it opens something.
        ConflictError where the name is taken."""
        if is_taken(self._tx, name):
            raise ConflictError(f"There is a token {name!r} already.", remedy="Choose another name or revoke that one.")
        secret = f"mcml_{secrets.token_urlsafe(32)}"
        row = {"name": name, "sha256": digest_of(secret), "hint": secret[:9], "created": now(), "expires": expires}
        key = self._tx.insert_row(token, **row)
        whose = None if owner is None else owner.key
        self._tx.run(insert(grant).values(token=key, scope=scope, account=whose))
        for each in projects:
            self._tx.run(insert(granted_project).values(token=key, project=each))
        self._activity.note("token", "add", subject=name)
        return secret

    def all(self) -> list[TokenSummary]:
        """By name."""
        columns = (token.c.name, token.c.hint, token.c.created, token.c.expires, grant.c.scope)
        wanted = select(*columns, account.c.name.label("account"), grant.c.used).select_from(_GRANTED)
        rows = self._tx.fetch_all(wanted.order_by(token.c.name))
        named = select(token.c.name, project.c.name).select_from(granted_project.join(token).join(project))
        where: dict[str, tuple[str, ...]] = {}
        for whose, name in self._tx.fetch_all(named.order_by(project.c.name)):
            where[whose] = (*where.get(whose, ()), name)
        return [TokenSummary(**row._mapping, projects=where.get(row.name, ())) for row in rows]

    def exist(self) -> bool:
        """Tell whether there is any token, including expired ones."""
        return bool(self._tx.fetch_all(_ANY))

    def remove(self, name: str) -> None:
        """NotFoundError."""
        # Sessions that it was exchanged for end with it.
        its = select(token.c.id).where(token.c.name == name).scalar_subquery()
        self._tx.run(delete(session).where(session.c.token == its))
        for table in (grant, granted_project):
            self._tx.run(delete(table).where(table.c.token == its))
        if not self._tx.run(delete(token).where(token.c.name == name)):
            raise NotFoundError(f"There is no token {name!r}.", remedy="See `mcml token list`.")
        self._activity.note("token", "revoke", subject=name)

    def entry(self, secret: str) -> Entry | None:
        """Return the user of the token with this secret, None if it is unknown or has expired."""
        return self.came(secret)[0]

    def came(self, secret: str) -> tuple[Entry | None, bool]:
        """As `entry`, and whether it is noted that the token was used within the last hour."""
        rows = [_Coming(*row) for row in self._tx.fetch_all(_COMING, {"digest": digest_of(secret)})]
        if not rows or (rows[0].expires is not None and rows[0].expires < now()):
            return None, False
        used = rows[0].used
        return entry_of(self._tx, rows[0].name, rows), used is not None and used >= now(-timedelta(hours=USED_HOURS))

    def name(self, secret: str) -> str | None:
        """The name of the token with this secret."""
        wanted = select(token.c.name).where(token.c.sha256 == digest_of(secret))
        name: str | None = self._tx.fetch_value(wanted)
        return name

    def note_use(self, secret: str) -> None:
        """Note that it was used now."""
        its = select(token.c.id).where(token.c.sha256 == digest_of(secret)).scalar_subquery()
        self._tx.run(update(grant).where(grant.c.token == its).values(used=now()))
