"""The file beside the store: an SQLite file of parts, each with its checksum."""

from __future__ import annotations

import os
import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import xxhash

from mcml_service.settings import cache_folder
from mcml_service.storage.database import Database

FORMAT = 2
"""Of the file and of all parts. A file of another one is thrown away."""
FAULTS = (sqlite3.Error, OSError, UnicodeDecodeError)
"""Errors of a damaged or unwritable file. With a damaged file even messages may be invalid text."""
BUSY_SECONDS = 5.0
PAGE_BYTES = 32_768
OFF = "none"

_opening = threading.Lock()
_SCHEMA = (
    "CREATE TABLE IF NOT EXISTS part (held BLOB NOT NULL, name TEXT NOT NULL, mark TEXT NOT NULL, "
    "used INTEGER NOT NULL, size INTEGER NOT NULL, checksum BLOB NOT NULL, data BLOB NOT NULL, UNIQUE (held, name))",
    "CREATE INDEX IF NOT EXISTS by_use ON part (used, size)",
    "CREATE TABLE IF NOT EXISTS history (whole_since INTEGER NOT NULL)",
    f"PRAGMA user_version={FORMAT}",
)


def path_of(database: Database, folder: str) -> Path | None:
    """Where the file of a store is, None where none is kept. folder: as the setting has it."""
    url = database.dialect.engine.url
    if folder == OFF or (database.dialect.personal and database.dialect.file is None):
        return None
    if not folder and database.dialect.file is not None:
        return database.dialect.file.with_name(f"{database.dialect.file.name}-cache")
    known = url if database.dialect.file is None else url.set(database=str(database.dialect.file.resolve()))
    number = xxhash.xxh3_64(known.render_as_string(hide_password=True).encode()).hexdigest()
    return (Path(folder) if folder else cache_folder()) / f"{Path(url.database or '').name}-{number}.db-cache"


def why_not(path: Path) -> str:
    """Why nothing can be kept there, "" where it can."""
    try:
        opened(path).close()
    except FAULTS as error:
        return str(error)
    return ""


def opened(path: Path) -> sqlite3.Connection:
    """A connection to the file.

    If the file is missing, damaged or of another format, it is created again. Raises OSError and
    sqlite3.OperationalError if that fails.
    """
    # If two threads find it damaged, one creates it again, and the other does not remove the new file.
    with _opening:
        try:
            return _connected(path)
        except sqlite3.OperationalError:
            raise
        except (sqlite3.DatabaseError, UnicodeDecodeError):
            remove(path)
            return _connected(path)


def _connected(path: Path) -> sqlite3.Connection:
    if not path.parent.is_dir():
        path.parent.mkdir(mode=0o700, parents=True)
    # Made before SQLite does: captures are of people.
    os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
    connection = sqlite3.connect(path, timeout=BUSY_SECONDS, check_same_thread=False, isolation_level=None)
    try:
        if connection.execute("PRAGMA page_count").fetchone() == (0,):
            connection.execute(f"PRAGMA page_size={PAGE_BYTES}")
            connection.execute("PRAGMA auto_vacuum=INCREMENTAL")
        # It may be lost at any time: nothing waits for the disk. Not mapped into memory: a process that truncates it
        # would end the process.
        for pragma in ("journal_mode=WAL", "synchronous=OFF", "secure_delete=ON"):
            connection.execute(f"PRAGMA {pragma}").fetchall()
        connection.execute("PRAGMA journal_size_limit=1048576")
        if connection.execute("PRAGMA user_version").fetchone() != (FORMAT,):
            connection.execute("BEGIN IMMEDIATE")
            if connection.execute("PRAGMA user_version").fetchone() != (FORMAT,):
                if connection.execute("SELECT 1 FROM sqlite_master LIMIT 1").fetchone():
                    raise sqlite3.DatabaseError("The file is of another format.")
                for statement in _SCHEMA:
                    connection.execute(statement)
            connection.execute("COMMIT")
    except BaseException:
        connection.close()
        raise
    return connection


def cleared(connection: sqlite3.Connection, whole_since: int) -> bool:
    """Whether all parts went, as they do where they were made while the store's history was whole since another commit:
    something was purged since, or the store is another one. In a transaction."""
    found = connection.execute("SELECT whole_since FROM history").fetchone()
    if found == (whole_since,):
        return False
    connection.execute("DELETE FROM part")
    connection.execute("DELETE FROM history")
    connection.execute("INSERT INTO history VALUES (?)", (whole_since,))
    return found is not None


def emptied(connection: sqlite3.Connection) -> None:
    """Remove all traces of deleted data from the files."""
    connection.execute("PRAGMA incremental_vacuum").fetchall()
    # The log contains old pages.
    connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()


def forget(database: Database, folder: str) -> None:
    """Remove the parts of purged or pruned data from the disk; a running server continues with an empty file."""
    path = path_of(database, folder)
    if path is None or not path.exists():
        return
    with database.read() as tx:
        since = tx.pruning.whole_since()
    try:
        with closing(opened(path)) as connection:
            connection.execute("BEGIN IMMEDIATE")
            cleared(connection, since)
            connection.execute("COMMIT")
            emptied(connection)
    except FAULTS:
        remove(path)


def remove(path: Path) -> None:
    """Remove the file, and SQLite's files beside it."""
    for ending in ("", "-wal", "-shm", "-journal"):
        path.with_name(path.name + ending).unlink(missing_ok=True)


def checksum_of(held: bytes, name: str, mark: str, data: bytes) -> bytes:
    """Return the checksum of a row, including its name: a part under another name is wrong, too."""
    summed = xxhash.xxh3_128(held + f"\0{name}\0{mark}\0".encode())
    summed.update(data)
    return summed.digest()
