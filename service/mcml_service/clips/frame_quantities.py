"""Quantities of the frames of a stored document that positions of joints do not tell."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import cast

import numpy as np
from numpy.typing import NDArray

from mcml.errors import DocumentError, FormatError, LimitError, NotFoundError
from mcml.files.gait_labels import find_exclusions, find_gait_labels
from mcml.formats.analog_files import analog_part, channels_reader
from mcml.formats.measurements import Measurements
from mcml.laboratory.gait_contacts import find_contacts
from mcml.laboratory.gait_events import GaitEvent, Side, WalkerPaths
from mcml.laboratory.gait_points import GaitPoints, find_gait_points
from mcml.laboratory.measure_gait import EventSource, Gait, GaitEvents, find_gait_events, find_walker, measure_gait
from mcml.language.elements import to_head
from mcml.motion.bodies.quantities import AskedQuantity
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.clip import ClipHead
from mcml.motion.markers import read_marker_positions
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import Body, read_turned
from mcml_service.clips.read_clip import Skeletons, read_clip
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.transaction import Transaction


def is_beside_positions(asked: AskedQuantity) -> bool:
    """Whether `FrameQuantities` reads it: it takes rotations, the gait of a walker, or the file states it."""
    return asked.of_file or asked.of_gait or asked.needs_rotations


class FrameQuantities:
    """Quantities of all frames of a document, which share what they read.

    body: of the document. skeletons: as for `read_clip`.
    """

    def __init__(
        self, tx: Transaction, stored: StoredDocument | Listed, body: Body, skeletons: Skeletons | None = None
    ) -> None:
        self._tx, self._stored, self.body, self._skeletons = tx, stored, body, skeletons
        self._events: dict[str | None, GaitEvents] = {}

    def read(self, asked: AskedQuantity) -> Array:
        """(n,) of all frames, NaN where unknown.

        Raises NotFoundError for a measurement that it has not, DocumentError for forces on feet and contacts that
        are unknown.
        """
        if asked.of_gait:
            person, _, side = asked.arguments[0].rpartition(":")
            found = self._find_events(person or None)
            return find_contacts(found.events, cast("Side", side), found.rate, self._stored.frames)
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
        exclusions = find_exclusions((span.first - 1, span.last - 1, span.name) for span in self._spans)
        return measure_gait(*self._walker(subject), source, self._find_plate_events, exclusions)

    def units(self, asked: Sequence[AskedQuantity]) -> list[str]:
        """The unit of each quantity: where the file decides it, as the file writes it."""
        return [each.unit or (self.measurements.unit(each) if each.of_file else "") for each in asked]

    def _positions(self, joints: Sequence[int]) -> Array:
        return read_marker_positions(read_clip(self._tx, self._stored, labelled=False).clip, joints)

    def _walker(self, subject: str | None) -> tuple[GaitPoints, Stretch, list[GaitEvent]]:
        """Points, their positions, and the events that labels state."""
        points = find_gait_points(self._head.skeleton, subject)
        labels = find_gait_labels([(span.first - 1, span.name) for span in self._spans], self._head, subject)
        return points, self.body.stretch(points.names), labels

    def _find_plate_events(self, walker: WalkerPaths) -> list[GaitEvent]:
        return self.measurements.find_events(self._ids, walker)

    def _find_events(self, subject: str | None) -> GaitEvents:
        if subject not in self._events:
            self._events[subject] = find_gait_events(*self._walker(subject), "auto", self._find_plate_events)
        return self._events[subject]

    @cached_property
    def _spans(self) -> list[StoredSpan]:
        return self._tx.spans.of(self._stored.key)

    @cached_property
    def _head(self) -> ClipHead:
        return read_clip(self._tx, self._stored, bare=True, skeletons=self._skeletons).clip.head

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
    part = analog_part(head)
    stream = None if part is None else tx.uploads.open(stored.key, part)
    return Measurements(head, None if stream is None else channels_reader(head, stream))
