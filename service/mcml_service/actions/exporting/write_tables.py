"""Numbers and rows as files of columns: NumPy's npy and npz, Arrow IPC, Parquet, CSV. Streams: a block at a time."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain, islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import UnsupportedError
from mcml.motion.skeleton import Array
from mcml_service.actions.exporting.export_motion import Tail, zip_files
from mcml_service.cells import safe_cell

Batches = Iterator[Mapping[str, Any]]
"""Batches of columns by name; all batches have the same names."""

ROWS = 5000
"""Rows of one batch."""


def npy_header(shape: tuple[int, ...], dtype: str) -> bytes:
    """How the file begins that numpy.save writes."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": f"<{dtype}", "fortran_order": False, "shape": shape})
    return header.getvalue()


def npy_blocks(blocks: Iterator[Array], shape: tuple[int, ...], dtype: str) -> Iterator[bytes | memoryview]:
    """An array of this shape as numpy.save writes it, from blocks of its rows."""
    yield npy_header(shape, dtype)
    yield from plain_blocks(blocks, dtype)


def plain_blocks(blocks: Iterator[Array], dtype: str) -> Iterator[memoryview]:
    """The numbers alone, little-endian, row after row."""
    for values in blocks:
        yield np.ascontiguousarray(values, dtype=f"<{dtype}").reshape(-1).view(np.uint8).data


def npz_blocks(arrays: Mapping[str, Callable[[], Iterator[bytes | memoryview]]]) -> Iterator[bytes]:
    """Write arrays like numpy.savez, each computed in turn."""
    return zip_files((f"{name}.npy", content) for name, content in arrays.items())


def npy_of(values: Sequence[str] | NDArray[Any]) -> Iterator[bytes]:
    """A small array as numpy.save writes it; texts have the width of the longest."""
    content = io.BytesIO()
    np.save(content, np.asarray(values))
    yield content.getvalue()


def batches_of(rows: Iterator[tuple[Any, ...]], names: Sequence[str]) -> Batches:
    """Rows as columns of these names, some thousands at a time."""
    for some in iter(lambda: list(islice(rows, ROWS)), []):
        yield dict(zip(names, map(list, zip(*some, strict=True)), strict=True))


@dataclass(frozen=True)
class About:
    """Facts about columns before the first batch, for forms that use them.

    types: by Arrow's names ("string", "int64"), if there may be no batch to derive them. units: of some columns. raw:
    do not escape texts that spreadsheets read as formulas.
    """

    types: Mapping[str, str] | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    raw: bool = False


def write_csv(batches: Batches, about: About) -> Iterator[bytes]:
    """Write batches as CSV (RFC 4180) with a row of names; unknown values are empty."""
    shown = str if about.raw else safe_cell
    head = True
    for batch in batches:
        content = io.StringIO()
        writer = csv.writer(content)
        if head:
            writer.writerow(map(shown, batch))
            head = False
        columns = [
            [shown(item) for item in column]
            if isinstance(next(iter(column), None), str)
            else np.asarray(column).tolist()
            for column in batch.values()
        ]
        writer.writerows(["" if value != value else value for value in row] for row in zip(*columns, strict=True))
        yield content.getvalue().encode()


def write_columns(form: str, batches: Batches, about: About) -> Iterator[bytes]:
    """Batches as an Arrow stream or a Parquet file. form: "arrow" or "parquet".

    UnsupportedError where pyarrow is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise UnsupportedError(
            f"{form} needs a library that is not installed.",
            remedy="Install the extra: pip install 'mcml-repository[arrow]'.",
        ) from None
    tail, types, units = Tail(), about.types, about.units
    schema = None if types is None else pa.schema([(name, pa.type_for_alias(kind)) for name, kind in types.items()])
    empty: dict[str, Any] = {} if types is None else {name: [] for name in types}
    first = pa.RecordBatch.from_pydict(dict(next(batches, empty)), schema)
    if units:
        fields = [
            column.with_metadata({"unit": units[column.name]}) if column.name in units else column
            for column in first.schema
        ]
        first = pa.RecordBatch.from_arrays(first.columns, schema=pa.schema(fields))
    sink = pa.PythonFile(tail, "w")
    if form == "arrow":
        writer: Any = pa.ipc.new_stream(sink, first.schema)
    else:
        writer = pq.ParquetWriter(sink, first.schema, compression="zstd")
    with writer:
        for batch in chain((first,), (pa.RecordBatch.from_pydict(dict(item), first.schema) for item in batches)):
            writer.write_batch(batch)
            yield from tail.take_blocks()
    yield from tail.take_blocks()


TABLES: Mapping[str, tuple[str, Callable[[Batches, About], Iterator[bytes]]]] = {
    "arrow": ("application/vnd.apache.arrow.stream", partial(write_columns, "arrow")),
    "parquet": ("application/vnd.apache.parquet", partial(write_columns, "parquet")),
    "csv": ("text/csv", write_csv),
}
"""Forms of tables: media type and writer of batches."""

TYPES = {
    "block": "application/vnd.mcml.block",
    "npy": "application/octet-stream",
    "npz": "application/octet-stream",
    **{form: media_type for form, (media_type, _) in TABLES.items()},
}
"""Media types by form."""


def write_table(form: str, batches: Batches, about: About) -> Iterator[bytes]:
    """Batches in one of the forms of TABLES."""
    return TABLES[form][1](batches, about)
