"""List the children of one element, page by page: only the requested frames are read, for a motion of any length."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcml.language.addresses import MOTION, address_frame, number_steps, read_frame_address
from mcml.language.elements import Element
from mcml.language.vocabulary import FRAME, FRAME_BONE, FRAMES, FRAMETIME
from mcml_service.actions.reading.read_element import element_at, frame_at
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

ROOT = "/mcml"


@dataclass(frozen=True)
class Child:
    """An element without what is in it. children: how many it has."""

    address: str
    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    text: str = ""
    children: int = 0


def list_children(
    tx: Transaction, stored: StoredDocument, address: str, first: int, limit: int
) -> tuple[int, list[Child]]:
    """Return (the number of children, those from number `first` on, from 1).

    Raises NotFoundError if the element does not exist.
    """
    start, stop = first - 1, first - 1 + limit
    if address == MOTION:
        leaves = _leaves(stored)
        low, high = max(start - len(leaves), 0), min(stop - len(leaves), stored.frames)
        return len(leaves) + stored.frames, leaves[start:stop] + _frames(tx, stored, low + 1, high)
    if address == ROOT:
        document = tx.heads.document(stored)
        motion = Child(MOTION, "motion", children=len(_leaves(stored)) + stored.frames)
        return len(document.children) + 1, [*_below(document, ROOT), motion][start:stop]
    place = read_frame_address(address)
    element = frame_at(tx, stored, place.frame) if place and not place.tag else element_at(tx, stored, address)
    return len(element.children), _below(element, address)[start:stop]


def _below(element: Element, address: str) -> list[Child]:
    always = (FRAME_BONE,) if element.tag == FRAME else ()
    steps = number_steps([child.tag for child in element.children], always)
    return [
        Child(f"{address}/{step}", child.tag, child.attributes, child.text, len(child.children))
        for step, child in zip(steps, element.children, strict=True)
    ]


def _leaves(stored: StoredDocument) -> list[Child]:
    """Return the children of a motion before its frames."""
    leaves = [Child(f"{MOTION}/{FRAMES}", FRAMES, text=str(stored.frames))]
    if stored.frame_time is not None:
        leaves.append(Child(f"{MOTION}/{FRAMETIME}", FRAMETIME, text=stored.frame_time))
    return leaves


def _frames(tx: Transaction, stored: StoredDocument, first: int, last: int) -> list[Child]:
    if last < first:
        return []
    ids = tx.tracks.frame_ids(stored.key, first, last)
    counts = children_of_frames(tx, stored, first, last).tolist()
    return [
        Child(address_frame(first + index), FRAME, {"id": str(name)}, children=counts[index])
        for index, name in enumerate(ids)
    ]


def children_of_frames(tx: Transaction, stored: StoredDocument, first: int, last: int) -> NDArray[np.int64]:
    """How many motion_names and frame_bones each of the frames first to last has."""
    runs = list(tx.tracks.frame_bones(stored.key, first, last))
    counts = np.repeat([bones for _, bones in runs], [frames for frames, _ in runs]).astype(np.int64)
    changes = np.zeros(last - first + 2, np.int64)
    for span in tx.spans.of(stored.key, first, last):
        changes[max(span.first, first) - first] += 1
        changes[min(span.last, last) - first + 1] -= 1
    return counts + np.cumsum(changes)[:-1]
