"""`mcml retarget`: a motion on the skeleton of another document."""

from __future__ import annotations

from typing import Annotated

import typer

from schemas.retarget import RetargetRequest
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, open_library, print_json


def add_to(app: typer.Typer) -> None:
    app.command()(retarget)


def retarget(
    id: Annotated[str, typer.Argument(help="Document with the motion")],
    skeleton: Annotated[str, typer.Argument(help="Document with the skeleton")],
    joints: Annotated[list[str] | None, typer.Option("--joint", help="SOURCE=TARGET, for all that shall move")] = None,
    clean_feet: Annotated[bool, typer.Option("--clean-feet", help="Hold feet where they stand")] = False,
    name: Annotated[str | None, typer.Option(help="Name of the new document; default the source's")] = None,
    project: Annotated[str | None, typer.Option(help="Project of the new document; default the source's")] = None,
    preview: Annotated[bool, typer.Option("--preview", help="Say how well it fits; store nothing")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Bring a motion onto the skeleton of another document, as a new document."""
    pairs = [text.partition("=")[::2] for text in joints or ()]
    if not all(one and other for one, other in pairs):
        raise typer.BadParameter("SOURCE=TARGET, such as left_hand=left_wrist", param_hint="--joint")
    request = RetargetRequest.model_validate(
        {
            "skeleton": skeleton,
            "mapping": [{"source": one, "target": other} for one, other in pairs] or None,
            "clean_feet": clean_feet,
            "name": name,
            "project": project,
            "preview": preview,
        }
    )
    made = open_library(database, server).retarget(id, request)
    if as_json:
        print_json(made)
        return
    console.print(f"{'would make' if preview else 'made'}  {made.document or ''}  {made.frames:,} frames")
    for match in made.matches:
        console.print(f"  {match.source} -> {match.target}  {match.confidence:.2f}  {match.reason}", markup=False)
    for bone in made.bones:
        if bone.leads and bone.mean > 0.5:
            console.print(f"  {bone.bone} to {bone.end}: {bone.mean:.1f} degrees off, {bone.largest:.1f} at most")
    for foot in made.feet:
        console.print(f"  {foot.foot} slides {foot.before:.3g} -> {foot.after:.3g} in {foot.stances} stances")
    for notice in made.notices:
        console.print(f"  {notice}", style="yellow")
