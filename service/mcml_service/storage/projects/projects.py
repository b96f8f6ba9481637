"""Projects."""

from __future__ import annotations

from sqlalchemy import bindparam, select

from mcml.errors import AccessError, NotFoundError
from mcml_service.storage.core.identifiers import normalise_name, now
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import is_seen, may
from mcml_service.storage.projects.quotas import Quotas

_ALL = select(project.c.name).order_by(project.c.name)
_BY_NAME = Prepared(select(project.c.id).where(project.c.name == bindparam("name")))


class Projects:
    def __init__(self, tx: BaseTransaction, quotas: Quotas) -> None:
        self._tx = tx
        self._quotas = quotas
        self._added: dict[str, int] = {}

    def names(self) -> list[str]:
        """The names of visible projects."""
        return self._tx.fetch_column(_ALL.where(is_seen(self._tx.view, project.c.id)))

    def name(self, key: int) -> str:
        (name,) = self._tx.fetch_column(select(project.c.name).where(project.c.id == key))
        return str(name)

    def find(self, name: str) -> int | None:
        """The key of one that is seen."""
        key = self._key(name)
        return key if key is not None and self._tx.view.sees(key) else None

    def _key(self, name: str) -> int | None:
        key: int | None = self._tx.fetch_value(_BY_NAME, {"name": normalise_name(name)})
        return key

    def get(self, name: str) -> int:
        """The project's key; NotFoundError."""
        key = self.find(name)
        if key is None:
            raise NotFoundError(f"There is no project {name!r}.", remedy="Create it, or check the name.")
        return key

    def get_or_add(self, name: str) -> int:
        """Return the key of a project for writing; create it if needed.

        Further calls in a transaction use the cached key. Raises AccessError without the right to write there, or to
        create projects.
        """
        if name not in self._added:
            self._added[name] = self._find_or_add(name)
        return self._added[name]

    def _find_or_add(self, name: str) -> int:
        key = self._writable(name)
        if key is not None:
            return key
        self._tx.order()
        key = self._writable(name)
        if key is not None:
            return key
        return self._tx.insert_row(project, name=normalise_name(name), created=now())

    def _writable(self, name: str) -> int | None:
        """Return the key of a writable project, None if there is none and the user may create it.

        Raises AccessError.
        """
        key = self._key(name)
        view = self._tx.view
        if key is not None and view.sees(key):
            self._quotas.require(key)
        elif key is not None or not may(view.everywhere, "edit"):
            # The error does not reveal whether the project exists.
            raise AccessError(
                f"There is no project {name!r} that you may write into.",
                remedy="Name one that you are an editor of, or ask an owner for more.",
            )
        return key
