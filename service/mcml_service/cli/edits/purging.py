"""`mcml purge`: remove documents permanently."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from mcml.client.choosing import choose_documents
from mcml.errors import McmlError
from mcml_service.cli.terminal.choosing import YesOption
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    choose_settings,
    console,
    open_database,
    print_json,
    table,
)
from mcml_service.local_store import Local

if TYPE_CHECKING:
    from mcml_service.actions.keeping.purge_documents import Purgeable


def purge(
    ids: Annotated[list[str] | None, typer.Argument(help="Full ids of documents, deleted or not")] = None,
    deleted_before: Annotated[
        float | None, typer.Option(min=0, help="Also all documents that were deleted so many days ago or longer")
    ] = None,
    project: Annotated[str | None, typer.Option(help="Also all documents of this project that are not deleted")] = None,
    motion_name: Annotated[str | None, typer.Option(help="Of those, the ones with a frame of this name")] = None,
    xpath: Annotated[
        str | None, typer.Option("--xpath", help="Of those, the ones in which this finds something")
    ] = None,
    yes: YesOption = False,
    database: DatabaseOption = None,
    as_json: JsonOption = False,
) -> None:
    """Remove documents permanently: all revisions and files, and results made only from them. This cannot be undone."""
    chooses = any(option is not None for option in (project, motion_name, xpath))
    if not ids and deleted_before is None and not chooses:
        raise McmlError("Nothing is named.", remedy="Name full ids, --deleted-before DAYS, or --project NAME.")
    from mcml_service.actions.keeping.purge_documents import purge_documents, purgeable

    settings = choose_settings(database)
    store = open_database(settings)
    wanted = list(ids or ())
    if chooses:
        with Local(store, settings) as client:
            chosen = choose_documents(client, project=project, motion_name=motion_name, xpath=xpath)
            wanted += [item.id for item in chosen]
    documents = purgeable(store, wanted, deleted_before)
    done = 0
    if yes:
        done = purge_documents(store, [document.uuid for document in documents], cache_dir=settings.cache_dir)
    if as_json:
        print_json({"purged": done, "documents": [asdict(document) for document in documents]})
        return
    _show(documents)
    if yes:
        console.print(f"purged {done} documents. Backups made before still hold them.")
    elif documents:
        console.print("Nothing was purged: --yes does it, and nothing brings them back. Older backups still hold them.")


def _show(found: list[Purgeable]) -> None:
    rows = table("id", "name", "project", "deleted", "revisions#", "MB#")
    for document in found:
        rows.add_row(
            document.uuid,
            document.name,
            document.project,
            document.deleted or "no",
            str(document.revisions),
            f"{document.bytes / 1e6:,.1f}",
        )
    if found:
        console.print(rows)
    else:
        console.print("no such documents")
    for document in found:
        for kind, made in (("clip", document.clips), ("model or result", document.results)):
            for uuid, name in made:
                console.print(f"stays    the {kind} {name} ({uuid}) was made from {document.name}, among others")
