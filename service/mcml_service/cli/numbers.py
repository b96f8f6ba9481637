"""`mcml numbers`, `mcml arrays` and `mcml analog`: frames and analog channels as tables or arrays."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import typer

from mcml.client.choosing import id_of
from mcml.errors import RequestError
from mcml.files.read_numbers import Space
from mcml_schemas.arrays import ArrayForm
from mcml_schemas.frames import FrameForm
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    RawOption,
    ServerOption,
    open_client,
    write_blocks,
)

_FORMS = [form for form in get_args(FrameForm) if form not in ("json", "block")]
"""Forms that are files."""


def numbers(
    id: Annotated[str, typer.Argument(help="Document")],
    output: Annotated[
        Path | None, typer.Argument(help=".csv, .npz, .npy, .arrow or .parquet; default CSV to the terminal")
    ] = None,
    quantity: Annotated[
        list[str] | None,
        typer.Option(help="Of the body, such as angle:left-knee-flexion or speed:right_hand,Root; may be repeated"),
    ] = None,
    bone: Annotated[
        list[str] | None, typer.Option(help="Channels of this bone; may be repeated; default all, or none")
    ] = None,
    first: Annotated[int, typer.Option(help="First frame, a position from 1")] = 1,
    last: Annotated[int | None, typer.Option(help="Last frame, included")] = None,
    step: Annotated[int, typer.Option(help="Every step-th frame")] = 1,
    raw: RawOption = False,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Export frames of a document as a table: channels, and quantities of the body in metres, seconds and degrees."""
    form = "csv" if output is None else output.suffix.removeprefix(".")
    if form not in _FORMS:
        raise RequestError(
            f"{output} is no table or array by its name.", remedy=f"End it in one of: .{', .'.join(_FORMS)}."
        )
    client = open_client(database, server)
    answer = client.call(
        "get_frames",
        id=id_of(client, id),
        quantity=quantity or None,
        bone=bone or None,
        first=first,
        last=last,
        step=step,
        format=form,
        raw=raw,
    )
    write_blocks(answer.blocks, output, force=force)


def arrays(
    output: Annotated[Path, typer.Argument(help=".npz, .csv, .arrow or .parquet")],
    ids: Annotated[
        list[str] | None, typer.Argument(metavar="[ID]...", help="Documents, or collection:NAME", show_default=False)
    ] = None,
    project: Annotated[str | None, typer.Option(help="All documents of this project")] = None,
    query: Annotated[
        str | None, typer.Option(help="An XPath expression; the frame ranges that it finds are exported")
    ] = None,
    space: Annotated[Space, typer.Option(help="Joint positions, joint rotations, or channels")] = "positions",
    bone: Annotated[list[str] | None, typer.Option(help="Only this bone; may be repeated; default all")] = None,
    quantity: Annotated[
        list[str] | None, typer.Option(help="Such as angle:left-knee-flexion, with --space channels; may be repeated")
    ] = None,
    columns: Annotated[
        Literal["all", "shared"], typer.Option(help="Columns of any clip, or those that all clips share")
    ] = "all",
    raw: RawOption = False,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Export frames of many clips as one array or table."""
    form = output.suffix.removeprefix(".").lower()
    if form not in get_args(ArrayForm):
        forms = ", .".join(get_args(ArrayForm))
        raise RequestError(f"{output} is no array or table by its name.", remedy=f"End it in one of: .{forms}.")
    client = open_client(database, server)
    selection: dict[str, Any] = {} if project is None else {"project": project}
    if ids:
        selection["documents"] = [id_of(client, text) for text in ids]
    request = {
        "selection": selection or None,
        "query": query,
        "space": space,
        "bones": bone or [],
        "quantities": quantity or [],
        "columns": columns,
        "as": form,
        "raw": raw,
    }
    answer = client.call("export_arrays", request=request)
    write_blocks(answer.blocks, output, force=force)
    for notice in answer.notices:
        print(f"mcml: {notice.what}", file=sys.stderr)


def analog(
    id: Annotated[str, typer.Argument(help="Document")],
    output: Annotated[Path | None, typer.Argument(help=".csv, .arrow or .parquet; default CSV to the terminal")] = None,
    channel: Annotated[list[str] | None, typer.Option(help="Only this channel; may be repeated; default all")] = None,
    first: Annotated[int, typer.Option(help="First frame, a position from 1")] = 1,
    last: Annotated[int | None, typer.Option(help="Last frame, included")] = None,
    scaled: Annotated[bool, typer.Option(help="In the unit of the channel, or as the file stores the numbers")] = True,
    raw: RawOption = False,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Export the analog channels of a document at their own rate, such as electromyography."""
    form = "csv" if output is None else output.suffix.removeprefix(".")
    if form not in ("csv", "arrow", "parquet"):
        raise RequestError(f"{output} is no table by its name.", remedy="End it in .csv, .arrow or .parquet.")
    client = open_client(database, server)
    answer = client.call(
        "get_analog",
        id=id_of(client, id),
        channel=channel or None,
        first=first,
        last=last,
        scaled=scaled,
        format=form,
        raw=raw,
    )
    write_blocks(answer.blocks, output, force=force)
