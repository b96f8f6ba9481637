"""`mcml retarget` and `mcml mapping`: motions on the skeleton of another document."""

from __future__ import annotations

import json
from typing import Annotated, Any
from urllib.parse import quote

import typer

from schemas.retarget import JointPair, Mapping, MappingPage, Retargeted, RetargetedOne, RetargetMany, RetargetRequest
from service.cli.names import alias, aliases
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, open_api, print_json, table

JointsOption = Annotated[
    list[str] | None, typer.Option("--joint", help="SOURCE=TARGET, for all that shall move; may be repeated")
]


def add_to(app: typer.Typer) -> None:
    app.command()(retarget)
    about = "Saved mappings: which joint of one rig is which of another; and what a project calls joints."
    mapping = typer.Typer(no_args_is_help=True, help=about)
    for command in (list_, show, save, delete, aliases, alias):
        mapping.command(command.__name__.rstrip("_"))(command)
    app.add_typer(mapping, name="mapping")


def retarget(
    ids: Annotated[
        list[str],
        typer.Argument(metavar="[ID] SKELETON", help="Document with the motion, and the one with the skeleton"),
    ],
    mapping: Annotated[str | None, typer.Option(help="A saved mapping of joints, by its name")] = None,
    joints: JointsOption = None,
    clean_feet: Annotated[bool, typer.Option("--clean-feet", help="Hold feet where they stand")] = False,
    all_of: Annotated[str | None, typer.Option("--all-of", help="Instead of ID: all of this project")] = None,
    motion_name: Annotated[str | None, typer.Option(help="Instead of ID: documents with a frame of this name")] = None,
    xpath: Annotated[str | None, typer.Option(help="Instead of ID: documents in which this finds something")] = None,
    name: Annotated[str | None, typer.Option(help="Name of the new document; default the source's")] = None,
    project: Annotated[str | None, typer.Option(help="Project of the new documents; default the source's")] = None,
    preview: Annotated[bool, typer.Option("--preview", help="Say how well it fits; store nothing")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Bring a motion, or all that a selection finds, onto the skeleton of another document, as new documents."""
    selection = {"project": all_of, "motion_name": motion_name, "xpath": xpath}
    selection = {key: value for key, value in selection.items() if value is not None}
    if len(ids) != (1 if selection else 2):
        raise typer.BadParameter("name the motion and the skeleton; with --all-of, --motion-name, --xpath the skeleton")
    asked: dict[str, Any] = {
        "skeleton": ids[-1],
        "mapping": mapping if mapping is not None else _pairs(joints) or None,
        "clean_feet": clean_feet,
        "project": project,
        "preview": preview,
    }
    asked = {key: value for key, value in asked.items() if value is not None}
    if selection:
        many = RetargetMany.model_validate(asked | {"selection": selection})
        _retarget_many(many, database, server, as_json)
        return
    request = RetargetRequest.model_validate(asked | ({} if name is None else {"name": name}))
    body = request.model_dump(exclude_none=True)
    made = Retargeted(**open_api(database, server).send("POST", f"/documents/{ids[0]}/retarget", json=body).json())
    if as_json:
        print_json(made)
        return
    console.print(f"{'would make' if preview else 'made'}  {made.document or ''}  {made.frames:,} frames")
    for match in made.matches:
        console.print(f"  {match.source} -> {match.target}  {match.confidence:.2f}  {match.reason}")
    for bone in made.bones:
        if bone.leads and bone.mean > 0.5:
            console.print(f"  {bone.bone} to {bone.end}: {bone.mean:.1f} degrees off, {bone.largest:.1f} at most")
    for foot in made.feet:
        console.print(f"  {foot.foot} slides {foot.before:.3g} -> {foot.after:.3g} in {foot.stances} stances")
    for notice in made.notices:
        console.print(f"  {notice}", style="yellow")


def _retarget_many(request: RetargetMany, database: str | None, server: str | None, as_json: bool) -> None:
    made = failed = 0
    body = request.model_dump(exclude_none=True)
    with open_api(database, server).stream("POST", "/retarget", json=body) as answer:
        for line in answer.iter_lines():
            item = RetargetedOne(**json.loads(line))
            made += item.made is not None
            failed += item.made is None
            if as_json:
                print(line, flush=True)
            elif item.made is not None:
                worst = max((bone.mean for bone in item.made.bones if bone.leads), default=0.0)
                what = "would make" if request.preview else f"made {item.made.document}"
                console.print(f"{what}  {item.name}  {item.made.frames:,} frames, {worst:.1f} degrees off")
            elif item.problem is not None:
                console.print(f"failed  {item.name}  {item.source}: {item.problem.detail}")
    if not as_json:
        console.print(f"{made} made, {failed} failed")
    if failed:
        raise typer.Exit(3 if made else 1)


ProjectOption = Annotated[str, typer.Option(help="Project that keeps the mapping")]


def list_(
    project: Annotated[str | None, typer.Option(help="Only of this project")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List saved mappings."""
    asked = {} if project is None else {"project": project}
    found = MappingPage(**open_api(database, server).send("GET", "/mappings", params=asked).json())
    if as_json:
        print_json(found)
        return
    rows = table("project", "name", "joints#", "version#", "author", "changed")
    for item in found.items:
        rows.add_row(item.project, item.name, f"{len(item.pairs)}", f"{item.version}", item.author, item.changed)
    console.print(rows)


def show(
    name: Annotated[str, typer.Argument(help="Mapping")],
    project: ProjectOption = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show a mapping: source and target of each pair."""
    api = open_api(database, server)
    _told(Mapping(**api.send("GET", _address(name), params={"project": project}).json()), as_json)


def save(
    name: Annotated[str, typer.Argument(help="Mapping; one of that name is replaced")],
    joints: JointsOption = None,
    suggest: Annotated[
        tuple[str, str] | None, typer.Option(metavar="ID SKELETON", help="Begin with what is suggested for these two")
    ] = None,
    project: ProjectOption = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Save which joint is which: pairs of your own, over those that are suggested for two documents."""
    api = open_api(database, server)
    pairs: dict[str, str] = {}
    if suggest is not None:
        asked = {"skeleton": suggest[1], "preview": True}
        found = Retargeted(**api.send("POST", f"/documents/{suggest[0]}/retarget", json=asked).json())
        pairs = {match.target: match.source for match in found.matches}
    pairs |= {pair["target"]: pair["source"] for pair in _pairs(joints)}
    if not pairs:
        raise typer.BadParameter("give --joint SOURCE=TARGET, or --suggest ID SKELETON")
    body = {"pairs": [JointPair(source=source, target=target).model_dump() for target, source in pairs.items()]}
    present = api.send("GET", _address(name), (404,), params={"project": project})
    headers = {"if-match": present.headers["etag"]} if present.is_success else {}
    answer = api.send("PUT", _address(name), json=body, params={"project": project}, headers=headers)
    _told(Mapping(**answer.json()), as_json)


def delete(
    name: Annotated[str, typer.Argument(help="Mapping")],
    project: ProjectOption = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Delete a mapping; what was made with it stays."""
    api = open_api(database, server)
    api.send("DELETE", _address(name), params={"project": project}, headers={"if-match": "*"})


def _address(name: str) -> str:
    """Names may hold what means something in an address, such as ? and /."""
    return f"/mappings/{quote(name, safe='')}"


def _told(mapping: Mapping, as_json: bool) -> None:
    if as_json:
        print_json(mapping)
        return
    console.print(f"{mapping.name}  version {mapping.version}  {len(mapping.pairs)} joints")
    for pair in mapping.pairs:
        console.print(f"  {pair.source} -> {pair.target}")


def _pairs(joints: list[str] | None) -> list[dict[str, str]]:
    pairs = [text.partition("=")[::2] for text in joints or ()]
    if not all(one and other for one, other in pairs):
        raise typer.BadParameter("SOURCE=TARGET, such as left_hand=left_wrist", param_hint="--joint")
    return [{"source": one, "target": other} for one, other in pairs]
