"""`mcml export`: documents as files of any format."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from mcml.files.convert_files import files_to_write
from mcml.files.on_disk import write_file
from mcml_service.cli.terminal.choosing import (
    IdsArgument,
    MotionNameOption,
    ProjectOption,
    XPathOption,
    for_each,
    resolve_documents,
)
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    ForOption,
    RawOption,
    ServerOption,
    console,
    open_client,
    write_to_the_end,
)


def export(
    ids: IdsArgument = None,
    project: ProjectOption = None,
    motion_name: MotionNameOption = None,
    xpath: XPathOption = None,
    format: Annotated[
        str | None,
        typer.Option(
            help="bvh (default), asf-amc, asf, amc, htr, c3d, trc, glb, vrma, usd, usda, mot, sto, smpl, mcml, csv, "
            "original"
        ),
    ] = None,
    for_: ForOption = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File or folder; default this folder, - prints")
    ] = None,
    force: ForceOption = False,
    first: Annotated[int, typer.Option(min=1, help="First frame, from 1")] = 1,
    last: Annotated[int | None, typer.Option(min=1, help="Last frame, included")] = None,
    names: Annotated[str | None, typer.Option(help="Joint names: mcml, bvh1, bvh2, asf or htr")] = None,
    unit: Annotated[str | None, typer.Option(help="Scale lengths to this unit")] = None,
    up: Annotated[str | None, typer.Option(help="Turn so that this axis points up")] = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, where the document does not say")] = None,
    fps: Annotated[float | None, typer.Option(min=0.001, help="Frames a second of the result")] = None,
    scale: Annotated[float | None, typer.Option(help="Factor of all lengths")] = None,
    height: Annotated[float | None, typer.Option(help="Scale so that the body stands this many metres tall")] = None,
    in_place: Annotated[bool, typer.Option("--in-place", help="Without travel over the ground")] = False,
    guesses: Annotated[bool, typer.Option(help="Guess a unit and an up axis that the format needs")] = True,
    character: Annotated[
        str | None, typer.Option(help="glTF and USD: a body instead of bones: own, or a document with a character")
    ] = None,
    raw: RawOption = False,
    original: Annotated[bool, typer.Option(help="The kept bytes of documents that were not edited")] = True,
    revision: Annotated[int | None, typer.Option(min=1, help="As this revision left it")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Export documents to any format. With equal names, the second file gets the end of its id."""
    write_to_the_end()
    client = open_client(database, server)
    documents = resolve_documents(client, ids, project, motion_name, xpath)
    if character not in (None, "own"):
        (found,) = resolve_documents(client, [character], None, None, None)
        character = found.id
    written: set[Path] = set()
    stated: dict[str, Any] = {"first": first, "last": last, "names": names, "unit": unit, "up": up}
    stated |= {
        "frame_time": frame_time,
        "fps": fps,
        "scale": scale,
        "height": height,
        "in_place": in_place,
        "guesses": guesses,
        "character": character,
        "raw": raw,
        "for_": for_,
    }
    form = format or ("bvh" if for_ is None else None)

    def export_one(item: Any) -> None:
        to_name = output is not None and str(output) != "-" and not output.is_dir() and len(documents) == 1
        if not to_name or output is None or form is None:
            write_one(item, output, form)
            return
        for path, part in files_to_write(output, form):
            write_one(item, path, part)

    def write_one(item: Any, output: Path | None, part: str | None) -> None:
        file = client.call("export_document", id=item.id, format=part, revision=revision, original=original, **stated)
        if output is not None and str(output) == "-":
            for block in file.blocks:
                sys.stdout.buffer.write(block)
            sys.stdout.buffer.flush()
            return
        target = output if output is not None else Path(".")
        target = target / local_name(file.name or item.id) if target.is_dir() or len(documents) > 1 else target
        if target in written:
            target = target.with_stem(f"{target.stem}-{item.id[-6:]}")
        write_file(target, file.blocks, force=force)
        written.add(target)
        console.print(f"wrote    {target}")
        for notice in file.notices:
            console.print(f"         {notice.what}", style="yellow")

    for_each(documents, export_one)


def local_name(said: str) -> str:
    """Return only the name of a file, so that a server cannot make the command write outside the given folder."""
    from mcml.files.check_names import file_name

    return file_name(said) or "document"
