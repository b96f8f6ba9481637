"""What endpoints ask for: the store, pages and cursors, conditional requests."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from typing import Annotated, Any

import orjson
from fastapi import Depends, Header, Path, Query, Request

from schemas.examples import CURSOR, DOCUMENT, PROJECT
from service.actions.checking.preconditions import check_match
from service.errors import NotFoundError, QueryError
from service.settings import Settings
from service.storage.database import Database, Transaction
from service.storage.documents import StoredDocument
from service.xpath.run import Queries


# What only looks something up is async: FastAPI would send each into a thread.
async def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


async def _database(request: Request) -> Database:
    database: Database = request.app.state.database
    return database


async def _author(request: Request) -> str:
    return str(request.scope.get("mcml.author", "local"))


async def _queries(request: Request) -> Queries:
    queries: Queries = request.app.state.queries
    return queries


SettingsDep = Annotated[Settings, Depends(_settings)]
DatabaseDep = Annotated[Database, Depends(_database)]
AuthorDep = Annotated[str, Depends(_author)]
QueriesDep = Annotated[Queries, Depends(_queries)]
MOST = 2**31 - 1
"""Of numbers in requests: what every database can compare."""
DocumentId = Annotated[str, Path(description="Id of the document", examples=[DOCUMENT])]
ProjectQuery = Annotated[str | None, Query(description="This project only", examples=[PROJECT])]
RevisionQuery = Annotated[
    int | None, Query(ge=1, le=MOST, description="Read this revision instead of the current one", examples=[1])
]
First = Annotated[int, Query(ge=1, le=MOST, description="First frame, a position from 1", examples=[100])]
Last = Annotated[
    int | None, Query(ge=1, le=MOST, description="Last frame, included; default the last one", examples=[142])
]


def encode_cursor(*parts: Any) -> str:
    """An opaque cursor; `decode_cursor` gives the parts back."""
    return base64.urlsafe_b64encode(orjson.dumps(parts)).decode().rstrip("=")


def decode_cursor(cursor: str, *kinds: type) -> list[Any]:
    """The parts of a cursor. QueryError where it is none of ours."""
    try:
        parts = orjson.loads(base64.urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4)))
    except (binascii.Error, ValueError):
        parts = None
    fits = isinstance(parts, list) and len(parts) == len(kinds)
    if not fits or not all(_is(part, kind) for part, kind in zip(parts or [], kinds, strict=True)):
        raise QueryError("This cursor is not one that was handed out here.", remedy="Begin again without a cursor.")
    return list(parts or [])


def _is(part: object, kind: type) -> bool:
    if isinstance(part, str):
        return kind is str and "\0" not in part
    return type(part) is kind and (not isinstance(part, int) or 0 <= part <= MOST)


@dataclass(frozen=True)
class Page:
    limit: int
    cursor: str | None


async def _page(
    settings: SettingsDep,
    limit: Annotated[int, Query(ge=1, description="Most items on the page", examples=[20])] = 100,
    cursor: Annotated[
        str | None, Query(max_length=4096, description="`next_cursor` of the page before", examples=[CURSOR])
    ] = None,
) -> Page:
    return Page(min(limit, settings.page_limit), cursor)


PageDep = Annotated[Page, Depends(_page)]


def etag(stored: StoredDocument, format_name: str) -> str:
    """The strong tag of a representation: revision and format."""
    return f'"{stored.revision}-{format_name}"'


IfMatch = Annotated[
    str | None,
    Header(
        description='The ETag that was read, or its revision as `"7"`; `*` for whatever is current',
        examples=['"7"'],
    ),
]


def checked_for_write(tx: Transaction, uuid: str, if_match: str | None, *, deleted: bool = False) -> StoredDocument:
    """The document, locked for a change, if the request was made for its current revision."""
    found = tx.documents.find(uuid, deleted=deleted)
    if found is None:
        raise NotFoundError(f"There is no document {uuid}.", remedy="List the documents to see their ids.")
    tx.documents.lock(found.key)
    stored = tx.documents.get(uuid, deleted=deleted)
    check_match(if_match, stored.revision, "document", "revision")
    return stored


def at_revision(tx: Transaction, uuid: str, revision: int | None) -> tuple[Transaction, StoredDocument]:
    """The document as it is, or as a revision left it, and the transaction to read it with."""
    if revision is None:
        return tx, tx.documents.get(uuid)
    current = tx.documents.get(uuid)
    then = tx.at_commit(tx.documents.commit_of(current.key, revision))
    return then, then.documents.get(uuid)
