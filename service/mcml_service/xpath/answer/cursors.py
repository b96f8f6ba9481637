"""Cursors: the end of a page, the state of the store, and the query."""

from __future__ import annotations

import base64
import binascii
import zlib
from dataclasses import dataclass

import orjson

from mcml.errors import QueryError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.storage.transaction import LATEST


@dataclass(frozen=True, slots=True)
class Cursor:
    """commit: the state of the store.

    whole_since: the commit since which the history was complete. offset: number of items on earlier pages. check:
    identifies its query.
    """

    commit: int
    whole_since: int
    offset: int
    check: int

    def __str__(self) -> str:
        return (
            base64.urlsafe_b64encode(orjson.dumps([self.commit, self.whole_since, self.offset, self.check]))
            .decode()
            .rstrip("=")
        )


def question(request: QueryRequest) -> int:
    """Return a number that identifies a query."""
    asked = [request.q, request.document, request.project, request.as_, request.per, request.guesses, request.variables]
    return zlib.crc32(orjson.dumps(asked))


def read_cursor(request: QueryRequest) -> Cursor | None:
    """Return the request's cursor. Raises QueryError for the cursor of another query."""
    if request.cursor is None:
        return None
    try:
        text = request.cursor + "=" * (-len(request.cursor) % 4)
        commit, since, offset, check = (int(part) for part in orjson.loads(base64.urlsafe_b64decode(text)))
    except (binascii.Error, ValueError, TypeError, OverflowError):
        commit, since, offset, check = -1, -1, -1, -1
    if check != question(request) or not (0 <= commit < LATEST and 0 <= offset < LATEST):
        raise QueryError("This cursor is for another query.", remedy="Begin again without a cursor.")
    return Cursor(commit, since, offset, check)
