"""Analog channels of the file of a document, at their own rate, in the order of its frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError, NotFoundError
from mcml.formats.c3d.analog import Channels
from mcml.formats.measurements import NAMED
from mcml.language.elements import to_head
from mcml.motion.skeleton import Array
from mcml_service.actions.exporting.write_tables import About, Batches
from mcml_service.clips.frame_quantities import read_measurements
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

_TOGETHER = 512
"""Frames of a batch."""


def read_analog(
    tx: Transaction, stored: StoredDocument, labels: Sequence[str] | None, first: int, last: int, *, scaled: bool
) -> tuple[Batches, About]:
    """Batches of position of the frame, seconds from the first frame, and a column for each channel; and their units.

    labels: of some channels, in this order; None for all. first, last: positions of frames from 1, both included.
    scaled: in the unit of the channel, otherwise as the file stores them. NaN in frames that are not of the file. Lives
    as long as the transaction. Raises NotFoundError for an unknown channel, ConversionError where the frames are not
    those of the channels.
    """
    measurements = read_measurements(tx, stored)
    channels = measurements.channels
    known = () if channels is None else channels.labels
    chosen = list(known if labels is None else dict.fromkeys(labels))
    unknown = next((label for label in chosen if label not in known), None)
    if channels is None or unknown is not None:
        what = f"analog channel {unknown!r}" if unknown is not None else "analog channels"
        listed = f"It has: {', '.join(known[:NAMED])}." if known else "Only C3D files whose upload is kept have any."
        raise NotFoundError(f"The file of this document has no {what}.", remedy=listed)
    if measurements.rate_difference:
        raise ConversionError(
            f"The frames are not those of the analog channels: {measurements.rate_difference}.",
            remedy="Ask for a revision before the frame rate was changed.",
        )
    places = [known.index(label) for label in chosen]
    units = {label: channels.units[place] for label, place in zip(chosen, places, strict=True) if channels.units[place]}
    types = {"frame": "int64", "time": "float64", **dict.fromkeys(chosen, "float64")}
    stated = to_head(tx.heads.document(stored), stored.frame_time).seconds_per_frame()
    seconds = np.nan if stated is None else stated

    def batches() -> Iterator[dict[str, Array | NDArray[np.int64]]]:
        for start in range(first, last + 1, _TOGETHER):
            end = min(start + _TOGETHER - 1, last)
            ids = np.asarray(tx.tracks.frame_ids(stored.key, start, end))
            values = _read_frames(channels, ids, places, scaled=scaled)
            frames = np.repeat(np.arange(start, end + 1), channels.samples)
            within = np.tile(np.arange(channels.samples), end - start + 1) / channels.samples
            yield {
                "frame": frames,
                "time": (frames - 1 + within) * seconds,
                **{label: values[:, column] for column, label in enumerate(chosen)},
            }

    return batches(), About(types, {} if not scaled else units)


def _read_frames(channels: Channels, ids: NDArray[np.generic], places: Sequence[int], *, scaled: bool) -> Array:
    """(frames × samples, channels), NaN in frames that are not of the file."""
    values = np.full((len(ids), channels.samples, len(places)), np.nan)
    if ids.dtype.kind != "i":
        return values.reshape(-1, len(places))
    numbers = ids.astype(np.int64) - channels.first
    # Runs of frames that follow each other in the file are read at once.
    starts = np.flatnonzero(np.diff(numbers, prepend=numbers[0] - 2) != 1)
    read = channels.read if scaled else channels.read_raw
    for begin, end in zip(starts.tolist(), [*starts[1:].tolist(), len(numbers)], strict=True):
        low = max(0, -int(numbers[begin]))
        high = min(end - begin, channels.frames - int(numbers[begin]))
        if low < high:
            run = read(int(numbers[begin]) + low, high - low, places)
            values[begin + low : begin + high] = run.reshape(high - low, channels.samples, len(places))
    return values.reshape(-1, len(places))
