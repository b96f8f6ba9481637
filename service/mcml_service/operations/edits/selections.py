"""Many documents at once: hidden, brought back, changed, copied. All of them, or none."""

from __future__ import annotations

from mcml_schemas.documents import ChangedDocuments
from mcml_schemas.jobs import Selection
from mcml_schemas.selections import CopiedDocuments, ManyChanges, ManyCopies, ManyDocuments
from mcml_service.actions.editing import whole_document as changes
from mcml_service.actions.labelling import edit_labels
from mcml_service.operations.call import Call
from mcml_service.operations.documents import describe_changed
from mcml_service.storage.documents.documents import StoredDocument


def delete_documents(call: Call, selection: Selection) -> ChangedDocuments:
    """Nothing is lost: `POST /selections/restore` with the ids that are answered brings them back. An import is undone
    so, with the ids of its answer.
    """
    done: list[StoredDocument] = []

    def delete() -> None:
        uuids = _choose(call, selection)
        done.clear()
        with call.database.write(call.author) as tx:
            for uuid in uuids:
                stored = tx.documents.get(uuid)
                tx.documents.lock(stored.key)
                changes.delete_document(tx, stored)
                done.append(tx.documents.get(uuid, deleted=True))

    call.database.reserve.spend(delete)
    return describe_changed(done)


def restore_documents(call: Call, request: ManyDocuments) -> ChangedDocuments:
    """Documents that are not deleted do not change."""
    done = []
    with call.database.write(call.author) as tx:
        for uuid in dict.fromkeys(request.documents):
            stored = tx.documents.get(uuid, deleted=True)
            tx.documents.lock(stored.key)
            if tx.documents.find(uuid) is None:
                done.append(changes.restore_document(tx, stored))
    return describe_changed(done)


def copy_documents(call: Call, request: ManyCopies) -> CopiedDocuments:
    """Copies include the whole histories and the uploaded files. The target may be another project or the same one."""
    # Imported here: other operations move no rows.
    from mcml_service.storage.upkeep.project_rows import copy_document

    uuids = _choose(call, request.selection)
    with call.database.write(call.author) as tx:
        tx.order()
        project = tx.projects.get_or_add(request.project)
        made = [copy_document(tx, tx.documents.get(uuid).key, project) for uuid in uuids]
        for uuid in made:
            tx.activity.note("document", "copy", project_key=project, document=uuid)
        tx.quotas.require_room(project)
    return CopiedDocuments(documents=made)


def change_documents(call: Call, request: ManyChanges) -> ChangedDocuments:
    """Each is one revision, which `undo` takes back; a document that already is so makes none."""
    uuids = _choose(call, request.selection)
    facts = request.change.model_dump(exclude_unset=True, exclude={"message", "properties", "name"})
    facts = {name: value for name, value in facts.items() if value is not None}
    if request.change.properties is not None:
        facts["properties"] = [(item.name, item.value, item.unit) for item in request.change.properties]
    done = []
    with call.database.write(call.author) as tx:
        for uuid in uuids:
            stored = tx.documents.get(uuid)
            tx.documents.lock(stored.key)
            told = changes.set_facts(tx, stored, **facts)
            for label in request.labels:
                last = stored.frames if label.last is None else min(label.last, stored.frames)
                if label.first <= last:
                    told += edit_labels.name_frames(tx, stored, label.name, label.first, last)
            if told:
                tx.documents.add_revision(stored, "change", request.change.message or ", ".join(told)[:200])
                done.append(tx.documents.get(uuid))
    return describe_changed(done)


def _choose(call: Call, selection: Selection) -> list[str]:
    # Imported here: it takes all that analyses need.
    from mcml_service.actions.composing.select_documents import select_documents

    uuids, _ = select_documents(call.database, call.queries, selection)
    return [str(item["document"]) for item in uuids]
