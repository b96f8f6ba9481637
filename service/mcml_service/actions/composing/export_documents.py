"""Many documents as one zip, made while it is sent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain
from pathlib import PurePath

from mcml.errors import McmlError
from mcml.files.targets import find_target
from mcml.formats import WRITERS
from mcml_schemas.jobs import Selection
from mcml_service.actions.composing.select_documents import select_documents
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document, zip_files
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries

REFUSED = "refused.txt"
"""The file of a zip that lists missing documents with their reasons."""


def export_documents(
    database: Database, queries: Queries, selection: Selection, options: ExportOptions
) -> Iterator[bytes]:
    """Stream a zip of the selected documents at their current revisions.

    Two documents with the same name become two files, the second with the end of its id. Documents that the format
    cannot represent are listed in `refused.txt`, the last file. Raises UnsupportedError for an unknown format, before
    anything is made.
    """
    parts: list[str | None] = [options.format]
    if options.format is not None:
        name, part = find_target(options.format)
        parts = [item.name for item in WRITERS[name].parts] if name in WRITERS and part is None else parts
    uuids, _ = select_documents(database, queries, selection)
    # A started export cannot be made again, which would be needed if a replica became unreachable.
    database = database.for_call(database.view)
    return zip_files(_files(database, [str(item["document"]) for item in uuids], options, parts))


def _files(
    database: Database, documents: list[str], options: ExportOptions, parts: list[str | None]
) -> Iterator[tuple[str, Callable[[], Iterator[bytes]]]]:
    taken: set[str] = set()
    refused: list[str] = []
    for uuid in documents:
        for part in parts:
            try:
                with database.read() as tx:
                    stored = tx.documents.get(uuid)
                    export = export_document(tx, stored, replace(options, format=part))
                    # A conversion reads the whole motion before its first block, and then reports losses.
                    content = chain((next(export.content, b""),), export.content)
                    yield _free(export.file_name, uuid, taken), lambda content=content: content  # type: ignore[misc]
            except McmlError as error:
                refused.append(f"{uuid}: {error}")
                break
    if refused:
        text = "\n".join([*refused, ""]).encode()
        yield REFUSED, lambda: iter([text])


def _free(file_name: str, uuid: str, taken: set[str]) -> str:
    path = PurePath(file_name)
    name = file_name if file_name not in taken else f"{path.stem}-{uuid[-6:]}{path.suffix}"
    taken.add(name)
    return name
