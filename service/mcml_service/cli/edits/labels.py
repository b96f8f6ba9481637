"""`mcml label` and `mcml labels suggest`: motion names for frames."""

from __future__ import annotations

import sys
from typing import Annotated, Literal

import typer

from mcml.client.choosing import id_of
from mcml.files.import_options import Label, parse_label
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_client,
    print_json,
    write_to_the_end,
)
from mcml_service.cli.terminal.present import present
from mcml_service.operations import OPERATIONS

StrictOption = Annotated[bool, typer.Option("--strict", help="Refuse names that are no anatomical movement")]


def label(
    id: Annotated[str, typer.Argument(help="Document")],
    labels: Annotated[list[str], typer.Argument(help="NAME:FIRST-LAST, or NAME for all frames")],
    strict: StrictOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Label frames of a document."""
    write_to_the_end()
    client = open_client(database, server)
    document = client.call("get_document", id=id_of(client, id))
    id, frames = document.id, document.frames
    asked = [_range(parse_label(text), frames) for text in labels]
    added = client.call("add_labels", id=id, labels=asked, strict=strict, if_match="*")
    if as_json:
        print_json(added)
        return
    for item in added.items:
        console.print(f"named    {item.first}-{item.last}  {item.name}")


def suggest(
    id: Annotated[str, typer.Argument(help="Document")],
    kind: Annotated[
        Literal["activities", "movements"],
        typer.Option(help="Of the body in everyday words, or of joints in the words of anatomy"),
    ] = "activities",
    confidence: Annotated[float, typer.Option(min=0, max=1, help="The least, 0 to 1")] = 0.5,
    facing: Annotated[
        str | None,
        typer.Option(
            help="For movements: facing direction of the upright body, such as Z or -X; default: from joint names"
        ),
    ] = None,
    accept: Annotated[bool, typer.Option("--accept", help="Name the frames so, as one revision")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Find activities in a motion, such as walk, turn left or sit, as names for its frames."""
    write_to_the_end()
    client = open_client(database, server)
    id = id_of(client, id)
    asked_facing = facing and facing.upper()
    suggestions = client.call("suggest_labels", id=id, kind=kind, confidence=confidence, facing=asked_facing)
    if accept and suggestions.items:
        asked = [{"name": item.name, "first": item.first, "last": item.last} for item in suggestions.items]
        client.call("add_labels", id=id, labels=asked, strict=kind == "movements", if_match="*")
    present(OPERATIONS["suggest_labels"], suggestions, as_json)
    if not as_json:
        console.print(f"{len(suggestions.items)} {'accepted' if accept else 'suggested'}")
        for warning in suggestions.warnings:
            print(f"mcml: {warning}", file=sys.stderr)


def _range(label: Label, frames: int) -> dict[str, str | int]:
    first = 1 if label.first is None else label.first
    return {"name": label.name, "first": first, "last": frames if label.last is None else label.last}
