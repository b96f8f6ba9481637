"""`mcml frames`: ranges of frames of a document, changed."""

from __future__ import annotations

import re
from typing import Annotated, Any

import typer

from schemas.frames import FrameEdits
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, open_library, print_json


def add_to(app: typer.Typer) -> None:
    app.command()(frames)


def frames(
    id: Annotated[str, typer.Argument(help="Document")],
    do: Annotated[str, typer.Argument(help="delete, keep, reverse, move or insert")],
    range: Annotated[str, typer.Argument(metavar="FIRST-LAST", help="Frames, positions from 1")],
    to: Annotated[int | None, typer.Option("--to", help="move, insert: before this frame")] = None,
    source: Annotated[str | None, typer.Option("--from", help="insert: document that has the frames")] = None,
    keep_ids: Annotated[bool, typer.Option("--keep-ids", help="Leave frame ids as they are")] = False,
    message: Annotated[str, typer.Option("-m", "--message", help="Why, for the history")] = "",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Delete, keep, reverse, move or insert a range of frames, as one revision."""
    match = re.fullmatch(r"(\d{1,10})(?:-(\d{1,10}))?", range)
    if match is None or do not in ("delete", "keep", "reverse", "move", "insert"):
        raise typer.BadParameter("say delete, keep, reverse, move or insert, and a range such as 10-20")
    edit: dict[str, Any] = {"do": do, "first": int(match[1]), "last": int(match[2] or match[1])}
    if do in ("move", "insert"):
        if to is None:
            raise typer.BadParameter(f"{do} needs --to FRAME")
        edit["to" if do == "move" else "at"] = to
    if do == "insert" and source is not None:
        edit["document"] = source
    request = FrameEdits(edits=[edit], renumber=not keep_ids, message=message)
    done = open_library(database, server).edit_frames(id, request)
    if as_json:
        print_json(done)
    else:
        console.print(f"revision {done.revision}, {done.frames:,} frames")
