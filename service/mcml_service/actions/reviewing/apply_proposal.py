"""Apply a proposed change to a document, as one revision."""

from __future__ import annotations

from dataclasses import dataclass

from mcml_schemas.frames import FrameEdits, InsertFrames
from mcml_service.actions.editing.drafts import Changes, apply_changes
from mcml_service.actions.editing.edit_report import EditReport
from mcml_service.actions.editing.frame_ranges import edit_frames
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


@dataclass(frozen=True)
class Proposed:
    """A change that may be applied: edits of frame ranges, or changes of values, labels, elements and facts."""

    edits: FrameEdits | None
    changes: Changes | None
    message: str = ""


def apply_proposed(
    tx: Transaction, stored: StoredDocument, proposed: Proposed, report: EditReport, message: str
) -> StoredDocument:
    """Apply a change by the same edits as a direct change of the document; return the changed document.

    message: for the history; empty: the change in words.
    """
    if proposed.edits is not None:
        return edit_frames(tx, stored, proposed.edits.model_copy(update={"message": message}), report)
    before = tx.tracks.pieces(stored.key, 1, stored.frames)
    changed = apply_changes(tx, stored, proposed.changes or Changes(), message)
    report.follow(before, tx.tracks.pieces(stored.key, 1, changed.frames))
    return changed


def find_inputs(tx: Transaction, proposed: Proposed) -> dict[str, int]:
    """Return the current revisions of other documents whose frames a change inserts, by their ids.

    Raises NotFoundError for documents that the user does not see.
    """
    edits = [] if proposed.edits is None else proposed.edits.edits
    uuids = {edit.document for edit in edits if isinstance(edit, InsertFrames) and edit.document is not None}
    return {uuid: tx.documents.get(uuid).revision for uuid in sorted(uuids)}
