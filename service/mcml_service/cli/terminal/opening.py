"""Options that commands share, and how they print."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer
from pydantic import BaseModel, ValidationError
from rich.console import Console
from rich.table import Table

from mcml.client.client import Client
from mcml.errors import McmlError
from mcml.files.on_disk import write_file
from mcml.files.presets import PRESETS
from mcml_service.local_secret import read_secret
from mcml_service.settings import Settings, data_folder, is_loopback, private_folder
from mcml_service.storage.database import Database

DatabaseOption = Annotated[str | None, typer.Option("--database", help="Store to work on, as an SQLAlchemy URL")]
ServerOption = Annotated[str | None, typer.Option("--server", help="Work against this server instead, http://…")]
MessageOption = Annotated[str, typer.Option("-m", "--message", help="Why, for the history")]
RevisionOption = Annotated[
    int | None, typer.Option("--revision", min=1, help="Only if the document is still at this revision")
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace a file of that name")]
RawOption = Annotated[
    bool, typer.Option("--raw", help="In CSV, also texts that spreadsheets take for formulas as they are")
]
ForOption = Annotated[
    str | None,
    typer.Option(
        "--for", help=f"Program that reads the result, which decides format, unit and axes: {', '.join(PRESETS)}"
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for scripts")]

# Names of files and documents may hold brackets: nothing that is printed is markup.
console = Console(highlight=False, markup=False, soft_wrap=True, width=None if sys.stdout.isatty() else 1000)


def choose_settings(database: str | None = None, **changes: Any) -> Settings:
    """Return settings from the environment and the command line. Raises McmlError for an invalid variable."""
    overrides = {key: value for key, value in {"database": database, **changes}.items() if value is not None}
    try:
        return Settings().model_copy(update=overrides)
    except ValidationError as error:
        fault = error.errors()[0]
        name = f"MCML_{'_'.join(map(str, fault['loc'])).upper()}"
        raise McmlError(f"{name}: {fault['msg']}.", remedy="docs/settings.md lists the allowed values.") from None


def find_database(settings: Settings) -> Database:
    """Open the store with any schema; create the folder of an SQLite file."""
    url = settings.database_url
    if url.startswith("sqlite:///"):
        private_folder(Path(url.removeprefix("sqlite:///")).parent)
    return Database(url)


def open_database(settings: Settings) -> Database:
    """The store; a new one is made. StoreError where an older program made it: only `mcml db upgrade` and `mcml serve`
    upgrade a store."""
    database = find_database(settings)
    database.make_or_require()
    return database


def upgrade_database(settings: Settings) -> Database:
    """Open the store, create or upgrade it if needed; print the upgrade and the path of the copy made before."""
    from mcml_service.actions.keeping.keep_store import upgrade

    database = find_database(settings)
    before, wanted = database.schema_versions()
    kept = upgrade(database)
    if before not in (None, wanted):
        console.print(f"schema {before} -> {wanted}" + (f"; the store as it was: {kept}" if kept else ""))
    return database


def open_client(database: str | None, server: str | None) -> Client:
    """Return the client of a command: a local store, or a server."""
    settings = choose_settings(database)
    if server is None:
        from mcml_service.local_store import Local

        local = Local(open_database(settings), settings)
        local.repository.evaluated = "bounded"
        return local
    # Imported late: commands on a store of this machine need no HTTP.
    from mcml.client.remote import Remote, host_of

    token = settings.token
    if token is None and is_loopback(host_of(server)):
        # A server on this machine is sent the secret that it keeps for its owner.
        token = read_secret(data_folder())
    return Remote(server, token)


def write_to_the_end() -> None:
    """Let this command continue if the reader of its output ends: it also writes other data."""
    sys.stdout = _Unheard(sys.stdout)


class _Unheard:
    """Standard output, until its reader leaves; nothing afterwards."""

    def __init__(self, out: TextIO) -> None:
        self._out = out

    def __getattr__(self, name: str) -> Any:
        return getattr(self._out, name)

    def write(self, text: str) -> int:
        with suppress(BrokenPipeError):
            self._out.write(text)
        return len(text)

    def flush(self) -> None:
        try:
            self._out.flush()
        except BrokenPipeError:
            # Buffered output would fail again when Python ends.
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._out.fileno())


def match_of(revision: int | None) -> str:
    """Return the `If-Match` of a change: a given revision, or the current one."""
    return "*" if revision is None else f'"{revision}"'


def write_blocks(blocks: Iterable[bytes | memoryview], output: Path | None, *, force: bool = False) -> None:
    """To a file, whole or not at all; else to standard output."""
    if output is not None:
        write_file(output, blocks, force=force)
        console.print(f"wrote    {output}")
        return
    for block in blocks:
        sys.stdout.buffer.write(block)
    sys.stdout.buffer.flush()


def print_json(answer: BaseModel | dict[str, Any]) -> None:
    if isinstance(answer, BaseModel):
        print(answer.model_dump_json(indent=2, exclude_none=True))
    else:
        import json

        print(json.dumps(answer, indent=2, ensure_ascii=False))


def table(*columns: str) -> Table:
    """A plain table; columns whose name ends in `#` are numbers."""
    result = Table(box=None, pad_edge=False, header_style="bold")
    for column in columns:
        result.add_column(column.removesuffix("#"), justify="right" if column.endswith("#") else "left")
    return result
