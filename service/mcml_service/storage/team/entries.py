"""Identities of users and their rights: roles, tokens, sessions and accounts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from sqlalchemy import select

from mcml_service.storage.core.identifiers import normalise_name
from mcml_service.storage.core.tables import token
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import SCOPES, WHOLE, View
from mcml_service.storage.team.tables import account, membership

if TYPE_CHECKING:
    from mcml_service.storage.team.shares import Share

ROLES: Final[Mapping[str, str | None]] = {"member": None, "reader": "read", "editor": "edit", "owner": "operate"}
"""Roles in the repository, with their scope in all its projects."""


PROJECT_ROLES: Final[Mapping[str, str]] = {"reader": "read", "editor": "edit", "owner": "own"}
"""Roles in a project, with their scope in it."""


@dataclass(frozen=True)
class Entry:
    """An identified user.

    author: name in revisions. view: access of the user. account: its name; None for tokens without an account, and for
    share links. share: the share link of a visitor, None for everybody else.
    """

    author: str
    view: View = WHOLE
    account: str | None = None
    share: Share | None = None


def entry_of(tx: BaseTransaction, author: str, rows: Sequence[Any]) -> Entry | None:
    """Return the user of a token or a session, None if the account is closed.

    Damaged rows give no access. rows: one, or one for each project of a limited token, all from one statement: token
    (key) and its scope, person (key of the account), account (its name), role and closed, project (key); None where
    missing.
    """
    row = rows[0]
    if row.closed is not None:
        return None
    view = WHOLE
    if row.person is not None:
        if row.role not in ROLES:
            return None
        view = View(ROLES[row.role], scopes_of(tx, row.person))
    if row.token is not None:
        if row.scope not in SCOPES:
            return None
        view = view.within(row.scope, frozenset(each.project for each in rows if each.project is not None) or None)
    return Entry(row.account or author, view, row.account)


def scopes_of(tx: BaseTransaction, account_key: int) -> frozenset[tuple[int, str]]:
    """(key of a project, scope there) of the projects that an account belongs to."""
    wanted = select(membership.c.project, membership.c.role).where(membership.c.account == account_key)
    rows = tx.fetch_all(wanted)
    return frozenset((key, PROJECT_ROLES[role]) for key, role in rows if role in PROJECT_ROLES)


def is_taken(tx: BaseTransaction, name: str) -> bool:
    """Tell whether an account or a token has a name: revisions and history identify authors by it."""
    named = select(account.c.id).where(account.c.name == normalise_name(name))
    called = select(token.c.id).where(token.c.name == name)
    return any(tx.fetch_one(query.limit(1)) is not None for query in (named, called))
