"""Results of analyses: listed, read part by part, deleted."""

from __future__ import annotations

import io
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from schemas.examples import RESULT
from schemas.jobs import ArrayValues, PartSummary, Result, ResultPage
from service.actions.analysing.describe_job import part_answer, result_answer
from service.errors import NotFoundError, SizeError
from service.operations.arguments import MOST, InProject, Page
from service.operations.call import Call, Content
from service.operations.operation import gives
from service.storage.database import Transaction
from service.storage.results import StoredPart, StoredResult

ResultId = Annotated[str, Field(description="Id of the result", examples=[RESULT])]
PartName = Annotated[str, Field(description="Name of the part", examples=["speed"])]

INLINE_NUMBERS = 2_000_000
"""Most numbers in one JSON answer."""


def list_results(
    call: Call,
    page: Page,
    project: InProject = None,
    analysis: Annotated[str | None, Field(description="Results of this analysis", examples=["beats"])] = None,
    parent: Annotated[str | None, Field(description="Results made from this one", examples=[RESULT])] = None,
) -> ResultPage:
    before = page.after(int)
    with call.database.read() as tx:
        found = tx.results.page(
            project_name=project,
            analysis=analysis,
            parent=parent,
            before=None if before is None else before[0],
            limit=page.most(call) + 1,
        )
    shown, more = page.cut(call, found, lambda result: (result.key,))
    return ResultPage(items=[result_answer(result) for result in shown], next_cursor=more)


def get_result(call: Call, id: ResultId) -> Result:
    """Arrays are fetched one by one."""
    with call.database.read() as tx:
        stored = tx.results.get(id)
        return result_answer(stored, tx.results.parts(stored.key))


def delete_result(call: Call, id: ResultId) -> None:
    """Documents that were stored from it stay."""
    with call.database.write(call.author) as tx:
        tx.results.remove(tx.results.get(id).key)
    call.repository.results.forget(id)


def get_result_part(call: Call, id: ResultId, part: PartName) -> PartSummary:
    with call.database.read() as tx:
        return part_answer(_part(tx, id, part)[1])


@gives("Rows of the array; or with `format=npy` a NumPy file", {"application/octet-stream": None})
def get_result_array(
    call: Call,
    id: ResultId,
    part: PartName,
    array: Annotated[str, Field(description="Name of the array", examples=["speed"])],
    first: Annotated[int, Field(ge=0, le=MOST, description="First row, from 0", examples=[0])] = 0,
    rows: Annotated[int | None, Field(ge=1, le=MOST, description="Most rows; default all", examples=[100])] = None,
    format: Annotated[Literal["json", "npy"], Field(description="JSON, or a NumPy file")] = "json",
) -> ArrayValues | Content:
    with call.database.read() as tx:
        stored, found = _part(tx, id, part)
        values = tx.results.array(stored.key, found, array)
    chosen = values[first : None if rows is None else first + rows] if values.ndim else values
    if format == "npy":
        return npy(chosen, f"{part}-{array}")
    if chosen.size > INLINE_NUMBERS:
        raise SizeError(
            f"The array has {chosen.size:,} numbers.", remedy="Fetch it with format=npy, or some rows of it."
        )
    plain = chosen.astype(object) if chosen.dtype.kind == "f" else chosen
    if chosen.dtype.kind == "f":
        plain[~np.isfinite(chosen)] = None
    return ArrayValues(
        dtype=values.dtype.str, shape=list(values.shape), first=first, values=np.atleast_1d(plain).tolist()
    )


def npy(values: Any, name: str) -> Content:
    """An array as the file that numpy.save writes."""
    content = io.BytesIO()
    np.save(content, values)
    return Content(iter([content.getvalue()]), "application/octet-stream", f"{name}.npy")


def _part(tx: Transaction, uuid: str, name: str) -> tuple[StoredResult, StoredPart]:
    stored = tx.results.get(uuid)
    parts = {part.name: part for part in tx.results.parts(stored.key)}
    if name not in parts:
        raise NotFoundError(f"The result has no part {name!r}.", remedy=f"It has: {', '.join(parts) or 'none'}.")
    return stored, parts[name]
