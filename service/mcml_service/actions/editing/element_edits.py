"""Several elements edited as one revision: all, or none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcml.errors import ConflictError, DocumentError, NotFoundError, Place
from mcml.language.addresses import (
    MOTION,
    address_attribute,
    address_frame,
    find_frame,
    move_frame,
    read_frame_address,
    split_attribute,
)
from mcml.language.element import Element, addresses
from mcml_service.actions.editing.element_insertion import Where, insert_elements, replace_element
from mcml_service.actions.editing.frame_splicing import counts_up
from mcml_service.actions.editing.single_element import Change, apply_change, apply_deletion
from mcml_service.actions.reading.read_element import read_element
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.timelines import common_frames
from mcml_service.storage.transaction import Transaction

_KINDS = ("", "motion_name", "frame_bone")


@dataclass(frozen=True)
class Insertion:
    """An insertion. where: beside the element at the address, or into it."""

    where: Where
    elements: tuple[Element, ...]
    renumber: bool = True


@dataclass(frozen=True)
class Replacement:
    elements: tuple[Element, ...]


@dataclass(frozen=True)
class Deletion:
    """renumber: ids of frames that counted up by one do so again behind a frame that goes; else they keep theirs."""

    renumber: bool = False


What = Change | Insertion | Replacement | Deletion


@dataclass(frozen=True)
class ElementEdit:
    """address: canonical, as the document is before any of the edits."""

    address: str
    what: What


def edit_elements(
    tx: Transaction, stored: StoredDocument, edits: Sequence[ElementEdit], message: str = "", *, gapless: bool = False
) -> StoredDocument:
    """Make all edits, as one revision. They are made from the end of the document to its beginning, so that none moves
    what another one means; those at one address in the order given.

    gapless: DocumentError where the ids of frames do not count up by one afterwards.
    """
    if not edits:
        raise NotFoundError("The expression selects nothing.", remedy="Try it with GET /xpath first.")
    make_edits(tx, stored, edits)
    if gapless:
        _check_ids(tx, tx.documents.get(stored.uuid))
    tx.documents.add_revision(stored, "edit", message or describe_edits(edits))
    return tx.documents.get(stored.uuid)


def make_edits(tx: Transaction, stored: StoredDocument, edits: Sequence[ElementEdit]) -> None:
    """Make all edits; the caller makes the revision."""
    counting = counts_up(tx, stored)
    order = {address: place for place, (address, _) in enumerate(addresses(tx.heads.document(stored)))}
    for edit in sorted(edits, key=lambda edit: _place(edit.address, order), reverse=True):
        _make(tx, tx.documents.get(stored.uuid), edit, counting)


def _make(tx: Transaction, stored: StoredDocument, edit: ElementEdit, counting: bool) -> None:
    """counting: whether the ids of frames counted up by one before the first edit."""
    if isinstance(edit.what, Change):
        apply_change(tx, stored, edit.address, edit.what)
    elif isinstance(edit.what, Insertion):
        what = edit.what
        insert_elements(tx, stored, edit.address, what.where, list(what.elements), renumber=what.renumber and counting)
    elif isinstance(edit.what, Replacement):
        replace_element(tx, stored, edit.address, list(edit.what.elements))
    else:
        apply_deletion(tx, stored, edit.address, renumber=edit.what.renumber and counting)


def _check_ids(tx: Transaction, stored: StoredDocument) -> None:
    ids = tx.tracks.frame_ids(stored.key, 1, stored.frames)
    if not isinstance(ids, np.ndarray):
        raise DocumentError("Ids of frames are not all whole numbers.", remedy="Allow gaps, or change the ids first.")
    gaps = np.flatnonzero(np.diff(ids) != 1)
    if len(gaps):
        place = int(gaps[0])
        raise DocumentError(
            f"Frame {ids[place]} would be followed by frame {ids[place + 1]}.",
            at=Place(element=address_attribute(address_frame(place + 2), "id")),
            remedy="Renumber the frames, or allow gaps.",
        )


def describe_edits(edits: Sequence[ElementEdit]) -> str:
    """Describe edits for the history."""
    words = {Change: "changed", Insertion: "inserted at", Replacement: "replaced", Deletion: "deleted"}
    told = ", ".join(f"{words[type(edit.what)]} {edit.address}" for edit in edits[:3])
    return told + (f" and {len(edits) - 3} more" if len(edits) > 3 else "")


def _place(address: str, order: dict[str, int]) -> tuple[int, int, int, int]:
    """Return the sort key of an address in document order: head, then frames, in them names, then frame_bones."""
    place = read_frame_address(address)
    if place is None:
        return (1 if address.startswith(MOTION) else 0, order.get(split_attribute(address)[0], 0), 0, 0)
    return 2, place.frame, _KINDS.index(place.tag), place.number


def carry_over(
    then: Transaction, base: StoredDocument, now: Transaction, current: StoredDocument, addresses_then: Sequence[str]
) -> list[str]:
    """Return the current addresses of elements that nobody has changed since a revision.

    Raises ConflictError, with the old and the current element, if an element was changed or its frame deleted.
    """
    runs = common_frames(
        then.tracks.pieces(base.key, 1, base.frames), now.tracks.pieces(current.key, 1, current.frames)
    )
    result = []
    for address in addresses_then:
        position = find_frame(address)
        moved = address
        if position is not None:
            run = next((run for run in runs if run.before <= position < run.before + run.count), None)
            if run is None:
                raise _conflict(address, _read(then, base, address), None)
            moved = move_frame(address, run.after + position - run.before)
        before, after = _read(then, base, address), _read(now, current, moved)
        if before != after:
            raise _conflict(address, before, after)
        result.append(moved)
    return result


def _read(tx: Transaction, stored: StoredDocument, address: str) -> str | None:
    try:
        return read_element(tx, stored, address).decode()
    except (NotFoundError, DocumentError):
        return None


def _conflict(address: str, before: str | None, after: str | None) -> ConflictError:
    return ConflictError(
        f"{address} was changed since: it was {_short(before)}, it is {_short(after)}.",
        at=Place(element=address),
        remedy="Read the document again and decide.",
        code="changed-meanwhile",
        before=before,
        after=after,
    )


def _short(text: str | None) -> str:
    return "gone" if text is None else text if len(text) <= 300 else text[:300] + "…"
