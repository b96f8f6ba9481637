"""`mcml names`, and the aliases of `mcml mapping`: what joints are called."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from schemas.documents import DocumentPage
from schemas.names import Alias, AliasTable, AppliedNames
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, open_api, print_json, table
from service.mcml.joint_names import alias_key

ProjectOption = Annotated[str, typer.Option(help="Project whose files call joints so")]


def add_to(app: typer.Typer) -> None:
    names = typer.Typer(no_args_is_help=True, help="Names of joints of documents that exist.")
    # One command alone would lose its name.
    names.callback()(_group)
    names.command("apply")(apply)
    app.add_typer(names, name="names")


def _group() -> None:
    """Names of joints of documents that exist."""


def apply(
    ids: Annotated[list[str] | None, typer.Argument(metavar="[ID]...", help="Documents")] = None,
    project: Annotated[str | None, typer.Option(help="Instead: all documents of this project")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be renamed; change nothing")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Give joints the names that an import would give them now, each document as a revision that undo takes back."""
    if bool(ids) == (project is not None):
        raise typer.BadParameter("name documents, or a --project")
    api = open_api(database, server)
    wanted, asked = list(ids or ()), {"project": project, "limit": 1000}
    while project is not None:
        page = DocumentPage(**api.send("GET", "/documents", params=asked).json())
        wanted += [item.id for item in page.items]
        if page.next_cursor is None:
            break
        asked["cursor"] = page.next_cursor
    done = 0
    for id in wanted:
        answer = api.send("POST", f"/documents/{id}/names", params={"dry_run": dry_run}, headers={"if-match": "*"})
        made = AppliedNames(**answer.json())
        done += bool(made.items)
        if as_json:
            print_json(made)
            continue
        for item in made.items:
            console.print(f"{id}  {item.source}: {item.before} -> {item.after}")
    if not as_json:
        console.print(f"{done} of {len(wanted)} documents {'would be' if dry_run else 'were'} changed")


def aliases(
    project: ProjectOption = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List what a project calls joints, beside the names that are known."""
    _told(AliasTable(**open_api(database, server).send("GET", "/aliases", params={"project": project}).json()), as_json)


def alias(
    pairs: Annotated[list[str] | None, typer.Argument(help="NAME=JOINT, such as Hüfte=Root")] = None,
    remove: Annotated[list[str] | None, typer.Option("--remove", help="Take this one away; may be repeated")] = None,
    project: ProjectOption = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say what a project calls joints, for imports to come. `mcml names apply` renames documents that exist."""
    given = [text.rpartition("=")[::2] for text in pairs or ()]
    if not all(one and other for one, other in given) or not (given or remove):
        raise typer.BadParameter("NAME=JOINT, such as Hüfte=Root, or --remove NAME")
    api, asked = open_api(database, server), {"project": project}
    present = api.send("GET", "/aliases", params=asked)
    gone = {alias_key(name) for name in (*(one for one, _ in given), *(remove or ()))}
    items = [item for item in AliasTable(**present.json()).items if alias_key(item.source) not in gone]
    items += [Alias(source=one, name=other) for one, other in given]
    headers = {"if-match": present.headers["etag"]}
    if not items:
        api.send("DELETE", "/aliases", params=asked, headers=headers)
        return
    body: dict[str, Any] = {"items": [item.model_dump() for item in items]}
    _told(AliasTable(**api.send("PUT", "/aliases", json=body, params=asked, headers=headers).json()), as_json)


def _told(made: AliasTable, as_json: bool) -> None:
    if as_json:
        print_json(made)
        return
    rows = table("name in files", "joint")
    for item in made.items:
        rows.add_row(item.source, item.name)
    console.print(rows)
    console.print(f"project {made.project}, version {made.version}")
