"""Options that commands share, and how they print."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import BaseModel, ValidationError
from rich.console import Console
from rich.table import Table

from service.cli.access import Library, LocalLibrary, RemoteLibrary
from service.cli.api import Api, local_api, remote_api
from service.errors import McmlError
from service.settings import Settings, private_folder
from service.storage.database import Database

DatabaseOption = Annotated[str | None, typer.Option("--database", help="Store to work on, as an SQLAlchemy URL")]
ServerOption = Annotated[str | None, typer.Option("--server", help="Work against this server instead, http://…")]
MessageOption = Annotated[str, typer.Option("-m", "--message", help="Why, for the history")]
RevisionOption = Annotated[
    int | None, typer.Option("--revision", min=1, help="Only if the document is still at this revision")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for scripts")]

# Names of files and documents may hold brackets: nothing that is printed is markup.
console = Console(highlight=False, markup=False, soft_wrap=True, width=None if sys.stdout.isatty() else 1000)


def chosen_settings(database: str | None = None, **changes: Any) -> Settings:
    """Settings from the environment, with what the command line says. McmlError for a variable that makes no sense."""
    given = {key: value for key, value in {"database": database, **changes}.items() if value is not None}
    try:
        return Settings().model_copy(update=given)
    except ValidationError as error:
        fault = error.errors()[0]
        name = f"MCML_{'_'.join(map(str, fault['loc'])).upper()}"
        raise McmlError(f"{name}: {fault['msg']}.", remedy="See docs/settings.md for what it may be.") from None


def open_database(settings: Settings, *, migrate: bool = True) -> Database:
    """The store; a new SQLite file is made, and its schema brought up to date."""
    url = settings.database_url
    if url.startswith("sqlite:///"):
        private_folder(Path(url.removeprefix("sqlite:///")).parent)
    database = Database(url)
    if migrate:
        database.migrate()
    return database


def open_library(database: str | None, server: str | None) -> Library:
    """The library that a command works on: a store here, or a server."""
    settings = chosen_settings(database)
    if server:
        return RemoteLibrary(remote_api(server, settings.token))
    return LocalLibrary(open_database(settings), settings)


def open_api(database: str | None, server: str | None) -> Api:
    """The REST API of a server, or of the service in this process."""
    settings = chosen_settings(database)
    return remote_api(server, settings.token) if server else local_api(open_database(settings), settings)


def if_match(revision: int | None) -> dict[str, str]:
    """The header of a change: for one revision, or for whatever is current."""
    return {"if-match": "*" if revision is None else f'"{revision}"'}


def print_json(answer: BaseModel | list[Any] | dict[str, Any]) -> None:
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
