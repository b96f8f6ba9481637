"""`mcml project`: archives, quotas, reviews, and whole projects as files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from mcml.files.on_disk import write_file
from mcml.formats.format import SourceFile
from mcml_schemas.jobs import Selection
from mcml_schemas.selections import ManyCopies
from mcml_service.cli.terminal.opening import DatabaseOption, ForceOption, ServerOption, console, open_client

Project: TypeAlias = Annotated[str, typer.Argument(help="Name of the project")]


def archive(project: Project, database: DatabaseOption = None, server: ServerOption = None) -> None:
    """Archive a project: it becomes read-only."""
    open_client(database, server).call("change_project", project=project, change={"archived": True})
    console.print(f"{project} is archived")


def open_(project: Project, database: DatabaseOption = None, server: ServerOption = None) -> None:
    """Open an archived project for changes."""
    open_client(database, server).call("change_project", project=project, change={"archived": False})
    console.print(f"{project} is open")


def quota(
    project: Project,
    documents: Annotated[int | None, typer.Option(min=0, help="Most documents; 0: no bound")] = None,
    megabytes: Annotated[
        int | None, typer.Option(min=0, help="Most MB of uploaded files and media; 0: no bound")
    ] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Set the quotas of a project; without options, print its use and quotas."""
    client = open_client(database, server)
    size = None if megabytes is None else megabytes * 1_000_000
    if documents is None and size is None:
        told = client.call("get_project", project=project)
    else:
        change = {"most_documents": documents, "most_bytes": size}
        told = client.call("change_project", project=project, change=change)
    of = [f" of {most:,}" if most else "" for most in (told.most_documents, (told.most_bytes or 0) // 1_000_000)]
    console.print(f"{told.documents:,}{of[0]} documents, {told.bytes / 1e6:,.1f}{of[1]} MB")


def review(
    project: Project,
    required: Annotated[bool, typer.Option("--required/--optional", help="Whether changes need a review")] = True,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Require a review: documents change by proposals only, which another editor has approved."""
    open_client(database, server).call("change_project", project=project, change={"review_required": required})
    console.print(f"{project} {'requires' if required else 'does not require'} a review of changes")


def copy(
    project: Annotated[str, typer.Argument(help="Where the copies go")],
    ids: Annotated[list[str], typer.Argument(help="Ids of documents")],
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Copy documents with their whole histories into a project."""
    request = ManyCopies(selection=Selection(documents=ids), project=project)
    for made in open_client(database, server).call("copy_documents", request=request).documents:
        print(made)


def export(
    project: Project,
    file: Annotated[Path | None, typer.Argument(help="File to write; default PROJECT.project.zip")] = None,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Export a whole project with every revision as one file."""
    answer = open_client(database, server).call("export_project", project=project)
    target = file or Path(answer.name or f"{project}.project.zip")
    write_file(target, answer.blocks, force=force)
    console.print(f"wrote    {target}")


def import_(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A file from `mcml project export`")],
    name: Annotated[str | None, typer.Option(help="Default: the original name of the project")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Import a project from an exported file, with every revision, or not at all."""
    with file.open("rb") as stream:
        made = open_client(database, server).call("import_project", file=SourceFile(file.name, stream), name=name)
    console.print(f"{made.project}: {made.documents} documents")
