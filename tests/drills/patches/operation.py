"""The document with the most frames."""

from __future__ import annotations

from mcml_schemas.longest import Longest

from mcml.errors import NotFoundError
from mcml_service.operations.call import Call
from mcml_service.storage.lists.filtering import DocumentFilter


def find_longest(call: Call) -> Longest:
    """Of all projects."""
    with call.database.read() as tx:
        found = tx.documents.page(DocumentFilter(), after=None, limit=10_000)
    if not found:
        raise NotFoundError("There is no document.", remedy="Import one.")
    longest = max(found, key=lambda stored: stored.frames)
    return Longest(id=longest.uuid, frames=longest.frames)
