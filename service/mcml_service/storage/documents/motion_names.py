"""Spans to the motion names of single frames."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from mcml_service.storage.documents.spans import StoredSpan


def names_of_frames(spans: Sequence[StoredSpan], positions: range) -> list[tuple[str, ...]] | None:
    """The motion names of each frame in order of rank, None where no frame has any."""
    if not spans:
        return None
    changes = sorted({span.first for span in spans} | {span.last + 1 for span in spans})
    # Between two changes all frames have the same names, so the number of positions there is arithmetic.
    inner = [change for change in changes if positions.start < change < positions.stop]
    result: list[tuple[str, ...]] = []
    for start, stop in pairwise([positions.start, *inner, positions.stop]):
        covering = [span for span in spans if span.first <= start <= span.last]
        names = tuple(span.name for span in sorted(covering, key=lambda span: (span.rank, span.key)))
        result += [names] * (len(range(positions.start, stop, positions.step)) - len(result))
    return result if any(result) else None
