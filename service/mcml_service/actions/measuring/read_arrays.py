"""Frames of many clips one after the other, with the same columns: for arrays and tables of a library."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import DocumentError, FormatError, LimitError, NotFoundError, RequestError
from mcml.files.read_numbers import Numbers, read_numbers
from mcml.motion.bodies.quantities import AskedQuantity, asked_quantity
from mcml.motion.skeleton import Array
from mcml_schemas.arrays import ArraysRequest
from mcml_service.actions.exporting.write_tables import About, npy_blocks, npy_of, npz_blocks, write_table
from mcml_service.actions.measuring.choose_ranges import ChosenClip
from mcml_service.actions.reading.read_quantities import quantity_columns, with_quantities
from mcml_service.clips.bodies import Body
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.clips.read_clip import StoredClip, read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

ReadBody = Callable[[Transaction, StoredDocument], Body]
MOST_COLUMNS = 20_000
_LACKS = (DocumentError, FormatError, LimitError, NotFoundError)
"""Errors of a quantity that one clip has not."""


@dataclass(frozen=True, eq=False)
class Part:
    """A frame range of a document, with its own columns. first, last: positions from 1."""

    tx: Transaction
    stored: StoredDocument
    first: int
    last: int
    columns: Sequence[str]

    @property
    def frames(self) -> int:
        return self.last - self.first + 1


@dataclass(frozen=True, eq=False)
class ClipArrays:
    """parts: in their order. columns: of all parts, bones for positions and rotations; shape: of one frame. units: of
    columns, empty for channels."""

    parts: Sequence[Part]
    columns: Sequence[str]
    shape: tuple[int, ...]
    units: Sequence[str]
    warnings: Sequence[str]
    _read: Callable[[Part], Numbers]

    @property
    def frames(self) -> int:
        return sum(part.frames for part in self.parts)

    @cached_property
    def _places(self) -> Mapping[str, int]:
        return {name: place for place, name in enumerate(self.columns)}

    def blocks(self, part: Part) -> Iterator[tuple[Array, NDArray[np.int64] | list[str]]]:
        """Yield (numbers (F, *shape), ids of the frames) of a part, NaN in columns that it lacks."""
        numbers = self._read(part)
        own = [place for place, name in enumerate(numbers.columns) if name in self._places]
        places = [self._places[numbers.columns[place]] for place in own]
        for values, ids in numbers.blocks():
            filled = np.full((len(values), *self.shape), np.nan)
            filled[:, places] = values[:, own]
            yield filled, ids


def read_arrays(
    tx: Transaction, read_body: ReadBody, clips: Sequence[ChosenClip], request: ArraysRequest, check: Callable[[], None]
) -> ClipArrays:
    """Look at the columns of clips; their numbers are read while the arrays are written.

    Raises RequestError for unknown quantities, quantities beside positions, and if no clip or no column is left.
    """
    asked = [asked_quantity(name) for name in dict.fromkeys(request.quantities)]
    if asked and request.space != "channels":
        raise RequestError("Quantities stand beside channels.", remedy="State space=channels, and bones if needed.")
    parts: list[Part] = []
    warnings: list[str] = []
    without: list[str] = []
    for clip in clips:
        check()
        current = tx.documents.get(clip.document)
        then = tx.at_commit(tx.documents.commit_of(current.key, clip.revision))
        stored = then.documents.get(clip.document)
        if not stored.frames:
            without.append(stored.name)
            continue
        columns = _own_numbers(read_clip(then, stored, first=1, last=1, labelled=False), request).columns
        columns = [*columns, *(quantity.text for quantity in asked)]
        if not columns:
            without.append(stored.name)
            continue
        ranges = [(1, stored.frames)] if clip.found is None else clip.found
        parts += [Part(then, stored, first, last, columns) for first, last in ranges]
    if without:
        more = f" and {len(without) - 3:,} more" if len(without) > 3 else ""
        names = ", ".join(map(repr, without[:3]))
        warnings.append(f"{len(without):,} clips left out: they have no frames or none of the bones ({names}{more}).")
    if not parts:
        raise RequestError("No frames are found.", remedy="Select clips with these bones, or change the query.")
    columns = list(dict.fromkeys(name for part in parts for name in part.columns))
    if request.columns == "shared":
        shared = set.intersection(*(set(part.columns) for part in parts))
        columns = [name for name in columns if name in shared]
    if not 0 < len(columns) <= MOST_COLUMNS:
        raise RequestError(
            f"The clips have {len(columns):,} columns together; 1 to {MOST_COLUMNS:,} can be exported.",
            remedy="State bones, or columns=all." if not columns else "State bones, or columns=shared.",
        )
    vector = {"channels": (), "positions": (3,), "rotations": (4,)}[request.space]
    units = {quantity.text: quantity.unit for quantity in asked}
    read = partial(_read, read_body, request, asked)
    return ClipArrays(
        parts, columns, (len(columns), *vector), [units.get(name, "") for name in columns], warnings, read
    )


def write_arrays(arrays: ClipArrays, form: str, dtype: str, *, raw: bool) -> Iterator[bytes]:
    """Write npz, or one table in another form. npz: `values`, `columns`, `starts`, and an entry for each range."""
    if form != "npz":
        return write_table(
            form, _batches(arrays, dtype), About(units=dict(zip(arrays.columns, arrays.units, strict=True)), raw=raw)
        )
    seconds = [_seconds(part) for part in arrays.parts]
    starts = np.cumsum([0, *(part.frames for part in arrays.parts)])
    each: dict[str, Callable[[], Any]] = {
        "documents": lambda: [part.stored.uuid for part in arrays.parts],
        "names": lambda: [part.stored.name for part in arrays.parts],
        "revisions": lambda: np.array([part.stored.revision for part in arrays.parts]),
        "first": lambda: np.array([part.first for part in arrays.parts]),
        "last": lambda: np.array([part.last for part in arrays.parts]),
        "seconds_per_frame": lambda: np.array(seconds),
        "columns": lambda: list(arrays.columns),
        "units": lambda: list(arrays.units),
        "starts": lambda: starts,
    }
    values = (block for part in arrays.parts for block, _ in arrays.blocks(part))
    files: dict[str, Callable[[], Iterator[bytes | memoryview]]] = {
        "values": lambda: npy_blocks(values, (arrays.frames, *arrays.shape), dtype)
    }
    files |= {name: partial(_array_of, made) for name, made in each.items()}
    return npz_blocks(files)


def _array_of(made: Callable[[], Any]) -> Iterator[bytes | memoryview]:
    yield from npy_of(made())


def _batches(arrays: ClipArrays, dtype: str) -> Iterator[dict[str, Any]]:
    names = list(arrays.columns)
    if len(arrays.shape) == 2:
        names = [f"{bone}.{part}" for bone in names for part in "xyzw"[: arrays.shape[1]]]
    # The quantity `time`, from frame 1, is not the time from the first frame of the table.
    names = ["mo:time" if name == "time" else name for name in names]
    for part in arrays.parts:
        done = 0
        for block, ids in arrays.blocks(part):
            places = np.arange(part.first + done, part.first + done + len(block))
            done += len(block)
            rows = block.reshape(len(block), len(names)).astype(dtype)
            yield {
                "document": [part.stored.uuid] * len(block),
                "name": [part.stored.name] * len(block),
                "frame": places,
                "id": list(map(str, ids)),
                "time": (places - 1) * _seconds(part),
                **{name: rows[:, place] for place, name in enumerate(names)},
            }


def _seconds(part: Part) -> float:
    return float("nan") if part.stored.seconds_per_frame is None else part.stored.seconds_per_frame


def _own_numbers(source: StoredClip, request: ArraysRequest) -> Numbers:
    """Of the bones that a clip has."""
    bones = [bone for bone in request.bones if bone in source.names] if request.bones else None
    if bones == [] or (bones is None and request.quantities):
        return Numbers([], (0,), lambda: iter(()))
    return read_numbers(source.clip, source.names, bones, request.space, held=False)


def _read(read_body: ReadBody, request: ArraysRequest, asked: Sequence[AskedQuantity], part: Part) -> Numbers:
    source = read_clip(part.tx, part.stored, first=part.first, last=part.last, labelled=False)
    numbers = _own_numbers(source, request)
    if not asked:
        return numbers
    quantities = FrameQuantities(part.tx, part.stored, read_body(part.tx, part.stored))
    values = np.full((part.frames, len(asked)), np.nan)
    for place, quantity in enumerate(asked):
        # A clip without it has no value; the columns of others stay.
        with suppress(*_LACKS):
            values[:, [place]] = quantity_columns(quantities, [quantity], part.first, part.last)
    alone = not numbers.columns
    channels = read_numbers(source.clip, source.names, None, "channels") if alone else numbers
    return with_quantities(channels, asked, [quantity.unit for quantity in asked], values, alone=alone)
