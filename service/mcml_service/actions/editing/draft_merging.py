"""Merge changes for an older revision into the current one: changes of items that nobody else has changed since are
applied, all others are conflicts, with the old, the current and the requested value.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import DocumentError, NotFoundError
from mcml.language import motion_names
from mcml.language.addresses import address_attribute, address_frame, find_frame, move_frame
from mcml.language.elements import to_head
from mcml.motion.skeleton import CHANNEL_INDEX, Array
from mcml.numerics.runs import find_true
from mcml_service.actions.editing.drafts import Changes, Label, Values
from mcml_service.actions.editing.element_edits import ElementEdit
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.reading.read_element import read_element
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.timelines import common_frames
from mcml_service.storage.transaction import Transaction

MOST_VALUES = 1000
"""Limit of values reported for a conflict."""


@dataclass(frozen=True)
class Conflict:
    """A conflict.

    kind: element, frames, label or fact. address: of the element or other item. base, theirs, mine: the old, the
    current and the requested value. first, last: frames, in the current revision.
    """

    kind: str
    address: str
    base: Any
    theirs: Any
    mine: Any
    first: int | None = None
    last: int | None = None


@dataclass(frozen=True)
class _State:
    tx: Transaction
    stored: StoredDocument

    def read(self, address: str) -> str | None:
        try:
            return read_element(self.tx, self.stored, address).decode()
        except (NotFoundError, DocumentError):
            return None


class Merge:
    """A merge of changes.

    then, base: the document at the revision of the changes. now, current: the current document.
    """

    def __init__(self, then: Transaction, base: StoredDocument, now: Transaction, current: StoredDocument) -> None:
        self.then, self.now = _State(then, base), _State(now, current)
        self.conflicts: list[Conflict] = []
        self.mergeable: list[str] = []
        # The current position of each frame of `then`, from 1; 0 for deleted ones.
        self._moved = np.zeros(base.frames + 1, np.int64)
        runs = common_frames(
            then.tracks.pieces(base.key, 1, base.frames), now.tracks.pieces(current.key, 1, current.frames)
        )
        for run in runs:
            self._moved[run.before : run.before + run.count] = run.after + np.arange(run.count)

    def carry_over(self, changes: Changes) -> Changes:
        """Return the changes for the current revision; `conflicts` has those that cannot be merged."""
        return Changes(
            [moved for edit in changes.elements for moved in self._element(edit)],
            [moved for block in changes.frames for moved in self._values(block)],
            None if changes.labels is None else self._labels(changes.labels),
            dict(self._facts(changes.facts)),
        )

    def _element(self, edit: ElementEdit) -> Iterator[ElementEdit]:
        position = find_frame(edit.address)
        moved = edit.address
        if position is not None:
            to = int(self._moved[position]) if position < len(self._moved) else 0
            if not to:
                self._conflict("element", edit.address, self.then.read(edit.address), None, _describe(edit))
                return
            moved = move_frame(edit.address, to)
        parts = [""]
        if isinstance(edit.what, Change) and edit.what.text is None and "/@" not in edit.address:
            # Others may have set other attributes of the same element.
            parts = list(edit.what.attributes)
        for part in parts:
            before, after = (
                state.read(address_attribute(address, part) if part else address)
                for state, address in ((self.then, edit.address), (self.now, moved))
            )
            mine = edit.what.attributes[part] if part and isinstance(edit.what, Change) else _describe(edit)
            if before != after and after != mine:
                self._conflict("element", address_attribute(moved, part) if part else moved, before, after, mine)
                return
        self.mergeable.append(moved)
        yield replace(edit, address=moved)

    def _values(self, block: Values) -> Iterator[Values]:
        last = block.first + len(block.values) - 1
        base = _samples(self.then, block.first, last, block.columns)
        wanted = np.where(np.isnan(block.values), base, block.values)
        mine = ~_same(wanted, base)
        places = self._moved[block.first : last + 1]
        for start, stop in _neighbours(places):
            to = int(places[start])
            rows = slice(start, stop)
            if not to:
                if mine[rows].any():
                    address = address_frame(block.first + start)
                    self._conflict("frames", address, _list_values(base[rows]), None, _list_values(wanted[rows]))
                continue
            theirs = _samples(self.now, to, to + stop - start - 1, block.columns)
            fought = mine[rows] & ~_same(theirs, base[rows]) & ~_same(theirs, wanted[rows])
            for column, name in enumerate(block.columns):
                for first, end in find_true(fought[:, column]):
                    some = slice(start + first, start + end)
                    self.conflicts.append(
                        Conflict(
                            "frames",
                            ".".join(name),
                            _list_values(base[some, column]),
                            _list_values(theirs[first:end, column]),
                            _list_values(wanted[some, column]),
                            to + first,
                            to + end - 1,
                        )
                    )
            kept = mine[rows] & ~fought
            if kept.any():
                names = [".".join(name) for column, name in enumerate(block.columns) if kept[:, column].any()]
                self.mergeable.append(f"{', '.join(names)} {to}-{to + stop - start - 1}")
                yield Values(to, block.columns, np.where(kept, wanted[rows], np.nan))

    def _labels(self, labels: Sequence[Label]) -> list[Label]:
        """Return the current labels, without removed and with added ones."""
        wanted = [moved for label in labels if (moved := self._label(motion_names.canonical(label[0]), *label[1:]))]
        base = [
            moved
            for span in self.then.tx.spans.of(self.then.stored.key)
            if (moved := self._label(span.name, span.first, span.last))
        ]
        theirs = [(span.name, span.first, span.last) for span in self.now.tx.spans.of(self.now.stored.key)]
        added, taken = _without(wanted, base), _without(base, wanted)
        their_added, their_taken = _without(theirs, base), _without(base, theirs)
        for label in taken:
            if label in their_taken and (other := _like(label, their_added)):
                mine = _like(label, added)
                if mine != other:
                    self.conflicts.append(Conflict("label", label[0], label[1:], other, mine, label[1], label[2]))
        for label in [*taken, *added]:
            self.mergeable.append(f"{label[0]} {label[1]}-{label[2]}")
        return [label for label in theirs if label not in taken] + _without(added, theirs)

    def _label(self, name: str, first: int, last: int) -> Label | None:
        """Return the current place of a label; None if none of its frames exists any more."""
        places = self._moved[first : last + 1]
        places = places[places > 0]
        return (name, int(places.min()), int(places.max())) if len(places) else None

    def _facts(self, facts: dict[str, Any]) -> Iterator[tuple[str, Any]]:
        before, after = _facts_of(self.then), _facts_of(self.now)
        for name, wanted in facts.items():
            mine = [list(item) for item in wanted] if name == "properties" else wanted
            if before[name] == mine:
                continue
            if before[name] != after[name] and after[name] != mine:
                self._conflict("fact", name, before[name], after[name], mine)
                continue
            self.mergeable.append(name)
            yield name, wanted

    def _conflict(self, kind: str, address: str, base: Any, theirs: Any, mine: Any) -> None:
        self.conflicts.append(Conflict(kind, address, base, theirs, mine))


def _facts_of(state: _State) -> dict[str, Any]:
    stored = state.stored
    head = to_head(state.tx.heads.document(stored), stored.frame_time)
    return {
        "name": stored.name,
        "project": stored.project,
        "description": head.description,
        "properties": [list(item) for item in head.properties],
        "unit": head.fields.get("calibration_unit", ""),
        "up": head.fields.get("global_axis_of_gravity", ""),
        "frame_time": stored.frame_time,
    }


def _samples(state: _State, first: int, last: int, columns: Sequence[tuple[str, str]]) -> Array:
    """Return (n, D) samples of frames first to last, NaN for missing samples or bones."""
    numbers = {name: number for number, name in state.tx.heads.bone_names(state.stored.key).items()}
    wanted = [(numbers.get(bone, -1), CHANNEL_INDEX.get(channel, -1)) for bone, channel in columns]
    samples = np.full((last - first + 1, len(columns)), np.nan)
    bones = sorted({bone for bone, _ in wanted if bone >= 0})
    at = 0
    for block in state.tx.tracks.blocks(state.stored.key, first, last, bones=bones):
        place = {column: index for index, column in enumerate(block.columns)}
        for index, column in enumerate(wanted):
            if column in place:
                samples[at : at + len(block), index] = block.values[:, place[column]]
        at += len(block)
    return samples


def _same(one: Array, other: Array) -> NDArray[np.bool_]:
    equal: NDArray[np.bool_] = (one == other) | (np.isnan(one) & np.isnan(other))
    return equal


def _neighbours(places: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """(start, stop) of runs of frames that are still neighbours, or are all gone."""
    steps = np.diff(places)
    breaks = np.flatnonzero((steps != 1) & ~((steps == 0) & (places[1:] == 0))) + 1
    ends = [0, *breaks.tolist(), len(places)]
    yield from pairwise(ends)


def _list_values(values: Array) -> list[Any]:
    listed: list[Any] = values[:MOST_VALUES].tolist()
    return listed


def _without(labels: Sequence[Label], others: Sequence[Label]) -> list[Label]:
    left = list(others)
    rest = []
    for label in labels:
        if label in left:
            left.remove(label)
        else:
            rest.append(label)
    return rest


def _like(label: Label, others: Sequence[Label]) -> Label | None:
    """The label that one has become: of the same name over some of its frames."""
    return next(
        (other for other in others if other[0] == label[0] and other[1] <= label[2] and label[1] <= other[2]), None
    )


def _describe(edit: ElementEdit) -> Any:
    return {"attributes": edit.what.attributes, "text": edit.what.text} if isinstance(edit.what, Change) else None
