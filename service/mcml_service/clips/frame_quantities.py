"""Quantities of the frames of a stored document that positions of joints do not tell."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from mcml.errors import DocumentError, FormatError, LimitError, NotFoundError
from mcml.formats.measurements import Measurements, has_capture_numbers
from mcml.laboratory.measure_gait import find_walker
from mcml.language.elements import to_head
from mcml.motion.bodies.quantities import AskedQuantity
from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import Body, read_turned
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def is_beside_positions(asked: AskedQuantity) -> bool:
    """Whether `read_quantity` reads it: it takes rotations, or the file states it."""
    return asked.of_file or asked.needs_rotations


def read_quantity(tx: Transaction, stored: StoredDocument | Listed, asked: AskedQuantity, body: Body) -> Array:
    """(n,) of all frames, NaN where unknown. body: of the document.

    Raises NotFoundError for a measurement that it has not, DocumentError for forces on feet that are unknown.
    """
    if not asked.of_file:
        return read_turned(tx, stored, asked.arguments[0], body)
    head = to_head(tx.heads.document(stored), stored.frame_time)
    ids = tx.tracks.frame_ids(stored.key, 1, stored.frames)
    return _measurements(tx, stored, head).values(asked, ids, partial(find_walker, head.skeleton, body.stretch))


def read_known_quantity(tx: Transaction, stored: StoredDocument | Listed, asked: AskedQuantity, body: Body) -> Array:
    """The same, NaN where the file of the document has no such measurement, or cannot be read any more."""
    try:
        return read_quantity(tx, stored, asked, body)
    except (DocumentError, NotFoundError, FormatError, LimitError):
        return np.full(stored.frames, np.nan)


def read_units(tx: Transaction, stored: StoredDocument | Listed, asked: Sequence[AskedQuantity]) -> list[str]:
    """The unit of each quantity: where the file decides it, as the file writes it."""
    stated: dict[tuple[str, str], str] = {}
    if any(each.of_file and not each.unit for each in asked):
        listed = read_measurements(tx, stored).describe()
        stated = {(each.function, each.name): each.unit for each in listed}
    return [each.unit or (stated.get((each.name, each.arguments[0]), "") if each.of_file else "") for each in asked]


def read_measurements(tx: Transaction, stored: StoredDocument | Listed) -> Measurements:
    """The measurements of the file of a document, as long as the transaction lasts."""
    return _measurements(tx, stored, to_head(tx.heads.document(stored), stored.frame_time))


def _measurements(tx: Transaction, stored: StoredDocument | Listed, head: ClipHead) -> Measurements:
    return Measurements(head, tx.uploads.open(stored.key, "c3d") if has_capture_numbers(head) else None)
