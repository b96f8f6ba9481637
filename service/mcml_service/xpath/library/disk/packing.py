"""Columns as bytes: concatenated arrays, each compressed if that saves space, with a table of contents."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import orjson
import zstandard
from pcodec import ChunkConfig, standalone

FEW = 4096
"""Bytes that are not worth being compressed."""
PAYS = 0.7
"""If compression gives more than this share, an array is stored uncompressed, which is read without decoding."""
LEVEL = 2
"""Of pcodec: a higher one packs a tenth smaller and is read no faster."""
_RAW, _ZSTD, _NUMBERS, _JSON = range(4)


def pack(columns: Mapping[str, Any]) -> bytes:
    """Pack arrays and JSON values, by name. Raises TypeError for other values."""
    table: list[tuple[str, int, str, tuple[int, ...], int, int]] = []
    parts: list[bytes] = []
    at = 0
    for name, column in columns.items():
        if isinstance(column, np.ndarray):
            way, data = _packed(np.ascontiguousarray(column))
            kind, shape = column.dtype.str, column.shape
        else:
            way, data, kind, shape = _JSON, orjson.dumps(column), "", ()
        table.append((name, way, kind, shape, at, len(data)))
        # Aligned to eight bytes, so that arrays are read in place.
        parts.append(data + bytes(-len(data) % 8))
        at += len(parts[-1])
    head = orjson.dumps(table)
    head += b" " * (-(len(head) + 8) % 8)
    return b"".join([struct.pack("<Q", len(head)), head, *parts])


def _packed(array: np.ndarray) -> tuple[int, bytes]:
    raw = array.tobytes()
    if len(raw) <= FEW:
        return _RAW, raw
    if array.dtype == np.float64:
        return _NUMBERS, standalone.simple_compress(array.ravel(), ChunkConfig(compression_level=LEVEL))
    small = _compressor().compress(raw)
    return (_ZSTD, small) if len(small) <= PAYS * len(raw) else (_RAW, raw)


def _compressor() -> zstandard.ZstdCompressor:
    return zstandard.ZstdCompressor(level=1)


@cache
def _kind(name: str) -> np.dtype[Any]:
    return np.dtype(name)


class Packed:
    """The output of `pack`; each column is decoded on use. Raises ValueError for other bytes."""

    def __init__(self, data: bytes) -> None:
        try:
            (size,) = struct.unpack_from("<Q", data)
            table = orjson.loads(memoryview(data)[8 : 8 + size])
        except struct.error as error:
            raise ValueError(str(error)) from None
        self._data = memoryview(data)[8 + size :]
        self._table = {name: rest for name, *rest in table}

    def __getitem__(self, name: str) -> Any:
        way, kind, shape, at, size = self._table[name]
        data = self._data[at : at + size]
        if way == _JSON:
            return orjson.loads(data)
        if way == _NUMBERS:
            return np.asarray(standalone.simple_decompress(bytes(data))).reshape(shape)
        if way == _ZSTD:
            # A decompressor is no thread's but the one's that uses it; to make one takes a microsecond.
            data = memoryview(zstandard.ZstdDecompressor().decompress(data))
        return np.frombuffer(data, _kind(kind)).reshape(shape)
