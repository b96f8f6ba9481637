"""`mcml follow`: a document in which a body follows a path."""

from __future__ import annotations

import re
from typing import Annotated

import typer

from mcml.client.choosing import id_of
from mcml_schemas.matching import FollowRequest
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_client,
    print_json,
)
from mcml_service.cli.terminal.requests import request_of

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_POINT = re.compile(rf"({_NUMBER}),({_NUMBER})")


def follow(
    points: Annotated[
        list[str], typer.Argument(help="Points of the path in metres, such as 0,0 4,0 4,4; after -- if one is negative")
    ],
    document: Annotated[list[str] | None, typer.Option(help="Document whose frames are used; may be repeated")] = None,
    all_of: Annotated[str | None, typer.Option("--all-of", help="All documents of this project")] = None,
    motion_name: Annotated[str | None, typer.Option(help="Documents with a frame of this name")] = None,
    xpath: Annotated[str | None, typer.Option(help="Documents in which this finds something")] = None,
    skeleton: Annotated[str | None, typer.Option(help="Document whose skeleton is used")] = None,
    speed: Annotated[float | None, typer.Option(help="Metres a second; default the usual one of the clips")] = None,
    facing: Annotated[float, typer.Option(help="Degrees to the left of the course to which the body faces")] = 0.0,
    steering: Annotated[float, typer.Option(help="Degrees by which each cut may turn the body, at most")] = 10.0,
    name: Annotated[str, typer.Option(help="Name of the new document")] = "path",
    project: Annotated[str, typer.Option(help="Project of the new document")] = "default",
    preview: Annotated[bool, typer.Option("--preview", help="Preview the result without storing it")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make a document in which a body follows a path, of frames of many clips (motion matching)."""
    path = [_point(text) for text in points]
    client = open_client(database, server)
    request = request_of(
        FollowRequest,
        {
            "selection": {
                "documents": [id_of(client, one) for one in document or ()],
                "project": all_of,
                "motion_name": motion_name,
                "xpath": xpath,
            },
            "skeleton": None if skeleton is None else id_of(client, skeleton),
            "path": path,
            "speed": speed,
            "facing": facing,
            "steering": steering,
            "name": name,
            "project": project,
            "preview": preview,
        },
    )
    made = client.call("follow_path", request=request)
    if as_json:
        print_json(made)
        return
    console.print(f"{'would make' if preview else 'made'}  {name}  {made.document or ''}  {made.frames:,} frames")
    console.print(
        f"  {made.metres:.1f} m of the path at {made.speed:.2f} m/s, from it {made.distance.mean:.2f} m on the mean, "
        f"{made.distance.largest:.2f} m at most; {len(made.seams)} cuts"
    )
    for one in made.left_out:
        console.print(f"  left out  {one.name}: {one.reason}")
    for notice in made.notices:
        console.print(f"  {notice}", style="yellow")


def _point(text: str) -> list[float]:
    match = _POINT.fullmatch(text)
    if match is None:
        raise typer.BadParameter(f"{text!r} is not two numbers with a comma, such as 4,0")
    return [float(match[1]), float(match[2])]
