"""Curves of a document over a frame range: channels and quantities of the body, reduced to extremes for drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcml.errors import NotFoundError, RequestError
from mcml.motion.bodies.quantities import AskedQuantity
from mcml.motion.skeleton import Array
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.actions.reading.reduce_frames import reduce_frames, reduce_values
from mcml_service.clips.bodies import read_bodies
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


@dataclass(frozen=True)
class Curve:
    """name: BONE.CHANNEL, or a quantity as it was asked for. unit: "" for channels. first: position of the first frame.

    step: frames a row. values: (rows, 2) least and greatest, NaN without samples.
    """

    name: str
    unit: str
    first: int
    step: int
    values: Array


def read_curves(
    tx: Transaction,
    stored: StoredDocument,
    columns: Sequence[str],
    quantities: Sequence[AskedQuantity],
    frames: tuple[int, int],
    pixels: int,
) -> list[Curve]:
    """Read channels (BONE.CHANNEL), then quantities, of frames (first, last; positions from 1).

    Values are those of `reduce_frames` and `quantity_columns`, in at most `pixels` rows. The body is read past all
    caches, so uncommitted revisions can be read. Raises NotFoundError for bones, channels and measurements that the
    document has not, RequestError for a column without a channel.
    """
    first, last = frames
    curves: list[Curve] = []
    if columns:
        _check_names(columns)
        bones = list(dict.fromkeys(column.rpartition(".")[0] for column in columns))
        reduced = reduce_frames(tx, stored, first, last, pixels, bones)
        place = {name: index for index, name in enumerate(reduced.columns)}
        for column in columns:
            if column not in place:
                raise NotFoundError(
                    f"The document has no channel {column!r}.", remedy=f"These bones have: {', '.join(place)}."[:400]
                )
            curves.append(Curve(column, "", first, reduced.step, reduced.values[:, place[column]]))
    if quantities:
        (listed,) = tx.columns.documents([stored.key])
        source = FrameQuantities(tx, stored, read_bodies(tx, [listed])[stored.key])
        step, values = reduce_values(quantity_columns(source, quantities, first, last), pixels)
        units = source.units(quantities)
        for index, (quantity, unit) in enumerate(zip(quantities, units, strict=True)):
            curves.append(Curve(quantity.text, unit, first, step, values[:, index]))
    return curves


def _check_names(columns: Sequence[str]) -> None:
    for column in columns:
        if not all(column.rpartition(".")):
            raise RequestError(f"{column!r} names no channel of a bone.", remedy="Write BONE.CHANNEL: Root.Ty.")
