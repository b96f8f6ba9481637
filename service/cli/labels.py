"""`mcml labels`: labels of a document, of many at once, and suggested ones."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from schemas.documents import ChangedDocuments, LabelPage
from schemas.labels import SuggestedLabels
from service.cli.shared import (
    DatabaseOption,
    JsonOption,
    RevisionOption,
    ServerOption,
    console,
    if_match,
    open_api,
    print_json,
    table,
)
from service.errors import McmlError


def add_to(app: typer.Typer) -> None:
    labels = typer.Typer(
        no_args_is_help=True, help="Labels of many documents: by query, as tables; and from the motion."
    )
    labels.command("list")(list_)
    labels.command("change")(change)
    labels.command("delete")(delete)
    labels.command("query")(by_query)
    labels.command("suggest")(suggest)
    labels.command("export")(export)
    labels.command("import")(import_)
    app.add_typer(labels, name="labels")


def list_(
    id: Annotated[str, typer.Argument(help="Document")],
    name: Annotated[str | None, typer.Option(help="Only this motion name")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List the labels of a document with their ids, which `change` and `delete` take."""
    asked: dict[str, Any] = {"limit": 1000} | ({} if name is None else {"name": name})
    api, items = open_api(database, server), []
    while True:
        page = LabelPage(**api.send("GET", f"/documents/{id}/labels", params=asked).json())
        items += page.items
        if page.next_cursor is None:
            break
        asked["cursor"] = page.next_cursor
    _shown(LabelPage(items=items), as_json)


def change(
    id: Annotated[str, typer.Argument(help="Document")],
    label: Annotated[int, typer.Argument(help="Id of the label")],
    name: Annotated[str | None, typer.Option(help="Another motion name")] = None,
    first: Annotated[int | None, typer.Option(min=1, help="Another first frame")] = None,
    last: Annotated[int | None, typer.Option(min=1, help="Another last frame")] = None,
    split: Annotated[int | None, typer.Option(min=2, help="Make two of it; the second begins here")] = None,
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Rename a label, move its ends, or split it."""
    given = {"name": name, "first": first, "last": last, "split": split}
    body = {key: value for key, value in given.items() if value is not None}
    if not body:
        raise typer.BadParameter("say what becomes of it: --name, --first, --last or --split")
    url, headers = f"/documents/{id}/labels/{label}", if_match(revision)
    _shown(LabelPage(**open_api(database, server).send("PATCH", url, json=body, headers=headers).json()), as_json)


def delete(
    id: Annotated[str, typer.Argument(help="Document")],
    label: Annotated[int, typer.Argument(help="Id of the label")],
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Take a label off its frames."""
    open_api(database, server).send("DELETE", f"/documents/{id}/labels/{label}", headers=if_match(revision))


def by_query(
    name: Annotated[str, typer.Argument(help="Motion name")],
    xpath: Annotated[str, typer.Argument(help="An expression that selects the frames")],
    project: Annotated[str | None, typer.Option(help="Only in this project")] = None,
    document: Annotated[list[str] | None, typer.Option(help="Only in this document; may be repeated")] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Take the name off these frames")] = False,
    instead_of: Annotated[
        str | None, typer.Option("--instead-of", help="Take this name off the same frames: so names are changed")
    ] = None,
    strict: Annotated[bool, typer.Option(help="Refuse names that are no anatomical movement")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Name all frames that an XPath expression selects."""
    asked = {"name": name, "xpath": xpath, "document": document or [], "remove": remove, "strict": strict}
    asked |= {key: value for key, value in (("project", project), ("instead_of", instead_of)) if value is not None}
    _told(ChangedDocuments(**open_api(database, server).send("POST", "/labels", json=asked).json()))


def suggest(
    id: Annotated[str, typer.Argument(help="Document")],
    confidence: Annotated[float, typer.Option(min=0, max=1, help="The least, 0 to 1")] = 0.5,
    facing: Annotated[
        str | None, typer.Option(help="Where the body faces as it stands upright, such as Z or -X; names tell else")
    ] = None,
    accept: Annotated[bool, typer.Option("--accept", help="Name the frames so, as one revision")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Find anatomical movements in a motion, as names for its frames."""
    api = open_api(database, server)
    url = f"/documents/{id}/labels"
    asked = {"confidence": confidence} | ({} if facing is None else {"facing": facing.upper()})
    answer = api.send("GET", f"{url}/suggested", params=asked)
    found = SuggestedLabels(**answer.json())
    if accept and found.items:
        body = [item.model_dump(include={"name", "first", "last"}) for item in found.items]
        api.send("POST", url, json=body, params={"strict": True}, headers={"if-match": "*"})
    if as_json:
        print_json(found)
        return
    shown = table("name", "first#", "last#", "degrees#", "confidence#")
    for item in found.items:
        shown.add_row(item.name, f"{item.first}", f"{item.last}", f"{item.degrees:.0f}", f"{item.confidence:.2f}")
    console.print(shown)
    console.print(f"{len(found.items)} {'accepted' if accept else 'suggested'}")


def export(
    output: Annotated[Path, typer.Argument(help="CSV file to write")],
    project: Annotated[str | None, typer.Option(help="Only of this project")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Write labels as a table: document, label, first, last."""
    answer = open_api(database, server).send("GET", "/labels", params={} if project is None else {"project": project})
    output.write_bytes(answer.content)
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
    asked: dict[str, Any] = {"strict": strict, "replace": replace}
    asked |= {} if project is None else {"project": project}
    api, headers = open_api(database, server), {"content-type": "text/csv"}
    try:
        answer = api.send("PUT", "/labels", content=table.read_bytes(), params=asked, headers=headers)
        _told(ChangedDocuments(**answer.json()))
    except McmlError as error:
        raise error.in_file(table.name) from error


def _shown(page: LabelPage, as_json: bool) -> None:
    if as_json:
        print_json(page)
        return
    rows = table("id#", "first#", "last#", "name")
    for item in page.items:
        rows.add_row(f"{item.id}", f"{item.first}", f"{item.last}", item.name)
    console.print(rows)


def _told(changed: ChangedDocuments) -> None:
    for item in changed.items:
        console.print(f"changed  {item.name}  {item.id}  revision {item.revision}")
    console.print(f"{len(changed.items)} changed")
