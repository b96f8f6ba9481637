"""Comments on documents, their frames and joints. No revision: they belong to the document in all of them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml.errors import NotFoundError
from mcml_schemas.team.comments import CommentChange, CommentPage, CommentRequest, CommentView
from mcml_service.operations.arguments import MOST, DocumentId, Page, at_revision
from mcml_service.operations.call import Call
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.team.comments import Comment
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.undo.frame_history import FrameHistory

CommentId = Annotated[int, Field(ge=1, le=MOST, description="Number of the comment", examples=[7])]


def list_comments(
    call: Call,
    id: DocumentId,
    page: Page,
    proposal: Annotated[
        int | None, Field(ge=1, le=MOST, description="Only comments on this proposal", examples=[3])
    ] = None,
) -> CommentPage:
    """Lists the oldest first, including resolved ones."""
    after = page.after(int)
    with call.database.read() as tx:
        stored = tx.documents.get(id)
        comments = tx.comments.of(stored, 0 if after is None else after[0], page.most(call) + 1, proposal)
        shown, more = page.cut(call, comments, lambda comment: (comment.number,))
        history = FrameHistory(tx, stored)
        return CommentPage(items=[_view(tx, stored, comment, history) for comment in shown], next_cursor=more)


def add_comment(call: Call, id: DocumentId, comment: CommentRequest) -> CommentView:
    """Everybody with access to the document may comment on it, except visitors with a share link. @name mentions a
    person of the project.
    """
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        then, looked_at = at_revision(tx, id, comment.revision)
        last = comment.first if comment.last is None else comment.last
        if last is not None and last > looked_at.frames:
            raise NotFoundError(f"There is no frame {last}.", remedy=f"The document has {looked_at.frames:,} frames.")
        if comment.bone is not None and comment.bone not in then.heads.bone_names(stored.key).values():
            raise NotFoundError(f"There is no joint {comment.bone!r}.", remedy="Name one as its skeleton does.")
        if comment.proposal is not None:
            tx.proposals.get(stored, comment.proposal)
        place = (comment.first, last, comment.bone, comment.proposal)
        made = tx.comments.add(stored, looked_at.revision, comment.text, *place)
        return _view(tx, stored, made)


def change_comment(call: Call, id: DocumentId, comment: CommentId, change: CommentChange) -> CommentView:
    """Only its author may."""
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        return _view(tx, stored, tx.comments.change(stored, comment, change.text))


def resolve_comment(call: Call, id: DocumentId, comment: CommentId) -> CommentView:
    """Allowed for its author and for editors of the document."""
    return _resolve(call, id, comment, resolved=True)


def reopen_comment(call: Call, id: DocumentId, comment: CommentId) -> CommentView:
    """Allowed for its author and for editors of the document."""
    return _resolve(call, id, comment, resolved=False)


def delete_comment(call: Call, id: DocumentId, comment: CommentId) -> None:
    """Its author may, and owners of the project."""
    with call.database.write(call.author) as tx:
        tx.comments.delete(tx.documents.get(id), comment)


def _resolve(call: Call, id: str, comment: int, *, resolved: bool) -> CommentView:
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        return _view(tx, stored, tx.comments.resolve(stored, comment, resolved=resolved))


def _view(
    tx: Transaction, stored: StoredDocument, comment: Comment, history: FrameHistory | None = None
) -> CommentView:
    facts = {name: value for name, value in vars(comment).items() if name != "number"}
    if comment.first is not None:
        last = comment.first if comment.last is None else comment.last
        found = (history or FrameHistory(tx, stored)).find(comment.revision, comment.first, last)
        facts["first_now"], facts["last_now"] = found or (None, None)
    return CommentView(id=comment.number, mentions=tx.comments.find_mentioned(stored, comment.text), **facts)
