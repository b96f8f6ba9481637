"""A disk with no byte left: what opens, and what makes room."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from sqlalchemy import Connection
from sqlalchemy.exc import OperationalError

from mcml_service.storage.core.reserve import TO_OPEN
from mcml_service.storage.database import Database
from tests.builders import one_kind

ALONE = ["unshare", "-rm"]
"""What a program mounts, it alone sees."""

PROGRAM = """
import json, os, sys
from contextlib import suppress
from pathlib import Path
from typer.testing import CliRunner
from mcml_service.cli import app
from mcml.errors import SpaceError
from mcml_service.storage.core import reserve
from mcml_service.storage.database import Database
from tests.builders import bvh, served, store

reserve.BYTES = 2 << 20
folder = Path(sys.argv[1])
path = folder / "store.db"
found = {}

def fill():
    with suppress(OSError), (folder / "other").open("ab", buffering=0) as file:
        while file.write(bytes(4096)):
            pass

def opened(work):
    database = Database(f"sqlite:///{path}")
    try:
        return work(database)
    finally:
        database.close()

def prepare(database):
    database.migrate()
    ids = [store(database, {f"{n}.bvh": bvh(3000, seed=n)})[0] for n in range(3)]
    if sys.argv[2] == "reserve":
        database.reserve.keep()
    return ids

def serve(database):
    if sys.argv[2] == "reserve":
        database.reserve.keep()
    # A server starts where nothing is left, too.
    fill()
    try:
        return asked(database)
    except SpaceError as error:
        return [str(error)]

def asked(database):
    with served(database) as client:
        fill()
        gone = client.delete(f"/api/v1/documents/{ids[0]}", headers={"if-match": "*"})
        fill()
        stored = client.post("/api/v1/documents", files=[("file", ("d.bvh", bvh(9000, seed=9)))])
        return [gone.status_code, stored.status_code]

def run(*words):
    # By itself a command asks for nothing that the store gave to the one before.
    fill()
    done = CliRunner().invoke(app, [*words, "--database", f"sqlite:///{path}"])
    return [done.exit_code, str(done.exception or "")]

ids = opened(prepare)
found["list"] = run("ls")
found["purge"] = run("purge", ids[1], "--yes")
found["compact"] = run("db", "compact")
(folder / "other").unlink()
found["serve"] = opened(serve)
(folder / "other").unlink()
found["faults"] = opened(lambda database: database.check(past=True))
print(json.dumps(found))
"""


def on_a_small_disk(folder: Path, reserve: str) -> dict[str, list[object]]:
    """What the program above finds on a file system of its own."""
    disk, script = folder / "disk", folder / "program.py"
    disk.mkdir()
    script.write_text(PROGRAM)
    mounting = [*ALONE, "sh", "-c", 'mount -t tmpfs -o size=24m tmpfs "$0" && exec "$@"', str(disk)]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MCML_")}
    done = subprocess.run(
        [*mounting, sys.executable, str(script), str(disk), reserve],
        env=environment | {"PYTHONPATH": os.getcwd()},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, list[object]] = json.loads(done.stdout)
    return found


def may_mount() -> bool:
    tried = [*ALONE, "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return (
        shutil.which("unshare") is not None and not subprocess.run(tried, capture_output=True, check=False).returncode
    )


FULL = "There is no room left on the disk. Make room on the server, then repeat the request."
MEASURED = {
    "reserve": {"list": [0, ""], "purge": [0, ""], "compact": [1, FULL], "serve": [204, 507], "faults": []},
    "none": {"list": [1, FULL], "purge": [1, FULL], "compact": [1, FULL], "serve": [FULL], "faults": []},
}


@pytest.mark.slow
@pytest.mark.skipif(not may_mount(), reason="no file system may be mounted here")
@pytest.mark.parametrize("reserve", ["reserve", pytest.param("none", marks=pytest.mark.fuzz)])
def test_deleting_and_purging_work_where_no_byte_is_left(tmp_path: Path, reserve: str) -> None:
    """Without the reserve they are refused in words: what is shown here comes from it."""
    assert on_a_small_disk(tmp_path, reserve) == MEASURED[reserve]


@one_kind
def test_a_store_that_cannot_be_opened_spends_a_little(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no file system may be mounted: the driver says what it says on a full disk, until the file gave."""
    database.reserve.keep()
    spare = Path(database.url.removeprefix("sqlite:///") + ".reserve")
    before = spare.stat().st_size
    reading = database.dialect.reading

    def refused() -> AbstractContextManager[Connection]:
        if spare.stat().st_size == before:
            error = sqlite3.OperationalError("disk I/O error")
            error.sqlite_errorcode = sqlite3.SQLITE_IOERR_SHMSIZE
            raise OperationalError("SELECT", None, error)
        return reading()

    monkeypatch.setattr(database.dialect, "reading", refused)
    database.require_schema()
    assert before - spare.stat().st_size == TO_OPEN
    database.reserve.keep()
    assert spare.stat().st_size == before
