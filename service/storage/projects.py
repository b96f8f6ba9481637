"""Projects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import bindparam, select

from service.errors import NotFoundError
from service.storage.identifiers import now, stored_form
from service.storage.tables import project

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
