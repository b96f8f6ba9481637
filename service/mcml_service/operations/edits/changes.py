"""Save all changes of a draft as one revision: test them, merge them with changes by others, and write them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from mcml.errors import ConflictError, DocumentError, McmlError
from mcml_schemas import changes as wire
from mcml_schemas.changes import ChangeSet, ChangesMade, Fault, FrameBlock
from mcml_service.actions.editing.draft_merging import Conflict, Merge
from mcml_service.actions.editing.drafts import Changes, Values, apply_changes
from mcml_service.actions.editing.element_edits import ElementEdit
from mcml_service.operations.arguments import DocumentId, IfMatch, at_revision, tag
from mcml_service.operations.call import Call
from mcml_service.operations.edits.elements import Edit, make_edits
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_TRIED = 200
"""Parts of a request that cannot be made which a dry run tries one by one."""

Part = Literal["elements", "frames", "labels", "document", "all"]


@dataclass
class Wanted:
    """A decoded request, and its unreadable parts."""

    elements: list[tuple[int, list[ElementEdit]]] = field(default_factory=list)
    frames: list[Values] = field(default_factory=list)
    labels: list[tuple[str, int, int]] | None = None
    facts: dict[str, Any] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    @property
    def changes(self) -> Changes:
        return Changes([edit for _, edits in self.elements for edit in edits], self.frames, self.labels, self.facts)

    def parts(self) -> Iterator[tuple[Part, int | None, Changes]]:
        for number, edits in self.elements:
            yield "elements", number, Changes(edits)
        for place, block in enumerate(self.frames):
            yield "frames", place, Changes(frames=[block])
        if self.labels is not None:
            yield "labels", None, Changes(labels=self.labels)
        if self.facts:
            yield "document", None, Changes(facts=self.facts)


def make_changes(
    call: Call,
    id: DocumentId,
    changes: ChangeSet,
    merge: Annotated[
        bool,
        Field(description="If the revision is stale: apply the changes to untouched parts, or 409 with all conflicts"),
    ] = False,
    dry_run: Annotated[bool, Field(description="Report all errors and conflicts without changing anything")] = False,
    if_match: IfMatch = None,
) -> ChangesMade:
    """All, or nothing.

    Values come first, then labels, then elements, then facts. A conflict has the old, the current and the requested
    value (`details.conflicts`); `details.mergeable` lists the other changes.
    """
    edit = Edit(merge=merge, if_match=if_match)
    wanted = read_changes(call, id, changes, edit.base, tell=dry_run)
    if dry_run:
        return _preview(call, id, wanted, edit, changes.message)
    with call.database.write(call.author) as tx:
        stored, base = edit.check(tx, id)
        merging = None if base is None else Merge(*_states(tx, id, base, stored))
        todo = wanted.changes if merging is None else merging.carry_over(wanted.changes)
        if merging is not None and merging.conflicts:
            raise _refuse(merging, stored)
        changed = apply_changes(tx, stored, todo, changes.message)
    call.tag = tag(changed)
    return ChangesMade(revision=changed.revision, frames=changed.frames, merged=merging is not None)


def _preview(call: Call, uuid: str, wanted: Wanted, edit: Edit, message: str) -> ChangesMade:
    with call.database.trial(call.author) as tx:
        stored, base = edit.check(tx, uuid)
        merging = None if base is None else Merge(*_states(tx, uuid, base, stored))
        todo = wanted.changes if merging is None else merging.carry_over(wanted.changes)
        answer = _try(wanted, merging, stored, lambda: apply_changes(tx, stored, todo, message))
    if answer.faults:
        answer.faults = wanted.faults + (_each(call, uuid, wanted, edit) or answer.faults)
    answer.faults = answer.faults or wanted.faults
    return answer


def _states(
    tx: Transaction, uuid: str, base: int, stored: StoredDocument
) -> tuple[Transaction, StoredDocument, Transaction, StoredDocument]:
    return *at_revision(tx, uuid, base), tx, stored


def read_changes(call: Call, uuid: str, changes: ChangeSet, base: int | None, *, tell: bool = False) -> Wanted:
    """Decode a request and resolve its expressions.

    base: the revision that they refer to; default the current one. tell: faults are collected; else the first is
    raised.
    """
    wanted = Wanted()
    for number, item in enumerate(changes.elements):
        with _fault(wanted.faults if tell else None, "elements", number):
            edits = make_edits(call, uuid, item, base, many=changes.many, renumber=changes.renumber)
            wanted.elements.append((number, edits))
    for number, block in enumerate(changes.frames):
        with _fault(wanted.faults if tell else None, "frames", number):
            wanted.frames.append(_values(block))
    if changes.labels is not None:
        wanted.labels = [(item.name, item.first, item.last) for item in changes.labels]
    if changes.document is not None:
        wanted.facts = changes.document.model_dump(exclude_unset=True, exclude={"message", "properties"})
        wanted.facts = {name: value for name, value in wanted.facts.items() if value is not None}
        if changes.document.properties is not None:
            wanted.facts["properties"] = [(item.name, item.value, item.unit) for item in changes.document.properties]
    return wanted


def _values(block: FrameBlock) -> Values:
    columns = [(text.rpartition(".")[0], text.rpartition(".")[2]) for text in block.columns]
    if block.data is not None:
        numbers = np.frombuffer(block.data, "<f8") if len(block.data) % 8 == 0 else np.empty(0)
        rows = [numbers] if numbers.size == 0 or numbers.size % len(columns) else numbers.reshape(-1, len(columns))
    else:
        rows = [np.array([math.nan if value is None else value for value in row]) for row in block.values or ()]
    if not len(rows) or {len(row) for row in rows} != {len(columns)}:
        raise DocumentError(
            f"{len(columns)} columns are named, and some rows have another number of values.",
            remedy="Send a value for each column; null leaves it as it is.",
        )
    return Values(block.first, columns, np.array(rows, np.float64))


def _try(
    wanted: Wanted, merging: Merge | None, stored: StoredDocument, make: Callable[[], StoredDocument]
) -> ChangesMade:
    answer = ChangesMade(revision=stored.revision, frames=stored.frames, merged=merging is not None)
    if merging is not None:
        answer.conflicts = [wire.Conflict(**vars(conflict)) for conflict in merging.conflicts]
        answer.mergeable = merging.mergeable
    with _fault(answer.faults, "all", None):
        answer.frames = make().frames
    return answer


def _each(call: Call, uuid: str, wanted: Wanted, edit: Edit) -> list[Fault]:
    """The faults of each part that cannot be made alone."""
    faults: list[Fault] = []
    for place, (part, number, changes) in enumerate(wanted.parts()):
        if place >= MOST_TRIED:
            break
        with call.database.trial(call.author) as tx:
            stored, base = edit.check(tx, uuid)
            with _fault(faults, part, number):
                todo = changes if base is None else Merge(*_states(tx, uuid, base, stored)).carry_over(changes)
                apply_changes(tx, stored, todo)
    return faults


@contextmanager
def _fault(faults: list[Fault] | None, part: Part, number: int | None) -> Iterator[None]:
    """Errors of a part are noted, where they are to be collected."""
    try:
        yield
    except McmlError as error:
        if faults is None:
            raise
        at = error.at
        place = (None, None, None) if at is None else (at.line, at.column, at.element)
        line, column, address = place
        faults.append(
            Fault(
                part=part,
                number=number,
                what=error.what,
                line=line,
                column=column,
                address=address,
                remedy=error.remedy,
            )
        )


def _refuse(merging: Merge, stored: StoredDocument) -> ConflictError:
    count = len(merging.conflicts)
    return ConflictError(
        f"The document is at revision {stored.revision}: {count} of these changes touch what was changed meanwhile.",
        remedy="Decide about each conflict, and send the changes again for the present revision.",
        code="changed-meanwhile",
        revision=stored.revision,
        conflicts=[_conflict(conflict) for conflict in merging.conflicts],
        mergeable=merging.mergeable,
    )


def _conflict(one: Conflict) -> dict[str, Any]:
    return wire.Conflict(**vars(one)).model_dump()
