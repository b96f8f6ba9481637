"""A store of very many documents for measures of lists: some are imported, the others are copies of their rows.

Copies have what lists read of documents, and no frames: what reads motions must not be asked of this store.
"""

from __future__ import annotations

import io
import itertools
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import select

from mcml.files.import_options import ImportOptions, Label
from mcml.formats import FORMATS
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.demo import body
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import new_uuid, now
from mcml_service.storage.core.tables import (
    commit,
    content,
    document,
    document_upload,
    header,
    property_,
    revision,
    span,
)
from mcml_service.storage.core.tables import thumbnail as picture
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction

KINDS = 1000
"""Documents that are imported."""

A_COMMIT = 100
"""Documents that one commit brought."""

MOVES = ("walk", "reach", "wave", "dance")
RATES = (1 / 30, 1 / 60, 0.0083333)
COPIED = (content, header, property_, span, picture, document_upload)
PROJECTS = 12
LEFT_OUT = frozenset(("checksum", "id"))


def many_documents(documents: int) -> Path:
    """The store of so many; made once a machine, kept in the folder for temporary files."""
    path = Path(tempfile.gettempdir()) / f"mcml-lists-{documents}" / "store.db"
    if path.is_file():
        return path
    path.parent.mkdir(exist_ok=True)
    unfinished = path.with_name("unfinished.db")
    unfinished.unlink(missing_ok=True)
    database = Database(f"sqlite:///{unfinished}")
    fill(database, documents)
    database.close()
    unfinished.rename(path)
    return path


def fill(database: Database, documents: int) -> None:
    """Make an empty store one of so many documents."""
    database.migrate()
    _import_kinds(database, min(documents, KINDS))
    with database.read() as tx:
        rows = {table: _rows_by_document(tx, table) for table in COPIED}
        names = _names(document)
        read = select(*(document.c[name] for name in names))
        kinds = [dict(zip(names, row, strict=True)) for row in tx.connection.execute(read)]
        keys = list(tx.connection.execute(select(document.c.id)).scalars())
    for first in range(KINDS, documents, A_COMMIT * 50):
        numbers = range(first, min(documents, first + A_COMMIT * 50))
        with database.write() as tx:
            for group in itertools.groupby(numbers, lambda number: number // A_COMMIT):
                _copy(tx, list(group[1]), kinds, keys, rows)


def _import_kinds(database: Database, count: int) -> None:
    rng = np.random.default_rng(5)
    for number in range(count):
        move = MOVES[number % len(MOVES)]
        height, age = round(float(rng.uniform(150, 195)), 1), int(rng.integers(20, 70))
        motion = getattr(body, move)
        shape = {"walk": (1.0, 6.0), "reach": (40.0,), "wave": (1.0,), "dance": (100.0, 1.0)}[move]
        clip = body.clip(f"{move}_{number}", height, *motion(height, float(rng.uniform(0.2, 1.2)), *shape))
        text = b"".join(FORMATS["bvh"].write(clip, "bvh"))
        properties = (("age", str(age), "year"), ("height", str(height), "cm"), ("take", f"take {number % 7}", ""))
        options = ImportOptions(
            project=f"project-{number % PROJECTS}",
            labels=(Label(move, 1, 5), Label(f"variant-{number % 40}", 3, 6)),
            properties=properties,
            description=f"Clip {number} of a {move}, recorded on day {number % 97}.",
            frame_time=repr(RATES[number % len(RATES)]),
            unit="cm",
            up="Y",
        )
        done = import_files(database, [SourceFile(f"{move}_{number:06}.bvh", io.BytesIO(text))], options, Settings())
        if done.problems:
            raise done.problems[0][1]


def _names(table: Any) -> list[str]:
    return [column.name for column in table.c if column.name not in LEFT_OUT]


def _rows_by_document(tx: Transaction, table: Any) -> dict[int, list[tuple[Any, ...]]]:
    names = _names(table)
    found: dict[int, list[tuple[Any, ...]]] = {}
    for row in tx.connection.execute(select(*map(table.c.get, names))):
        found.setdefault(row[names.index("document")], []).append(tuple(row))
    return found


def _copy(tx: Transaction, numbers: list[int], kinds: list[dict[str, Any]], keys: list[int], rows: Any) -> None:
    """Copies of as many documents, as one commit."""
    made = tx.newest_commit() + 1
    tx.insert_rows(commit, [{"number": made, "time": now(), "author": "local"}])
    copies, revisions = [], []
    for number in numbers:
        kind = kinds[number % len(kinds)]
        name = f"{kind['name'].partition('_')[0]}_{number:06}"
        form = "trc" if number % 10 == 9 else kind["format"]
        copies.append(kind | {"uuid": new_uuid(), "name": name, "format": form, "created_commit": made})
    first = tx.insert_row(document, **copies[0])
    tx.insert_rows(document, copies[1:])
    for place, copied in enumerate(copies):
        revisions.append((first + place, 1, made, None, "import", "", copied["name"], copied["project"]))
    names = ("document", "number", "commit", "parent", "operation", "message", "name", "project")
    tx.insert_tuples(revision, names, revisions)
    for table in COPIED:
        columns = tuple(_names(table))
        at = columns.index("document")
        copied_rows = [
            (*row[:at], first + place, *row[at + 1 :])
            for place, number in enumerate(numbers)
            for row in rows[table].get(keys[number % len(keys)], ())
        ]
        tx.insert_tuples(table, columns, copied_rows)
