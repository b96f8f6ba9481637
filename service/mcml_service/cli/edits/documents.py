"""`mcml delete`, `rename`, `move`, `set`: changes of one or many documents."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from mcml.client.choosing import id_of
from mcml_schemas.documents import DocumentDetail
from mcml_service.cli.terminal.choosing import (
    IdsArgument,
    MotionNameOption,
    ProjectOption,
    XPathOption,
    YesOption,
    confirm,
    for_each,
    resolve_documents,
)
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    MessageOption,
    RevisionOption,
    ServerOption,
    console,
    match_of,
    open_client,
    print_json,
    write_to_the_end,
)


def delete(
    ids: IdsArgument = None,
    project: ProjectOption = None,
    motion_name: MotionNameOption = None,
    xpath: XPathOption = None,
    yes: YesOption = False,
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Delete documents. They are only hidden: `mcml restore ID` restores one."""
    write_to_the_end()
    client = open_client(database, server)
    documents = resolve_documents(client, ids, project, motion_name, xpath)
    if not confirm(documents, yes, "deleted"):
        return

    def delete_one(item: Any) -> None:
        client.call("delete_document", id=item.id, if_match=match_of(revision))
        console.print(f"deleted  {item.name}  {item.id}")

    for_each(documents, delete_one)


def rename(
    id: Annotated[str, typer.Argument(help="Document: id, beginning of an id, or name")],
    name: Annotated[str, typer.Argument(help="Its new name")],
    message: MessageOption = "",
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Rename a document."""
    write_to_the_end()
    client = open_client(database, server)
    change = {"name": name, "message": message}
    _print_changes(
        client.call("change_document", id=id_of(client, id), change=change, if_match=match_of(revision)),
        as_json,
    )


def move(
    to: Annotated[str, typer.Argument(metavar="PROJECT", help="Project that they go to; made if new")],
    ids: IdsArgument = None,
    project: ProjectOption = None,
    motion_name: MotionNameOption = None,
    xpath: XPathOption = None,
    yes: YesOption = False,
    message: MessageOption = "",
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Move documents to a project."""
    write_to_the_end()
    client = open_client(database, server)
    documents = resolve_documents(client, ids, project, motion_name, xpath)
    if not confirm(documents, yes, "moved"):
        return
    change = {"project": to, "message": message}

    def move_one(item: Any) -> None:
        client.call("change_document", id=item.id, change=change, if_match="*")
        console.print(f"moved    {item.name}  {item.id}  to {to}")

    for_each(documents, move_one)


def set_(
    ids: IdsArgument = None,
    project: ProjectOption = None,
    motion_name: MotionNameOption = None,
    xpath: XPathOption = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, such as 0.0083333")] = None,
    unit: Annotated[str | None, typer.Option(help="Length unit, such as cm; empty: unknown")] = None,
    up: Annotated[str | None, typer.Option(help="Axis that points up, X, Y or Z; empty: unknown")] = None,
    description: Annotated[str | None, typer.Option(help="Description; empty: none")] = None,
    message: MessageOption = "",
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Set values that the files of documents do not state. Nothing is converted; each change is a revision."""
    stated = {"frame_time": frame_time, "unit": unit, "up": up, "description": description}
    facts = {key: value for key, value in stated.items() if value is not None}
    if not facts:
        raise typer.BadParameter("say what: --frame-time, --unit, --up or --description")
    write_to_the_end()
    client = open_client(database, server)
    change = dict(**facts, message=message)

    def set_one(item: Any) -> None:
        _print_changes(client.call("change_document", id=item.id, change=change, if_match=match_of(revision)), as_json)

    for_each(resolve_documents(client, ids, project, motion_name, xpath), set_one)


def _print_changes(made: DocumentDetail, as_json: bool) -> None:
    if as_json:
        print_json(made)
    else:
        console.print(f"{made.name}  {made.id}  revision {made.revision}, {made.frames:,} frames")
