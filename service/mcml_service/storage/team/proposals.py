"""Proposed changes of documents: open, then approved, then applied; or closed."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import orjson
from sqlalchemy import delete, func, select, update

from mcml.errors import AccessError, ConflictError, LimitError, NotFoundError
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.seals import SEALS, verify
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import may
from mcml_service.storage.documents.documents import Documents, StoredDocument
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.work.tables import comment, proposal

MOST_OPEN = 20
"""Open and approved proposals of a document."""
MOST_ENDED = 80
"""Applied and closed proposals of a document that are kept."""
PENDING = ("open", "approved")
_COLUMNS = SEALS[proposal].columns


@dataclass(frozen=True)
class StoredProposal:
    """number: in the document. revision: that the change was made for. kind: frames or changes. content: the request as
    JSON. inputs: revisions of other documents whose frames it inserts, by id. summary: the change in words. state:
    open, approved, applied or closed. reviewer, reviewed: person and time of its approval. closer, closed: person and
    time of closing or applying it. applied: the revision that it became.
    """

    number: int
    revision: int
    kind: str
    content: str
    inputs: Mapping[str, int]
    summary: str
    message: str
    author: str
    created: str
    state: str
    reviewer: str | None
    reviewed: str | None
    closer: str | None
    closed: str | None
    applied: int | None


class Proposals:
    """Every method takes a document that is seen; those that write take a locked one."""

    def __init__(self, tx: BaseTransaction, activity: Activity, documents: Documents, quotas: Quotas) -> None:
        self._tx = tx
        self._activity = activity
        self._documents = documents
        self._quotas = quotas

    def of(
        self, stored: StoredDocument, states: Collection[str] | None, before: int | None, limit: int
    ) -> list[StoredProposal]:
        """The newest first, those with numbers below `before`; in some states, None for all."""
        query = select(*_READ).where(proposal.c.document == stored.key).order_by(proposal.c.number.desc()).limit(limit)
        if states is not None:
            query = query.where(proposal.c.state.in_(states))
        if before is not None:
            query = query.where(proposal.c.number < before)
        return [_to_proposal(row) for row in self._tx.fetch_all(verify(query, proposal))]

    def get(self, stored: StoredDocument, number: int) -> StoredProposal:
        """Raises NotFoundError."""
        its = (proposal.c.document == stored.key, proposal.c.number == number)
        rows = self._tx.fetch_all(verify(select(*_READ).where(*its), proposal))
        if not rows:
            raise NotFoundError(f"The document has no proposal {number}.", remedy="List its proposals.")
        return _to_proposal(rows[0])

    def count_comments(self, stored: StoredDocument, numbers: Collection[int]) -> dict[int, int]:
        """Comments on proposals, by their numbers; none for those without comments."""
        its = (comment.c.document == stored.key, comment.c.deleted.is_(None), comment.c.proposal.in_(numbers))
        query = select(comment.c.proposal, func.count()).where(*its).group_by(comment.c.proposal)
        return {row[0]: row[1] for row in self._tx.fetch_all(query)}

    def add(
        self, stored: StoredDocument, kind: str, content: str, inputs: Mapping[str, int], summary: str, message: str
    ) -> StoredProposal:
        """Add an open proposal for the current revision. Raises LimitError if too many are open."""
        self._quotas.require_open(stored.project_key)
        own = proposal.c.document == stored.key
        pending = self._tx.fetch_value(
            select(func.count()).select_from(proposal).where(own, proposal.c.state.in_(PENDING))
        )
        if int(pending) >= MOST_OPEN:
            raise LimitError(
                f"The document has {pending} open proposals.", remedy="Close or apply some of them before the next one."
            )
        number = int(self._tx.fetch_value(select(func.coalesce(func.max(proposal.c.number), 0)).where(own))) + 1
        self._tx.insert_rows(
            proposal,
            [
                {
                    "document": stored.key,
                    "number": number,
                    "revision": stored.revision,
                    "kind": kind,
                    "content": content,
                    "inputs": orjson.dumps(dict(inputs)).decode(),
                    "summary": summary,
                    "message": message,
                    "author": self._tx.author,
                    "created": now(),
                    "state": "open",
                    **dict.fromkeys(("reviewer", "reviewed", "closer", "closed", "applied")),
                }
            ],
        )
        self._forget_oldest(stored)
        return self._to_proposal(stored, number, "add")

    def approve(self, stored: StoredDocument, number: int, revision: int | None) -> StoredProposal:
        """Approve an open proposal. revision: that the user looked at, None if unknown.

        Raises AccessError for users who may not edit, and for its author where changes need a review; ConflictError if
        it is not open, or was rebased meanwhile.
        """
        found = self._require_state(stored, number, "open")
        self._quotas.require(stored.project_key)
        if found.author == self._tx.author and self._quotas.of(stored.project_key).review_required:
            raise AccessError(
                f"Proposal {number} is your own.", remedy="Another editor of the project has to approve it."
            )
        if revision not in (None, found.revision):
            raise ConflictError(
                f"Proposal {number} is for revision {found.revision} by now.", remedy="Look at it again."
            )
        self._set(stored, number, state="approved", reviewer=self._tx.author, reviewed=now())
        return self._to_proposal(stored, number, "approve")

    def rebase(
        self, stored: StoredDocument, number: int, content: str, inputs: Mapping[str, int], summary: str
    ) -> StoredProposal:
        """Make a proposal one for the current revision; its approval ends. Raises AccessError, ConflictError."""
        self._require_own(stored, number)
        self._set(
            stored,
            number,
            revision=stored.revision,
            content=content,
            inputs=orjson.dumps(dict(inputs)).decode(),
            summary=summary,
            state="open",
            reviewer=None,
            reviewed=None,
        )
        return self._to_proposal(stored, number, "rebase")

    def close(self, stored: StoredDocument, number: int) -> StoredProposal:
        """Close a proposal without applying it. Raises AccessError unless called by its author or an editor."""
        self._require_own(stored, number)
        self._set(stored, number, state="closed", closer=self._tx.author, closed=now())
        return self._to_proposal(stored, number, "close")

    def begin_applying(self, stored: StoredDocument, number: int) -> StoredProposal:
        """Let this transaction apply a proposal. Raises AccessError, and ConflictError if it is not pending, lacks an
        approval, or was made for another revision.
        """
        found = self._require_state(stored, number, *PENDING)
        self._quotas.require(stored.project_key)
        if self._quotas.of(stored.project_key).review_required and found.reviewer in (None, found.author):
            raise ConflictError(
                f"Proposal {number} has no approval by another person.",
                remedy="Another editor of the project has to approve it first.",
                code="review-required",
            )
        if found.revision != stored.revision:
            raise ConflictError(
                f"The document is at revision {stored.revision}, proposal {number} is for revision {found.revision}.",
                remedy=f"Rebase the proposal, look at it again, then apply it: mcml proposal rebase ID {number}",
                code="changed-meanwhile",
                revision=stored.revision,
            )
        self._documents.allow_reviewed(stored.key)
        return found

    def finish_applying(self, stored: StoredDocument, number: int, revision: int) -> StoredProposal:
        """Note the revision that a proposal became. stored: the document before."""
        self._set(stored, number, state="applied", closer=self._tx.author, closed=now(), applied=revision)
        return self._to_proposal(stored, number, "apply")

    def _require_own(self, stored: StoredDocument, number: int) -> StoredProposal:
        found = self._require_state(stored, number, *PENDING)
        self._quotas.require_open(stored.project_key)
        if found.author != self._tx.author and not may(self._tx.view.scope(stored.project_key), "edit"):
            raise AccessError(f"Proposal {number} is {found.author}'s.", remedy="Ask its author or an editor.")
        return found

    def _require_state(self, stored: StoredDocument, number: int, *states: str) -> StoredProposal:
        found = self.get(stored, number)
        if found.state not in states:
            made = "" if found.applied is None else f" as revision {found.applied}"
            raise ConflictError(f"Proposal {number} is {found.state}{made}.", remedy="Propose the change again.")
        return found

    def _set(self, stored: StoredDocument, number: int, **values: Any) -> None:
        its = (proposal.c.document == stored.key, proposal.c.number == number)
        query = select(*(proposal.c[name] for name in _COLUMNS)).where(*its)
        (held,) = self._tx.fetch_all(verify(query, proposal))
        row = dict(zip(_COLUMNS, held, strict=True)) | values
        changed = update(proposal).where(*its)
        self._tx.run(changed.values(**values, checksum=SEALS[proposal].of((*row.values(),))))

    def _forget_oldest(self, stored: StoredDocument) -> None:
        """Remove the oldest ended proposals of a document that has too many; comments on them stay."""
        ended = (proposal.c.document == stored.key, proposal.c.state.not_in(PENDING))
        query = select(proposal.c.number).where(*ended).order_by(proposal.c.number.desc()).offset(MOST_ENDED)
        numbers = self._tx.fetch_column(query.limit(MOST_ENDED))
        if numbers:
            self._tx.run(delete(proposal).where(*ended, proposal.c.number.in_(numbers)))

    def _to_proposal(self, stored: StoredDocument, number: int, what: str) -> StoredProposal:
        made = self.get(stored, number)
        self._activity.note(
            "proposal",
            what,
            project_key=stored.project_key,
            document=stored.uuid,
            revision=made.applied or made.revision,
            subject=str(number),
        )
        return made


_READ = tuple(column for column in proposal.c if column.name not in ("document", "checksum"))
"""The columns of a StoredProposal."""


def _to_proposal(row: Any) -> StoredProposal:
    facts = dict(zip((column.name for column in _READ), row, strict=True))
    return StoredProposal(**facts | {"inputs": orjson.loads(facts["inputs"])})
