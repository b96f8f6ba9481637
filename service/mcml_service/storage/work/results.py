"""Results of analyses: parts, each with JSON for people and arrays kept in full."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import orjson
import zstandard
from numpy.typing import NDArray
from sqlalchemy import Row, Select, delete, select, update

from mcml.errors import NotFoundError
from mcml_service.storage.core.identifiers import new_uuid, normalise_name, now
from mcml_service.storage.core.seals import damage, verify
from mcml_service.storage.core.tables import document, project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import is_seen
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.work.tables import job, result, result_block, result_part

BLOCK_BYTES = 4 << 20
"""Of an array in one row, before compression."""

OPERATION = "operation"
"""The parameter of a kept result that names the operation that made it."""

_PARENT = result.alias()
_LISTED = (
    select(result, project.c.name.label("project_name"), _PARENT.c.uuid.label("parent_uuid"))
    .join(project, project.c.id == result.c.project)
    .outerjoin(_PARENT, _PARENT.c.id == result.c.parent)
)
_PART = (result_part.c.name, result_part.c.kind, result_part.c.data, result_part.c.arrays)


@dataclass(frozen=True)
class StoredResult:
    """A result. inputs: [{"document", "revision"}]. made_with: versions of the libraries that computed it."""

    key: int
    uuid: str
    project: str
    parent: str | None
    analysis: str
    name: str
    owner: str
    inputs: list[dict[str, Any]]
    parameters: dict[str, Any]
    made_with: dict[str, str]
    created: str

    @property
    def continues(self) -> bool:
        """Whether an operation on its parent kept it: it holds what is new, and needs its parent."""
        return self.parent is not None and OPERATION in self.parameters


@dataclass(frozen=True)
class StoredPart:
    """A part of a result without its arrays. arrays: name -> {"dtype", "shape"}. document: uuid of its clip."""

    name: str
    kind: str
    data: dict[str, Any]
    arrays: dict[str, dict[str, Any]]
    document: str | None


class Results:
    def __init__(self, tx: BaseTransaction, quotas: Quotas) -> None:
        self._tx = tx
        self._quotas = quotas

    def add(
        self,
        project_key: int,
        analysis: str,
        name: str,
        owner: str,
        inputs: list[dict[str, Any]],
        parameters: dict[str, Any],
        made_with: dict[str, str],
        parent: str | None = None,
    ) -> tuple[int, str]:
        """A result without parts; its key and uuid. AccessError."""
        self._quotas.require(project_key)
        uuid = new_uuid()
        key = self._tx.insert_row(
            result,
            uuid=uuid,
            project=project_key,
            parent=None if parent is None else self.get(parent).key,
            analysis=analysis,
            name=normalise_name(name),
            owner=owner,
            inputs=json.dumps(inputs),
            parameters=json.dumps(parameters),
            made_with=json.dumps(made_with),
            created=now(),
        )
        return key, uuid

    def add_part(
        self,
        key: int,
        name: str,
        kind: str,
        data: Mapping[str, Any],
        arrays: Mapping[str, NDArray[Any]],
        document_key: int | None = None,
    ) -> None:
        text = orjson.dumps(data, option=orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_NON_STR_KEYS)
        listed = {array: {"dtype": values.dtype.str, "shape": list(values.shape)} for array, values in arrays.items()}
        row = {
            "result": key,
            "name": name,
            "kind": kind,
            "data": zstandard.ZstdCompressor(level=3).compress(text),
            "arrays": json.dumps(listed),
            "document": document_key,
        }
        self._tx.insert_rows(result_part, [row])
        for array, values in arrays.items():
            for number, block in enumerate(_blocks(values)):
                self._tx.insert_rows(
                    result_block, [{"result": key, "part": name, "array": array, "number": number, "data": block}]
                )

    def get(self, uuid: str) -> StoredResult:
        """NotFoundError."""
        row = self._tx.fetch_one(self._select_seen().where(result.c.uuid == uuid))
        if row is None:
            raise NotFoundError(f"There is no result {uuid}.", remedy="List the results to see their ids.")
        return _to_result(row)

    def page(
        self,
        *,
        project_name: str | None,
        analysis: str | None,
        parent: str | None,
        before: int | None,
        limit: int,
    ) -> list[StoredResult]:
        """The newest first. before: the key of the last result of the page before."""
        query = self._select_seen().order_by(result.c.id.desc()).limit(limit)
        if project_name is not None:
            query = query.where(project.c.name == normalise_name(project_name))
        if analysis is not None:
            query = query.where(result.c.analysis == analysis)
        if parent is not None:
            query = query.where(_PARENT.c.uuid == parent)
        if before is not None:
            query = query.where(result.c.id < before)
        return [_to_result(row) for row in self._tx.fetch_all(query)]

    def _select_seen(self) -> Select[Any]:
        return _LISTED.where(is_seen(self._tx.view, result.c.project))

    def parts(self, key: int) -> list[StoredPart]:
        query = (
            select(*_PART, document.c.uuid)
            .outerjoin(document, document.c.id == result_part.c.document)
            .where(result_part.c.result == key)
            .order_by(result_part.c.name)
        )
        return [
            StoredPart(
                name, kind, orjson.loads(zstandard.ZstdDecompressor().decompress(data)), json.loads(arrays), uuid
            )
            for name, kind, data, arrays, uuid in self._tx.fetch_all(verify(query, result_part))
        ]

    def array(self, key: int, part: StoredPart, name: str) -> NDArray[Any]:
        """An array of a part, whole. NotFoundError."""
        dtype, shape = _about(part, name)
        values = np.empty(shape, dtype=dtype)
        flat, start = values.reshape(-1).view(np.uint8), 0
        for block in self._blocks(key, part, name):
            flat[start : start + len(block)] = block
            start += len(block)
        if start != flat.nbytes:
            raise damage("The store", f"the array {name!r} of a result")
        return values

    def rows(self, key: int, part: StoredPart, name: str, wanted: NDArray[np.intp]) -> NDArray[Any]:
        """Return rows of an array of a part, in the requested order; blocks without these rows are not read.

        Raises NotFoundError, also for a row that the array does not have.
        """
        dtype, shape = _about(part, name)
        if not shape or (len(wanted) and not (wanted.min() >= 0 and wanted.max() < shape[0])):
            raise NotFoundError(
                f"The array {name!r} has rows 0 to {shape[0] - 1 if shape else 0}.", remedy="Ask for rows of these."
            )
        values = np.empty((len(wanted), *shape[1:]), dtype=dtype)
        size = dtype.itemsize * math.prod(shape[1:])
        flat = values.reshape(len(wanted), -1).view(np.uint8)
        starts = wanted * size
        touched = sorted({int(n) for n in starts // BLOCK_BYTES} | {int(n) for n in (starts + size - 1) // BLOCK_BYTES})
        if not size or not touched:
            return values
        numbers = range(touched[0], touched[-1] + 1) if size > BLOCK_BYTES else touched
        for number, block in zip(numbers, self._blocks(key, part, name, numbers), strict=True):
            low = number * BLOCK_BYTES
            inside = np.flatnonzero((starts < low + len(block)) & (starts + size > low))
            for row in inside.tolist():
                begin, end = max(int(starts[row]), low), min(int(starts[row]) + size, low + len(block))
                flat[row, begin - starts[row] : end - starts[row]] = block[begin - low : end - low]
        return values

    def _blocks(
        self, key: int, part: StoredPart, name: str, numbers: Sequence[int] | None = None
    ) -> Iterator[NDArray[np.uint8]]:
        """The bytes of an array, block after block. Raises DamageError."""
        query = (
            select(result_block.c.data)
            .where(result_block.c.result == key, result_block.c.part == part.name, result_block.c.array == name)
            .order_by(result_block.c.number)
        )
        if numbers is not None:
            query = query.where(result_block.c.number.in_(numbers))
        for block in self._tx.stream(verify(query, result_block), 4):
            for (data,) in block:
                yield np.frombuffer(zstandard.ZstdDecompressor().decompress(data), np.uint8)

    def remove(self, key: int) -> None:
        """Drop a result and all that was made from it; documents that came of them stay. AccessError."""
        self._quotas.require(self._tx.fetch_value(select(result.c.project).where(result.c.id == key)))
        for child in self._tx.fetch_column(select(result.c.id).where(result.c.parent == key)):
            self.remove(child)
        self._tx.run(update(job).where(job.c.result == key).values(result=None))
        for table in (result_block, result_part):
            self._tx.run(delete(table).where(table.c.result == key))
        self._tx.run(delete(result).where(result.c.id == key))


def _about(part: StoredPart, name: str) -> tuple[np.dtype[Any], tuple[int, ...]]:
    """Type and shape of an array of a part. NotFoundError."""
    if name not in part.arrays:
        names = ", ".join(part.arrays) or "none"
        raise NotFoundError(f"The part {part.name} has no array {name!r}.", remedy=f"It has: {names}.")
    about = part.arrays[name]
    return np.dtype(about["dtype"]), tuple(about["shape"])


def _blocks(values: NDArray[Any]) -> Iterator[bytes]:
    flat = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    for start in range(0, len(flat), BLOCK_BYTES):
        yield zstandard.ZstdCompressor(level=1).compress(flat[start : start + BLOCK_BYTES].tobytes())


def _to_result(row: Row[Any]) -> StoredResult:
    return StoredResult(
        key=row.id,
        uuid=row.uuid,
        project=row.project_name,
        parent=row.parent_uuid,
        analysis=row.analysis,
        name=row.name,
        owner=row.owner,
        inputs=json.loads(row.inputs),
        parameters=json.loads(row.parameters),
        made_with=json.loads(row.made_with),
        created=row.created,
    )
