"""`mcml numbers` and `mcml analog`: frames and analog channels of a document as tables or arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

import typer

from mcml.client.choosing import id_of
from mcml.errors import RequestError
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
