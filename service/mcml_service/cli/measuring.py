"""`mcml measure`: quantities in frame ranges of many clips, as a table with outliers first."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from mcml.client.choosing import id_of
from mcml.errors import RequestError
from mcml_schemas.measure import Measures, MeasureTable
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    JsonOption,
    RawOption,
    ServerOption,
    console,
    open_client,
    print_json,
    write_blocks,
)
from mcml_service.cli.terminal.opening import table as new_table

_FORMS = ("csv", "arrow", "parquet", "npz")


def measure(
    ids: Annotated[
        list[str] | None, typer.Argument(metavar="[ID]...", help="Documents, or collection:NAME", show_default=False)
    ] = None,
    quantity: Annotated[
        list[str] | None, typer.Option(help="Such as angle:left-knee-flexion or speed:right_hand; may be repeated")
    ] = None,
    project: Annotated[str | None, typer.Option(help="All documents of this project")] = None,
    motion_name: Annotated[str | None, typer.Option(help="Documents with a frame of this name")] = None,
    query: Annotated[
        str | None, typer.Option(help="An XPath expression; the frame ranges that it finds are measured")
    ] = None,
    cycles: Annotated[
        list[str] | None, typer.Option(help="Label whose occurrences are measured; may be repeated")
    ] = None,
    strides: Annotated[bool, typer.Option("--strides", help="Measure strides of gait")] = False,
    by: Annotated[
        list[str] | None,
        typer.Option(help="Groups: clip, label, side, person, project, property:NAME; may be repeated; default side"),
    ] = None,
    guesses: Annotated[
        Literal["yes", "no"], typer.Option(help="no: leave out clips where a quantity depends on a guess")
    ] = "yes",
    limit: Annotated[int, typer.Option(min=1, max=10_000, help="Most rows to print")] = 100,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write all rows: .csv, .npz, .arrow or .parquet")
    ] = None,
    table: Annotated[
        MeasureTable, typer.Option(help="Rows of the file: ranges, points of their curves, or points of groups")
    ] = "ranges",
    raw: RawOption = False,
    force: ForceOption = False,
    as_json: JsonOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Measure quantities in many clips, frame ranges, cycles or strides: a table with outliers first, and mean
    curves."""
    form = "json" if output is None else output.suffix.removeprefix(".").lower()
    if output is not None and form not in _FORMS:
        raise RequestError(f"{output} is no table by its name.", remedy=f"End it in one of: .{', .'.join(_FORMS)}.")
    if not quantity:
        raise RequestError("No quantity is stated.", remedy="State one: --quantity angle:left-knee-flexion.")
    client = open_client(database, server)
    conditions: dict[str, Any] = {"project": project, "motion_name": motion_name}
    selection = {name: value for name, value in conditions.items() if value is not None}
    if ids:
        selection["documents"] = [id_of(client, text) for text in ids]
    request = {
        "selection": selection or None,
        "query": query,
        "quantities": quantity,
        "cycles": cycles or [],
        "strides": strides,
        "by": by or ["side"],
        "guesses": guesses,
        "limit": limit,
        "as": form,
        "table": table,
        "raw": raw,
    }
    answer = client.call("measure", request=request)
    if output is not None:
        write_blocks(answer.blocks, output, force=force)
    elif as_json:
        print_json(answer)
    else:
        _print(answer)


def _print(found: Measures) -> None:
    headings = ("min#", "max#", "mean#", "SD#", "at max (s)#", "score#")
    rows = new_table("name", "first#", "last#", "quantity", "unit", *headings)
    for row in found.ranges:
        figures = (row.minimum, row.maximum, row.mean, row.sd, row.max_time, row.score)
        shown = ["" if value is None else f"{value:.4g}" for value in figures]
        rows.add_row(
            row.name, str(row.first), str(row.last), row.quantity, row.unit, *shown,
            style="yellow" if row.outlier else None,
        )  # fmt: skip
    console.print(rows)
    groups = new_table("quantity", "group", "ranges#", "min#", "max#", "mean#", "range#")
    for group in found.groups:
        means = (group.minimum, group.maximum, group.mean, group.range)
        shown = [f"{each.mean:.4g}" + ("" if each.sd is None else f" ± {each.sd:.2g}") for each in means]
        groups.add_row(group.quantity, " ".join(group.group.values()), str(group.ranges), *shown)
    console.print(groups)
    for warning in found.warnings:
        print(f"mcml: {warning}", file=sys.stderr)
