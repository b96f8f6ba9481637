"""`mcml compose`: a new document from frames of others."""

from __future__ import annotations

import re
from typing import Annotated, Any

import typer

from schemas.compose import Composed, ComposeRequest, SplitParts, SplitRequest
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, open_api, print_json

_RANGE = re.compile(
    r"(?P<document>[0-9a-fA-F-]{36})(?:@(?P<revision>\d{1,9}))?(?::(?P<first>\d{1,9})-(?P<last>\d{1,9}))?"
)


def add_to(app: typer.Typer) -> None:
    app.command()(compose)
    app.command()(split)


def compose(
    segments: Annotated[
        list[str], typer.Argument(help="ID, ID:FIRST-LAST, ID@REVISION:FIRST-LAST, or an XPath expression, in order")
    ],
    transition: Annotated[int, typer.Option(help="Frames between segments")] = 12,
    style: Annotated[str, typer.Option(help="bridge or crossfade")] = "bridge",
    rate: Annotated[float | None, typer.Option(help="Frames a second; default the first segment's")] = None,
    align: Annotated[bool, typer.Option(help="Let the body go on where it stands")] = True,
    header: Annotated[str | None, typer.Option(help="Document whose header is used")] = None,
    skeleton: Annotated[str | None, typer.Option(help="Document whose skeleton is used")] = None,
    name: Annotated[str, typer.Option(help="Name of the new document")] = "composed",
    project: Annotated[str, typer.Option(help="Project of the new document")] = "default",
    preview: Annotated[bool, typer.Option("--preview", help="Say what would be made; store nothing")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make a document of frames of others, with transitions between them."""
    request = ComposeRequest.model_validate(
        {
            "segments": [_segment(text) for text in segments],
            "transition": transition,
            "style": style,
            "rate": rate,
            "align": align,
            "header": header,
            "skeleton": skeleton,
            "name": name,
            "project": project,
            "preview": preview,
        }
    )
    asked = request.model_dump(exclude_unset=True, exclude_none=True)
    made = Composed(**open_api(database, server).send("POST", "/compose", json=asked).json())
    if as_json:
        print_json(made)
        return
    console.print(f"{'would make' if preview else 'made'}  {name}  {made.document or ''}  {made.frames:,} frames")
    for seam in made.seams:
        console.print(
            f"  frame {seam.first}: {seam.transition} frames of transition, turned {seam.degrees:.1f} degrees, "
            f"largest step {max(seam.root_step, seam.angle_step):.2f} of those inside"
        )
    for notice in made.notices:
        console.print(f"  {notice}", style="yellow")


def split(
    id: Annotated[str, typer.Argument(help="Document")],
    at: Annotated[list[int] | None, typer.Argument(min=2, help="First frames of the parts after the first")] = None,
    label: Annotated[str | None, typer.Option(help="Instead: every range of this motion name is a part")] = None,
    project: Annotated[str | None, typer.Option(help="Project of the parts; default the document's")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Store parts of a document as documents of their own; it stays itself."""
    if bool(at) == (label is not None):
        raise typer.BadParameter("say before which frames, or around which --label")
    body = SplitRequest(at=at or [], label=label, project=project).model_dump(exclude_none=True)
    made = SplitParts(**open_api(database, server).send("POST", f"/documents/{id}/split", json=body).json())
    if as_json:
        print_json(made)
        return
    for part in made.items:
        console.print(f"made  {part.name}  {part.document}")


def _segment(text: str) -> dict[str, Any]:
    match = _RANGE.fullmatch(text)
    if match is None:
        if re.match(r"[0-9a-fA-F-]{36}[@:]", text):
            raise typer.BadParameter(f"{text!r} is not ID:FIRST-LAST or ID@REVISION:FIRST-LAST, frames counted from 1")
        return {"xpath": text}
    found = {key: int(value) for key, value in match.groupdict().items() if value is not None and key != "document"}
    return {"document": match["document"], **found}
