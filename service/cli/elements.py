"""`mcml element`: elements of a document, addressed by XPath: read, changed, replaced, inserted, moved, deleted."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import httpx
import typer

from schemas.elements import ElementEdited
from service.cli.shared import (
    DatabaseOption,
    JsonOption,
    MessageOption,
    RevisionOption,
    ServerOption,
    console,
    if_match,
    open_api,
    print_json,
)

IdArgument = Annotated[str, typer.Argument(help="Document")]
PathArgument = Annotated[str, typer.Argument(metavar="XPATH", help="Selects the element")]
FragmentArgument = Annotated[Path, typer.Argument(help="File with elements as MCML; - reads standard input")]
WhereOption = Annotated[str, typer.Option(help="before, after or into the element")]
ManyOption = Annotated[bool, typer.Option("--many", help="The expression may select several; each is edited so")]
MergeOption = Annotated[
    bool, typer.Option("--merge", help="With --revision: edit all the same where nobody changed these elements")
]


def add_to(app: typer.Typer) -> None:
    group = typer.Typer(no_args_is_help=True, help="Elements of a document, addressed by XPath. An edit is a revision.")
    for command in (get, set_, delete, replace, insert, move, batch):
        group.command(command.__name__.rstrip("_"))(command)
    app.add_typer(group, name="element")


def get(
    id: IdArgument,
    xpath: PathArgument,
    revision: Annotated[int | None, typer.Option(min=1, help="Read this revision")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Print an element as MCML, or the value of an attribute."""
    asked: dict[str, Any] = {"xpath": xpath} | ({} if revision is None else {"revision": revision})
    text = open_api(database, server).send("GET", f"/documents/{id}/elements", params=asked).text
    print(text.rstrip("\n"))


def set_(
    id: IdArgument,
    xpath: PathArgument,
    attributes: Annotated[list[str] | None, typer.Argument(help="NAME=VALUE; NAME= takes the attribute away")] = None,
    text: Annotated[str | None, typer.Option(help="Text of the element")] = None,
    many: ManyOption = False,
    message: MessageOption = "",
    revision: RevisionOption = None,
    merge: MergeOption = False,
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
    api, asked = open_api(database, server), {"xpath": xpath, "many": many, "merge": merge}
    answer = api.send("PATCH", f"/documents/{id}/elements", json=body, params=asked, headers=if_match(revision))
    _told(answer, as_json)


def delete(
    id: IdArgument,
    xpath: PathArgument,
    many: ManyOption = False,
    renumber: Annotated[bool, typer.Option("--renumber", help="Let the ids of later frames move up")] = False,
    revision: RevisionOption = None,
    merge: MergeOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Delete elements or attributes, unless mcml.dtd or the frames need them."""
    api, asked = open_api(database, server), {"xpath": xpath, "many": many, "merge": merge, "renumber": renumber}
    _told(api.send("DELETE", f"/documents/{id}/elements", params=asked, headers=if_match(revision)), as_json)


def replace(
    id: IdArgument,
    xpath: PathArgument,
    fragment: FragmentArgument = Path("-"),
    revision: RevisionOption = None,
    merge: MergeOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Put other elements in the place of one."""
    api, asked, headers = open_api(database, server), {"xpath": xpath, "merge": merge}, if_match(revision)
    content = _content(fragment)
    _told(api.send("PUT", f"/documents/{id}/elements", content=content, params=asked, headers=headers), as_json)


def insert(
    id: IdArgument,
    xpath: PathArgument,
    fragment: FragmentArgument = Path("-"),
    where: WhereOption = "into",
    keep_ids: Annotated[bool, typer.Option("--keep-ids", help="Leave frame ids as they are")] = False,
    revision: RevisionOption = None,
    merge: MergeOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Put elements beside one, or into it, at its end."""
    api, headers = open_api(database, server), if_match(revision)
    asked = {"xpath": xpath, "where": where, "renumber": not keep_ids, "merge": merge}
    content = _content(fragment)
    _told(api.send("POST", f"/documents/{id}/elements", content=content, params=asked, headers=headers), as_json)


def move(
    id: IdArgument,
    xpath: PathArgument,
    to: Annotated[str, typer.Argument(metavar="TO", help="Selects the element that it goes to")],
    where: WhereOption = "into",
    keep_ids: Annotated[bool, typer.Option("--keep-ids", help="Leave frame ids as they are")] = False,
    message: MessageOption = "",
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Take an element from its place and put it beside another, or into it."""
    body = {
        "edits": [{"do": "move", "xpath": xpath, "to": to, "where": where}],
        "renumber": not keep_ids,
        "message": message,
    }
    api, headers = open_api(database, server), if_match(revision)
    _told(api.send("POST", f"/documents/{id}/elements/batch", json=body, headers=headers), as_json)


def batch(
    id: IdArgument,
    edits: Annotated[Path, typer.Argument(help='JSON file: {"edits": [{"do": "change", …}, …]}; - reads it')],
    revision: RevisionOption = None,
    merge: MergeOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make many edits as one revision: all, or none."""
    api, asked = open_api(database, server), {"merge": merge}
    headers = if_match(revision) | {"content-type": "application/json"}
    content = _content(edits)
    _told(api.send("POST", f"/documents/{id}/elements/batch", content=content, params=asked, headers=headers), as_json)


def _content(path: Path) -> bytes:
    return sys.stdin.buffer.read() if str(path) == "-" else path.read_bytes()


def _told(answer: httpx.Response, as_json: bool) -> None:
    done = ElementEdited(**answer.json())
    if as_json:
        print_json(done)
    else:
        console.print(f"revision {done.revision}, {done.elements:,} edited")
