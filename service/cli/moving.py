"""`mcml project export` and `import`: whole projects as files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcml.files import write_file
from service.cli.shared import DatabaseOption, ForceOption, ServerOption, console, opened
from service.formats.format import SourceFile


def export(
    project: Annotated[str, typer.Argument(help="Name of the project")],
    file: Annotated[Path | None, typer.Argument(help="File to write; default PROJECT.project.zip")] = None,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Write a whole project with every revision as one file."""
    answer = opened(database, server).call("export_project", project=project)
    target = file or Path(answer.name or f"{project}.project.zip")
    write_file(target, answer.blocks, force=force)
    console.print(f"wrote    {target}")


def import_(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="What `mcml project export` wrote")],
    name: Annotated[str | None, typer.Option(help="Default: as the project was called")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Make a project of such a file, with every revision, or nothing at all."""
    with file.open("rb") as stream:
        made = opened(database, server).call("import_project", file=SourceFile(file.name, stream), name=name)
    console.print(f"{made.project}: {made.documents} documents")
