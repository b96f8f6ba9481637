"""Spans to the motion names of single frames."""

from __future__ import annotations

from collections.abc import Sequence

from service.storage.spans import StoredSpan


def names_of_frames(spans: Sequence[StoredSpan], positions: range) -> list[tuple[str, ...]] | None:
    """The motion names of each frame in order of rank, None where no frame has any."""
    if not spans:
        return None
    changes = sorted({span.first for span in spans} | {span.last + 1 for span in spans})
    result: list[tuple[str, ...]] = []
    change = 0
    current: tuple[str, ...] = ()
    for position in positions:
        moved = False
        while change < len(changes) and changes[change] <= position:
            change, moved = change + 1, True
        if moved or not result:
            covering = [span for span in spans if span.first <= position <= span.last]
            current = tuple(span.name for span in sorted(covering, key=lambda span: (span.rank, span.key)))
        result.append(current)
    return result if any(result) else None
