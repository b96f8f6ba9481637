"""`mcml search`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from mcml.client.choosing import id_of
from mcml.files.on_disk import opened_files
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_client,
    print_json,
    table,
)


def search(
    what: Annotated[list[str], typer.Argument(help="A document, or the files of a clip that need not be stored")],
    first: Annotated[int, typer.Option(min=1, help="Its frame, a position from 1")] = 1,
    last: Annotated[
        int | None, typer.Option(min=1, help="The motion from --first to here; without it the pose in --first")
    ] = None,
    within: Annotated[
        list[str] | None, typer.Option(help="Look in this document; may be repeated; default all")
    ] = None,
    project: Annotated[str | None, typer.Option(help="Look in this project only")] = None,
    limit: Annotated[int, typer.Option(min=1, help="Most hits")] = 20,
    apart: Annotated[
        float | None,
        typer.Option(help="Minimum seconds between hits in one document; default 1, or the duration of the motion"),
    ] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Find the poses or motions of the library that are most similar to a given one, on any rig."""
    client = open_client(database, server)
    inside = [id_of(client, text) for text in within or ()]
    if all(Path(text).is_file() for text in what):
        with opened_files([Path(text) for text in what]) as files:
            answer = client.call(
                "search_file",
                file=files,
                first=first,
                last=last,
                within=inside or None,
                project=project,
                limit=limit,
                apart=apart,
            )
    elif len(what) > 1:
        raise typer.BadParameter("name one document, or files that are there")
    else:
        asked = {
            "document": id_of(client, what[0]),
            "first": first,
            "last": last,
            "within": inside,
            "project": project,
            "limit": limit,
            "apart": apart,
        }
        answer = client.call("search_motion", request=asked)
    if as_json:
        print_json(answer)
        return
    for warning in answer.warnings:
        print(f"mcml: {warning}", file=sys.stderr)
    rows = table("document", "name", "first#", "last#", "distance#")
    for hit in answer.hits:
        rows.add_row(hit.document, hit.name, str(hit.first), str(hit.last), f"{hit.distance:.4f}")
    console.print(rows)
