"""The JSON and the numbers of a glTF file: containers, buffers, accessors.

Source: glTF 2.0 specification, sections 3.6 (buffers, accessors) and 4.4 (GLB), Khronos Group 2021.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
import struct
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO, Final
from urllib.parse import unquote

import numpy as np

from mcml.errors import FormatError, LimitError, UnsupportedError
from mcml.motion.skeleton import Array

DAMAGED: Final = "Send the file whole, or save it again."
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_TYPES: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_NUMBERS: Final = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_LARGEST: Final = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}
_MOST_VALUES: Final = 1 << 28


MOST_TEXT: Final = 128 << 20
"""Bytes of JSON: parsed, they take several times as many."""
BUFFER: Final = ".bin"
"""How files with the numbers of a glTF end."""
_URI = re.compile(rb'"uri"\s*:\s*"((?!data:)[^"]{1,1000})"')


def find_uris(stream: BinaryIO) -> set[str]:
    """The paths of the files that the text of a glTF names, with slashes."""
    stream.seek(0)
    text = stream.read()
    stream.seek(0)
    return {_path_of(uri.decode("utf-8", "replace")) for uri in _URI.findall(text)}


def _path_of(uri: str) -> str:
    return unquote(uri).replace("\\", "/")


class Document:
    """A glTF file. companion: the bytes of a file that was sent with it, by the name that the file gives it."""

    def __init__(self, data: bytes, companion: Callable[[str], bytes | None]) -> None:
        text, self._binary = _split(data) if data.startswith(b"glTF") else (data, b"")
        self.json = _parse(text)
        version = str(_get(self.json, "asset", dict).get("version", ""))
        if not version.startswith("2."):
            raise UnsupportedError(f"glTF {version or 'without a version'} is not read", remedy="Save it as glTF 2.0.")
        self._companion = companion
        self._buffers: dict[int, bytes] = {}

    def items(self, name: str) -> list[dict[str, Any]]:
        """The objects of a list at the top level; empty where there is none. FormatError where it is none."""
        found = self.json.get(name, [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            raise FormatError(f"{name} is no list of objects", remedy=DAMAGED)
        return found

    def extension(self, name: str) -> dict[str, Any] | None:
        """An extension of the file, None where it has none of that name."""
        return _get(_get(self.json, "extensions", dict), name, dict) or None

    def read(self, number: object, width: int) -> Array:
        """(count, width) the numbers of an accessor; normalised integers as fractions. FormatError."""
        accessor = self.item("accessors", number)
        kind, component = accessor.get("type"), accessor.get("componentType")
        if _TYPES.get(kind if isinstance(kind, str) else "") != width or component not in _NUMBERS:
            raise FormatError(f"accessor {number} is a {kind}, not {width} numbers", remedy=DAMAGED)
        count = as_number(accessor.get("count"), "count")
        if count * width > _MOST_VALUES:
            raise FormatError(f"accessor {number} has {count} elements, more than any file holds", remedy=DAMAGED)
        dtype = np.dtype(_NUMBERS[component])
        if "bufferView" in accessor:
            found = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), dtype, count, width)
        elif count * width * dtype.itemsize > (1 << 26):
            raise FormatError(f"accessor {number} has {count} elements and no data", remedy=DAMAGED)
        else:
            found = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            found = self._with_sparse(found, accessor["sparse"], dtype)
        values: Array = found.astype(np.float64)
        if accessor.get("normalized") and component in _LARGEST:
            values = np.maximum(values / _LARGEST[component], -1.0)
        return values

    def _with_sparse(self, found: Array, sparse: object, dtype: np.dtype[Any]) -> Array:
        facts = sparse if isinstance(sparse, dict) else {}
        count = as_number(facts.get("count"), "sparse.count")
        indices, values = _get(facts, "indices", dict), _get(facts, "values", dict)
        kind = _NUMBERS.get(indices.get("componentType", 0), "<u4")
        places = self._view(indices.get("bufferView"), indices.get("byteOffset", 0), np.dtype(kind), count, 1)[:, 0]
        if len(places) and int(places.max()) >= len(found):
            raise FormatError("a sparse accessor changes elements that there are not", remedy=DAMAGED)
        changed = np.array(found)
        changed[places.astype(np.intp)] = self._view(
            values.get("bufferView"), values.get("byteOffset", 0), dtype, count, found.shape[1]
        )
        return changed

    def _view(self, number: object, offset: object, dtype: np.dtype[Any], count: int, width: int) -> Any:
        view = self.item("bufferViews", number)
        if "EXT_meshopt_compression" in _get(view, "extensions", dict):
            raise UnsupportedError(
                "the animation is compressed (EXT_meshopt_compression)", remedy="Save it without compression."
            )
        buffer = self._buffer(as_number(view.get("buffer"), "buffer"))
        start = as_number(view.get("byteOffset", 0), "byteOffset")
        end = start + as_number(view.get("byteLength"), "byteLength")
        first = start + as_number(offset, "byteOffset")
        element = dtype.itemsize * width
        stride = as_number(view.get("byteStride", element), "byteStride") or element
        last = first + stride * (count - 1) + element if count else first
        if stride < element or last > min(end, len(buffer)):
            raise FormatError(f"the data of buffer view {number} ends before its elements", remedy=DAMAGED)
        if not count:
            return np.zeros((0, width), dtype)
        return np.ndarray((count, width), dtype, buffer, first, (stride, dtype.itemsize))

    def _buffer(self, number: int) -> bytes:
        if number not in self._buffers:
            buffer = self.item("buffers", number)
            self._buffers[number] = self._load(buffer.get("uri"), number)
        return self._buffers[number]

    def _load(self, uri: object, number: int) -> bytes:
        if uri is None:
            return self._binary if number == 0 else b""
        if not isinstance(uri, str):
            raise FormatError(f"the address of buffer {number} is no text", remedy=DAMAGED)
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except (binascii.Error, ValueError):
                raise FormatError(f"the data of buffer {number} is not base64", remedy=DAMAGED) from None
        name = _path_of(uri).rsplit("/", 1)[-1]
        found = self._companion(name)
        if found is None:
            raise FormatError(
                f"the file needs {name[:100]!r}, which was not sent", remedy="Send both, or save the motion as GLB."
            )
        return found

    def bytes_of(self, view: object) -> bytes:
        """The bytes of a buffer view. FormatError."""
        length = as_number(self.item("bufferViews", view).get("byteLength"), "byteLength")
        return bytes(self._view(view, 0, np.dtype("u1"), length, 1))

    def item(self, name: str, number: object) -> dict[str, Any]:
        """The object at a place of a list at the top level. FormatError where there is none."""
        items, place = self.items(name), as_number(number, name)
        if place >= len(items):
            raise FormatError(f"there is no {name}[{place}]", remedy=DAMAGED)
        return items[place]


def as_number(value: object, name: str) -> int:
    """A whole number of at least zero. FormatError for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < 1 << 40 or value % 1:
        raise FormatError(f"{name} is {str(value)[:40]!r}, not a number of things", remedy=DAMAGED)
    return int(value)


def as_numbers(values: object, count: int, name: str) -> Array:
    """(count,) numbers. FormatError for anything else."""
    if not isinstance(values, list) or len(values) != count or not all(isinstance(v, (int, float)) for v in values):
        raise FormatError(f"{name} is not {count} numbers", remedy=DAMAGED)
    return np.array(values, np.float64)


def _get(values: Mapping[str, Any], name: str, kind: type[dict[str, Any]]) -> dict[str, Any]:
    found = values.get(name)
    return found if isinstance(found, kind) else {}


def _split(data: bytes) -> tuple[bytes, bytes]:
    """The JSON and the binary chunk of a GLB."""
    if len(data) < 20:
        raise FormatError("the GLB file ends in its header", remedy=DAMAGED)
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise UnsupportedError(f"glTF {version} is not read", remedy="Save it as glTF 2.0.")
    if length > len(data):
        raise FormatError(f"the GLB file says it has {length} bytes, {len(data)} came", remedy=DAMAGED)
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > length:
            raise FormatError(f"a chunk at byte {at} ends after the file", remedy=DAMAGED)
        chunks.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size + (-size % 4)
    if _JSON not in chunks:
        raise FormatError("the GLB file has no JSON", remedy=DAMAGED)
    return chunks[_JSON], chunks.get(_BINARY, b"")


def _parse(text: bytes) -> dict[str, Any]:
    if len(text) > MOST_TEXT:
        raise LimitError(
            f"the JSON of the glTF file has {len(text) >> 20} MiB, the limit is {MOST_TEXT >> 20}",
            remedy="Save it as GLB, whose numbers are not text.",
        )
    try:
        found = json.loads(text.decode("utf-8-sig").rstrip("\0 "))
    except (ValueError, RecursionError):
        raise FormatError("the JSON of the glTF file is damaged or cut off", remedy=DAMAGED) from None
    if not isinstance(found, dict):
        raise FormatError("the JSON of the glTF file is no object", remedy=DAMAGED)
    return found
