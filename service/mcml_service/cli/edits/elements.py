"""`mcml element set` and `move`: edits with shorter arguments than in the API."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from mcml.client.choosing import id_of
from mcml_schemas.elements import ElementEdits
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    MessageOption,
    RevisionOption,
    ServerOption,
    match_of,
    open_client,
)
from mcml_service.cli.terminal.present import present
from mcml_service.cli.terminal.requests import request_of
from mcml_service.operations import OPERATIONS

IdArgument = Annotated[str, typer.Argument(help="Document")]
PathArgument = Annotated[str, typer.Argument(metavar="XPATH", help="Selects the element")]


def add_to(group: typer.Typer) -> None:
    group.command("set")(set_)
    group.command()(move)


def set_(
    id: IdArgument,
    xpath: PathArgument,
    attributes: Annotated[list[str] | None, typer.Argument(help="NAME=VALUE; NAME= takes the attribute away")] = None,
    text: Annotated[str | None, typer.Option(help="Text of the element")] = None,
    many: Annotated[bool, typer.Option("--many", help="The expression may select several; each is edited so")] = False,
    message: MessageOption = "",
    revision: RevisionOption = None,
    merge: Annotated[
        bool, typer.Option("--merge", help="With --revision: edit anyway if these elements have not changed")
    ] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Change attributes or the text of elements, such as `… "//frame[@id=7]/frame_bone[1]" Rx=45.2`."""
    pairs = [item.partition("=") for item in attributes or ()]
    if not all(name and equals for name, equals, _ in pairs) or not (pairs or text is not None):
        raise typer.BadParameter("write NAME=VALUE, or --text TEXT")
    body: dict[str, Any] = {"attributes": {name: value or None for name, _, value in pairs}, "message": message}
    body |= {} if text is None else {"text": text}
    client = open_client(database, server)
    done = client.call(
        "change_element",
        id=id_of(client, id),
        xpath=xpath,
        change=dict(**body),
        many=many,
        merge=merge,
        if_match=match_of(revision),
    )
    present(OPERATIONS["change_element"], done, as_json)


def move(
    id: IdArgument,
    xpath: PathArgument,
    to: Annotated[str, typer.Argument(metavar="TO", help="Selects the element that it goes to")],
    where: Annotated[str, typer.Option(help="before, after or into the element")] = "into",
    renumber: Annotated[bool, typer.Option(help="Ids of frames that counted up by one do so again")] = True,
    message: MessageOption = "",
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Move an element beside another, or into it."""
    edit = {"do": "move", "xpath": xpath, "to": to, "where": where}
    request = request_of(ElementEdits, {"edits": [edit], "renumber": renumber, "message": message})
    client = open_client(database, server)
    done = client.call("edit_elements", id=id_of(client, id), request=request, if_match=match_of(revision))
    present(OPERATIONS["edit_elements"], done, as_json)
