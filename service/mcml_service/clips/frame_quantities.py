"""Quantities of the frames of a stored document that positions of joints do not tell."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import cast

import numpy as np
from numpy.typing import NDArray

from mcml.errors import DocumentError, FormatError, LimitError, NotFoundError
from mcml.files.gait_labels import find_exclusions, find_gait_labels
from mcml.formats.measurements import Measurements, has_capture_numbers
from mcml.laboratory.gait_events import Side
from mcml.laboratory.gait_points import find_gait_points
from mcml.laboratory.measure_gait import EventSource, Gait, find_walker, measure_gait
from mcml.language.elements import to_head
from mcml.motion.bodies.quantities import AskedQuantity
from mcml.motion.clip import ClipHead
from mcml.motion.markers import read_marker_positions
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import Body, read_turned
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def is_beside_positions(asked: AskedQuantity) -> bool:
    """Whether `FrameQuantities` reads it: it takes rotations, the gait of a walker, or the file states it."""
    return asked.of_file or asked.of_gait or asked.needs_rotations


class FrameQuantities:
    """Quantities of all frames of a document, which share what they read.

    body: of the document.
    """

    def __init__(self, tx: Transaction, stored: StoredDocument | Listed, body: Body) -> None:
        self._tx, self._stored, self.body = tx, stored, body

    def read(self, asked: AskedQuantity) -> Array:
        """(n,) of all frames, NaN where unknown.

        Raises NotFoundError for a measurement that it has not, DocumentError for forces on feet and contacts that
        are unknown.
        """
        if asked.of_gait:
            return self.measure_gait().contacts(cast("Side", asked.arguments[0]), self._stored.frames)
        if not asked.of_file:
            return read_turned(self._tx, self._stored, asked.arguments[0], self.body)
        walker = partial(find_walker, self._head.skeleton, self.body.stretch)
        return self.measurements.values(asked, self._ids, walker, self._positions)

    def read_known(self, asked: AskedQuantity) -> Array:
        """The same, NaN where the file of the document has no such measurement, or cannot be read any more."""
        try:
            return self.read(asked)
        except (DocumentError, NotFoundError, FormatError, LimitError):
            return np.full(self._stored.frames, np.nan)

    def measure_gait(self, source: EventSource = "auto", subject: str | None = None) -> Gait:
        """Measure the gait of the document.

        source, subject: as for `measure_gait` and `find_gait_points`. Raises DocumentError without a frame time, or if
        heels, toes or hips are unknown.
        """
        points = find_gait_points(self._head.skeleton, subject)
        spans = self._tx.spans.of(self._stored.key)
        labels = find_gait_labels([(span.first - 1, span.name) for span in spans], self._head, subject)
        exclusions = find_exclusions((span.first - 1, span.last - 1, span.name) for span in spans)
        find_plates = partial(self.measurements.find_events, self._ids)
        return measure_gait(points, self.body.stretch(points.names), labels, source, find_plates, exclusions)

    def units(self, asked: Sequence[AskedQuantity]) -> list[str]:
        """The unit of each quantity: where the file decides it, as the file writes it."""
        return [each.unit or (self.measurements.unit(each) if each.of_file else "") for each in asked]

    def _positions(self, joints: Sequence[int]) -> Array:
        return read_marker_positions(read_clip(self._tx, self._stored, labelled=False).clip, joints)

    @cached_property
    def _head(self) -> ClipHead:
        return to_head(self._tx.heads.document(self._stored), self._stored.frame_time)

    @cached_property
    def measurements(self) -> Measurements:
        """Of the file of the document, as long as the transaction lasts."""
        return _open_measurements(self._tx, self._stored, self._head)

    @cached_property
    def _ids(self) -> NDArray[np.int64] | list[str]:
        return self._tx.tracks.frame_ids(self._stored.key, 1, self._stored.frames)


def read_measurements(tx: Transaction, stored: StoredDocument | Listed) -> Measurements:
    """The measurements of the file of a document, as long as the transaction lasts."""
    return _open_measurements(tx, stored, to_head(tx.heads.document(stored), stored.frame_time))


def _open_measurements(tx: Transaction, stored: StoredDocument | Listed, head: ClipHead) -> Measurements:
    return Measurements(head, tx.uploads.open(stored.key, "c3d") if has_capture_numbers(head) else None)
