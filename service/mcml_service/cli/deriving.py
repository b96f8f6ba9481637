"""Derive bodies of documents for queries about motion: `mcml db derive`, and the last step of `mcml import`."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, get_args

from rich.text import Text

from mcml.errors import McmlError
from mcml_service.cli.terminal.bar import Bar
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    choose_settings,
    console,
    open_database,
    print_json,
)
from mcml_service.clips.bodies import Body
from mcml_service.clips.derive import derive_missing
from mcml_service.clips.deriver import Stage
from mcml_service.xpath.column_builder import build_stage
from mcml_service.xpath.library.preparing import count_prepared
from mcml_service.xpath.queries import Queries

if TYPE_CHECKING:
    from mcml.client.client import Client
    from mcml_schemas.documents import ImportedDocument
    from mcml_service.settings import Settings
    from mcml_service.storage.database import Database
    from mcml_service.storage.documents.columns import Listed

FEW = 8
"""Limit of imported documents whose calibration is printed one by one; for more, counts are printed."""
CALIBRATED = {"unit": "metres", "up": "up", "floor": "floor", "leg": "leg"}
"""Printed values, and the values that they depend on."""


def derive(database: DatabaseOption = None, as_json: JsonOption = False) -> None:
    """Derive the missing bodies of documents and build the missing columns of queries, so that first queries are fast.
    You can stop it and start it again at any time."""
    settings = choose_settings(database)
    store = open_database(settings)
    started = time.monotonic()
    done, failed = _derive(store, None, quiet=as_json)
    built, groups = _build_columns(store, settings, quiet=as_json)
    if as_json:
        print_json({"derived": done, "failed": failed, "columns": built, "groups": groups})
        return
    if done or failed:
        console.print(f"derived the bodies of {done:,} documents in {time.monotonic() - started:.1f} s")
    else:
        console.print("all documents have their bodies")
    console.print(f"{built:,} of {groups:,} groups of documents have the columns of queries on disk")


def _build_columns(store: Database, settings: Settings, *, quiet: bool) -> tuple[int, int]:
    """Build the missing columns. Return the groups of documents that have theirs, and all groups."""
    queries = Queries(store, settings)
    try:
        for stage in get_args(Stage):
            with Bar("building columns", "groups", disable=quiet or not sys.stderr.isatty()) as bar:
                build_stage(queries, stage, lambda done, of: bar.tell(done, of, "building columns"))
        return count_prepared(store, queries.caches)
    finally:
        queries.close()


def derive_stored(store: Database, ids: set[str], *, quiet: bool) -> None:
    """Derive the bodies of imported documents. Errors here do not affect the import."""
    try:
        _derive(store, ids, quiet=quiet)
    except KeyboardInterrupt:
        console.print("All is stored. Bodies are missing: mcml db derive goes on with them.", style="dim")
        raise


def tell_calibrations(client: Client, documents: Sequence[ImportedDocument]) -> None:
    """One line for each of a few documents: unit, up axis, floor, leg, and where each is from."""
    for document in documents:
        try:
            calibration = client.call("get_calibration", id=document.id)
        except McmlError as error:
            console.print(Text(f"body     {document.name}: {error.what}"), style="yellow")
            continue
        parts = []
        for name in CALIBRATED:
            measured = getattr(calibration, name)
            value = f"{measured.value:.4g}" if isinstance(measured.value, float) else measured.value
            parts.append(f"{name} {measured.origin}" if value is None else f"{name} {value} ({measured.origin})")
        console.print(Text(f"body     {document.name}: {', '.join(parts)}"))


def tell_origins(store: Database, ids: set[str]) -> None:
    """Of how many documents unit, up axis, floor and leg are stated, measured, guessed, unknown."""
    with store.read() as tx:
        kept = tx.bodies.of([listed for listed in tx.columns.documents() if listed.uuid in ids])
    known = [
        body.calibration.origins for stored_body in kept.values() if (body := Body.restore(stored_body)) is not None
    ]
    for name, source in CALIBRATED.items():
        counts = Counter(origins[source].kind for origins in known)
        told = ", ".join(f"{count:,} {kind}" for kind, count in counts.most_common())
        console.print(Text(f"{name:<8} {told}"), style="dim")


def _derive(store: Database, ids: set[str] | None, *, quiet: bool) -> tuple[int, int]:
    """How many bodies were derived, and how many could not be."""
    failed: list[str] = []

    def note(listed: Listed, error: Exception) -> None:
        failed.append(listed.uuid)
        console.print(Text.assemble(("no body", "yellow"), f"  {listed.name}  {listed.uuid}: {error}"))

    with Bar("deriving", "documents", disable=quiet or not sys.stderr.isatty()) as bar:
        return derive_missing(store, lambda done, of: bar.tell(done, of, "deriving"), note, ids), len(failed)
