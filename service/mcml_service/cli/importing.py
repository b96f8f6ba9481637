"""`mcml import`: files and folders stored, with progress; by hand, since a folder is many calls."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from mcml.client.choosing import id_of
from mcml.client.client import Client
from mcml.client.folders import import_paths
from mcml.errors import RequestError
from mcml.files.on_disk import opened_files
from mcml_schemas.documents import ImportedDocument, Receipt
from mcml_schemas.revisions import FileReplaced
from mcml_service.cli.deriving import FEW, derive_stored, tell_calibrations, tell_origins
from mcml_service.cli.terminal.bar import Bar
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_client,
    print_json,
    write_to_the_end,
)
from mcml_service.local_store import Local


def import_(
    paths: Annotated[list[Path], typer.Argument(help="Files, folders or zips")],
    project: Annotated[str, typer.Option(help="Project to store into; made if new")] = "default",
    name: Annotated[str | None, typer.Option(help="Name of the document, for a single one")] = None,
    description: Annotated[str | None, typer.Option(help="Description")] = None,
    label: Annotated[list[str] | None, typer.Option(help="Motion name: NAME or NAME:FIRST-LAST")] = None,
    property: Annotated[list[str] | None, typer.Option(help="Property: age=23 or 'age=23 year'")] = None,
    encoding: Annotated[str | None, typer.Option(help="Text encoding, if it is not UTF-8")] = None,
    repair: Annotated[
        list[str] | None,
        typer.Option(
            help="Repair first: split-numbers, decimal-commas, missing-samples, stated-dof, three-dof, whole-frames; "
            "may be repeated"
        ),
    ] = None,
    translation: Annotated[
        str | None, typer.Option(help="auto, absolute or relative: whether translations replace offsets or add to them")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="Length unit of the files")] = None,
    up: Annotated[str | None, typer.Option(help="Axis that points up")] = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, where the files do not say")] = None,
    take: Annotated[str | None, typer.Option(help="Motion of a file that holds several; default all")] = None,
    rate: Annotated[float | None, typer.Option(min=0.001, help="Frames a second at which keys are sampled")] = None,
    replacing: Annotated[
        str | None, typer.Option("--as", help="Document whose frames the file replaces, as a new revision")
    ] = None,
    replace_skeleton: Annotated[
        bool, typer.Option("--replace-skeleton", help="With --as: replace skeleton, unit and frame rate too")
    ] = False,
    skeleton: Annotated[
        str | None, typer.Option(help="Stored document whose ASF to use for an AMC without one")
    ] = None,
    strict_names: Annotated[
        bool, typer.Option("--strict-names", help="Refuse labels that are no anatomical movement")
    ] = False,
    movements: Annotated[
        float | None,
        typer.Option(min=0, max=1, help="Name anatomical movements found in the motion with this confidence or more"),
    ] = None,
    again: Annotated[bool, typer.Option("--again", help="Store files again that are stored already")] = False,
    no_derive: Annotated[
        bool, typer.Option("--no-derive", help="Do not derive bodies now; a server or mcml db derive does it later")
    ] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Store files. Existing clips are skipped, so an interrupted import can be repeated."""
    write_to_the_end()
    client = open_client(database, server)
    if replacing is not None:
        for_new = {
            "--name": name, "--description": description, "--label": label, "--property": property, "--unit": unit,
            "--up": up, "--frame-time": frame_time, "--skeleton": skeleton, "--movements": movements,
        }  # fmt: skip
        _refuse_with_as([option for option, value in for_new.items() if value])
        stated = {
            "encoding": encoding,
            "translation": translation or "auto",
            "take": take,
            "rate": rate,
            "repair": repair or None,
            "replace_skeleton": replace_skeleton,
        }
        _replace(client, id_of(client, replacing), paths, stated, as_json=as_json)
        return
    options: dict[str, Any] = {
        "project": project,
        "name": name,
        "description": description,
        "label": label,
        "property": property,
        "encoding": encoding,
        "repair": repair or None,
        "translation": translation,
        "unit": unit,
        "up": up,
        "frame_time": frame_time,
        "take": take,
        "rate": rate,
        "skeleton": skeleton and id_of(client, skeleton),
        "strict_names": strict_names,
        "movements": movements,
        "on_duplicate": "new" if again else "skip",
    }
    stored, failed, answers = 0, 0, []
    with Bar("importing", disable=as_json or not sys.stderr.isatty()) as bar:
        for answer in import_paths(client, paths, options, bar.tell):
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
    documents = [document for answer in answers for document in answer.documents]
    if as_json:
        problems = [item.model_dump(exclude_none=True) for answer in answers for item in answer.problems]
        print_json({"documents": [item.model_dump() for item in documents], "problems": problems})
    else:
        console.print(f"{stored} stored, {failed} failed")
    _derive(client, documents, no_derive=no_derive, quiet=as_json)
    if failed:
        raise typer.Exit(3 if stored else 1)


def _refuse_with_as(options: list[str]) -> None:
    """Raises RequestError for options that only a new document has."""
    if options:
        raise RequestError(
            f"{options[0]} is an option of new documents; --as replaces the frames of one.",
            remedy="Leave it out, and change the document with: mcml set ID.",
        )


def _replace(client: Client, document: str, paths: list[Path], stated: dict[str, Any], *, as_json: bool) -> None:
    """Replace the frames of a document by those of a file, and print the difference."""
    with opened_files(paths) as files:
        made: FileReplaced = client.call("replace_file", id=document, file=files, if_match="*", **stated)
    if as_json:
        print_json(made.model_dump())
    elif made.first is None:
        console.print("unchanged: the file has the frames of the document")
    else:
        console.print(f"revision {made.revision}: frames {made.first} to {made.last} replaced, {made.frames} in all")
        if made.skeleton is not None:
            for word in ("added", "removed", "changed"):
                joints = getattr(made.skeleton, word)
                if joints:
                    console.print(f"         {len(joints)} joints {word}: {', '.join(joints)}", soft_wrap=True)
        if made.largest is not None:
            change = made.largest
            text = f"{change.bone} {change.channel} in frame {change.frame}: {change.before:g} → {change.after:g}"
            console.print(f"         {len(made.joints)} joints differ, most of all {text}")


def _derive(client: Client, documents: list[ImportedDocument], *, no_derive: bool, quiet: bool) -> None:
    """Derive bodies in a local store; a server does so automatically. Print their calibration."""
    stored = [document for document in documents if not document.skipped]
    here = isinstance(client, Local) and client.repository.settings.derive and not no_derive
    if isinstance(client, Local) and here:
        # Existing ones too: their import may have been stopped while it derived.
        derive_stored(client.repository.database, {document.id for document in documents}, quiet=quiet)
    if quiet:
        return
    if len(stored) <= FEW:
        tell_calibrations(client, stored)
    elif isinstance(client, Local) and here:
        tell_origins(client.repository.database, {document.id for document in stored})


def _say_names(facts: Receipt) -> str:
    """How many joints have a name of MCML's, or how many markers are on a known landmark."""
    if facts.naming is None:
        return ""
    if facts.markers:
        return f", {len(facts.naming.landmarks)} of {facts.joints} markers on known landmarks"
    return f", {len(facts.naming.mapped)} of {facts.joints} joints mapped"


def _print_imported(document: ImportedDocument) -> None:
    if document.skipped:
        console.print(f"skipped  {document.name}  {document.id} (stored already)")
        return
    facts = document.receipt
    rate = f"{facts.frame_rate.frames_per_second:.6g} Hz" if facts.frame_rate.frames_per_second else "rate unknown"
    unit = facts.unit.value or "unit unknown"
    known = f"{facts.frames:,} frames, {rate}, {unit}{_say_names(facts)}"
    console.print(f"stored   {document.name}  {document.id}\n         {known}")
    if document.movements is not None:
        console.print(f"         {document.movements} movements named")
    for notice in facts.notices:
        if notice.kind in ("repair", "warning"):
            console.print(f"         {notice.kind}: {notice.what}", style="yellow")
