"""`mcml import ls show export label`: documents of a library, here or on a server."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from schemas.documents import ChangedDocuments, DocumentDetail, ImportedDocument, LabelPage
from service.actions.exporting.export_motion import ExportOptions
from service.actions.reading.import_options import ImportOptions, Label, parse_label, parse_property
from service.cli.access import name_of
from service.cli.api import Api
from service.cli.shared import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_api,
    open_library,
    print_json,
    table,
)
from service.errors import McmlError, UnsupportedError
from service.storage.filtering import DocumentFilter

EXTENSIONS = {".bvh", ".asf", ".amc", ".htr", ".htr2", ".c3d", ".trc", ".mcml", ".xml", ".zip"}

PAIRED = (".asf", ".amc")

MOST_FILES, MOST_BYTES = 128, 64 << 20
"""Of one call: its files are open together, and what became of them is told when all are stored."""

SECONDS_DRAWN = 0.1
"""Between two drawings of the bar, each of which takes as long as to read a short clip."""


def add_to(app: typer.Typer) -> None:
    app.command("import")(import_)
    app.command()(ls)
    app.command()(show)
    app.command()(export)
    app.command()(label)


def import_(
    paths: Annotated[list[Path], typer.Argument(help="Files, folders or zips")],
    project: Annotated[str, typer.Option(help="Project to store into; made if new")] = "default",
    name: Annotated[str | None, typer.Option(help="Name of the document, for a single one")] = None,
    label: Annotated[list[str] | None, typer.Option(help="Motion name: NAME or NAME:FIRST-LAST")] = None,
    property: Annotated[list[str] | None, typer.Option(help="Property: age=23 or 'age=23 year'")] = None,
    encoding: Annotated[str | None, typer.Option(help="Text encoding, if it is not UTF-8")] = None,
    unit: Annotated[str | None, typer.Option(help="Length unit of the files")] = None,
    up: Annotated[str | None, typer.Option(help="Axis that points up")] = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, where the files do not say")] = None,
    skeleton: Annotated[str | None, typer.Option(help="Stored document whose ASF an AMC alone shall use")] = None,
    movements: Annotated[
        float | None,
        typer.Option(min=0, max=1, help="Name anatomical movements found in the motion with this confidence or more"),
    ] = None,
    again: Annotated[bool, typer.Option(help="Store files again that are stored already")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Store files. Files that are stored already are skipped, so an interrupted import goes on where it stopped."""
    options = ImportOptions(
        project=project,
        name=name,
        labels=tuple(parse_label(text) for text in label or ()),
        properties=tuple(parse_property(text) for text in property or ()),
        encoding=encoding,
        unit=unit,
        up=up,
        frame_time=frame_time,
        skeleton=skeleton,
        on_duplicate="new" if again else "skip",
        movements=movements,
    )
    library = open_library(database, server)
    stored, failed, answers = 0, 0, []
    # A name is for the one document of a call.
    groups = list(_groups(paths, MOST_FILES if name is None else 1))
    with _Bar(sum(map(len, groups)), disable=as_json or not sys.stderr.isatty()) as bar:
        for group in groups:
            bar.begin(group)
            answer = library.import_paths(group, options, bar.tell)
            answers.append(answer)
            for document in answer.documents:
                stored += not document.skipped
                if not as_json:
                    _print_imported(document)
            for problem in answer.problems:
                failed += 1
                if not as_json:
                    remedy = f"\n         {problem.problem.remedy}" if problem.problem.remedy else ""
                    line = problem.problem.where.line if problem.problem.where else None
                    place = f"{problem.file}:{line}" if line else problem.file
                    console.print(Text.assemble(("failed", "red"), f"   {place}: {problem.problem.detail}{remedy}"))
    if as_json:
        documents = [item.model_dump() for answer in answers for item in answer.documents]
        problems = [item.model_dump(exclude_none=True) for answer in answers for item in answer.problems]
        print_json({"documents": documents, "problems": problems})
    else:
        console.print(f"{stored} stored, {failed} failed")
    if failed:
        raise typer.Exit(3 if stored else 1)


def _print_imported(document: ImportedDocument) -> None:
    if document.skipped:
        console.print(f"skipped  {document.name}  {document.id} (stored already)")
        return
    facts = document.receipt
    rate = f"{facts.frame_rate.frames_per_second:.6g} Hz" if facts.frame_rate.frames_per_second else "rate unknown"
    mapped = "" if facts.naming is None else f", {len(facts.naming.mapped)} of {facts.joints} joints mapped"
    unit = facts.unit.value or "unit unknown"
    console.print(f"stored   {document.name}  {document.id}\n         {facts.frames:,} frames, {rate}, {unit}{mapped}")
    if document.movements is not None:
        console.print(f"         {document.movements} movements named")
    for notice in facts.notices:
        if notice.kind in ("repair", "warning"):
            console.print(f"         {notice.kind}: {notice.what}", style="yellow")


class _Bar:
    """How many files are done. It is drawn by whoever tells it: beside a thread that drew it, no import could fork."""

    def __init__(self, files: int, *, disable: bool) -> None:
        what = TextColumn("{task.description}", markup=False)
        columns = (what, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        self._bar = Progress(*columns, console=console, transient=True, disable=disable, auto_refresh=False)
        self._task = self._bar.add_task("importing", total=files)
        self._before = 0
        self._files = 0
        self._names: set[str] = set()
        self._drawn = 0.0

    def __enter__(self) -> _Bar:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def begin(self, group: list[Path]) -> None:
        """All before these files are done."""
        self._before += self._files
        self._files = len(group)
        self._names = set()
        self._draw(name_of(group[0]))

    def tell(self, name: str, _frames: int, _of: int | None) -> None:
        """The progress of an import: a file of the group is read."""
        self._names.add(name)
        if time.monotonic() - self._drawn > SECONDS_DRAWN:
            self._draw(name)

    def _draw(self, name: str) -> None:
        completed = self._before + max(0, len(self._names) - 1)
        self._bar.update(self._task, description=name[:40], completed=completed, refresh=True)
        self._drawn = time.monotonic()


def _groups(paths: list[Path], most: int) -> Iterator[list[Path]]:
    """Files for one call each: ASF with the AMC files of its folder, a zip alone, at most so many others together."""
    others: list[Path] = []
    for path in paths:
        if not path.exists():
            raise UnsupportedError(f"{path} does not exist.")
        if not path.is_dir():
            others += [] if path.suffix.lower() in PAIRED else [path]
            continue
        paired: dict[Path, list[Path]] = {}
        for file in sorted(found for found in path.rglob("*") if found.suffix.lower() in EXTENSIONS):
            if file.suffix.lower() in PAIRED:
                paired.setdefault(file.parent, []).append(file)
            else:
                others.append(file)
        yield from paired.values()
    yield from _bounded(others, most)
    loose = [path for path in paths if path.is_file() and path.suffix.lower() in PAIRED]
    if loose:
        yield loose


def _bounded(files: list[Path], most: int) -> Iterator[list[Path]]:
    group: list[Path] = []
    size = 0
    for file in files:
        if file.suffix.lower() == ".zip":
            # Its ASF and AMC files are looked for among all of a call.
            yield [file]
            continue
        size += file.stat().st_size
        if group and (len(group) == most or size > MOST_BYTES):
            yield group
            group, size = [], file.stat().st_size
        group.append(file)
    if group:
        yield group


def ls(
    text: Annotated[str | None, typer.Argument(help="Part of the name")] = None,
    project: Annotated[str | None, typer.Option(help="Only this project")] = None,
    motion_name: Annotated[str | None, typer.Option(help="Documents with a frame of this name")] = None,
    format: Annotated[str | None, typer.Option(help="Source format")] = None,
    deleted: Annotated[bool, typer.Option("--deleted", help="List deleted documents instead")] = False,
    limit: Annotated[int, typer.Option(min=1, help="Most documents to list")] = 1000,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List documents."""
    wanted = DocumentFilter(project=project, text=text, motion_name=motion_name, format=format, deleted=deleted)
    page = open_library(database, server).documents(wanted, limit)
    if as_json:
        print_json(page)
        return
    rows = table("id", "name", "project", "format", "frames#", "seconds#")
    for item in page.items:
        seconds = "" if item.duration is None else f"{item.duration:.2f}"
        rows.add_row(item.id, item.name, item.project, item.format, f"{item.frames:,}", seconds)
    console.print(rows)
    console.print(f"{len(page.items)} of {page.total} documents", style="dim")


def show(
    id: Annotated[str, typer.Argument(help="Document")],
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show a document: facts, header, bones, labels, receipt."""
    found = open_library(database, server).document(id)
    if as_json:
        print_json(found)
        return
    rate = f"{1 / found.seconds_per_frame:.6g} Hz" if found.seconds_per_frame else "rate unknown"
    console.print(Text.assemble((found.name, "bold"), f"  {found.id}  revision {found.revision}"))
    console.print(
        f"{found.format}, {found.frames:,} frames, {rate}, unit {found.unit or 'unknown'}, up {found.up or 'unknown'}"
    )
    for fact in found.properties:
        console.print(f"  {fact.name} = {fact.value} {fact.unit}")
    rows = table("bone", "source name", "parent", "channels")
    for bone in found.bones:
        rows.add_row(bone.name, bone.source_name, bone.parent or "", " ".join(bone.channels))
    console.print(rows)
    for item in found.labels:
        console.print(f"  {item.first}-{item.last}  {item.name}")


def export(
    ids: Annotated[list[str], typer.Argument(help="Documents")],
    format: Annotated[str, typer.Option(help="bvh, asf-amc, asf, amc, htr, c3d, trc, mcml or csv")] = "bvh",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File or folder; default this folder, - prints")
    ] = None,
    first: Annotated[int, typer.Option(help="First frame, from 1")] = 1,
    last: Annotated[int | None, typer.Option(help="Last frame, included")] = None,
    names: Annotated[str | None, typer.Option(help="Joint names: mcml, bvh1, bvh2, asf or htr")] = None,
    unit: Annotated[str | None, typer.Option(help="Scale lengths to this unit")] = None,
    up: Annotated[str | None, typer.Option(help="Turn so that this axis points up")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Write documents as files of any format."""
    library = open_library(database, server)
    options = ExportOptions(format, first, last, names, unit, up)
    for uuid in ids:
        with library.export(uuid, options) as (file_name, content, notices):
            if output is not None and str(output) == "-":
                for block in content:
                    sys.stdout.buffer.write(block)
                continue
            target = Path(output) if output is not None else Path(".")
            target = target / file_name if target.is_dir() or len(ids) > 1 else target
            target.parent.mkdir(parents=True, exist_ok=True)
            part = target.with_name(target.name + ".part")
            try:
                with part.open("wb") as stream:
                    for block in content:
                        stream.write(block)
                    stream.flush()
                    os.fsync(stream.fileno())
                part.replace(target)
            finally:
                part.unlink(missing_ok=True)
            console.print(f"wrote    {target}")
            for notice in notices:
                console.print(f"         {notice}", style="yellow")


def label(
    id: Annotated[str | None, typer.Argument(help="Document")] = None,
    labels: Annotated[list[str] | None, typer.Argument(help="NAME:FIRST-LAST, or NAME for all frames")] = None,
    properties: Annotated[
        Path | None, typer.Option(help="Instead: a CSV table of properties, such as name,age (year),height (cm)")
    ] = None,
    project: Annotated[str | None, typer.Option(help="Project in which the table's names are looked up")] = None,
    strict: Annotated[bool, typer.Option(help="Refuse names that are no anatomical movement")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Name frames of a document, or set properties of many documents from a table."""
    api = open_api(database, server)
    if properties is not None:
        _set_properties(api, properties, project, as_json)
        return
    if id is None or not labels:
        raise typer.BadParameter("name a document and its labels, or --properties TABLE")
    frames = DocumentDetail(**api.send("GET", f"/documents/{id}").json()).frames
    body = [_range(parse_label(text), frames) for text in labels]
    asked, headers = {"strict": strict}, {"if-match": "*"}
    added = LabelPage(**api.send("POST", f"/documents/{id}/labels", json=body, params=asked, headers=headers).json())
    if as_json:
        print_json(added)
        return
    for item in added.items:
        console.print(f"named    {item.first}-{item.last}  {item.name}")


def _set_properties(api: Api, path: Path, project: str | None, as_json: bool) -> None:
    asked, headers = {} if project is None else {"project": project}, {"content-type": "text/csv"}
    try:
        answer = api.send("POST", "/properties", content=path.read_bytes(), params=asked, headers=headers)
        changed = ChangedDocuments(**answer.json())
    except McmlError as error:
        raise error.in_file(path.name) from error
    if as_json:
        print_json(changed)
        return
    for item in changed.items:
        console.print(f"changed  {item.name}  {item.id}  revision {item.revision}")
    console.print(f"{len(changed.items)} changed")


def _range(label: Label, frames: int) -> dict[str, Any]:
    first = 1 if label.first is None else label.first
    return {"name": label.name, "first": first, "last": frames if label.last is None else label.last}
