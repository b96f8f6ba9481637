"""`mcml jobs`: what runs, and ending it."""

from __future__ import annotations

from typing import Annotated

import typer

from service.cli.analyse import show_job
from service.cli.shared import DatabaseOption, JsonOption, ServerOption, console, print_json, table
from service.cli.work import open_work

JobArgument = Annotated[str, typer.Argument(help="Job")]


def add_to(app: typer.Typer) -> None:
    app.command("list")(list_)
    app.command()(show)
    app.command()(watch)
    app.command()(cancel)


def list_(
    project: Annotated[str | None, typer.Option(help="Only of this project")] = None,
    state: Annotated[str | None, typer.Option(help="waiting, running, done, failed or cancelled")] = None,
    limit: Annotated[int, typer.Option(min=1, help="Most jobs to list")] = 100,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List jobs, the newest first."""
    found = open_work(database, server).jobs(project, state, limit)
    if as_json:
        print_json([item.model_dump(exclude_none=True) for item in found])
        return
    rows = table("id", "state", "done#", "analysis", "name", "stage", "created")
    for job in found:
        rows.add_row(job.id, job.state, f"{job.share:.0%}", job.analysis, job.name, job.stage, job.created)
    console.print(rows)


def show(
    id: JobArgument, database: DatabaseOption = None, server: ServerOption = None, as_json: JsonOption = False
) -> None:
    """Show a job."""
    show_job(open_work(database, server).job(id), as_json)


def watch(
    id: JobArgument, database: DatabaseOption = None, server: ServerOption = None, as_json: JsonOption = False
) -> None:
    """Wait until a job has ended."""
    work = open_work(database, server)
    with console.status("waiting") as line:
        ended = work.wait(work.job(id), lambda stage, share: line.update(f"{share:.0%} {stage}"))
    show_job(ended, as_json)


def cancel(id: JobArgument, database: DatabaseOption = None, server: ServerOption = None) -> None:
    """End a job."""
    job = open_work(database, server).cancel(id)
    console.print(f"{job.state if job.state != 'running' else 'ending'}  {job.name}  {job.id}")
