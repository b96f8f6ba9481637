"""Proposed changes of documents: made by everybody with access, approved and applied by editors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field, ValidationError

from mcml.errors import ConflictError, DocumentError, RequestError, SizeError
from mcml_schemas.frames import FramesEdited
from mcml_schemas.team.proposals import (
    ProposalDetail,
    ProposalPage,
    ProposalRequest,
    ProposalView,
)
from mcml_service.actions.editing.edit_report import EditReport
from mcml_service.actions.reviewing.apply_proposal import Proposed, apply_proposed, find_inputs
from mcml_service.actions.reviewing.rebase_changes import rebase_changes, require_same_frames
from mcml_service.operations.arguments import MOST, DocumentId, IfMatch, Page, Shown, at_revision, find_for_write
from mcml_service.operations.call import Call
from mcml_service.operations.edits.changes import read_changes
from mcml_service.operations.edits.frame_edits import Compared, preview_edits
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.team.proposals import PENDING, StoredProposal
from mcml_service.storage.transaction import Transaction

MOST_BYTES = 2 << 20
"""Of the JSON of a proposal."""

ProposalNumber = Annotated[int, Field(ge=1, le=MOST, description="Number of the proposal", examples=[3])]


def list_proposals(
    call: Call,
    id: DocumentId,
    page: Page,
    state: Annotated[
        Literal["pending", "open", "approved", "applied", "closed"] | None,
        Field(description="Only in this state; pending: open or approved; default all", examples=["pending"]),
    ] = None,
) -> ProposalPage:
    """Lists the newest first."""
    before = page.after(int)
    with call.database.read() as tx:
        stored = tx.documents.get(id)
        states = PENDING if state == "pending" else state and (state,)
        found = tx.proposals.of(stored, states, None if before is None else before[0], page.most(call) + 1)
        shown, more = page.cut(call, found, lambda one: (one.number,))
        comments = tx.proposals.count_comments(stored, [one.number for one in shown])
        return ProposalPage(items=[_view(stored, one, comments.get(one.number, 0)) for one in shown], next_cursor=more)


def get_proposal(call: Call, id: DocumentId, proposal: ProposalNumber) -> ProposalDetail:
    with call.database.read() as tx:
        stored = tx.documents.get(id)
        found = tx.proposals.get(stored, proposal)
        facts = _tell(tx, stored, found).model_dump()
    return ProposalDetail(**facts, **vars(_read_content(found)))


def create_proposal(call: Call, id: DocumentId, proposal: ProposalRequest, if_match: IfMatch = None) -> ProposalView:
    """Everybody with access to the document may propose changes, except visitors with a share link. The change is
    tried first: a change that cannot be made is refused.

    A document has at most 20 open proposals of at most 2 MiB each.
    """
    content = proposal.model_dump_json(exclude_unset=True)
    if len(content) > MOST_BYTES:
        raise SizeError(
            f"The proposal has {len(content):,} bytes.", remedy=f"Propose at most {MOST_BYTES:,} bytes at once."
        )
    proposed = _prepare(call, id, proposal)
    tried = _try(call, id, proposed, if_match)
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, f'"{tried.revision}"')
        kind = "changes" if proposal.edits is None else "frames"
        made = tx.proposals.add(stored, kind, content, tried.inputs, tried.summary, proposed.message)
        call.created = f"documents/{id}/proposals/{made.number}"
        return _tell(tx, stored, made)


def preview_changes(
    call: Call,
    id: DocumentId,
    proposal: ProposalRequest,
    shown: Shown,
    compared: Compared,
    if_match: IfMatch = None,
) -> FramesEdited:
    """Nothing is stored, and no right to edit is needed. `kept` pairs the frames before with those after."""
    proposed = _prepare(call, id, proposal)
    with call.database.trial(call.author) as tx:
        stored = find_for_write(tx, id, if_match)
        return preview_edits(tx, stored, proposed, shown, compared)


def preview_proposal(
    call: Call, id: DocumentId, proposal: ProposalNumber, shown: Shown, compared: Compared
) -> FramesEdited:
    """Shows the effect on the current revision; `notes` says if it is for an older one."""
    with call.database.read() as tx:
        found = tx.proposals.get(tx.documents.get(id), proposal)
    _require_pending(found)
    proposed = _prepare(call, id, _read_content(found))
    with call.database.trial(call.author) as tx:
        stored = find_for_write(tx, id, "*")
        answer = preview_edits(tx, stored, proposed, shown, compared)
    if stored.revision != found.revision:
        answer.notes.insert(0, f"made for revision {found.revision}; this is its effect on revision {stored.revision}")
    return answer


def approve_proposal(
    call: Call,
    id: DocumentId,
    proposal: ProposalNumber,
    revision: Annotated[
        int | None,
        Field(ge=1, le=MOST, description="Revision that you saw it for; 409 if it was rebased since", examples=[4]),
    ] = None,
) -> ProposalView:
    """Where the project requires a review, its author cannot approve it."""
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, "*")
        return _tell(tx, stored, tx.proposals.approve(stored, proposal, revision))


def apply_proposal(call: Call, id: DocumentId, proposal: ProposalNumber) -> ProposalView:
    """409 if the document has changed since: rebase the proposal first. Where the project requires a review, an
    approval by another person than the author is needed.
    """
    with call.database.read() as tx:
        found = tx.proposals.get(tx.documents.get(id), proposal)
    proposed = _prepare(call, id, _read_content(found), found.revision if found.state != "applied" else None)
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, "*")
        found = tx.proposals.begin_applying(stored, proposal)
        if find_inputs(tx, proposed) != found.inputs:
            raise ConflictError(
                f"A document whose frames proposal {proposal} inserts has changed.",
                remedy="Rebase the proposal and look at it again.",
                code="changed-meanwhile",
            )
        changed = apply_proposed(tx, stored, proposed, EditReport(), _message(found))
        return _tell(tx, changed, tx.proposals.finish_applying(stored, proposal, changed.revision))


def rebase_proposal(call: Call, id: DocumentId, proposal: ProposalNumber) -> ProposalView:
    """Allowed for its author and for editors of the document. Its approval ends.

    409 if frames were added, removed or moved since, so that positions mean other frames, or if the changes conflict.
    """
    with call.database.read() as tx:
        stored = tx.documents.get(id)
        found = tx.proposals.get(stored, proposal)
        _require_pending(found)
        then, base = at_revision(tx, id, found.revision)
        request = _read_content(found)
        if request.changes is not None:
            wanted = read_changes(call, id, request.changes, found.revision).changes
            request = ProposalRequest(changes=rebase_changes(request.changes, wanted, then, base, tx, stored))
        if request.edits is not None or wanted.elements:
            require_same_frames(then, base, tx, stored)
    tried = _try(call, id, _prepare(call, id, request), f'"{stored.revision}"')
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, f'"{tried.revision}"')
        content = request.model_dump_json(exclude_unset=True)
        return _tell(tx, stored, tx.proposals.rebase(stored, proposal, content, tried.inputs, tried.summary))


def close_proposal(call: Call, id: DocumentId, proposal: ProposalNumber) -> ProposalView:
    """Allowed for its author and for editors of the document. It stays in the list as closed."""
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, "*")
        return _tell(tx, stored, tx.proposals.close(stored, proposal))


@dataclass(frozen=True)
class _Tried:
    """A change that was tried. revision: of the document before it. inputs: revisions of other documents. summary: the
    change in words.
    """

    revision: int
    inputs: dict[str, int]
    summary: str


def _try(call: Call, uuid: str, proposed: Proposed, if_match: str | None) -> _Tried:
    """Apply a change and roll it back. Raises RequestError if it changes nothing."""
    with call.database.trial(call.author) as tx:
        stored = find_for_write(tx, uuid, if_match)
        inputs = find_inputs(tx, proposed)
        changed = apply_proposed(tx, stored, proposed, EditReport(), "")
        if changed.revision == stored.revision:
            raise RequestError("The proposal changes nothing.", remedy="Propose at least one change.")
        (made,) = tx.revisions.of(stored.key, limit=1)
        return _Tried(stored.revision, inputs, made.message)


def _prepare(call: Call, uuid: str, request: ProposalRequest, base: int | None = None) -> Proposed:
    """Resolve the expressions of a change. base: the revision that they refer to; default the current one."""
    if request.changes is not None:
        wanted = read_changes(call, uuid, request.changes, base)
        return Proposed(None, wanted.changes, request.changes.message)
    return Proposed(request.edits, None, request.edits.message if request.edits else "")


def _read_content(found: StoredProposal) -> ProposalRequest:
    try:
        return ProposalRequest.model_validate_json(found.content)
    except ValidationError as error:
        raise DocumentError(
            f"The change of proposal {found.number} cannot be read.", remedy="Close it and propose the change again."
        ) from error


def _require_pending(found: StoredProposal) -> None:
    if found.applied is not None:
        raise ConflictError(
            f"Proposal {found.number} was applied as revision {found.applied}.",
            remedy="Compare revisions instead: GET /documents/{id}/difference.",
        )


def _message(found: StoredProposal) -> str:
    people = found.author if found.reviewer is None else f"{found.author}, approved by {found.reviewer}"
    return f"{found.message or found.summary} (proposal {found.number} by {people})"


def _tell(tx: Transaction, stored: StoredDocument, found: StoredProposal) -> ProposalView:
    comments = tx.proposals.count_comments(stored, [found.number])
    return _view(stored, found, comments.get(found.number, 0))


def _view(stored: StoredDocument, found: StoredProposal, comments: int) -> ProposalView:
    facts = {name: value for name, value in vars(found).items() if name not in ("content", "inputs")}
    outdated = found.closed is None and found.revision != stored.revision
    return ProposalView(**facts, outdated=outdated, comments=comments)
