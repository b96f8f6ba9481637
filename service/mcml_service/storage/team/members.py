"""Members of projects and their roles."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import delete, insert, select

from mcml.errors import NotFoundError
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import SCOPES, greatest
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.team.accounts import Accounts
from mcml_service.storage.team.entries import PROJECT_ROLES, ROLES
from mcml_service.storage.team.tables import account, membership


@dataclass(frozen=True)
class Member:
    """A member of a project. role: in the project. everywhere: whether the role comes from the whole repository."""

    name: str
    role: str
    everywhere: bool


class Members:
    def __init__(self, tx: BaseTransaction, accounts: Accounts, activity: Activity, quotas: Quotas) -> None:
        self._tx = tx
        self._accounts = accounts
        self._activity = activity
        self._quotas = quotas

    def of_project(self, project_key: int) -> list[Member]:
        """By name; people whose accounts are open, with the greater of their roles."""
        own = membership.c.account == account.c.id
        wanted = select(account.c.name, account.c.role, membership.c.role.label("here")).select_from(
            account.outerjoin(membership, own & (membership.c.project == project_key))
        )
        members = []
        for row in self._tx.fetch_all(wanted.where(account.c.closed.is_(None)).order_by(account.c.name)):
            here, all_over = PROJECT_ROLES.get(row.here or ""), ROLES.get(row.role)
            scope = greatest(here, all_over)
            if scope is not None:
                role = "owner" if scope == SCOPES[-1] else _ROLE_OF[scope]
                members.append(Member(row.name, role, everywhere=scope == all_over))
        return members

    def put(self, project_key: int, name: str, role: str) -> None:
        """Give a person a role in a project, replacing an existing role. Raises AccessError, NotFoundError."""
        self._quotas.require(project_key, "own")
        person = self._accounts.get(name)
        self._remove(project_key, person.key)
        row = {"account": person.key, "project": project_key, "role": role}
        self._tx.run(insert(membership).values(**row))
        self._activity.note("member", "set", project_key=project_key, subject=f"{person.name} as {role}")

    def remove(self, project_key: int, name: str) -> None:
        """Remove a member from a project. Raises AccessError, and NotFoundError if the person is not a member."""
        self._quotas.require(project_key, "own")
        person = self._accounts.get(name)
        if not self._remove(project_key, person.key):
            raise NotFoundError(
                f"{name!r} is not a member of this project.",
                remedy="Change a role in the whole repository with mcml account role.",
            )
        self._activity.note("member", "remove", project_key=project_key, subject=person.name)

    def _remove(self, project_key: int, account_key: int) -> int:
        its = (membership.c.account == account_key, membership.c.project == project_key)
        return self._tx.run(delete(membership).where(*its))


_ROLE_OF = {scope: role for role, scope in PROJECT_ROLES.items()}
