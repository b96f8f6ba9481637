"""How much may be in a project, and whether it is archived."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import BigInteger, Boolean, Column, ForeignKey, String, Table, bindparam, delete, func, insert, select

from mcml.errors import AccessError, ConflictError
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import document, document_media, document_upload, project, upload
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import there
from mcml_service.storage.core.views import may

project_terms = Table(
    "project_terms",
    metadata,
    Column("project", ForeignKey("project.id"), primary_key=True),
    Column("archived", String(32)),
    Column("most_documents", BigInteger),
    Column("most_bytes", BigInteger),
    Column("review_required", Boolean),
)
"""`archived`: since when nothing in it changes. `most_bytes`: of the files that its documents came of, and their media,
each counted once. `review_required`: whether documents change by approved proposals only; null in older rows."""

_OF = Prepared(
    select(
        *(project_terms.c.archived, project_terms.c.most_documents, project_terms.c.most_bytes),
        project_terms.c.review_required,
    ).where(project_terms.c.project == bindparam("project"))
)

_UNPROPOSED = frozenset({"delete", "restore", "undo", "names"})
"""Operations that no proposal can hold: owners of a project may do them where changes need a review."""


@dataclass(frozen=True)
class Quota:
    """archived: since when, None where it is not. most_documents, most_bytes: None for no bound. review_required:
    whether documents change by approved proposals only.
    """

    archived: str | None = None
    most_documents: int | None = None
    most_bytes: int | None = None
    review_required: bool = False


class Quotas:
    """Of each project, as one transaction sees them."""

    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx
        self._known: dict[int, Quota] = {}

    def of(self, project: int) -> Quota:
        if project not in self._known:
            rows = self._tx.fetch_all(_OF, {"project": project})
            archived, documents, size, review = rows[0] if rows else (None, None, None, None)
            self._known[project] = Quota(archived, documents, size, bool(review))
        return self._known[project]

    def put(self, project: int, chosen: Quota) -> None:
        self._tx.run(delete(project_terms).where(project_terms.c.project == project))
        if chosen != Quota():
            self._tx.run(insert(project_terms).values(project=project, **vars(chosen)))
        self._known[project] = chosen

    def measure(self, project: int) -> tuple[int, int]:
        """Return (number of existing documents, bytes of uploaded files and media, including deleted documents)."""
        mine = select(document.c.id).where(document.c.project == project)
        shown = select(func.count()).select_from(document).where(there(self._tx.at), document.c.project == project)
        kept = [select(table.c.upload).where(table.c.document.in_(mine)) for table in (document_upload, document_media)]
        size = select(func.coalesce(func.sum(upload.c.size), 0)).where(upload.c.id.in_(kept[0].union(kept[1])))
        return self._one(shown), self._one(size)

    def _one(self, query: Any) -> int:
        return int(self._tx.fetch_value(query))

    def require(self, project: int, scope: str = "edit") -> None:
        """Check the right of the transaction's user in a project.

        Raises AccessError without it, ConflictError for changes in an archived project. A trial needs no right.
        """
        if self._tx.is_trial:
            return
        if not may(self._tx.view.scope(project), scope):
            raise AccessError(
                f"This needs the right to {scope} in the project {self._name(project)!r}.",
                remedy="Ask an owner of the project for another role in it.",
            )
        if scope == "edit":
            self.require_open(project)

    def require_open(self, project: int) -> None:
        """ConflictError where it is archived."""
        since = self.of(project).archived
        if since is not None:
            raise ConflictError(
                f"The project {self._name(project)!r} is archived since {since[:10]}.",
                remedy="An owner of it may open it again: mcml project open.",
            )

    def require_direct(self, project: int, operation: str) -> None:
        """Check that documents of a project may change without a review. Raises ConflictError.

        operation: as histories name it.
        """
        if self._tx.is_trial or not self.of(project).review_required:
            return
        if operation not in _UNPROPOSED:
            raise ConflictError(
                f"Changes in the project {self._name(project)!r} need a review.",
                remedy="Propose the change (POST /documents/{id}/proposals); another editor approves it.",
                code="review-required",
            )
        if not may(self._tx.view.scope(project), "own"):
            raise ConflictError(
                f"Changes in the project {self._name(project)!r} need a review, and no proposal can {operation}.",
                remedy="Ask an owner of the project to do it.",
                code="review-required",
            )

    def require_room(self, project: int) -> None:
        """ConflictError where more is in it than may be, which a document just came into."""
        chosen = self.of(project)
        if chosen.most_documents is None and chosen.most_bytes is None:
            return
        self._tx.write_gathered()
        documents, size = self.measure(project)
        for count, most, what in ((documents, chosen.most_documents, "documents"), (size, chosen.most_bytes, "bytes")):
            if most is not None and count > most:
                raise ConflictError(
                    f"The project {self._name(project)!r} may hold {most:,} {what}.",
                    remedy="Delete or move some, purge deleted ones, or ask an owner of the repository for more room.",
                )

    def _name(self, key: int) -> str:
        (name,) = self._tx.fetch_column(select(project.c.name).where(project.c.id == key))
        return str(name)
