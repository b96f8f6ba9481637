"""How jobs and results look on a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import typer
from rich.text import Text

from mcml.errors import McmlError
from mcml_service.cli.terminal.opening import console

if TYPE_CHECKING:
    from mcml_schemas.jobs import Job, PartSummary, Result

MOST_SHOWN = 12
"""Items of a list that a result shows."""


def show_result(found: Result) -> None:
    """Print a result with its parts and their summaries."""
    console.print(
        Text.assemble(
            (found.name, "bold"),
            f"  {found.id}\n{found.analysis} of {len(found.inputs)} clips, {found.created}",
        )
    )
    show_parts(found)
    for part in found.parts.values():
        for line in _facts(part.data.get("summary"), "  "):
            console.print(line)


def show_job(job: Job) -> None:
    """Print the progress and the outcome of a job."""
    console.print(f"{job.state:<9} {job.name}  {job.id}  {job.share:.0%} {job.stage}")
    if job.left_out:
        console.print(f"          without {job.left_out} clips that an analysis made (--include-made)")
    if job.result:
        console.print(f"          result {job.result}")


def fail_with(job: Job) -> None:
    """Exit code 1 where a job failed, with why, or was cancelled."""
    if job.problem is not None:
        error = McmlError(job.problem.detail, remedy=job.problem.remedy)
        if job.problem.code:
            error.details |= {"code": job.problem.code} | (job.problem.details or {})
        raise error
    if job.state == "cancelled":
        raise typer.Exit(1)


def show_parts(found: Result) -> None:
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
    """Summarise a part in one line: its plain numbers and texts, and the sizes of other values."""
    words = []
    for key, value in part.data.items():
        words.append(f"{key}: {len(value)}" if isinstance(value, list | dict) else f"{key} {_plain(value)}")
    words += [f"{name} {'x'.join(map(str, about.shape))}" for name, about in part.arrays.items()]
    return (f"document {part.document} " if part.document else "") + ", ".join(words)
