"""Arguments that many operations take, pages and their cursors, and versions of documents."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import orjson
from pydantic import Field

from mcml.errors import NotFoundError, QueryError
from mcml_schemas.examples import CURSOR, DOCUMENT, PROJECT
from mcml_service.actions.checking.preconditions import check_match
from mcml_service.operations.call import Call
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

if TYPE_CHECKING:
    from mcml_service.actions.reading.preview_motion import Window

MOST = 2**31 - 1
"""Greatest number in requests that every database can compare."""

DocumentId = Annotated[str, Field(description="Id of the document", examples=[DOCUMENT])]
Documents = Annotated[
    list[str] | None, Field(description="Only these documents; may be repeated; default all", examples=[[DOCUMENT]])
]
InProject = Annotated[str | None, Field(description="This project only", examples=[PROJECT])]
AtRevision = Annotated[
    int | None, Field(ge=1, le=MOST, description="Read this revision instead of the current one", examples=[1])
]
First = Annotated[int, Field(ge=1, le=MOST, description="First frame, a position from 1", examples=[100])]
Last = Annotated[
    int | None, Field(ge=1, le=MOST, description="Last frame, included; default the last one", examples=[142])
]
IfMatch = Annotated[
    str | None,
    Field(
        description='The ETag of the document as you read it, or its revision as `"7"`; `*` for the current revision',
        examples=['"7"'],
    ),
]
Raw = Annotated[
    bool, Field(description="CSV: also texts that spreadsheets take for formulas as they are, without an apostrophe")
]
Fps = Annotated[float | None, Field(gt=0, le=10_000, description="Frames a second of the result", examples=[30])]
CharacterId = Annotated[
    str | None,
    Field(description="Id of a document with a character: a file with a skinned mesh", examples=[DOCUMENT]),
]
Scale = Annotated[
    float | None, Field(gt=0, le=1e9, description="Factor of all lengths: the body becomes another size", examples=[1])
]
Guesses = Annotated[
    bool,
    Field(description="Guess the unit and the up axis that glTF and USD need, where the document states none"),
]
Item = TypeVar("Item")


@dataclass(frozen=True)
class Page:
    """Arguments of operations that list."""

    limit: Annotated[int, Field(ge=1, description="Most items on the page", examples=[20])] = 100
    cursor: Annotated[
        str | None, Field(max_length=4096, description="`next_cursor` of the page before", examples=[CURSOR])
    ] = None

    def after(self, *kinds: type) -> list[Any] | None:
        """Decode the cursor, None on the first page. Raises QueryError for an invalid cursor."""
        return None if self.cursor is None else decode_cursor(self.cursor, *kinds)

    def most(self, call: Call) -> int:
        """Items that the page may have."""
        return min(self.limit, call.settings.page_limit)

    def cut(
        self, call: Call, found: Sequence[Item], place: Callable[[Item], tuple[Any, ...]]
    ) -> tuple[Sequence[Item], str | None]:
        """Return (the page, the cursor of the next page) of items; one item more than the page is fetched if it exists.

        place: returns the cursor values of an item.
        """
        shown = found[: self.most(call)]
        return shown, encode_cursor(*place(shown[-1])) if len(found) > len(shown) else None


@dataclass(frozen=True)
class Shown:
    """Options for positions of the new motion, for viewing."""

    positions: Annotated[Literal["f4"] | None, Field(description="Include positions, as 32-bit floats in base64")] = (
        None
    )
    first: Annotated[int, Field(ge=1, le=MOST, description="First frame of the positions", examples=[1])] = 1
    last: Annotated[
        int | None,
        Field(ge=1, le=MOST, description="Last one; default: as many as fit into a response", examples=[240]),
    ] = None
    step: Annotated[int, Field(ge=1, le=MOST, description="Every step-th frame of them", examples=[4])] = 1

    @property
    def window(self) -> Window | None:
        # Imported here: most operations need no mathematics.
        from mcml_service.actions.reading.preview_motion import Window

        return None if self.positions is None else Window(self.first, self.last, self.step)


def encode_cursor(*parts: Any) -> str:
    """An opaque cursor; `decode_cursor` gives the parts back."""
    return base64.urlsafe_b64encode(orjson.dumps(parts)).decode().rstrip("=")


def decode_cursor(cursor: str, *kinds: type) -> list[Any]:
    """Return the parts of a cursor. Raises QueryError for an invalid cursor."""
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


def tag(stored: StoredDocument, form: str = "json") -> str:
    """The version of a representation: revision and form."""
    return f"{stored.revision}-{form}"


def find_for_write(tx: Transaction, uuid: str, if_match: str | None, *, deleted: bool = False) -> StoredDocument:
    """The document, locked for a change, if the request was made for its current revision."""
    current = tx.documents.find(uuid, deleted=deleted)
    if current is None:
        raise NotFoundError(f"There is no document {uuid}.", remedy="List the documents to see their ids.")
    tx.documents.lock(current.key)
    stored = tx.documents.get(uuid, deleted=deleted)
    check_match(if_match, stored.revision, "document", "revision")
    return stored


def at_revision(tx: Transaction, uuid: str, revision: int | None) -> tuple[Transaction, StoredDocument]:
    """Return the document at the current or a given revision, and the transaction to read it with."""
    if revision is None:
        return tx, tx.documents.get(uuid)
    current = tx.documents.get(uuid)
    then = tx.at_commit(tx.documents.commit_of(current.key, revision))
    return then, then.documents.get(uuid)
