"""`mcml history diff undo restore`: the revisions of a document."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from schemas.documents import DocumentDetail, RevisionPage
from schemas.revisions import Difference, FrameRange
from service.cli.shared import (
    DatabaseOption,
    JsonOption,
    RevisionOption,
    ServerOption,
    console,
    if_match,
    open_api,
    print_json,
    table,
)

IdArgument = Annotated[str, typer.Argument(help="Document")]


def add_to(app: typer.Typer) -> None:
    for command in (history, diff, undo, restore):
        app.command()(command)


def history(
    id: IdArgument,
    limit: Annotated[int, typer.Option(min=1, help="Most revisions")] = 100,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List the revisions of a document, the newest first: who changed it, when and why."""
    api, asked = open_api(database, server), {"limit": limit}
    page = RevisionPage(**api.send("GET", f"/documents/{id}/revisions", params=asked).json())
    if as_json:
        print_json(page)
        return
    rows = table("revision#", "time", "author", "what", "why")
    for item in page.items:
        rows.add_row(f"{item.number}", item.time, item.author, item.operation, item.message)
    console.print(rows)


def diff(
    id: IdArgument,
    before: Annotated[int, typer.Argument(min=1, help="The earlier revision")],
    after: Annotated[int | None, typer.Argument(min=1, help="The later revision; default the current one")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say what differs between two revisions: elements, frames, labels, samples, angles between poses."""
    asked = {"before": before} | ({} if after is None else {"after": after})
    found = Difference(**open_api(database, server).send("GET", f"/documents/{id}/difference", params=asked).json())
    if as_json:
        print_json(found)
        return
    for element in found.elements:
        for sign, text in (("-", element.before), ("+", element.after)):
            if text is not None:
                console.print(f"{sign} {element.address}  {text}")
    if found.frames_before != found.frames_after or found.frames_moved:
        console.print(f"frames {found.frames_before:,} -> {found.frames_after:,}")
    for sign, ranges in (("-", found.frames_removed), ("+", found.frames_added)):
        for item in ranges:
            console.print(f"{sign} frames {_range(item)}")
    for sign, labels in (("-", found.labels_removed), ("+", found.labels_added)):
        for label in labels:
            console.print(f"{sign} {label.first}-{label.last}  {label.name}")
    for bone in found.bones:
        channels = ", ".join(f"{name} by {value:.6g}" for name, value in bone.channels.items())
        angle = "" if bone.angle is None else f"; {bone.angle:.6g} degrees"
        console.print(f"~ {bone.bone}  {bone.first}-{bone.last}, {bone.frames:,} frames: {channels}{angle}")


def undo(
    id: IdArgument,
    undone: Annotated[
        int | None, typer.Argument(metavar="REVISION", min=1, help="What to take back; default the last one")
    ] = None,
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Take back what one revision did, as a new revision, if nothing later touched the same."""
    _change("undo", id, undone, revision, database, server, as_json)


def restore(
    id: IdArgument,
    restored: Annotated[
        int | None, typer.Argument(metavar="REVISION", min=1, help="Its content becomes current again")
    ] = None,
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Bring a deleted document back, or make an earlier revision current, as a new revision."""
    _change("restore", id, restored, revision, database, server, as_json)


def _change(
    what: str,
    id: str,
    number: int | None,
    revision: int | None,
    database: str | None,
    server: str | None,
    as_json: bool,
) -> None:
    asked: dict[str, Any] = {} if number is None else {"revision": number}
    api, headers = open_api(database, server), if_match(revision)
    made = DocumentDetail(**api.send("POST", f"/documents/{id}/{what}", params=asked, headers=headers).json())
    if as_json:
        print_json(made)
    else:
        console.print(f"revision {made.revision}, {made.frames:,} frames")


def _range(frames: FrameRange) -> str:
    return f"{frames.first}-{frames.last}"
