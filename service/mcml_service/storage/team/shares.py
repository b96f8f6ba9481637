"""Share links, which show some documents to people without an account."""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta

from sqlalchemy import (
    ColumnElement,
    delete,
    insert,
    select,
)

from mcml.errors import NotFoundError, RequestError
from mcml_service.storage.core.identifiers import digest_of, normalise_name, now
from mcml_service.storage.core.tables import document, project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import View, may
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.team.tables import session, share, shared_document


@dataclass(frozen=True)
class SharedDocument:
    revision: int
    latest: bool

    def choose_revision(self, asked: int | None) -> int | None:
        """Return the shown revision for a requested one, None for the last.

        Raises NotFoundError for a revision that is not shown.
        """
        if not self.latest and asked in (None, self.revision):
            return self.revision
        if self.latest and (asked is None or asked >= self.revision):
            return asked
        raise NotFoundError(f"This link does not show revision {asked}.", remedy="Leave the revision out.")


@dataclass(frozen=True)
class Share:
    """number: by which it is taken back. documents: by their ids."""

    number: int
    name: str
    project: str
    formats: frozenset[str]
    author: str
    created: str
    expires: str
    documents: Mapping[str, SharedDocument]


@dataclass(frozen=True)
class SharedMotion:
    id: str
    name: str
    revision: int
    frames: int
    seconds_per_frame: float | None


_ROWS = select(
    *(share.c.id, share.c.name, project.c.name.label("project_name"), share.c.formats, share.c.author),
    *(share.c.created, share.c.expires, share.c.project),
).join(project)


class Shares:
    def __init__(
        self, tx: BaseTransaction, activity: Activity, documents: Documents, projects: Projects, quotas: Quotas
    ) -> None:
        self._tx = tx
        self._activity = activity
        self._documents = documents
        self._projects = projects
        self._quotas = quotas

    def add(
        self,
        name: str,
        documents: Sequence[str],
        formats: Sequence[str],
        author: str,
        lasts: timedelta,
        *,
        latest: bool,
    ) -> tuple[str, Share]:
        """Add a link; return its secret and its data.

        Raises AccessError, NotFoundError; RequestError for documents of several projects.
        """
        stored = [self._documents.get(uuid) for uuid in dict.fromkeys(documents)]
        projects = {stored_document.project_key for stored_document in stored}
        if len(projects) != 1:
            raise RequestError("A link shows documents of one project.", remedy="Make a link for each project.")
        (key,) = projects
        self._quotas.require(key)
        secret = secrets.token_urlsafe(32)
        row = {"sha256": digest_of(secret), "name": normalise_name(name), "project": key, "formats": " ".join(formats)}
        number = self._tx.insert_row(share, **row, author=author, created=now(), expires=now(lasts))
        for stored_document in stored:
            about = {
                "share": number,
                "document": stored_document.key,
                "revision": stored_document.revision,
                "latest": latest,
            }
            self._tx.run(insert(shared_document).values(**about))
        self._activity.note("share", "add", project_key=key, subject=normalise_name(name))
        (made,) = self._find(share.c.id == number)
        return secret, made

    def all(self, project_key: int | None = None) -> list[Share]:
        """Return valid links to projects that the user can edit, the newest first."""
        wanted = share.c.expires >= now()
        shares = self._find(wanted if project_key is None else wanted & (share.c.project == project_key))
        return [link for link in shares if may(self._tx.view.scope(self._projects.get(link.project)), "edit")]

    def remove(self, number: int) -> None:
        """Revoke a link; its visitors lose access at once. Raises NotFoundError."""
        current = next((link for link in self.all() if link.number == number), None)
        if current is None:
            raise NotFoundError(f"There is no link {number}.", remedy="It has expired or was revoked.")
        self._activity.note("share", "revoke", project_key=self._projects.get(current.project), subject=current.name)
        self._tx.run(delete(session).where(session.c.share == number))
        self._tx.run(delete(shared_document).where(shared_document.c.share == number))
        self._tx.run(delete(share).where(share.c.id == number))

    def find(self, secret: str) -> Share | None:
        """Find a link by its secret, None if it has ended or does not exist."""
        shares = self._find((share.c.sha256 == digest_of(secret)) & (share.c.expires >= now()))
        return shares[0] if shares else None

    def find_by_number(self, number: int) -> Share | None:
        """None where it has ended."""
        shares = self._find((share.c.id == number) & (share.c.expires >= now()))
        return shares[0] if shares else None

    def view(self, shown: Share) -> View:
        """Return the access of its visitors."""
        key = self._projects.find(shown.project)
        return View(None, frozenset({(key, "read")}) if key else frozenset(), True, frozenset(shown.documents))

    def motions(self, shown: Share) -> list[SharedMotion]:
        """The documents of a link that are still there, at the revisions that it shows."""
        ranges = []
        for uuid, shared in shown.documents.items():
            current = self._documents.find(uuid)
            if current is not None:
                number = shared.choose_revision(None) or current.revision
                stored = self._documents.at(self._documents.commit_of(current.key, number)).get(uuid)
                rate = stored.seconds_per_frame
                ranges.append(SharedMotion(stored.uuid, stored.name, stored.revision, stored.frames, rate))
        return ranges

    def _find(self, wanted: ColumnElement[bool]) -> list[Share]:
        rows = self._tx.fetch_all(_ROWS.where(wanted).order_by(share.c.id.desc()))
        inside = select(shared_document, document.c.uuid).join(document, document.c.id == shared_document.c.document)
        inside = inside.where(shared_document.c.share.in_([row.id for row in rows]))
        held: dict[int, dict[str, SharedDocument]] = {row.id: {} for row in rows}
        for document_row in self._tx.fetch_all(inside):
            held[document_row.share][document_row.uuid] = SharedDocument(
                document_row.revision, bool(document_row.latest)
            )
        return [
            Share(
                row.id,
                row.name,
                row.project_name,
                frozenset(row.formats.split()),
                row.author,
                row.created,
                row.expires,
                held[row.id],
            )
            for row in rows
        ]
