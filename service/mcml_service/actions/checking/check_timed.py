"""Check that documents have a frame time."""

from __future__ import annotations

from mcml.errors import DocumentError
from mcml_service.storage.documents.documents import StoredDocument


def seconds_of(stored: StoredDocument) -> float:
    """Return the frame time in seconds. Raises DocumentError if it is unknown."""
    if stored.seconds_per_frame is None:
        raise DocumentError(
            f"{stored.name} ({stored.uuid}) has no frame time, so nothing is known of its speed.",
            remedy=f"State it: mcml set {stored.uuid} --frame-time SECONDS, or PATCH the document with frame_time.",
        )
    return stored.seconds_per_frame
