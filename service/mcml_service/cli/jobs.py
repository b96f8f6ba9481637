"""`mcml jobs watch`: a job followed to its end."""

from __future__ import annotations

from typing import Annotated

import typer

from mcml.client.client import follow
from mcml_service.cli.commands import add_group
from mcml_service.cli.terminal.opening import DatabaseOption, JsonOption, ServerOption, console, open_client
from mcml_service.cli.terminal.present import present
from mcml_service.operations import OPERATIONS

JobArgument = Annotated[str, typer.Argument(help="Job")]


def add_to(app: typer.Typer) -> None:
    app.command()(watch)
    add_group(app, "jobs")


def watch(
    id: JobArgument, database: DatabaseOption = None, server: ServerOption = None, as_json: JsonOption = False
) -> None:
    """Wait until a job has ended."""
    client = open_client(database, server)
    with console.status("waiting") as line:
        ended = follow(client, client.call("get_job", id=id), lambda stage, share: line.update(f"{share:.0%} {stage}"))
    present(OPERATIONS["get_job"], ended, as_json)
