"""`mcml analyse SUBJECT VERB`: a command for every entry of the catalogue, and for what its results can do."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import BaseModel
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from schemas.jobs import Job, PartSummary, Result, Selection
from service.actions.analysing.read_music import read_music
from service.actions.checking.check_names import file_name
from service.analysis.catalogue import SUBJECTS
from service.analysis.interface import Analysis
from service.analysis.interface import ResultUse as Operation
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, chosen_settings, console, print_json, table
from service.cli.work import Order, open_work
from service.errors import McmlError
from service.formats.format import SourceFile

Assignments = Annotated[
    list[str] | None, typer.Argument(metavar="[NAME=VALUE]...", help="Parameters; values as JSON or plain text")
]
ResultArgument = Annotated[str, typer.Argument(help="Result")]
MOST_SHOWN = 12
"""Items of a list that `info` shows."""


def add_to(app: typer.Typer) -> None:
    for subject, verbs in SUBJECTS.items():
        group = typer.Typer(no_args_is_help=True, help=", ".join(item.title for item in verbs.values()) + ".")
        operations: dict[str, Operation] = {}
        for verb, analysis in verbs.items():
            group.command(verb, help=_help(analysis.description, analysis.parameters))(_run(analysis))
            operations |= analysis.operations
        group.command("info", help="Show a result: its parts and what can be done with it.")(info)
        for name, operation in operations.items():
            group.command(name, help=_help(operation.description, operation.parameters))(_use(name))
        app.add_typer(group, name=subject)
        if subject == "dance":
            group.command("music")(music)
    app.command("results")(results)
    app.command("delete")(delete)


def _help(description: str, parameters: type[BaseModel]) -> str:
    """The description, then each parameter on a line."""
    lines = [description, "", "\b", "Parameters:"]
    for name, field in parameters.model_fields.items():
        default = (
            "" if field.is_required() else f" [{json.dumps(field.get_default(call_default_factory=True), default=str)}]"
        )
        lines.append(f"  {name}{default}  {field.description or ''}")
    return "\n".join(lines)


def assigned(pairs: list[str] | None) -> dict[str, Any]:
    """NAME=VALUE pairs as parameters: a value that is JSON is read as such, any other is text."""
    found: dict[str, Any] = {}
    for pair in pairs or ():
        name, equals, value = pair.partition("=")
        if not equals:
            raise typer.BadParameter(f"{pair!r} is no NAME=VALUE")
        place = found
        *above, last = name.strip().split(".")
        for step in above:
            place = place.setdefault(step, {})
        try:
            place[last] = json.loads(value)
        except json.JSONDecodeError:
            place[last] = value
    return found


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
        selection = Selection(
            documents=document or [],
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
            job = open_work(database, server).start(
                Order(analysis.name, selection, assigned(parameters), name, into, queue, extends, skeleton),
                lambda stage, share: bar.update(task, description=stage[:48], completed=share),
            )
        show_job(job, as_json)
        if job.state == "done" and not as_json and job.result:
            _show_result(open_work(database, server).result(job.result))

    return command


def show_job(job: Job, as_json: bool) -> None:
    """Print a job; exit code 1 where it failed or was cancelled."""
    if as_json:
        print_json(job)
    else:
        console.print(f"{job.state:<9} {job.name}  {job.id}  {job.share:.0%} {job.stage}")
        if job.left_out:
            console.print(f"          without {job.left_out} clips that an analysis made (--include-made)")
        if job.result:
            console.print(f"          result {job.result}")
    if job.problem is not None:
        error = McmlError(job.problem.detail, remedy=job.problem.remedy)
        if job.problem.code:
            error.details |= {"code": job.problem.code} | (job.problem.details or {})
        raise error
    if job.state == "cancelled":
        raise typer.Exit(1)


def info(
    id: ResultArgument, database: DatabaseOption = None, server: ServerOption = None, as_json: JsonOption = False
) -> None:
    """Show a result: its parts and what can be done with it."""
    found = open_work(database, server).result(id)
    if as_json:
        print_json(found)
        return
    console.print(
        Text.assemble(
            (found.name, "bold"),
            f"  {found.id}\n{found.analysis} of {len(found.inputs)} clips, {found.created}",
        )
    )
    _show_result(found)
    for part in found.parts.values():
        for line in _facts(part.data.get("summary"), "  "):
            console.print(line)


def _show_result(found: Result) -> None:
    for name, part in found.parts.items():
        console.print(f"  {name} ({part.kind}) {_gist(part)}", style="default")
    if found.operations:
        console.print(f"  then: {', '.join(found.operations)}", style="dim")


def _facts(value: Any, indent: str) -> Iterator[str]:
    """Facts within facts as lines: plain ones together, lists an item a line; long lists are cut."""
    if isinstance(value, dict):
        plain = [f"{key} {_plain(item)}" for key, item in value.items() if not isinstance(item, list | dict)]
        if plain:
            yield indent + ", ".join(plain)
        for key, item in value.items():
            if isinstance(item, list | dict) and item:
                yield f"{indent}{key}:"
                yield from _facts(item, indent + "  ")
    elif isinstance(value, list):
        nested = any(isinstance(item, list | dict) for item in value)
        if not nested:
            yield indent + ", ".join(map(_plain, value[:MOST_SHOWN]))
        for item in value[:MOST_SHOWN] if nested else ():
            yield from _facts(item, indent)
        if len(value) > MOST_SHOWN:
            yield f"{indent}… {len(value):,} in all (--json)"
    elif value is not None:
        yield indent + _plain(value)


def _plain(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _gist(part: PartSummary) -> str:
    """What a part says, in a line: its plain numbers and texts, and the sizes of the rest."""
    words = []
    for key, value in part.data.items():
        words.append(f"{key}: {len(value)}" if isinstance(value, list | dict) else f"{key} {_plain(value)}")
    words += [f"{name} {'x'.join(map(str, about.shape))}" for name, about in part.arrays.items()]
    return (f"document {part.document} " if part.document else "") + ", ".join(words)


def _use(operation: str) -> Callable[..., None]:
    def command(
        id: ResultArgument,
        parameters: Assignments = None,
        output: Annotated[
            Path | None, typer.Option("-o", "--output", help="Write the clip to this file; its ending says the format")
        ] = None,
        save: Annotated[bool, typer.Option("--save", help="Store the clip as a document")] = False,
        name: Annotated[str | None, typer.Option(help="Name of the clip")] = None,
        project: Annotated[str | None, typer.Option(help="Project of the document")] = None,
        database: DatabaseOption = None,
        server: ServerOption = None,
    ) -> None:
        saving: dict[str, Any] = {"save": save, "name": name, "project": project}
        saving = {key: value for key, value in saving.items() if value is not None}
        work, given = open_work(database, server), assigned(parameters)
        if output is None:
            print_json(work.use(id, operation, given, saving))
            return
        said, content = work.use_for_file(id, operation, given, saving, output.suffix.lstrip(".").lower() or "bvh")
        target = output / file_name(said) if output.is_dir() else output
        target.write_bytes(content)
        console.print(f"wrote    {target}")

    return command


def music(file: Annotated[Path, typer.Argument(help="WAV, FLAC or MP3")], database: DatabaseOption = None) -> None:
    """Find the beats of music, as JSON: what to correct, and to give to `make` as music=…"""
    with file.open("rb") as stream:
        print_json(read_music(SourceFile(file.name, stream), chosen_settings(database)))


def results(
    project: Annotated[str | None, typer.Option(help="Only of this project")] = None,
    analysis: Annotated[str | None, typer.Option(help="Only of this analysis")] = None,
    limit: Annotated[int, typer.Option(min=1, help="Most results to list")] = 100,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List results, the newest first."""
    found = open_work(database, server).results(project, analysis, limit)
    if as_json:
        print_json([item.model_dump(exclude_none=True) for item in found])
        return
    rows = table("id", "analysis", "name", "project", "clips#", "created")
    for item in found:
        rows.add_row(item.id, item.analysis, item.name, item.project, str(len(item.inputs)), item.created)
    console.print(rows)


def delete(id: ResultArgument, database: DatabaseOption = None, server: ServerOption = None) -> None:
    """Delete a result and what was made from it; documents that were stored from it stay."""
    open_work(database, server).delete_result(id)
    console.print(f"deleted  {id}")
