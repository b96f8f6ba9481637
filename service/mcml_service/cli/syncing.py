"""`mcml sync`: a folder and a project, kept equal."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from mcml.client.client import Client
from mcml.client.sync.bindings import Bindings
from mcml.client.sync.events import DONE, REFUSED, Event
from mcml.client.sync.folder_sync import FolderSync
from mcml.errors import BusyError, ConflictError, StoreError, UnsupportedError
from mcml_service.cli.deriving import derive_stored
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

STYLES = {"failed": "red", "conflict": "red", "waiting": "yellow", "gone": "yellow", "left": "yellow"}


def sync(
    folder: Annotated[Path, typer.Argument(help="Folder of motions", exists=True, file_okay=False)],
    project: Annotated[str, typer.Option(help="Project to store into; made if new")] = "default",
    both: Annotated[bool, typer.Option("--both", help="Also write new and changed documents into the folder")] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Continue until you stop it")] = False,
    interval: Annotated[float, typer.Option(min=0.2, help="Seconds between two looks of --watch")] = 2.0,
    encoding: Annotated[str | None, typer.Option(help="Text encoding, if it is not UTF-8")] = None,
    unit: Annotated[str | None, typer.Option(help="Length unit of new files")] = None,
    up: Annotated[str | None, typer.Option(help="Axis that points up in new files")] = None,
    frame_time: Annotated[str | None, typer.Option(help="Seconds a frame, where new files do not say")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Sync a folder: import new files, replace the frames of documents whose files changed. Nothing is deleted.

    You can stop it at any time; the next run continues.
    """
    write_to_the_end()
    client = open_client(database, server)
    options = {"encoding": encoding, "unit": unit, "up": up, "frame_time": frame_time}
    counts: Counter[str] = Counter()
    with hold(folder), Bar("syncing", disable=as_json or not sys.stderr.isatty()) as bar:
        bindings = Bindings.read(folder, _address_of(client, server), project)
        rounds = FolderSync(client, folder, bindings, project, options, bar.tell, both=both)
        try:
            _run_round(client, rounds, counts, as_json=as_json)
            while watch:
                pause(interval)
                _try_round(client, rounds, counts, as_json=as_json)
        except KeyboardInterrupt:
            if not watch:
                raise
    refused = any(counts[action] for action in REFUSED)
    if refused:
        raise typer.Exit(3 if any(counts[action] for action in DONE) else 1)


def pause(seconds: float) -> None:
    """Wait for the next look."""
    time.sleep(seconds)


@contextmanager
def hold(folder: Path) -> Iterator[None]:
    """Keep other syncs away from a folder. Raises ConflictError where one is at work."""
    if sys.platform == "win32":
        yield
        return
    import fcntl
    import os

    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ConflictError(f"Another mcml sync is at work in {folder}.", remedy="Stop that one first.") from None
        except OSError as error:
            raise UnsupportedError(f"{folder} cannot be locked: {error.strerror}.") from error
        yield
    finally:
        os.close(handle)


def _address_of(client: Client, server: str | None) -> str:
    if isinstance(client, Local):
        return client.repository.database.dialect.engine.url.render_as_string(hide_password=True)
    return (server or "").rstrip("/")


def _try_round(client: Client, rounds: FolderSync, counts: Counter[str], *, as_json: bool) -> None:
    """A round of --watch: an unreachable or busy repository is tried again later."""
    try:
        _run_round(client, rounds, counts, as_json=as_json, quiet=True)
    except (BusyError, StoreError) as error:
        print(f"mcml: {error.what} Trying again.", file=sys.stderr)


def _run_round(client: Client, rounds: FolderSync, counts: Counter[str], *, as_json: bool, quiet: bool = False) -> None:
    """Sync once, and print the results. quiet: print nothing where nothing happened."""
    events: list[Event] = []
    try:
        for event in rounds.run():
            events.append(event)
            if not as_json:
                _print_event(event)
    finally:
        counts.update(event.action for event in events)
        if events or not quiet:
            _print_summary(events, rounds.unchanged, as_json=as_json)
    if isinstance(client, Local) and client.repository.settings.derive:
        stored = {event.document for event in events if event.action == "stored" and event.document}
        if stored:
            derive_stored(client.repository.database, stored, quiet=as_json)


def _print_event(event: Event) -> None:
    facts = [event.path, event.document or "", f"revision {event.revision}" if event.revision else ""]
    console.print(
        Text.assemble((f"{event.action:<8}", STYLES.get(event.action, "")), " ", "  ".join(filter(None, facts)))
    )
    for line in filter(None, (event.detail, event.remedy)):
        console.print(f"         {line}")


def _print_summary(events: list[Event], unchanged: int, *, as_json: bool) -> None:
    counts = Counter[str](event.action for event in events)
    if as_json:
        rows: list[dict[str, Any]] = [{key: value for key, value in asdict(event).items() if value} for event in events]
        print_json({"files": rows, "counts": {**counts, "unchanged": unchanged}})
        return
    always = ("stored", "replaced", "fetched", "conflict", "failed")
    shown = [f"{counts[action]} {action}" for action in always if counts[action] or action in ("stored", "replaced")]
    shown += [f"{counts[action]} {action}" for action in ("skipped", "waiting", "gone", "left") if counts[action]]
    console.print(", ".join([*shown, f"{unchanged} unchanged"]))
