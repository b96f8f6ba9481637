"""`mcml xpath`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from mcml.client.choosing import id_of
from mcml_schemas.querying.queries import NodeItem, RunItem, ScalarItem, ValueItem
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    JsonOption,
    RawOption,
    ServerOption,
    console,
    open_client,
    print_json,
    table,
    write_blocks,
)
from mcml_service.xpath.answer.writing import STREAMS
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.types import type_of

FORMS = ("runs", "json", "xml", "ndjson", "csv", "count")


def xpath(
    query: Annotated[str, typer.Argument(help="An XPath expression, such as //frame[motion_name='walk']")],
    document: Annotated[list[str] | None, typer.Option(help="Document to ask; may be repeated; default all")] = None,
    revision: Annotated[int | None, typer.Option(min=1, help="With one --document: as this revision left it")] = None,
    project: Annotated[str | None, typer.Option(help="Only this project")] = None,
    as_: Annotated[
        str, typer.Option("--as", help="runs, json or count; or the whole result as xml, ndjson or csv")
    ] = "runs",
    limit: Annotated[int | None, typer.Option(help="Most items; default 1000, for xml, ndjson and csv all")] = None,
    variable: Annotated[
        list[str] | None, typer.Option("--var", help="name=value, for $name in the expression; may be repeated")
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write xml, ndjson or csv to this file")] = None,
    raw: RawOption = False,
    force: ForceOption = False,
    per: Annotated[str | None, typer.Option(help="document: one result per document")] = None,
    guesses: Annotated[
        str, typer.Option(help="no: functions of bodies leave out documents whose unit, up axis or floor is guessed")
    ] = "yes",
    explain: Annotated[bool, typer.Option(help="Say how the query ran")] = False,
    with_: Annotated[str | None, typer.Option("--with", help="Of runs: totals, range, or totals,range")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run an XPath query on the library."""
    if as_ not in FORMS:
        raise typer.BadParameter(f"--as is one of {', '.join(FORMS)}")
    if output is not None and as_ not in STREAMS:
        raise typer.BadParameter(f"--output needs --as {', '.join(STREAMS)}")
    variables = dict(_variable(text) for text in variable or ())
    client = open_client(database, server)
    text = f"count({query})" if as_ == "count" else query
    form = "json" if as_ == "count" or type_of(parse(text, variables).tree) != "nodes" else as_
    asked: dict[str, Any] = {
        "q": text,
        "document": [id_of(client, text) for text in document or ()],
        "project": project,
        "revision": revision,
        "per": per,
        "guesses": guesses,
        "explain": explain,
        "raw": raw,
        "variables": variables,
        "with": with_,
    }
    if form in STREAMS:
        response = client.call("post_query", request=dict(**asked, limit=limit, **{"as": form}))
        write_blocks(response.blocks, output, force=force)
        return
    limit = limit or 1000
    request = dict(**asked, limit=limit, **{"as": form})
    answer = client.call("post_query", request=request)
    if as_json:
        print_json(answer)
        return
    for warning in answer.warnings:
        print(f"mcml: {warning}", file=sys.stderr)
    if answer.value is not None:
        print(_text(answer.value))
    elif answer.type == "runs":
        rows = table("document", "name", "first#", "last#", "frames#", *([answer.range_of] if answer.range_of else []))
        for item in answer.items or []:
            if isinstance(item, RunItem):
                ends = [] if item.range is None else [f"{item.range[0]:g} .. {item.range[1]:g}"]
                rows.add_row(item.document, item.name, str(item.first), str(item.last), str(item.frames), *ends)
        console.print(rows)
        if answer.totals:
            told = answer.totals
            console.print(f"{told.frames:,} frames in {told.runs:,} runs of {told.documents:,} documents", style="dim")
    else:
        for item in answer.items or []:
            if isinstance(item, NodeItem):
                print(f"{item.document} {item.address} {item.value}")
            elif isinstance(item, ScalarItem):
                print(f"{item.document} {_text(item.value)}")
            elif isinstance(item, ValueItem):
                print(_text(item.value))
    if answer.next_cursor:
        print(f"mcml: only the first {limit} items; ask for more with --limit", file=sys.stderr)
    if answer.explain:
        for line in answer.explain.plan:
            print(f"plan: {line}", file=sys.stderr)
        print(f"plan: {answer.explain.way}, {answer.explain.milliseconds:.2f} ms", file=sys.stderr)


def _variable(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not separator:
        raise typer.BadParameter(f"--var {text}: write name=value")
    return name.strip().removeprefix("$"), value


def _text(value: str | float | bool) -> str:
    """A value as XPath's string() writes it: whole numbers without a point."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)
