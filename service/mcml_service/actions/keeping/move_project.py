"""A whole project as one file: MCML of its documents, the files that they came of, and rows with every revision.

    manifest.json           what it is, and how many rows of each kind there are
    mcml/NAME-ID.mcml       each document as it is now, for people and other programs
    files/SHA256            kept files, videos and sounds as they were uploaded
    rows/TABLE.jsonl        everything (`storage.project_rows`), of which the project is made again

Equal projects make equal files, byte for byte: times in the zip are fixed, keys and commits are numbered from 1.
"""

from __future__ import annotations

import hashlib
import lzma
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from typing import Any, BinaryIO

import orjson

from mcml.errors import ConflictError, FormatError, LimitError, Place
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document, zip_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.uploads import BLOCK_BYTES, compress_block
from mcml_service.storage.layout import LAYOUT, is_readable
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.upkeep.checks import document_faults
from mcml_service.storage.upkeep.project_rows import ADDED_TABLES, MOVED, ProjectRows, ProjectWriter, Row

FORMAT, VERSION = "mcml-project", 1
MOST_LINE = 64 << 20
"""Bytes of one row as JSON: a receipt, or the samples of a bone in a chunk."""

_BROKEN = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, RuntimeError, EOFError, UnicodeDecodeError)
_UNSAFE = re.compile(r"[^\w.-]+")


def export_project(tx: Transaction, project: str) -> Iterator[bytes]:
    """The file, made while it is sent. NotFoundError, DamageError. tx: lives as long."""
    rows = ProjectRows(tx, tx.projects.get(project))
    return zip_files(_members(tx, project, rows), compress=True)


def _members(
    tx: Transaction, project: str, rows: ProjectRows
) -> Iterator[tuple[str, Callable[[], Iterator[bytes | memoryview]]]]:
    counts: dict[str, int] = {}

    def lines(name: str) -> Iterator[bytes]:
        counts[name] = 0
        for row in rows.of(MOVED[name]):
            counts[name] += 1
            yield orjson.dumps(row, option=orjson.OPT_APPEND_NEWLINE)

    for key in rows.documents:
        stored = tx.documents.get_many([key])[0]
        if tx.documents.find(stored.uuid) is not None:
            name = f"mcml/{_UNSAFE.sub('_', stored.name)[:80]}-{stored.uuid[-12:]}.mcml"
            yield name, lambda stored=stored: export_document(tx, stored, ExportOptions("mcml")).content  # type: ignore[misc]
    for sha256, content in rows.files():
        yield f"files/{sha256}", content
    for name in MOVED:
        yield f"rows/{name}.jsonl", lambda name=name: lines(name)  # type: ignore[misc]
    about = {"format": FORMAT, "version": VERSION, "layout": LAYOUT, "project": project, "rows": counts}
    yield "manifest.json", lambda: iter([orjson.dumps(about, option=orjson.OPT_INDENT_2)])


def import_project(
    database: Database, stream: BinaryIO, settings: Settings, author: str, name: str | None = None
) -> tuple[str, int]:
    """Make a project from such a file, completely or not at all; return (its name, documents).

    name: by default the original name. Authors of revisions become text. Ids already in use are replaced. Raises
    ConflictError if the project exists; FormatError for an invalid file, LimitError.
    """
    try:
        with zipfile.ZipFile(stream) as archive:
            reading = _Reading(archive, settings)
            about = reading.manifest()
            wanted = name or str(about["project"])
            with database.write(author) as tx:
                tx.order()
                if tx.projects.find(wanted) is not None:
                    raise ConflictError(f"There is a project {wanted!r}.", remedy="Give it another name (`name`).")
                writer = ProjectWriter(tx, tx.projects.get_or_add(wanted))
                writer.uploads = reading.keep_files(tx)
                for table in MOVED.values():
                    if table.name in ADDED_TABLES and table.name not in about["rows"]:
                        continue
                    count = writer.write(table, reading.rows(table.name))
                    if count != about["rows"].get(table.name):
                        raise FormatError(
                            f"The file has {count} rows of {table.name}, its manifest says another number.",
                            remedy="Export the project again.",
                        )
                keys = list(writer.keys.get("document", {}).values())
                faults = document_faults(tx, keys)
                if faults:
                    raise FormatError(f"The project file is inconsistent: {faults[0]}")
                tx.activity.note("project", "import", project_key=writer.project_key, subject=wanted)
                return wanted, len(keys)
    except _BROKEN as error:
        raise FormatError("The zip is damaged or encrypted.", remedy="Export the project again.") from error


class _Reading:
    """The content of a zip, within the limits of zips."""

    def __init__(self, archive: zipfile.ZipFile, settings: Settings) -> None:
        self._archive = archive
        self._settings = settings
        self._total = 0
        self._names = {info.filename: info for info in archive.infolist()}

    def manifest(self) -> dict[str, Any]:
        """FormatError for that of no project, or of a program that this one does not know."""
        try:
            about = orjson.loads(b"".join(self._blocks("manifest.json")))
            is_known = about["format"] == FORMAT and about["version"] == VERSION and is_readable(about["layout"])
            fits = isinstance(about["rows"], dict) and isinstance(about["project"], str)
        except (KeyError, TypeError, orjson.JSONDecodeError):
            is_known = fits = False
        if not (is_known and fits):
            raise FormatError(
                "This is no project that this program can read.", remedy="Give a file of `mcml project export`."
            )
        return dict(about)

    def rows(self, table: str) -> Iterator[Row]:
        for line in self._lines(f"rows/{table}.jsonl"):
            try:
                row = orjson.loads(line)
            except orjson.JSONDecodeError:
                row = None
            if not isinstance(row, dict):
                raise FormatError(f"A row of {table} is no JSON object.", remedy="Export the project again.")
            yield row

    def keep_files(self, tx: Transaction) -> dict[str, int]:
        """The key of each kept file by its SHA-256, stored where it was not."""
        kept: dict[str, int] = {}
        for name in self._names:
            if name.startswith("files/"):
                sha256 = name.removeprefix("files/")
                kept[sha256] = self._keep_upload(tx, name, sha256)
        return kept

    def _keep_upload(self, tx: Transaction, name: str, sha256: str) -> int:
        size = self._names[name].file_size
        upload = tx.uploads.find(sha256, size)
        if upload is not None:
            return upload
        key, digest, taken = tx.uploads.begin(sha256, size), hashlib.sha256(), 0
        for number, block in enumerate(self._blocks(name)):
            digest.update(block)
            taken += len(block)
            tx.uploads.add_blocks(key, number, [compress_block(block)])
        if digest.hexdigest() != sha256 or taken != size:
            raise FormatError(f"{name} is not the file that it says.", remedy="Export the project again.")
        tx.uploads.complete(key)
        return key

    def _lines(self, name: str) -> Iterator[bytes]:
        rest = b""
        for block in self._blocks(name):
            *whole, rest = (rest + block).split(b"\n")
            yield from whole
            if len(rest) > MOST_LINE:
                raise LimitError(f"A line of {name} is longer than {MOST_LINE} bytes.")
        if rest:
            yield rest

    def _blocks(self, name: str) -> Iterator[bytes]:
        """The content of a member, BLOCK_BYTES at a time. Raises FormatError if it is missing."""
        info = self._names.get(name)
        if info is None:
            raise FormatError(f"The file has no {name}.", remedy="Give a file of `mcml project export`.")
        size, limits = 0, self._settings
        with self._archive.open(info) as member:
            while block := member.read(BLOCK_BYTES):
                size += len(block)
                self._total += len(block)
                # Declared sizes may be false.
                if (
                    self._total > limits.max_upload_bytes
                    or size > BLOCK_BYTES + limits.max_zip_ratio * info.compress_size
                ):
                    raise LimitError(f"{name} unpacks to more than the limits allow.", at=Place(element=name))
                yield block
