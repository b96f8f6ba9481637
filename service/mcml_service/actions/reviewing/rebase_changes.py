"""Carry a proposed change over to a later revision of its document."""

from __future__ import annotations

from mcml.errors import ConflictError
from mcml_schemas.changes import ChangeSet, FrameBlock
from mcml_schemas.documents import LabelRequest
from mcml_service.actions.editing.draft_merging import Merge
from mcml_service.actions.editing.drafts import Changes, Values
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.timelines import Run
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.undo.frame_pairs import pair_frames


def require_same_frames(then: Transaction, base: StoredDocument, now: Transaction, current: StoredDocument) -> None:
    """Check that positions of frames mean the same frames in two revisions. Raises ConflictError.

    then, base: the document at the revision of the change. now, current: the current document.
    """
    old = then.tracks.pieces(base.key, 1, base.frames)
    if pair_frames(old, now.tracks.pieces(current.key, 1, current.frames)) != [Run(1, 1, base.frames)]:
        raise ConflictError(
            f"Frames were added, removed or moved since revision {base.revision}, so positions mean other frames.",
            remedy="Close this proposal and propose the change again for the current revision.",
            code="changed-meanwhile",
            revision=current.revision,
        )


def rebase_changes(
    request: ChangeSet,
    wanted: Changes,
    then: Transaction,
    base: StoredDocument,
    now: Transaction,
    current: StoredDocument,
) -> ChangeSet:
    """Return a request for the current revision: values and labels at their new places, without those that it does not
    change, so that changes by others stay. Raises ConflictError where both change the same.

    wanted: the request, resolved at its revision. Others as in `require_same_frames`.
    """
    merge = Merge(then, base, now, current)
    todo = merge.carry_over(wanted)
    if merge.conflicts:
        raise ConflictError(
            f"{len(merge.conflicts)} of these changes touch what was changed since revision {base.revision}.",
            remedy="Close this proposal and propose the change again for the current revision.",
            code="changed-meanwhile",
            revision=current.revision,
            conflicts=[vars(conflict) for conflict in merge.conflicts],
        )
    labels = None
    if todo.labels is not None:
        labels = [LabelRequest(name=name, first=first, last=last) for name, first, last in todo.labels]
    moved = {"frames": [_block(values) for values in todo.frames], "labels": labels}
    stated = {name: value for name, value in moved.items() if name in request.model_fields_set}
    return request.model_copy(update=stated)


def _block(values: Values) -> FrameBlock:
    columns = [f"{bone}.{channel}" for bone, channel in values.columns]
    rows = [[None if value != value else value for value in row] for row in values.values.tolist()]
    return FrameBlock(first=values.first, columns=columns, values=rows)
