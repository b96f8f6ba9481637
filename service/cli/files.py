"""`mcml convert` and `mcml validate`: files only, nothing is stored."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, BinaryIO

import typer

from service.actions.exporting.convert_files import convert_files
from service.actions.exporting.export_motion import targets
from service.actions.reading.import_options import ImportOptions
from service.actions.reading.inspect_files import inspect_files
from service.cli.importing import name_of
from service.cli.shared import JsonOption, chosen_settings, console, print_json, write_file
from service.errors import McmlError, UnsupportedError
from service.formats import FORMATS
from service.formats.format import SourceFile


def convert(
    paths: Annotated[list[Path], typer.Argument(help="IN… OUT: files to read (ASF and AMC together), then the result")],
    to: Annotated[str | None, typer.Option(help="Format of the result, where its name does not say")] = None,
    skeleton: Annotated[Path | None, typer.Option(help="ASF file for an AMC")] = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, where the files do not say")] = None,
    encoding: Annotated[str | None, typer.Option(help="Text encoding of the input, if it is not UTF-8")] = None,
    names: Annotated[str | None, typer.Option(help="Joint names: mcml, bvh1, bvh2, asf or htr")] = None,
    quiet: Annotated[bool, typer.Option(help="Do not print what was guessed or lost")] = False,
) -> None:
    """Convert a motion between formats. For ASF/AMC name the .amc; its .asf is written beside it."""
    if len(paths) < 2:
        raise typer.BadParameter("give at least one file to read and one to write")
    *sources, result = paths
    target = to or _format_of(result)
    with ExitStack() as stack:
        inputs = [*sources, *([skeleton] if skeleton else [])]
        files = [SourceFile(name_of(path), stack.enter_context(_opened(path))) for path in inputs]
        converted = convert_files(
            files, target, chosen_settings(), frame_time=frame_time, encoding=encoding, names=names, stem=result.stem
        )
        done = stack.enter_context(converted)
        for extension, content in done.files.items():
            write_file(result if len(done.files) == 1 else result.with_suffix(extension), content)
        if not quiet:
            for notice in done.notices():
                console.print(f"{notice.kind}: {notice.what}", style="dim")


def _opened(path: Path) -> BinaryIO:
    try:
        return path.open("rb")
    except OSError as error:
        raise UnsupportedError(f"{path} cannot be read: {error.strerror}.") from error


def _format_of(path: Path) -> str:
    extension = path.suffix.lower()
    if extension in (".mcml", ".xml"):
        return "mcml"
    if extension == ".csv":
        return "csv"
    for name, format_ in FORMATS.items():
        if any(extension in part.extensions for part in format_.parts):
            return name
    raise UnsupportedError(
        f"{path.name!r} does not say which format to write.",
        remedy=f"Use --to with one of: {', '.join(sorted(targets()))}.",
    )


def validate(
    paths: Annotated[list[Path], typer.Argument(help="Files of any format, MCML or motion capture")],
    as_json: JsonOption = False,
) -> None:
    """Check files: MCML against mcml.dtd and the rules beyond it, other formats against theirs."""
    settings = chosen_settings()
    with ExitStack() as stack:
        files = [SourceFile(name_of(path), stack.enter_context(_opened(path))) for path in paths]
        clips, problems = inspect_files(files, ImportOptions(), settings)
    if as_json:
        print_json({"clips": clips, "problems": [{"file": name, "what": str(error)} for name, error in problems]})
    else:
        for clip in clips:
            facts = clip["receipt"]
            console.print(f"valid    {' + '.join(clip['files'])}: {facts['frames']:,} frames, {facts['joints']} joints")
        for name, error in problems:
            console.print(f"invalid  {_told(name, error)}")
    if problems:
        raise typer.Exit(1)


def _told(name: str, error: McmlError) -> str:
    text = str(error)
    return text if name in text else f"{name}: {text}"
