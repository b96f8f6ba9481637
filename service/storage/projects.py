"""Projects, and the tokens that open a server to other machines."""

from __future__ import annotations

import hashlib
import secrets
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sqlalchemy import bindparam, delete, select

from service.errors import ConflictError, NotFoundError
from service.storage.identifiers import now, stored_form
from service.storage.tables import project, token

if TYPE_CHECKING:
    from service.storage.database import Transaction

_BY_NAME = select(project.c.id).where(project.c.name == bindparam("name"))


class Projects:
    def __init__(self, tx: Transaction) -> None:
        self._tx = tx
        self._added: dict[str, int] = {}

    def names(self) -> list[str]:
        return list(self._tx.connection.execute(select(project.c.name).order_by(project.c.name)).scalars())

    def find(self, name: str) -> int | None:
        return self._tx.run(_BY_NAME, {"name": stored_form(name)}).scalar_one_or_none()

    def get(self, name: str) -> int:
        """The project's key; NotFoundError."""
        found = self.find(name)
        if found is None:
            raise NotFoundError(
                f"There is no project {name!r}.", remedy="Upload into it to make it, or check the name."
            )
        return found

    def get_or_add(self, name: str) -> int:
        """The project's key, of a new one where there is none. Asked again in one transaction, it looks no more."""
        if name not in self._added:
            self._added[name] = self._found_or_added(name)
        return self._added[name]

    def _found_or_added(self, name: str) -> int:
        found = self.find(name)
        if found is not None:
            return found
        self._tx.dialect.order_commits(self._tx.connection)
        found = self.find(name)
        if found is not None:
            return found
        return self._tx.insert_row(project, name=stored_form(name), created=now())


_ANY = select(token.c.name).limit(1)


@dataclass(frozen=True)
class TokenSummary:
    """A token as it is listed. hint: its first characters; the token itself is not kept."""

    name: str
    hint: str
    created: str
    expires: str | None


class Tokens:
    """Access tokens: `mcml_` and 32 random bytes, of which only the SHA-256 is kept."""

    def __init__(self, tx: Transaction) -> None:
        self._tx = tx

    def add(self, name: str, expires: str | None = None) -> str:
        """A new token, in clear for the only time. ConflictError where the name is taken."""
        if any(summary.name == name for summary in self.all()):
            raise ConflictError(f"There is a token {name!r} already.", remedy="Choose another name or revoke that one.")
        secret = f"mcml_{secrets.token_urlsafe(32)}"
        row = {"name": name, "sha256": _digest(secret), "hint": secret[:9], "created": now(), "expires": expires}
        self._tx.insert_row(token, **row)
        return secret

    def all(self) -> list[TokenSummary]:
        rows = self._tx.connection.execute(select(token).order_by(token.c.name))
        return [TokenSummary(row.name, row.hint, row.created, row.expires) for row in rows]

    def exist(self) -> bool:
        """Whether there is any token, an expired one too."""
        return bool(self._tx.rows(_ANY))

    def remove(self, name: str) -> None:
        from service.storage.visits import session

        # Sessions that it was exchanged for end with it.
        its = select(token.c.id).where(token.c.name == name).scalar_subquery()
        self._tx.connection.execute(delete(session).where(session.c.token == its))
        if not self._tx.connection.execute(delete(token).where(token.c.name == name)).rowcount:
            raise NotFoundError(f"There is no token {name!r}.", remedy="See `mcml token list`.")

    def owner(self, secret: str) -> str | None:
        """The name of the token with this secret, None where it is unknown or has expired."""
        row = self._tx.connection.execute(select(token).where(token.c.sha256 == _digest(secret))).one_or_none()
        if row is None or (row.expires is not None and row.expires < now()):
            return None
        return str(row.name)


def _digest(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
