"""`mcml labels`: labels of many documents at once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from schemas.documents import ChangedDocuments
from schemas.labels import LabelQuery
from service.cli.shared import DatabaseOption, ServerOption, console, open_library
from service.errors import McmlError


def add_to(app: typer.Typer) -> None:
    labels = typer.Typer(no_args_is_help=True, help="Labels of many documents: by query, and as tables.")
    labels.command("query")(by_query)
    labels.command("export")(export)
    labels.command("import")(import_)
    app.add_typer(labels, name="labels")


def by_query(
    name: Annotated[str, typer.Argument(help="Motion name")],
    xpath: Annotated[str, typer.Argument(help="An expression that selects the frames")],
    project: Annotated[str | None, typer.Option(help="Only in this project")] = None,
    document: Annotated[list[str] | None, typer.Option(help="Only in this document; may be repeated")] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Take the name off these frames")] = False,
    strict: Annotated[bool, typer.Option(help="Refuse names that are no anatomical movement")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Name all frames that an XPath expression selects."""
    request = LabelQuery(name=name, xpath=xpath, project=project, document=document or [], remove=remove, strict=strict)
    _told(open_library(database, server).label_by_query(request))


def export(
    output: Annotated[Path, typer.Argument(help="CSV file to write")],
    project: Annotated[str | None, typer.Option(help="Only of this project")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Write labels as a table: document, label, first, last."""
    text = open_library(database, server).label_table(project)
    output.write_text(text, encoding="utf-8", newline="")
    console.print(f"wrote    {output}")


def import_(
    table: Annotated[Path, typer.Argument(help="CSV file: document (or name), label, first, last")],
    project: Annotated[str | None, typer.Option(help="Project in which names are looked up")] = None,
    replace: Annotated[bool, typer.Option("--replace", help="The labels that these documents had go")] = False,
    strict: Annotated[bool, typer.Option(help="Refuse names that are no anatomical movement")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Add labels from a table; all of it, or nothing."""
    library = open_library(database, server)
    try:
        _told(library.write_label_table(table.read_bytes(), project, strict=strict, replace=replace))
    except McmlError as error:
        raise error.in_file(table.name) from error


def _told(changed: ChangedDocuments) -> None:
    for item in changed.items:
        console.print(f"changed  {item.name}  {item.id}  revision {item.revision}")
    console.print(f"{len(changed.items)} changed")
