"""Results of analyses: listed, read part by part, deleted."""

from __future__ import annotations

import io
from typing import Annotated, Any, Literal
from zlib import crc32

import numpy as np
from pydantic import Field

from mcml.answers import Content
from mcml.errors import NotFoundError, SizeError
from mcml_schemas.examples import RESULT
from mcml_schemas.jobs import ArrayValues, PartSummary, Result, ResultPage
from mcml_service.actions.analysing.describe_job import part_answer, result_answer
from mcml_service.actions.analysing.write_table import write_table
from mcml_service.operations.arguments import MOST, InProject, Page
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.results import StoredPart, StoredResult

ResultId = Annotated[str, Field(description="Id of the result", examples=[RESULT])]
PartName = Annotated[str, Field(description="Name of the part", examples=["speed"])]

INLINE_NUMBERS = 2_000_000
"""Most numbers in one JSON answer."""

MOST_ROWS = 500
"""Limit of rows named in one request."""


def list_results(
    call: Call,
    page: Page,
    project: InProject = None,
    analysis: Annotated[str | None, Field(description="Results of this analysis", examples=["beats"])] = None,
    parent: Annotated[str | None, Field(description="Results made from this one", examples=[RESULT])] = None,
) -> ResultPage:
    before = page.after(int)
    with call.database.read() as tx:
        results = tx.results.page(
            project_name=project,
            analysis=analysis,
            parent=parent,
            before=None if before is None else before[0],
            limit=page.most(call) + 1,
        )
    shown, more = page.cut(call, results, lambda result: (result.key,))
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
    call.results.forget(id)


@gives("The part; or with `format=csv` the rows of a table", {"text/csv": None})
def get_result_part(
    call: Call,
    id: ResultId,
    part: PartName,
    format: Annotated[
        Literal["json", "csv"], Field(description="JSON; or CSV, of a table, with units in the headings")
    ] = "json",
) -> PartSummary | Content:
    with call.database.read() as tx:
        stored, found = _part(tx, id, part)
    if format == "json":
        return part_answer(found)
    return Content(write_table(found), "text/csv; charset=utf-8", f"{stored.name}-{part}.csv")


@gives("Rows of the array; or with `format=npy` a NumPy file", {"application/octet-stream": None})
def get_result_array(
    call: Call,
    id: ResultId,
    part: PartName,
    array: Annotated[str, Field(description="Name of the array", examples=["speed"])],
    first: Annotated[int, Field(ge=0, le=MOST, description="First row, from 0", examples=[0])] = 0,
    rows: Annotated[int | None, Field(ge=1, le=MOST, description="Most rows; default all", examples=[100])] = None,
    row: Annotated[
        list[int] | None,
        Field(max_length=MOST_ROWS, description="These rows alone, in this order, from 0", examples=[[0, 5]]),
    ] = None,
    dtype: Annotated[
        Literal["f4"] | None, Field(description="Numbers in single precision; default as they were computed")
    ] = None,
    format: Annotated[Literal["json", "npy"], Field(description="JSON, or a NumPy file")] = "json",
) -> ArrayValues | Content:
    """A result never changes, so the answer can be cached."""
    with call.database.read() as tx:
        stored, stored_part = _part(tx, id, part)
        asked = crc32(repr((id, part, array, first, rows, row, dtype, format)).encode())
        call.set_tag(f"{array}-{asked:08x}", lasting=True)
        if row is not None:
            values = tx.results.rows(stored.key, stored_part, array, np.array(row, dtype=np.intp))
        else:
            values = tx.results.array(stored.key, stored_part, array)
    if dtype is not None:
        values = values.astype("<f4")
    whole = row is not None or not values.ndim
    chosen = values if whole else values[first : None if rows is None else first + rows]
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


@gives("The picture", {"image/svg+xml": None, "image/png": None})
def get_result_picture(
    call: Call,
    id: ResultId,
    name: Annotated[
        str | None, Field(description="Which picture: one of the analysis, or a part", examples=["map"])
    ] = None,
    format: Annotated[Literal["svg", "png"], Field(description="SVG, or PNG", examples=["svg"])] = "svg",
    dpi: Annotated[int, Field(ge=30, le=600, description="Dots an inch, of PNG", examples=[200])] = 200,
    width: Annotated[
        float | None, Field(ge=1, le=30, description="Inches; default as it is meant", examples=[7.0])
    ] = None,
    height: Annotated[
        float | None, Field(ge=1, le=30, description="Inches; default as it is meant", examples=[7.0])
    ] = None,
) -> Content:
    """For a page or a paper; needs the extra `plots`. A result never changes, so the answer can be cached."""
    from mcml_service.actions.analysing.draw_result import draw_result

    with call.database.read() as tx:
        asked = crc32(repr((id, name, format, dpi, width, height)).encode())
        call.set_tag(f"picture-{asked:08x}", lasting=True)
        chosen, data = draw_result(tx, id, name, format, dpi, (width, height))
    kind = {"svg": "image/svg+xml", "png": "image/png"}[format]
    return Content(iter([data]), kind, f"{chosen}.{format}", size=len(data), shown=True)


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
