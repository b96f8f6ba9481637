"""People: their accounts, and the invitations by which they come to have one."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from typing import TYPE_CHECKING, Any, Final

from sqlalchemy import Column, ForeignKey, String, Table, Text, UniqueConstraint, delete, insert, select, update

from service.errors import ConflictError, NotFoundError
from service.storage.identifiers import digest_of, now, stored_form
from service.storage.schema import KEY, NAME, metadata

if TYPE_CHECKING:
    from service.storage.database import Transaction

account = Table(
    "account",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("name", NAME, nullable=False),
    Column("role", String(16), nullable=False),
    Column("password", Text, nullable=False),
    Column("created", String(32), nullable=False),
    Column("closed", String(32)),
    UniqueConstraint("name"),
)
"""`password`: its Argon2 hash. `closed`: since when the account opens nothing; its name stays taken, as revisions carry
it."""

invitation = Table(
    "invitation",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False),
    Column("role", String(16), nullable=False),
    Column("author", NAME, nullable=False),
    Column("created", String(32), nullable=False),
    Column("expires", String(32), nullable=False),
    UniqueConstraint("sha256"),
)
"""`author`: who invites. It is used up by the account that it becomes."""

grant = Table(
    "token_grant",
    metadata,
    Column("token", ForeignKey("token.id"), primary_key=True),
    Column("scope", String(16), nullable=False),
    Column("account", ForeignKey("account.id")),
    Column("used", String(32)),
)
"""What a token may do; one without a row opens nothing. `account`: whose it is; it may do no more than that one, and
ends with it. `used`: about when it last was."""

ROLES: Final[Mapping[str, str]] = {"reader": "read", "editor": "edit", "owner": "operate"}
"""What people are, and the scope of what they may do."""

SCOPES: Final = ("read", "edit", "operate")
"""Each includes those before it."""


@dataclass(frozen=True)
class Account:
    """password: its hash. closed: since when it opens nothing, None while it is open."""

    key: int
    name: str
    role: str
    password: str
    created: str
    closed: str | None


@dataclass(frozen=True)
class Invitation:
    """number: by which it is taken back."""

    number: int
    role: str
    author: str
    created: str
    expires: str


@dataclass(frozen=True)
class Entry:
    """Who came in. author: whose name revisions carry. scope: of what they may do. account: its name; None for tokens
    that are nobody's, and for links."""

    author: str
    scope: str
    account: str | None = None


def entry_of(author: str, scope: str | None, person: Any) -> Entry | None:
    """Who comes in by a token or a session, None where their account is closed. scope: of the token, None: without one.
    person: a row with account, role, closed, all None where it is nobody's."""
    if person.closed is not None:
        return None
    scopes = [SCOPES[-1] if scope is None else scope]
    if person.account is not None:
        scopes.append(ROLES.get(person.role, ""))
    # What is damaged opens nothing.
    places = [SCOPES.index(one) if one in SCOPES else -1 for one in scopes]
    return None if min(places) < 0 else Entry(person.account or author, SCOPES[min(places)], person.account)


class Accounts:
    def __init__(self, tx: Transaction) -> None:
        self._tx = tx

    def all(self) -> list[Account]:
        """By name."""
        rows = self._tx.connection.execute(select(account).order_by(account.c.name))
        return [Account(*row) for row in rows]

    def find(self, name: str) -> Account | None:
        row = self._tx.connection.execute(select(account).where(account.c.name == stored_form(name))).one_or_none()
        return None if row is None else Account(*row)

    def get(self, name: str) -> Account:
        """NotFoundError."""
        found = self.find(name)
        if found is None:
            raise NotFoundError(f"There is no account {name!r}.", remedy="See `mcml account list`.")
        return found

    def exist(self) -> bool:
        """Whether there is any, a closed one too."""
        return self._tx.connection.execute(select(account.c.id).limit(1)).first() is not None

    def add(self, name: str, role: str, password: str) -> Account:
        """A new account. password: its hash. ConflictError where the name is taken, by a token too, as revisions and
        history tell people apart by it."""
        self._tx.dialect.order_commits(self._tx.connection)
        if self.find(name) is not None or any(token.name == name for token in self._tx.tokens.all()):
            raise ConflictError(f"The name {name!r} is taken.", remedy="Choose another name.")
        row = {"name": stored_form(name), "role": role, "password": password, "created": now(), "closed": None}
        self._tx.insert_row(account, **row)
        return self.get(name)

    def change(self, name: str, **values: str | None) -> Account:
        """Set role, password or closed. ConflictError where no owner would be left."""
        self._tx.dialect.order_commits(self._tx.connection)
        self.get(name)
        self._tx.connection.execute(update(account).where(account.c.name == stored_form(name)).values(**values))
        if not any(one.role == "owner" and one.closed is None for one in self.all()):
            raise ConflictError("The repository would have no owner.", remedy="Make somebody else an owner first.")
        return self.get(name)

    def invite(self, role: str, author: str, lasts: timedelta) -> str:
        """The secret of an invitation to an account of a role."""
        self._tx.connection.execute(delete(invitation).where(invitation.c.expires < now()))
        secret = secrets.token_urlsafe(32)
        row = {"sha256": digest_of(secret), "role": role, "author": author, "created": now(), "expires": now(lasts)}
        self._tx.connection.execute(insert(invitation).values(**row))
        return secret

    def invitations(self) -> list[Invitation]:
        """Those that can be accepted still, the newest first."""
        wanted = select(
            invitation.c.id, invitation.c.role, invitation.c.author, invitation.c.created, invitation.c.expires
        ).where(invitation.c.expires >= now())
        return [Invitation(*row) for row in self._tx.connection.execute(wanted.order_by(invitation.c.id.desc()))]

    def take_back(self, number: int) -> None:
        """NotFoundError."""
        if not self._tx.connection.execute(delete(invitation).where(invitation.c.id == number)).rowcount:
            raise NotFoundError(f"There is no invitation {number}.", remedy="It was used, or taken back.")

    def accept(self, secret: str) -> str | None:
        """The role of an invitation, which is used up by this; None where there is none, or it is too old."""
        its = invitation.c.sha256 == digest_of(secret)
        role = self._tx.connection.execute(
            select(invitation.c.role).where(its, invitation.c.expires >= now())
        ).scalar_one_or_none()
        # Of two that come at once one finds nothing to delete.
        if role is None or not self._tx.connection.execute(delete(invitation).where(its)).rowcount:
            return None
        return str(role)
