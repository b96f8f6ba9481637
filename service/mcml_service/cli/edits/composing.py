"""`mcml compose` and `mcml retarget`: new documents of the frames, and on the skeletons, of others."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from mcml.client.choosing import id_of
from mcml.client.client import Client
from mcml_schemas.compose import ComposeRequest
from mcml_schemas.retarget import RetargetedOne, RetargetMany, RetargetRequest
from mcml_service.cli.edits.names import JointsOption, joint_pairs
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_client,
    print_json,
    write_to_the_end,
)
from mcml_service.cli.terminal.requests import request_of

_RANGE = re.compile(
    r"(?P<document>[0-9a-fA-F-]{36})(?:@(?P<revision>\d{1,9}))?(?::(?P<first>\d{1,9})-(?P<last>\d{1,9}))?"
)


def compose(
    segments: Annotated[
        list[str], typer.Argument(help="ID, ID:FIRST-LAST, ID@REVISION:FIRST-LAST, or an XPath expression, in order")
    ],
    seconds: Annotated[float, typer.Option(help="Length of transitions between segments")] = 0.3,
    transition: Annotated[int | None, typer.Option(help="The same in frames")] = None,
    style: Annotated[str, typer.Option(help="bridge, crossfade or inertial")] = "bridge",
    lock_feet: Annotated[bool, typer.Option(help="Keep standing feet in place during transitions")] = True,
    match_phase: Annotated[
        bool, typer.Option("--match-phase", help="Let walks meet in the same phase: leave out up to 1.2 s of each")
    ] = False,
    rate: Annotated[float | None, typer.Option(help="Frames a second; default the first segment's")] = None,
    align: Annotated[bool, typer.Option(help="Continue at the current position of the body")] = True,
    header: Annotated[str | None, typer.Option(help="Document whose header is used")] = None,
    skeleton: Annotated[str | None, typer.Option(help="Document whose skeleton is used")] = None,
    name: Annotated[str, typer.Option(help="Name of the new document")] = "composed",
    project: Annotated[str, typer.Option(help="Project of the new document")] = "default",
    preview: Annotated[bool, typer.Option("--preview", help="Preview the result without storing it")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compose a new document from frames of others, with transitions between them."""
    request = request_of(
        ComposeRequest,
        {
            "segments": [_segment(text) for text in segments],
            "seconds": seconds,
            "transition": transition,
            "style": style,
            "lock_feet": lock_feet,
            "match_phase": match_phase,
            "rate": rate,
            "align": align,
            "header": header,
            "skeleton": skeleton,
            "name": name,
            "project": project,
            "preview": preview,
        },
    )
    made = open_client(database, server).call("compose", request=request)
    if as_json:
        print_json(made)
        return
    console.print(f"{'would make' if preview else 'made'}  {name}  {made.document or ''}  {made.frames:,} frames")
    for seam in made.seams:
        console.print(
            f"  frame {seam.first}: {seam.transition} frames of transition, turned {seam.degrees:.1f} degrees, "
            f"largest step {max(seam.root_step, seam.angle_step):.2f} of those inside, jerk {seam.jerk:.2f}"
            + (f", {' and '.join(seam.locked)} foot held" if seam.locked else "")
            + (f", {seam.left_out[0]} + {seam.left_out[1]} frames left out" if any(seam.left_out) else "")
        )
    for notice in made.notices:
        console.print(f"  {notice}", style="yellow")


def _segment(text: str) -> dict[str, Any]:
    match = _RANGE.fullmatch(text)
    if match is None:
        if re.match(r"[0-9a-fA-F-]{36}[@:]", text):
            raise typer.BadParameter(f"{text!r} is not ID:FIRST-LAST or ID@REVISION:FIRST-LAST, frames counted from 1")
        return {"xpath": text}
    fields = {key: int(value) for key, value in match.groupdict().items() if value is not None and key != "document"}
    return {"document": match["document"], **fields}


def retarget(
    ids: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[ID] [SKELETON]", help="Document with the motion, and without --to the one with the skeleton"
        ),
    ] = None,
    to: Annotated[str | None, typer.Option(help="Instead of SKELETON: a known rig, such as unreal5")] = None,
    mapping: Annotated[str | None, typer.Option(help="A saved mapping of joints, by its name")] = None,
    joints: JointsOption = None,
    clean_feet: Annotated[bool, typer.Option("--clean-feet", help="Lock feet on contact")] = False,
    travel_scale: Annotated[
        float | None, typer.Option(help="Distance travelled, relative to the source's; default by the legs")
    ] = None,
    file_limits: Annotated[
        bool, typer.Option("--file-limits", help="Keep joints inside the limits of the skeleton's file")
    ] = False,
    keep_hands: Annotated[
        bool, typer.Option("--keep-hands", help="Keep hands where they touch each other, head or thighs")
    ] = False,
    all_of: Annotated[str | None, typer.Option("--all-of", help="Instead of ID: all of this project")] = None,
    motion_name: Annotated[str | None, typer.Option(help="Instead of ID: documents with a frame of this name")] = None,
    xpath: Annotated[str | None, typer.Option(help="Instead of ID: documents in which this finds something")] = None,
    table: Annotated[
        Path | None, typer.Option(help="Of a selection: write one table (CSV) to this file, outliers first")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the new document; default the source's")] = None,
    project: Annotated[str | None, typer.Option(help="Project of the new documents; default the source's")] = None,
    preview: Annotated[bool, typer.Option("--preview", help="Say how well it fits; store nothing")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Retarget a motion, or all motions of a selection, to the skeleton of another document or to a known rig, as new
    documents."""
    write_to_the_end()
    client = open_client(database, server)
    selection = {"project": all_of, "motion_name": motion_name, "xpath": xpath}
    selection = {key: value for key, value in selection.items() if value is not None}
    ids = ids or []
    if len(ids) != (not selection) + (to is None):
        raise typer.BadParameter(
            "name the motion and the skeleton: no motion with --all-of, --motion-name, --xpath, no skeleton with --to"
        )
    asked: dict[str, Any] = {
        "skeleton": id_of(client, ids[-1]) if to is None else None,
        "to": to,
        "mapping": mapping if mapping is not None else joint_pairs(joints) or None,
        "clean_feet": clean_feet,
        "travel_scale": travel_scale,
        "limits": "file" if file_limits else None,
        "keep_hands": keep_hands,
        "project": project,
        "preview": preview,
    }
    asked = {key: value for key, value in asked.items() if value is not None}
    if selection:
        many = request_of(RetargetMany, asked | {"selection": selection})
        if table is not None:
            answer = client.call("retarget_many", request=many, format="csv")
            table.write_bytes(b"".join(map(bytes, answer.blocks)))
            console.print(f"wrote  {table}")
            return
        _retarget_many(client, many, as_json)
        return
    if table is not None:
        raise typer.BadParameter("a table is of a selection: use --all-of, --motion-name or --xpath")
    request = request_of(RetargetRequest, asked | ({} if name is None else {"name": name}))
    made = client.call("retarget", id=id_of(client, ids[0]), request=request)
    if as_json:
        print_json(made)
        return
    console.print(f"{'would make' if preview else 'made'}  {made.document or ''}  {made.frames:,} frames")
    for match in made.matches:
        console.print(f"  {match.source} -> {match.target}  {match.confidence:.2f}  {match.reason}")
    for bone in made.bones:
        if bone.leads and bone.mean > 0.5:
            console.print(f"  {bone.bone} to {bone.end}: {bone.mean:.1f} degrees off, {bone.largest:.1f} at most")
    for part in made.parts:
        console.print(f"  {part.part}: {part.mean:.1f} degrees off, {part.largest:.1f} at most in frame {part.frame}")
    for foot in made.feet:
        console.print(f"  {foot.foot} slides {foot.before:.3g} -> {foot.after:.3g} in {foot.stances} stances")
    for notice in made.notices:
        console.print(f"  {notice}", style="yellow")


def _retarget_many(client: Client, request: RetargetMany, as_json: bool) -> None:
    made = failed = 0
    answer = client.call("retarget_many", request=request)
    for line in lines_of(answer.blocks):
        item = RetargetedOne.model_validate_json(line)
        made += item.made is not None
        failed += item.made is None
        if as_json:
            print(line.decode(), flush=True)
        elif item.made is not None:
            worst = max((part.mean for part in item.made.parts), default=0.0)
            done = "would make" if request.preview else f"made {item.made.document}"
            console.print(f"{done}  {item.name}  {item.made.frames:,} frames, {worst:.1f} degrees off")
        elif item.problem is not None:
            console.print(f"failed  {item.name}  {item.source}: {item.problem.detail}")
    if not as_json:
        console.print(f"{made} made, {failed} failed")
    if failed:
        raise typer.Exit(3 if made else 1)


def lines_of(blocks: Iterable[bytes | memoryview]) -> Iterator[bytes]:
    """Yield the lines of bytes that arrive in blocks."""
    rest = b""
    for block in blocks:
        *whole, rest = (rest + bytes(block)).split(b"\n")
        yield from whole
    if rest:
        yield rest
