"""All changes of a draft as one revision: values of frames, labels, elements, facts.

All, or none. Everything refers to the document before the first change. Values are written first, then labels, then
elements from the end of the document to its beginning, then facts: so no change moves the target of another one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from mcml.language import motion_names
from mcml.motion.skeleton import Array
from mcml_service.actions.editing.element_edits import ElementEdit, describe_edits, make_edits
from mcml_service.actions.editing.frame_ranges import write_values
from mcml_service.actions.editing.frame_splicing import check_range
from mcml_service.actions.editing.whole_document import set_facts
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.transaction import Transaction

Label = tuple[str, int, int]
"""(name, first, last)."""


@dataclass(frozen=True)
class Values:
    """Samples of consecutive frames. columns: (bone, channel) of each column of values, (n, D); NaN: unchanged."""

    first: int
    columns: list[tuple[str, str]]
    values: Array


@dataclass(frozen=True)
class Changes:
    """The changes of a draft. labels: the complete new list, None to keep them. facts: as for `set_facts`."""

    elements: Sequence[ElementEdit] = ()
    frames: Sequence[Values] = ()
    labels: Sequence[Label] | None = None
    facts: dict[str, Any] = field(default_factory=dict)


def apply_changes(tx: Transaction, stored: StoredDocument, changes: Changes, message: str = "") -> StoredDocument:
    """Make them, as one revision. The same document where nothing was to change."""
    told = []
    for block in changes.frames:
        if write_values(tx, stored, block.first, block.columns, block.values, some=True):
            names = ", ".join(".".join(column) for column in block.columns[:4])
            told.append(f"set {names} of frames {block.first} to {block.first + len(block.values) - 1}")
    if changes.labels is not None:
        told += set_labels(tx, stored, changes.labels)
    if changes.elements:
        make_edits(tx, tx.documents.get(stored.uuid), changes.elements)
        told.append(describe_edits(changes.elements))
    facts = set_facts(tx, tx.documents.get(stored.uuid), **changes.facts)
    if facts:
        told.append(f"changed {', '.join(facts)}")
    if not told:
        return stored
    tx.documents.add_revision(stored, "edit", message or ", ".join(told)[:400])
    return tx.documents.get(stored.uuid)


def set_labels(tx: Transaction, stored: StoredDocument, labels: Sequence[Label]) -> list[str]:
    """Set the labels of a document to these; existing ones stay. Returns a description."""
    wanted: Counter[Label] = Counter()
    for name, first, last in labels:
        check_range(stored, first, last)
        wanted[motion_names.canonical(name), first, last] += 1
    gone: list[StoredSpan] = []
    for span in tx.spans.of(stored.key):
        key = (span.name, span.first, span.last)
        if wanted[key] > 0:
            wanted[key] -= 1
        else:
            gone.append(span)
    tx.spans.close([span.key for span in gone])
    added = list(wanted.elements())
    for name, first, last in added:
        tx.spans.add(stored.key, name, first, last)
    told = [f"unnamed {span.name} {span.first}-{span.last}" for span in gone]
    return told + [f"named {name} {first}-{last}" for name, first, last in added]
