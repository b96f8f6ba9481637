"""Comments on documents, their frames and joints."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select, update

from mcml.errors import AccessError, NotFoundError
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.seals import SEALS, verify
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import may
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.team.members import Members
from mcml_service.storage.work.tables import comment

_COLUMNS = SEALS[comment].columns


@dataclass(frozen=True)
class Comment:
    """number: in the store. revision: that was looked at. first, last: positions of frames there, None for all of the
    document. bone: name of a joint. edited, resolved: when, None for never. proposal: number of the proposal that it is
    about, None for the document itself."""

    number: int
    revision: int
    first: int | None
    last: int | None
    bone: str | None
    author: str
    created: str
    text: str
    edited: str | None
    resolved: str | None
    proposal: int | None


class Comments:
    """Every method takes a document that is seen."""

    def __init__(self, tx: BaseTransaction, activity: Activity, members: Members, quotas: Quotas) -> None:
        self._tx = tx
        self._activity = activity
        self._members = members
        self._quotas = quotas

    def of(self, stored: StoredDocument, after: int, limit: int, proposal: int | None = None) -> list[Comment]:
        """The oldest first, those with numbers above `after`; on one proposal, None for all."""
        its = (comment.c.document == stored.key, comment.c.deleted.is_(None), comment.c.id > after)
        query = select(*_TOLD).where(*its).order_by(comment.c.id).limit(limit)
        if proposal is not None:
            query = query.where(comment.c.proposal == proposal)
        return [Comment(*row) for row in self._tx.fetch_all(verify(query, comment))]

    def get(self, stored: StoredDocument, number: int) -> Comment:
        """NotFoundError."""
        its = (comment.c.id == number, comment.c.document == stored.key, comment.c.deleted.is_(None))
        rows = self._tx.fetch_all(verify(select(*_TOLD).where(*its), comment))
        if not rows:
            raise NotFoundError(f"There is no comment {number} on this document.", remedy="List its comments.")
        return Comment(*rows[0])

    def add(
        self,
        stored: StoredDocument,
        revision: int,
        text: str,
        first: int | None,
        last: int | None,
        bone: str | None,
        proposal: int | None = None,
    ) -> Comment:
        place = {"document": stored.key, "revision": revision, "first": first, "last": last, "bone": bone}
        place["proposal"] = proposal
        about = {"author": self._tx.author, "created": now(), "text": text}
        return self._to_comment(stored, self._tx.insert_row(comment, **place, **about), "add")

    def change(self, stored: StoredDocument, number: int, text: str) -> Comment:
        """Change a comment. Raises AccessError unless called by its author."""
        current = self.get(stored, number)
        if current.author != self._tx.author:
            raise AccessError(f"Comment {number} is {current.author}'s.", remedy="Reply with a comment of your own.")
        self._set(number, text=text, edited=now())
        return self._to_comment(stored, number, "change")

    def resolve(self, stored: StoredDocument, number: int, *, resolved: bool) -> Comment:
        """Resolve or reopen a comment. Raises AccessError unless called by its author or an editor of the document."""
        self._require(stored, number, "edit")
        self._set(number, resolved=now() if resolved else None)
        return self._to_comment(stored, number, "resolve" if resolved else "reopen")

    def delete(self, stored: StoredDocument, number: int) -> None:
        """Delete the text of a comment. Raises AccessError unless called by its author or an owner of the project."""
        self._require(stored, number, "own")
        self._set(number, text="", deleted=now())
        self._note(stored, number, "delete")

    def find_mentioned(self, stored: StoredDocument, text: str) -> list[str]:
        """People of the document's project whom a text names as @name, by name."""
        if "@" not in text:
            return []
        names = [member.name for member in self._members.of_project(stored.project_key)]
        # Of names that begin alike the longest is meant.
        longest = sorted(map(re.escape, names), key=len, reverse=True)
        mentions = re.findall(rf"(?<!\w)@({'|'.join(longest)})(?!\w)", text) if names else []
        return sorted(set(mentions))

    def _require(self, stored: StoredDocument, number: int, scope: str) -> None:
        mine = self.get(stored, number).author == self._tx.author
        if not mine and not may(self._tx.view.scope(stored.project_key), scope):
            raise AccessError(f"Comment {number} is another's.", remedy="Ask its author or an owner of the project.")

    def _set(self, number: int, **values: Any) -> None:
        query = select(*(comment.c[name] for name in _COLUMNS)).where(comment.c.id == number).with_for_update()
        (held,) = self._tx.fetch_all(verify(query, comment))
        row = dict(zip(_COLUMNS, held, strict=True)) | values
        changed = update(comment).where(comment.c.id == number)
        self._tx.run(changed.values(**values, checksum=SEALS[comment].of((*row.values(),))))

    def _to_comment(self, stored: StoredDocument, number: int, what: str) -> Comment:
        self._note(stored, number, what)
        return self.get(stored, number)

    def _note(self, stored: StoredDocument, number: int, what: str) -> None:
        self._quotas.require_open(stored.project_key)
        self._activity.note(
            "comment",
            what,
            project_key=stored.project_key,
            document=stored.uuid,
            revision=stored.revision,
            subject=str(number),
        )


_TOLD = (
    *(comment.c.id, comment.c.revision, comment.c.first, comment.c.last, comment.c.bone, comment.c.author),
    *(comment.c.created, comment.c.text, comment.c.edited, comment.c.resolved, comment.c.proposal),
)
"""The columns of a Comment."""
