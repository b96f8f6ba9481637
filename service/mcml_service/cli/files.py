"""`mcml convert` and `mcml validate`: files only, nothing is stored."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from mcml.errors import McmlError
from mcml.files.convert_files import convert_files, result_paths, stated_format
from mcml.files.import_options import ImportOptions
from mcml.files.on_disk import check_free, opened_character, opened_files, write_file
from mcml_service.actions.reading.inspect_files import inspect_files
from mcml_service.cli.terminal.opening import ForceOption, ForOption, JsonOption, choose_settings, console, print_json


def convert(
    paths: Annotated[list[Path], typer.Argument(help="IN… OUT: files to read (ASF and AMC together), then the result")],
    to: Annotated[str | None, typer.Option(help="Format of the result, where its name does not say")] = None,
    for_: ForOption = None,
    skeleton: Annotated[Path | None, typer.Option(help="ASF file for an AMC")] = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, where the files do not say")] = None,
    encoding: Annotated[str | None, typer.Option(help="Text encoding of the input, if it is not UTF-8")] = None,
    names: Annotated[str | None, typer.Option(help="Joint names: mcml, bvh1, bvh2, asf or htr")] = None,
    unit: Annotated[str | None, typer.Option(help="Unit of length of the input, where it does not say")] = None,
    up: Annotated[str | None, typer.Option(help="Axis of the input that points up, where it does not say")] = None,
    take: Annotated[str | None, typer.Option(help="Motion to convert, of a file that holds several")] = None,
    rate: Annotated[float | None, typer.Option(min=0.001, help="Frames a second at which keys are sampled")] = None,
    frames: Annotated[str | None, typer.Option(help="Frame range of the result: FIRST-LAST, from 1")] = None,
    fps: Annotated[float | None, typer.Option(min=0.001, help="Frames a second of the result")] = None,
    scale: Annotated[float | None, typer.Option(help="Factor of all lengths")] = None,
    height: Annotated[float | None, typer.Option(help="Scale so that the body stands this many metres tall")] = None,
    in_place: Annotated[bool, typer.Option("--in-place", help="Without travel over the ground")] = False,
    guesses: Annotated[bool, typer.Option(help="Guess a unit and an up axis that the format needs")] = True,
    character: Annotated[
        str | None, typer.Option(help="glTF and USD: a body instead of bones: own, or a file with a skinned mesh")
    ] = None,
    force: ForceOption = False,
    quiet: Annotated[bool, typer.Option(help="Do not print what was guessed or lost")] = False,
) -> None:
    """Convert a motion between formats. For ASF/AMC name the .amc; its .asf is written beside it."""
    if len(paths) < 2:
        raise typer.BadParameter("give at least one file to read and one to write")
    *sources, result = paths
    target = stated_format(result, to, for_)
    with ExitStack() as stack:
        inputs = [*sources, *([skeleton] if skeleton else [])]
        files = stack.enter_context(opened_files(inputs))
        converted = convert_files(
            files,
            target,
            choose_settings().file_limits,
            frame_time=frame_time,
            encoding=encoding,
            names=names,
            unit=unit,
            up=up,
            take=take,
            rate=rate,
            frames=frames,
            fps=fps,
            scale=scale,
            height=height,
            in_place=in_place,
            guesses=guesses,
            character=stack.enter_context(opened_character(character)),
            for_=for_,
            stem=result.stem,
        )
        done = stack.enter_context(converted)
        for path, content in result_paths(result, done, target):
            check_free(path, force=force, sources=inputs)
            write_file(path, content, force=force)
        if not quiet:
            for notice in done.notices():
                console.print(f"{notice.kind}: {notice.what}", style="dim")


def validate(
    paths: Annotated[list[Path], typer.Argument(help="Files of any format, MCML or motion capture")],
    as_json: JsonOption = False,
) -> None:
    """Check files: MCML against mcml.dtd and further rules, other formats against their specifications."""
    settings = choose_settings()
    with ExitStack() as stack:
        files = stack.enter_context(opened_files(paths))
        clips, problems = inspect_files(files, ImportOptions(), settings)
    if as_json:
        print_json({"clips": clips, "problems": [{"file": name, "what": str(error)} for name, error in problems]})
    else:
        for clip in clips:
            facts = clip["receipt"]
            console.print(f"valid    {' + '.join(clip['files'])}: {facts['frames']:,} frames, {facts['joints']} joints")
        for name, error in problems:
            console.print(f"invalid  {_describe(name, error)}")
    if problems:
        raise typer.Exit(1)


def _describe(name: str, error: McmlError) -> str:
    text = str(error)
    return text if name in text else f"{name}: {text}"
