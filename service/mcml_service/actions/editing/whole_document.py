"""Changes of a document as a whole: its facts, its labels, deletion, restoring a revision. Each makes a revision."""

from __future__ import annotations

from collections.abc import Iterable

from mcml.errors import ConflictError, DocumentError, NotFoundError
from mcml.files.check_names import check_frame_time, given_name
from mcml.files.edit_header import with_facts
from mcml.formats import READERS
from mcml.language import motion_names
from mcml.language.elements import Element
from mcml_service.storage.core.identifiers import normalise_name
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.rows import skeleton_rows
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.undo.restoring import reopen_rows
from mcml_service.storage.undo.undoing import undo_rows

_HELD_BY_MCML = frozenset({"unit", "up", "frame_time", "description", "properties"})


def change_document(
    tx: Transaction,
    stored: StoredDocument,
    *,
    message: str = "",
    name: str | None = None,
    project: str | None = None,
    description: str | None = None,
    properties: Iterable[tuple[str, str, str]] | None = None,
    unit: str | None = None,
    up: str | None = None,
    frame_time: str | float | None = None,
) -> StoredDocument:
    """Set the given facts (None keeps a fact) as one revision; return the changed document."""
    changed = set_facts(
        tx,
        stored,
        name=name,
        project=project,
        description=description,
        properties=properties,
        unit=unit,
        up=up,
        frame_time=frame_time,
    )
    if not changed:
        return stored
    tx.documents.add_revision(stored, "change", message or f"changed {', '.join(changed)}")
    return tx.documents.get(stored.uuid)


def set_facts(
    tx: Transaction,
    stored: StoredDocument,
    *,
    name: str | None = None,
    project: str | None = None,
    description: str | None = None,
    properties: Iterable[tuple[str, str, str]] | None = None,
    unit: str | None = None,
    up: str | None = None,
    frame_time: str | float | None = None,
) -> list[str]:
    """As `change_document`, but the caller makes the revision; answers which facts were given."""
    if name is not None:
        tx.documents.rename(stored.key, given_name(name, "document"))
    if project is not None and normalise_name(given_name(project, "project")) != stored.project:
        move_to_project(tx, stored, project)
    facts = {"description": description, "properties": properties, "unit": unit, "up": up}
    changed = {key for key, value in facts.items() if value is not None}
    if changed:
        document = with_facts(
            tx.heads.document(stored), description=description, properties=properties, unit=unit, up=up
        )
        tx.heads.write_header(stored.key, document.children[0], tx.commit)
    if frame_time is not None:
        frame_time = check_frame_time(frame_time)
        changed.add("frame_time")
    # After a change of what the source format itself holds, an export may no longer answer the kept bytes.
    touched = changed & (_HELD_BY_MCML if stored.format == "mcml" else READERS[stored.format].states)
    if changed or project is not None:
        rate = {} if frame_time is None else {"frame_time": frame_time}
        tx.documents.write_content(stored.key, tx.commit, **rate, intact=stored.intact and not touched)
    return sorted(changed | ({"name"} if name is not None else set()) | ({"project"} if project is not None else set()))


def move_to_project(tx: Transaction, stored: StoredDocument, project: str) -> None:
    """Skeletons are shared inside one project, so a move takes a copy of the skeleton along."""
    key = tx.projects.get_or_add(given_name(project, "project"))
    forest = tx.heads.skeleton(stored.skeleton)
    skeleton = tx.heads.add_skeleton(key, skeleton_rows(forest), _joints(forest))
    tx.documents.move(stored.key, key)
    tx.documents.write_content(stored.key, tx.commit, skeleton=skeleton)


def _joints(forest: list[Element]) -> int:
    waiting, count = list(forest), 0
    while waiting:
        element = waiting.pop()
        count += element.tag in ("root", "bone")
        waiting += element.children
    return count


def delete_document(tx: Transaction, stored: StoredDocument) -> None:
    tx.documents.delete(stored.key)
    tx.documents.add_revision(stored, "delete")


def restore_document(tx: Transaction, stored: StoredDocument) -> StoredDocument:
    """Restore a deleted document."""
    if tx.documents.find(stored.uuid) is not None:
        raise ConflictError("The document is not deleted.", remedy="Say which `revision` to restore.")
    tx.documents.undelete(stored.key)
    tx.documents.add_revision(stored, "restore")
    return tx.documents.get(stored.uuid)


def restore_revision(tx: Transaction, stored: StoredDocument, number: int) -> StoredDocument:
    """Make the document what it was at an earlier revision, name and project too, as a new revision."""
    tx.documents.undelete(stored.key)
    commit = tx.documents.commit_of(stored.key, number)
    then = tx.at_commit(commit).documents.get(stored.uuid, deleted=True)
    tx.documents.rename(stored.key, then.name)
    # With its project comes its skeleton, which only documents of that project share.
    tx.documents.move(stored.key, then.project_key)
    reopen_rows(tx, stored, commit)
    tx.documents.add_revision(stored, "restore", f"restored revision {number}")
    return tx.documents.get(stored.uuid)


def undo_revision(tx: Transaction, stored: StoredDocument, number: int) -> StoredDocument:
    """Revert the changes of one revision, as a new revision; later ones stay.

    Raises ConflictError if they changed the same items, or for the first revision.
    """
    undone = next(iter(tx.revisions.of(stored.key, before=number + 1, limit=1)), None)
    if undone is None or undone.number != number:
        raise NotFoundError(f"The document has no revision {number}.", remedy="List its revisions.")
    if undone.parent is None:
        raise ConflictError(
            "Nothing before this revision is kept: it is the document itself.", remedy="Delete the document instead."
        )
    if undone.operation in ("delete", "restore"):
        raise ConflictError(
            f"A revision of kind {undone.operation!r} cannot be reverted.", remedy="Restore the revision you want."
        )
    (before,) = tx.revisions.of(stored.key, before=number, limit=1)
    if before.name != undone.name:
        if stored.name != undone.name:
            raise ConflictError("The document was renamed since.", remedy="Rename it yourself.")
        tx.documents.rename(stored.key, before.name)
    if before.project != undone.project:
        raise ConflictError("A move to another project cannot be reverted.", remedy="Move the document yourself.")
    undo_rows(tx, stored, undone.commit)
    tx.documents.add_revision(stored, "undo", f"took back revision {number}")
    return tx.documents.get(stored.uuid)


def add_labels(
    tx: Transaction, stored: StoredDocument, labels: Iterable[tuple[str, int, int]], *, strict: bool = False
) -> list[StoredSpan]:
    """Name frames first to last of each (name, first, last). Names are stored canonically; VocabularyError."""
    added = []
    for name, first, last in labels:
        if not 1 <= first <= last <= stored.frames:
            raise DocumentError(
                f"Frames {first} to {last} are not in a document of {stored.frames} frames.",
                remedy="Frame numbers are positions, from 1, both ends included.",
            )
        added.append(tx.spans.add(stored.key, motion_names.canonical(name, strict=strict), first, last))
    if added:
        tx.documents.add_revision(stored, "label", ", ".join(sorted({span.name for span in added}))[:200])
    return added


def remove_labels(tx: Transaction, stored: StoredDocument, key: int) -> None:
    """Remove one span by its number; NotFoundError."""
    spans = [span for span in tx.spans.of(stored.key) if span.key == key]
    if not spans:
        raise NotFoundError(f"The document has no label {key}.", remedy="List its labels; numbers change with edits.")
    tx.spans.close([key])
    tx.documents.add_revision(stored, "unlabel", spans[0].name)
