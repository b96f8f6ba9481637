"""`mcml analyse SUBJECT VERB`: a command for every entry of the catalogue, and for the operations on its results."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import BaseModel
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from mcml.client.choosing import id_of
from mcml.files.on_disk import write_file
from mcml.formats.format import SourceFile
from mcml_schemas.jobs import Selection
from mcml_service.actions.analysing.read_music import read_music
from mcml_service.analysis.catalogue import SUBJECTS
from mcml_service.analysis.interface import Analysis
from mcml_service.analysis.interface import ResultUse as Operation
from mcml_service.cli.commands import add_group
from mcml_service.cli.exporting import local_name
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    JsonOption,
    ServerOption,
    choose_settings,
    console,
    open_client,
    print_json,
)
from mcml_service.cli.terminal.present import present
from mcml_service.cli.terminal.results import show_parts
from mcml_service.operations import OPERATIONS

Assignments = Annotated[
    list[str] | None, typer.Argument(metavar="[NAME=VALUE]...", help="Parameters; values as JSON or plain text")
]
ResultArgument = Annotated[str, typer.Argument(help="Result")]


def add_to(app: typer.Typer) -> None:
    for subject, verbs in SUBJECTS.items():
        group = typer.Typer(no_args_is_help=True, help=", ".join(item.title for item in verbs.values()) + ".")
        operations: dict[str, Operation] = {}
        for verb, analysis in verbs.items():
            group.command(verb, help=_help(analysis.description, analysis.parameters))(_run(analysis))
            operations |= analysis.operations
        group.command("info", help="Show a result: its parts and its actions.")(info)
        group.command("picture")(picture)
        group.command("table")(table)
        for name, operation in operations.items():
            group.command(name, help=_help(operation.description, operation.parameters))(_use(name))
        app.add_typer(group, name=subject)
        if subject == "dance":
            group.command("music")(music)
    add_group(app, "analyse")


def _help(description: str, parameters: type[BaseModel]) -> str:
    """The description, then each parameter on a line."""
    lines = [description, "", "\b", "Parameters:"]
    for name, field in parameters.model_fields.items():
        default = (
            "" if field.is_required() else f" [{json.dumps(field.get_default(call_default_factory=True), default=str)}]"
        )
        lines.append(f"  {name}{default}  {field.description or ''}")
    return "\n".join(lines)


def parse_assignments(pairs: list[str] | None) -> dict[str, Any]:
    """NAME=VALUE pairs as parameters: a value that is JSON is read as such, any other is text."""
    parameters: dict[str, Any] = {}
    for pair in pairs or ():
        name, equals, value = pair.partition("=")
        if not equals:
            raise typer.BadParameter(f"{pair!r} is no NAME=VALUE")
        place = parameters
        *above, last = name.strip().split(".")
        for step in above:
            place = place.setdefault(step, {})
        try:
            place[last] = json.loads(value)
        except json.JSONDecodeError:
            place[last] = value
    return parameters


def _run(analysis: Analysis) -> Callable[..., None]:
    def command(
        parameters: Assignments = None,
        document: Annotated[list[str] | None, typer.Option(help="Document; may be repeated")] = None,
        project: Annotated[str | None, typer.Option(help="All documents of this project")] = None,
        motion_name: Annotated[str | None, typer.Option(help="Documents with a frame of this name")] = None,
        property: Annotated[list[str] | None, typer.Option(help="Documents with age:20..30 or take:calm")] = None,
        xpath: Annotated[str | None, typer.Option(help="Documents in which this finds something")] = None,
        include_made: Annotated[bool, typer.Option("--include-made", help="Also clips that an analysis made")] = False,
        skeleton: Annotated[str | None, typer.Option(help="Document on whose skeleton clips are brought")] = None,
        name: Annotated[str | None, typer.Option(help="Name of the result")] = None,
        into: Annotated[str | None, typer.Option(help="Project of the result; default the documents'")] = None,
        queue: Annotated[bool, typer.Option("--queue", help="Leave it to a server of this store")] = False,
        extends: Annotated[str | None, typer.Option(help="Result to add the documents to, where it can grow")] = None,
        database: DatabaseOption = None,
        server: ServerOption = None,
        as_json: JsonOption = False,
    ) -> None:
        client = open_client(database, server)
        selection = Selection(
            documents=[id_of(client, text) for text in document or ()],
            project=project,
            motion_name=motion_name,
            property=property or [],
            xpath=xpath,
            include_made=include_made,
        )
        columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
        hidden = as_json or not sys.stderr.isatty()
        with Progress(*columns, console=console, transient=True, disable=hidden) as bar:
            task = bar.add_task("starting", total=1.0)
            if queue:
                client.queue()
            body = skeleton and id_of(client, skeleton)
            stated = {"name": name, "project": into, "extends": extends, "skeleton": body}
            request = {
                "inputs": selection,
                "parameters": parse_assignments(parameters),
                **{key: value for key, value in stated.items() if value is not None},
            }
            job = client.call(f"start_{analysis.name.replace('-', '_')}", request=request)
            if not queue:
                job = client.finish(job, lambda stage, share: bar.update(task, description=stage[:48], completed=share))
        present(OPERATIONS["get_job"], job, as_json)
        if job.state == "done" and not as_json and job.result:
            show_parts(client.call("get_result", id=job.result))

    return command


def info(
    id: ResultArgument, database: DatabaseOption = None, server: ServerOption = None, as_json: JsonOption = False
) -> None:
    """Show a result: its parts and its actions."""
    result = open_client(database, server).call("get_result", id=id)
    present(OPERATIONS["get_result"], result, as_json)


def picture(
    id: ResultArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="SVG or PNG, as its ending says; default NAME.svg here")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Which picture; default the first that there is")] = None,
    dpi: Annotated[int, typer.Option(help="Dots an inch, of PNG")] = 200,
    width: Annotated[float | None, typer.Option(help="Inches")] = None,
    height: Annotated[float | None, typer.Option(help="Inches")] = None,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Draw a result: curves, graph, map or table as a file for a page or a paper. Needs the extra `plots`."""
    target = output or Path()
    form = target.suffix.lstrip(".").lower() or "svg"
    if form not in ("svg", "png"):
        raise typer.BadParameter(f"{target.name} is to end in .svg or .png")
    client = open_client(database, server)
    drawn = client.call("get_result_picture", id=id, name=name, format=form, dpi=dpi, width=width, height=height)
    if target.is_dir():
        target = target / local_name(drawn.name or f"picture.{form}")
    write_file(target, drawn.blocks, force=force)
    console.print(f"wrote    {target}")


def table(
    id: ResultArgument,
    part: Annotated[str, typer.Argument(help="Name of a table of the result")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="CSV file; default NAME-PART.csv here")] = None,
    force: ForceOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Write a table of a result as CSV, with units in the headings."""
    written = open_client(database, server).call("get_result_part", id=id, part=part, format="csv")
    target = output or Path()
    if target.is_dir():
        target = target / local_name(written.name or f"{part}.csv")
    write_file(target, written.blocks, force=force)
    console.print(f"wrote    {target}")


def _use(operation: str) -> Callable[..., None]:
    def command(
        id: ResultArgument,
        parameters: Assignments = None,
        output: Annotated[
            Path | None, typer.Option("-o", "--output", help="Write the clip to this file; its ending says the format")
        ] = None,
        force: ForceOption = False,
        save: Annotated[bool, typer.Option("--save", help="Store the clip as a document")] = False,
        name: Annotated[str | None, typer.Option(help="Name of the clip")] = None,
        project: Annotated[str | None, typer.Option(help="Project of the document")] = None,
        database: DatabaseOption = None,
        server: ServerOption = None,
    ) -> None:
        saving: dict[str, Any] = {"save": save, "name": name, "project": project}
        saving = {key: value for key, value in saving.items() if value is not None}
        form = "json" if output is None else output.suffix.lstrip(".").lower() or "bvh"
        request = {"parameters": parse_assignments(parameters), **saving}
        done = open_client(database, server).call(
            f"use_{operation.replace('-', '_')}", id=id, request=request, format=form
        )
        if output is None:
            print_json(done.model_copy(update={"clip": None}))
            return
        target = output / local_name(done.name or operation) if output.is_dir() else output
        write_file(target, done.blocks, force=force)
        console.print(f"wrote    {target}")

    return command


def music(
    file: Annotated[Path, typer.Argument(help="WAV, FLAC or MP3")],
    bpm: Annotated[float | None, typer.Option(min=40, max=240, help="Beats a minute, where known")] = None,
    beats_per_bar: Annotated[int | None, typer.Option(min=2, max=4, help="Beats of a bar, where known")] = None,
    database: DatabaseOption = None,
) -> None:
    """Find the beats of music, as JSON: correct them and pass them to `make` as music=…"""
    with file.open("rb") as stream:
        print_json(read_music(SourceFile(file.name, stream), choose_settings(database), bpm, beats_per_bar))
