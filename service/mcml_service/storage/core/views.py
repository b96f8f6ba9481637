"""Visible projects of a user, and the user's rights in them.

A transaction knows its user: invisible data is missing from all reads, and forbidden changes are refused when they
would be written.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from sqlalchemy import ColumnElement, false, true

from mcml_service.storage.core.tables import document

SCOPES: Final = ("read", "edit", "own", "operate")
"""Scopes of rights, each including the ones before it: see, change, manage a project, maintain the repository."""


def least(*scopes: str | None) -> str | None:
    """The smallest of scopes; None, which allows nothing, where one is None or damaged."""
    places = [SCOPES.index(scope) if scope in SCOPES else -1 for scope in scopes]
    return None if min(places) < 0 else SCOPES[min(places)]


def may(held: str | None, scope: str) -> bool:
    """Whether who has one scope may do what another is needed for."""
    return least(held, scope) == scope


def greatest(*scopes: str | None) -> str | None:
    """The largest of scopes, None without any."""
    places = [SCOPES.index(scope) for scope in scopes if scope in SCOPES]
    return SCOPES[max(places)] if places else None


@dataclass(frozen=True)
class View:
    """The access of a user.

    everywhere: the scope in every project, None for none. projects: (key, scope) of projects with another scope.
    limited: only these projects, regardless of other rights of the user (a token of some projects). documents: ids of
    the only visible documents, None for all.
    """

    everywhere: str | None = SCOPES[-1]
    projects: frozenset[tuple[int, str]] = frozenset()
    limited: bool = False
    documents: frozenset[str] | None = None

    @property
    def is_whole(self) -> bool:
        """Whether every project is seen."""
        return self.everywhere is not None

    @cached_property
    def readable(self) -> frozenset[int]:
        """Keys of the projects that are seen where not all are."""
        return frozenset(key for key, _ in self.projects)

    @property
    def most(self) -> str:
        """The scope where it is largest."""
        return greatest("read", self.everywhere, *(scope for _, scope in self.projects)) or ""

    def scope(self, project: int) -> str | None:
        """In a project, None where it is not seen."""
        return greatest(self.everywhere, *(scope for key, scope in self.projects if key == project))

    def sees(self, project: int) -> bool:
        return self.is_whole or project in self.readable

    def shows(self, document: str, project: int) -> bool:
        """Whether a document is seen that is in a project."""
        return self.sees(project) and (self.documents is None or document in self.documents)

    def within(self, scope: str | None, projects: frozenset[int] | None) -> View:
        """Return this view limited to a scope. projects: only in these, None for all."""
        if projects is None:
            return View(
                least(scope, self.everywhere), frozenset((key, _least(scope, own)) for key, own in self.projects)
            )
        chosen = ((key, least(scope, self.scope(key), "own")) for key in projects)
        return View(None, frozenset((key, own) for key, own in chosen if own is not None), limited=True)


WHOLE: Final = View()
"""The view of administrators, and of automatic processes."""


def is_seen(view: View, project: ColumnElement[int] | Any = document.c.project) -> ColumnElement[bool]:
    """The condition that a row belongs to a project that is seen, and a document is seen there."""
    if view.is_whole:
        return true()
    its_own = project.in_(sorted(view.readable))
    if view.documents is None:
        return its_own
    return its_own & document.c.uuid.in_(sorted(view.documents)) if project is document.c.project else false()


def _least(scope: str | None, own: str) -> str:
    return least(scope, own) or ""
