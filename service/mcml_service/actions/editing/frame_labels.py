"""The motion_name elements of single frames: spans are split so that only these frames change."""

from __future__ import annotations

from mcml.errors import NotFoundError, Place
from mcml.language import motion_names
from mcml.language.addresses import address_child
from mcml.language.vocabulary import MOTION_NAME
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def rewrite_motion_name(tx: Transaction, stored: StoredDocument, frame: int, number: int, text: str | None) -> None:
    """Give the number-th motion_name of a frame another text, or delete it (None)."""
    covering = sorted(tx.spans.of(stored.key, frame, frame), key=lambda span: (span.rank, span.key))
    if not 1 <= number <= len(covering):
        raise NotFoundError(
            f"Frame {frame} has {len(covering)} motion names.",
            at=Place(element=address_child(frame, MOTION_NAME, number)),
        )
    span = covering[number - 1]
    name = None if text is None else motion_names.canonical(text.strip())
    tx.spans.close([span.key])
    rows = []
    if span.first < frame:
        rows.append({"name": span.name, "rank": span.rank, "first": span.first, "last": frame - 1})
    if name is not None:
        rows.append({"name": name, "rank": span.rank, "first": frame, "last": frame})
    if frame < span.last:
        rows.append({"name": span.name, "rank": span.rank, "first": frame + 1, "last": span.last})
    tx.spans.write(stored.key, rows, tx.commit)
