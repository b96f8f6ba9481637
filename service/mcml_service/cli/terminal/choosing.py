"""Options that select documents, and batches that continue after a refusal."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Annotated

import typer

from mcml.client.choosing import choose_documents
from mcml.client.client import Client
from mcml.errors import McmlError
from mcml_schemas.documents import DocumentSummary
from mcml_service.cli.terminal.opening import console, table

IdsArgument = Annotated[
    list[str] | None, typer.Argument(metavar="[ID]...", help="Documents: ids, beginnings of ids, or names")
]
ProjectOption = Annotated[str | None, typer.Option(help="Instead: all documents of this project")]
MotionNameOption = Annotated[str | None, typer.Option(help="Instead: documents with a frame of this name")]
XPathOption = Annotated[str | None, typer.Option("--xpath", help="Instead: documents in which this finds something")]
YesOption = Annotated[bool, typer.Option("--yes", "-y", help="Do it; without this option, list the affected documents")]


def resolve_documents(
    client: Client, ids: list[str] | None, project: str | None, motion_name: str | None, xpath: str | None
) -> list[DocumentSummary]:
    """Return the documents of a command: named ones, or those selected by options; both together are wrong usage."""
    options = [option for option in (project, motion_name, xpath) if option is not None]
    if bool(ids) == bool(options):
        raise typer.BadParameter("name documents, or choose them by --project, --motion-name, --xpath")
    documents = choose_documents(client, ids, project=project, motion_name=motion_name, xpath=xpath)
    if not documents:
        raise McmlError("No document fits.", remedy="Try the same options with `mcml ls`.")
    return documents


def confirm(found: list[DocumentSummary], yes: bool, what: str) -> bool:
    """Tell whether to continue; if not, print the documents and the option for continuing."""
    if yes:
        return True
    rows = table("id", "name", "project", "frames#")
    for item in found:
        rows.add_row(item.id, item.name, item.project, f"{item.frames:,}")
    console.print(rows)
    console.print(f"Nothing was {what}: --yes does it, to all of these ({len(found)}).")
    return False


def for_each(found: list[DocumentSummary], do: Callable[[DocumentSummary], None]) -> None:
    """Process each document; a refusal is printed and does not stop the others.

    Exit code 3, or 1 if all were refused.
    """
    refused = 0
    for item in found:
        try:
            do(item)
        except McmlError as error:
            if len(found) == 1:
                raise
            refused += 1
            print(f"mcml: {item.name} {item.id}: {error}", file=sys.stderr)
    if refused:
        raise typer.Exit(1 if refused == len(found) else 3)
