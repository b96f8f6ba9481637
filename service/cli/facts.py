"""`mcml set`: what people state of a document."""

from __future__ import annotations

from typing import Annotated

import typer

from schemas.documents import DocumentChange, DocumentDetail
from service.cli.shared import (
    DatabaseOption,
    JsonOption,
    MessageOption,
    RevisionOption,
    ServerOption,
    console,
    if_match,
    open_api,
    print_json,
)


def add_to(app: typer.Typer) -> None:
    app.command("set")(set_)


def set_(
    id: Annotated[str, typer.Argument(help="Document")],
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, such as 0.0083333")] = None,
    unit: Annotated[str | None, typer.Option(help="Length unit, such as cm; empty: unknown")] = None,
    up: Annotated[str | None, typer.Option(help="Axis that points up, X, Y or Z; empty: unknown")] = None,
    name: Annotated[str | None, typer.Option(help="Another name")] = None,
    project: Annotated[str | None, typer.Option(help="Another project")] = None,
    description: Annotated[str | None, typer.Option(help="What it is; empty: nothing")] = None,
    message: MessageOption = "",
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """State what the files of a document do not say, or give it another name or project. Nothing is converted."""
    stated = {"frame_time": frame_time, "unit": unit, "up": up, "name": name, "project": project}
    stated |= {"description": description}
    given = {key: value for key, value in stated.items() if value is not None}
    if not given:
        raise typer.BadParameter("say what: --frame-time, --unit, --up, --name, --project or --description")
    body = DocumentChange(**given, message=message).model_dump(exclude_unset=True)
    answer = open_api(database, server).send("PATCH", f"/documents/{id}", json=body, headers=if_match(revision))
    made = DocumentDetail(**answer.json())
    if as_json:
        print_json(made)
    else:
        console.print(f"revision {made.revision}, {made.frames:,} frames")
