"""Split a document into several documents."""

from __future__ import annotations

from itertools import pairwise

from mcml.errors import LimitError, NotFoundError
from mcml_schemas.compose import SplitPart, SplitParts, SplitRequest
from mcml_service.actions.editing.frame_splicing import check_range
from mcml_service.actions.importing.store_clip import store_stream
from mcml_service.clips.read_clip import read_clip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_PARTS = 1000


def split_document(database: Database, settings: Settings, uuid: str, request: SplitRequest, author: str) -> SplitParts:
    """Store parts of a document: numbers bit by bit, motion names with their frames, the same header and skeleton.

    Raises NotFoundError for missing frames and names, LimitError for more than 1000 parts.
    """
    items = []
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        for first, last in _ranges(tx, stored, request):
            name = f"{request.name or stored.name} {first}-{last}"
            if request.name and request.is_range:
                name = request.name
            made = store_stream(
                database,
                read_clip(tx, stored, first=first, last=last).clip,
                settings,
                name=name,
                project=request.project or stored.project,
                author=author,
                provenance={
                    "analysis": "split",
                    "sources": [
                        {
                            "document": stored.uuid,
                            "revision": stored.revision,
                            "first": first,
                            "frames": last - first + 1,
                        }
                    ],
                },
            )
            items.append(SplitPart(document=made, name=name, first=first, last=last))
    return SplitParts(items=items)


def _ranges(tx: Transaction, stored: StoredDocument, request: SplitRequest) -> list[tuple[int, int]]:
    """First and last frames of the parts, in order."""
    if request.is_range:
        first, last = request.first or 1, request.last or stored.frames
        check_range(stored, first, last)
        return [(first, last)]
    if request.label is None:
        starts = sorted({1, *request.at})
        if starts[-1] > stored.frames:
            raise NotFoundError(
                f"There is no frame {starts[-1]} in a document of {stored.frames} frames.",
                remedy="Frame numbers are positions, from 1.",
            )
        return [(first, after - 1) for first, after in pairwise([*starts, stored.frames + 1])]
    spans = [span for span in tx.spans.of(stored.key) if span.name == request.label]
    if not spans:
        raise NotFoundError(f"No frame is named {request.label!r}.", remedy="List the labels of the document.")
    if len(spans) > MOST_PARTS:
        raise LimitError(f"The name has more than {MOST_PARTS} ranges.", remedy="Split the document by frames first.")
    return [(span.first, span.last) for span in spans]
