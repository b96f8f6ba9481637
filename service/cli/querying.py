"""`mcml xpath`."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from schemas.queries import NodeItem, QueryRequest, RunItem, ScalarItem
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, open_library, print_json, table
from service.xpath.parse import parse
from service.xpath.tree import type_of


def add_to(app: typer.Typer) -> None:
    app.command()(xpath)


def xpath(
    query: Annotated[str, typer.Argument(help="An XPath expression, such as //frame[motion_name='walk']")],
    document: Annotated[list[str] | None, typer.Option(help="Document to ask; may be repeated; default all")] = None,
    project: Annotated[str | None, typer.Option(help="Only this project")] = None,
    as_: Annotated[str, typer.Option("--as", help="runs, json, xml or count")] = "runs",
    limit: Annotated[int, typer.Option(help="Most items")] = 1000,
    explain: Annotated[bool, typer.Option(help="Say how the query ran")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Ask the library an XPath question."""
    if as_ not in ("runs", "json", "xml", "count"):
        raise typer.BadParameter("--as is runs, json, xml or count")
    library = open_library(database, server)
    text = f"count({query})" if as_ == "count" else query
    form = "json" if as_ == "count" or type_of(parse(text).tree) != "nodes" else as_
    request = QueryRequest(
        q=text, document=document or [], project=project, limit=limit, explain=explain, **{"as": form}
    )
    answer = library.query(request)
    if as_json:
        print_json(answer)
        return
    for warning in answer.warnings:
        print(f"mcml: {warning}", file=sys.stderr)
    if answer.value is not None:
        print(_text(answer.value))
    elif answer.type == "runs":
        rows = table("document", "name", "first#", "last#", "frames#")
        for item in answer.items or []:
            if isinstance(item, RunItem):
                rows.add_row(item.document, item.name, str(item.first), str(item.last), str(item.frames))
        console.print(rows)
    else:
        for item in answer.items or []:
            if isinstance(item, NodeItem):
                print(item.value if as_ == "xml" else f"{item.document} {item.address} {item.value}")
            elif isinstance(item, ScalarItem):
                print(f"{item.document} {_text(item.value)}")
    if answer.next_cursor:
        print(f"mcml: only the first {limit} items; ask for more with --limit", file=sys.stderr)
    if answer.explain:
        for line in answer.explain.plan:
            print(f"plan: {line}", file=sys.stderr)
        print(f"plan: {answer.explain.way}, {answer.explain.milliseconds:.2f} ms", file=sys.stderr)


def _text(value: str | float | bool) -> str:
    """A value as XPath's string() writes it: whole numbers without a point."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)
