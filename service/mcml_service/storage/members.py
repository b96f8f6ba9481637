"""Who belongs to which project, and as what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from sqlalchemy import Column, ForeignKey, String, Table, delete, insert, select

from mcml.errors import NotFoundError
from mcml_service.storage.accounts import ROLES, account
from mcml_service.storage.schema import metadata
from mcml_service.storage.views import SCOPES, greatest, require

if TYPE_CHECKING:
    from mcml_service.storage.transaction import Transaction

membership = Table(
    "membership",
    metadata,
    Column("account", ForeignKey("account.id"), primary_key=True),
    Column("project", ForeignKey("project.id"), primary_key=True),
    Column("role", String(16), nullable=False),
)

PROJECT_ROLES: Final[Mapping[str, str]] = {"reader": "read", "editor": "edit", "owner": "own"}
"""What people are in a project, and the scope of what they may do there."""


@dataclass(frozen=True)
class Member:
    """role: in the project. everywhere: whether it is what they are in the whole repository."""

    name: str
    role: str
    everywhere: bool


class Members:
    def __init__(self, tx: Transaction) -> None:
        self._tx = tx

    def of_account(self, account_key: int) -> frozenset[tuple[int, str]]:
        """(key of a project, scope there) of the projects that an account belongs to."""
        wanted = select(membership.c.project, membership.c.role).where(membership.c.account == account_key)
        rows = self._tx.connection.execute(wanted)
        return frozenset((key, PROJECT_ROLES[role]) for key, role in rows if role in PROJECT_ROLES)

    def of_project(self, project_key: int) -> list[Member]:
        """By name; people whose accounts are open, with the greater of their roles."""
        own = membership.c.account == account.c.id
        wanted = select(account.c.name, account.c.role, membership.c.role.label("here")).select_from(
            account.outerjoin(membership, own & (membership.c.project == project_key))
        )
        found = []
        for row in self._tx.connection.execute(wanted.where(account.c.closed.is_(None)).order_by(account.c.name)):
            here, all_over = PROJECT_ROLES.get(row.here or ""), ROLES.get(row.role)
            scope = greatest(here, all_over)
            if scope is not None:
                role = "owner" if scope == SCOPES[-1] else _ROLE_OF[scope]
                found.append(Member(row.name, role, everywhere=scope == all_over))
        return found

    def put(self, project_key: int, name: str, role: str) -> None:
        """Let somebody be something in a project, whatever they were there. AccessError, NotFoundError."""
        require(self._tx, project_key, "own")
        person = self._tx.accounts.get(name)
        self._remove(project_key, person.key)
        row = {"account": person.key, "project": project_key, "role": role}
        self._tx.connection.execute(insert(membership).values(**row))
        self._tx.activity.note("member", "set", project_key=project_key, subject=f"{person.name} as {role}")

    def remove(self, project_key: int, name: str) -> None:
        """AccessError, NotFoundError for who does not belong to it."""
        require(self._tx, project_key, "own")
        person = self._tx.accounts.get(name)
        if not self._remove(project_key, person.key):
            raise NotFoundError(
                f"{name!r} does not belong to this project.",
                remedy="Who has a role in the whole repository loses it there: mcml account role.",
            )
        self._tx.activity.note("member", "remove", project_key=project_key, subject=person.name)

    def _remove(self, project_key: int, account_key: int) -> int:
        its = (membership.c.account == account_key, membership.c.project == project_key)
        return self._tx.connection.execute(delete(membership).where(*its)).rowcount


_ROLE_OF = {scope: role for role, scope in PROJECT_ROLES.items()}
