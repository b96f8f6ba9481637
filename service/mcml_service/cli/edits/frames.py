"""`mcml frames`: ranges of frames of a document, changed."""

from __future__ import annotations

import re
from typing import Annotated, Any, get_args

import typer

from mcml.client.choosing import id_of
from mcml_schemas.frames import FrameEdit, FrameEdits
from mcml_schemas.team.proposals import ProposalRequest
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

_EDITS = {get_args(kind.model_fields["do"].annotation)[0]: kind for kind in get_args(get_args(FrameEdit)[0])}
"""Edits of frames, by name."""
_NAMES = {"insert": {"to": "at", "source": "document"}}
"""Options that the API calls otherwise."""
_OPTIONS = {"first": "FIRST-LAST", "last": "FIRST-LAST", "factors": "--speed", "handles": "--pull or --turn"}
"""The reverse for fields that an edit needs."""


def _handles(options: dict[str, list[str]]) -> list[dict[str, Any]]:
    """The handles of `pose`, from HANDLE=X,Y,Z by the field of `MovedHandle`."""
    handles: dict[str, dict[str, Any]] = {}
    for field, texts in options.items():
        for text in texts:
            handle, _, vector = text.partition("=")
            try:
                numbers = [float(number) for number in vector.split(",")]
            except ValueError:
                numbers = []
            if len(numbers) != 3:
                raise typer.BadParameter("write HANDLE=X,Y,Z, such as left_hand=0,10,0", param_hint=text)
            handles.setdefault(handle, {"handle": handle})[field] = numbers
    return list(handles.values())


def frames(
    id: Annotated[str, typer.Argument(help="Document")],
    do: Annotated[str, typer.Argument(help=", ".join(_EDITS))],
    range: Annotated[
        str | None, typer.Argument(metavar="FIRST-LAST", help="Frames, positions from 1; resample and unroll take all")
    ] = None,
    to: Annotated[int | None, typer.Option("--to", help="move, insert: before this frame")] = None,
    source: Annotated[str | None, typer.Option("--from", help="insert: document that has the frames")] = None,
    rate: Annotated[float | None, typer.Option(help="resample: frames a second")] = None,
    seconds: Annotated[
        float | None,
        typer.Option(help="smooth: standard deviation; fill: longest gap of a spline; loop: length of the changed end"),
    ] = None,
    longest: Annotated[float | None, typer.Option(help="fill: seconds of the longest gap")] = None,
    search: Annotated[
        float | None, typer.Option(help="loop: part of the range at either end in which the cut is; 0: keep all")
    ] = None,
    in_place: Annotated[bool | None, typer.Option("--in-place", help="loop: without travel")] = None,
    sides: Annotated[list[str] | None, typer.Option("--side", help="lock-feet: left or right; default both")] = None,
    deviations: Annotated[
        float | None, typer.Option(help="despike: scaled median absolute deviations from the median")
    ] = None,
    window: Annotated[int | None, typer.Option(help="despike: frames of the median")] = None,
    hertz: Annotated[float | None, typer.Option(help="low-pass: cut-off; default by residual analysis")] = None,
    channels: Annotated[list[str] | None, typer.Option("--channel", help="adjust: Rx, Ty …; may be repeated")] = None,
    speeds: Annotated[
        list[float] | None,
        typer.Option("--speed", help="speed: 2 is twice as fast; several change over the range at even distances"),
    ] = None,
    pulls: Annotated[
        list[str] | None,
        typer.Option(
            "--pull", metavar="HANDLE=X,Y,Z", help="pose: move hips, head, left_hand … by so much; repeatable"
        ),
    ] = None,
    turns: Annotated[
        list[str] | None,
        typer.Option("--turn", metavar="HANDLE=X,Y,Z", help="pose: turn by a rotation vector in degrees; repeatable"),
    ] = None,
    hold: Annotated[
        list[str] | None, typer.Option(help="pose: handle that stays in place; default both feet; may be repeated")
    ] = None,
    factor: Annotated[float | None, typer.Option(help="adjust: multiply by this")] = None,
    offset: Annotated[float | None, typer.Option(help="adjust: then add this")] = None,
    bones: Annotated[
        list[str] | None, typer.Option("--bone", help="Edits of samples: only this; may be repeated")
    ] = None,
    ease: Annotated[
        int | None, typer.Option(help="Frames at either end over which an edit of samples comes and goes")
    ] = None,
    renumber: Annotated[bool, typer.Option(help="Ids of frames that counted up by one do so again")] = True,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Preview the notes and curves without changing anything")
    ] = False,
    propose: Annotated[
        bool, typer.Option("--propose", help="Propose the edit instead of making it; others review it")
    ] = False,
    columns: Annotated[
        list[str] | None, typer.Option("--column", help="--dry-run: compare BONE.CHANNEL; may be repeated")
    ] = None,
    quantities: Annotated[
        list[str] | None, typer.Option("--quantity", help="--dry-run: compare a quantity of the body; may be repeated")
    ] = None,
    message: MessageOption = "",
    revision: RevisionOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Delete, keep, move, insert, reverse, loop, mirror, fill, despike, filter or resample frames, lock feet, change
    speed, keep in place, pose."""
    kind = _EDITS.get(do)
    if kind is None:
        raise typer.BadParameter(f"say one of {', '.join(_EDITS)}", param_hint="DO")
    given: dict[str, Any] = {
        "to": to,
        "source": source,
        "rate": rate,
        "seconds": seconds,
        "longest": longest,
        "search": search,
        "in_place": in_place,
        "sides": sides,
        "deviations": deviations,
        "window": window,
        "hertz": hertz,
        "channels": channels,
        "factors": speeds,
        "handles": _handles({"move": pulls or [], "turn": turns or []}),
        "hold": hold,
        "factor": factor,
        "offset": offset,
        "bones": bones,
        "ease": ease,
    }
    edit: dict[str, Any] = {
        _NAMES.get(do, {}).get(key, key): value for key, value in given.items() if value not in (None, [])
    }
    match = re.fullmatch(r"(\d{1,10})(?:-(\d{1,10}))?", range or "")
    if match is not None:
        edit |= {"first": int(match[1]), "last": int(match[2] or match[1])}
    elif range is not None:
        raise typer.BadParameter("write a range such as 10-20", param_hint="FIRST-LAST")
    # A wrong request costs exit code 2, as all wrong usage does.
    for name, field in kind.model_fields.items():
        if field.is_required() and name not in edit and name != "do":
            raise typer.BadParameter(f"{do} needs {_OPTIONS.get(name, '--' + name)}")
    unused = sorted(set(edit) - set(kind.model_fields))
    if unused:
        raise typer.BadParameter(f"{do} has no use for {', '.join(unused)}")
    client = open_client(database, server)
    if source is not None:
        edit["document"] = id_of(client, source)
    request = request_of(FrameEdits, {"edits": [{"do": do} | edit], "renumber": renumber, "message": message})
    if propose and not dry_run:
        body = ProposalRequest(edits=request)
        made = client.call("create_proposal", id=id_of(client, id), proposal=body, if_match=match_of(revision))
        present(OPERATIONS["create_proposal"], made, as_json)
        return
    done = client.call(
        "edit_frames",
        id=id_of(client, id),
        edits=request,
        dry_run=dry_run,
        column=columns,
        quantity=quantities,
        if_match=match_of(revision),
    )
    present(OPERATIONS["edit_frames"], done, as_json)
