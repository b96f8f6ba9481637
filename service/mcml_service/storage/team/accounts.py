"""People: their accounts, and the invitations by which they come to have one."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from datetime import timedelta
from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select, update

from mcml.errors import AccessError, ConflictError, NotFoundError
from mcml_service.storage.core.identifiers import digest_of, normalise_name, now
from mcml_service.storage.core.tables import project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import may
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.team.entries import is_taken
from mcml_service.storage.team.tables import account, identity, invitation

if TYPE_CHECKING:
    pass


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
    """number: by which it is taken back. project: in which alone the role is given, None for all."""

    number: int
    role: str
    project: str | None
    author: str
    created: str
    expires: str


class Accounts:
    def __init__(self, tx: BaseTransaction, activity: Activity, projects: Projects) -> None:
        self._tx = tx
        self._activity = activity
        self._projects = projects

    def all(self) -> list[Account]:
        """By name."""
        rows = self._tx.fetch_all(select(account).order_by(account.c.name))
        return [Account(*row) for row in rows]

    def find(self, name: str) -> Account | None:
        row = self._tx.fetch_one(select(account).where(account.c.name == normalise_name(name)))
        return None if row is None else Account(*row)

    def get(self, name: str) -> Account:
        """NotFoundError."""
        person = self.find(name)
        if person is None:
            raise NotFoundError(f"There is no account {name!r}.", remedy="See `mcml account list`.")
        return person

    def find_identified(self, issuer: str, subject: str) -> Account | None:
        """The account of whom a provider knows, None where it has none here."""
        its = (identity.c.issuer == issuer, identity.c.subject == subject)
        row = self._tx.fetch_one(select(account).join(identity).where(*its))
        return None if row is None else Account(*row)

    def identify(self, person: Account, issuer: str, subject: str) -> None:
        """Let an account be that of whom a provider knows."""
        row = {"issuer": issuer, "subject": subject, "account": person.key}
        self._tx.run(insert(identity).values(**row))

    def exist(self) -> bool:
        """Tell whether there is any account, including closed ones."""
        return self._tx.fetch_one(select(account.c.id).limit(1)) is not None

    def have_owner(self) -> bool:
        """Whether an open account owns the repository."""
        its = (account.c.role == "owner", account.c.closed.is_(None))
        return self._tx.fetch_one(select(account.c.id).where(*its).limit(1)) is not None

    def require_owner(self) -> None:
        """Refuse what people without an owner would follow from. ConflictError."""
        if not self.have_owner():
            raise ConflictError(
                "This repository has no owner's account yet, and the first account closes it to everybody else.",
                remedy="Make your own account first: Settings in the studio, or `mcml account add NAME --role owner`.",
            )

    def add(self, name: str, role: str, password: str) -> Account:
        """A new account. password: its hash. ConflictError where the name is taken, by a token too, as revisions and
        history tell people apart by it; and where there would be accounts without an owner."""
        self._tx.order()
        if role != "owner":
            self.require_owner()
        if is_taken(self._tx, name):
            raise ConflictError(f"The name {name!r} is taken.", remedy="Choose another name.")
        row = {"name": normalise_name(name), "role": role, "password": password, "created": now(), "closed": None}
        self._tx.insert_row(account, **row)
        self._activity.note("account", "add", subject=f"{row['name']} as {role}")
        return self.get(name)

    def change(self, name: str, **values: str | None) -> Account:
        """Set role, password or closed. ConflictError where no owner would be left."""
        self._tx.order()
        person = self.get(name)
        self._tx.run(update(account).where(account.c.name == normalise_name(name)).values(**values))
        if not self.have_owner():
            raise ConflictError("The repository would have no owner.", remedy="Make another account an owner first.")
        for field, value in values.items():
            deed = field if field != "closed" else "close" if value else "reopen"
            self._activity.note("account", deed, subject=person.name + (f" as {value}" if field == "role" else ""))
        return self.get(name)

    def invite(self, role: str, author: str, lasts: timedelta, project_key: int | None = None) -> str:
        """Add an invitation to an account with a role; return its secret.

        project_key: of the only project of the role. Raises AccessError; ConflictError if the repository has no owner.
        """
        self._require(project_key)
        self.require_owner()
        self._tx.run(delete(invitation).where(invitation.c.expires < now()))
        secret = secrets.token_urlsafe(32)
        row = {"sha256": digest_of(secret), "role": role, "author": author, "created": now(), "expires": now(lasts)}
        self._tx.run(insert(invitation).values(**row, project=project_key))
        self._activity.note("account", "invite", project_key=project_key, subject=f"somebody as {role}")
        return secret

    def invitations(self) -> list[Invitation]:
        """Return valid invitations that the user may revoke, the newest first."""
        told = (invitation.c.id, invitation.c.role, project.c.name, invitation.c.author, invitation.c.created)
        wanted = select(*told, invitation.c.expires, invitation.c.project).outerjoin(project)
        rows = self._tx.fetch_all(wanted.where(invitation.c.expires >= now()).order_by(invitation.c.id.desc()))
        return [Invitation(*row[:-1]) for row in rows if self._decides(row[-1])]

    def take_back(self, number: int) -> None:
        """NotFoundError."""
        invited = next((pending for pending in self.invitations() if pending.number == number), None)
        if invited is None:
            raise NotFoundError(f"There is no invitation {number}.", remedy="It was used or revoked.")
        project_key = None if invited.project is None else self._projects.get(invited.project)
        self._activity.note("account", "uninvite", project_key=project_key, subject=f"somebody as {invited.role}")
        self._tx.run(delete(invitation).where(invitation.c.id == number))

    def accept(self, secret: str) -> tuple[str, int | None] | None:
        """Use up an invitation; return its role and the key of its project, None for all.

        Returns None if it does not exist or has expired.
        """
        its = invitation.c.sha256 == digest_of(secret)
        wanted = select(invitation.c.role, invitation.c.project).where(its, invitation.c.expires >= now())
        row = self._tx.fetch_one(wanted)
        # Of two that come at once one finds nothing to delete.
        if row is None or not self._tx.run(delete(invitation).where(its)):
            return None
        return str(row.role), row.project

    def _decides(self, project_key: int | None) -> bool:
        """Tell whether the user may invite to a project, or to the whole repository."""
        view = self._tx.view
        return may(view.everywhere, "operate") if project_key is None else may(view.scope(project_key), "own")

    def _require(self, project_key: int | None) -> None:
        if not self._decides(project_key):
            raise AccessError(
                "Only owners of the repository invite into all of it.",
                remedy="Name a project that you own, or ask an owner of the repository.",
            )
