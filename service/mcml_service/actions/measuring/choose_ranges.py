"""Choose the frame ranges that are measured: whole clips, answers of a query, occurrences of labels, or strides."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, Protocol

import numpy as np

from mcml.errors import RequestError, SizeError
from mcml.laboratory.measure_gait import Gait
from mcml_schemas.jobs import Selection
from mcml_schemas.measure import MeasureRequest
from mcml_schemas.querying.queries import MOST_DOCUMENTS, QueryRequest, RunItem
from mcml_service.actions.composing.select_documents import select_captured, select_documents
from mcml_service.storage.database import Database
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.queries import Queries

MOST_ROWS = 50_000
"""Limit of frame ranges times quantities."""
_PAGE = 1000


@dataclass(frozen=True)
class Range:
    """first, last: frames, positions from 1. begin, end: places of 0 and 100 %, from 0; between frames for strides."""

    first: int
    last: int
    begin: float
    end: float
    label: str = ""
    side: str = ""

    @classmethod
    def of_frames(cls, first: int, last: int, label: str = "") -> Range:
        """A range of whole frames."""
        return cls(first, last, first - 1.0, last - 1.0, label)


@dataclass(frozen=True)
class ChosenClip:
    """found: frame ranges of the query; None without a query."""

    document: str
    revision: int
    found: tuple[tuple[int, int], ...] | None = None


class RangesRequest(Protocol):
    """A request for the frame ranges of clips or of a query. quantities: each range has a row for each of them."""

    selection: Selection | None
    query: str | None
    quantities: list[str]
    guesses: Literal["yes", "no"]


def choose_clips(
    database: Database, queries: Queries, request: RangesRequest, limits: Limits
) -> tuple[list[ChosenClip], list[str]]:
    """Return the clips of a request in the order of their ids, and warnings.

    Raises RequestError for a request without clips, SizeError for too many ranges, and the errors of queries.
    """
    if request.selection is None and request.query is None:
        raise RequestError("No clips are selected.", remedy="State `selection`, or a `query` that finds frame ranges.")
    clips: list[ChosenClip] = []
    warnings: list[str] = []
    documents: list[str] = []
    if request.selection is not None:
        inputs, _ = select_documents(database, queries, request.selection)
        kept = select_captured(database, request.selection, inputs)
        if len(kept) < len(inputs):
            made = len(inputs) - len(kept)
            warnings.append(f"Clips made by analyses are left out ({made:,}); include_made of the selection adds them.")
        clips = [ChosenClip(str(item["document"]), int(str(item["revision"]))) for item in kept]
        documents = [clip.document for clip in clips]
    if request.query is None or (request.selection is not None and not clips):
        _require_room(len(clips), request)
        return clips, warnings
    if len(documents) > MOST_DOCUMENTS:
        raise SizeError(
            f"The selection has {len(documents):,} clips, and a query asks at most {MOST_DOCUMENTS:,}.",
            remedy="Narrow the selection, or leave it out: a query alone asks all clips.",
        )
    return _ask(queries, request, documents, limits, warnings), warnings


def check_kinds(request: MeasureRequest) -> None:
    """Raise RequestError for a request with two kinds of ranges."""
    kinds = [name for name in ("query", "cycles", "strides") if getattr(request, name)]
    if len(kinds) > 1:
        raise RequestError(
            f"{' and '.join(kinds)} both choose the frame ranges.", remedy="State one of query, cycles, strides."
        )


def _ask(
    queries: Queries, request: RangesRequest, documents: list[str], limits: Limits, warnings: list[str]
) -> list[ChosenClip]:
    found: dict[tuple[str, int], list[tuple[int, int]]] = {}
    cursor: str | None = None
    count = 0
    while True:
        page = QueryRequest(
            q=request.query or "", document=documents, limit=_PAGE, cursor=cursor, guesses=request.guesses,
            **{"as": "runs"},
        )  # fmt: skip
        answer = queries.answer(page, limits)
        for item in answer.items or ():
            if isinstance(item, RunItem):
                found.setdefault((item.document, item.revision), []).append((item.first, item.last))
                count += 1
        _require_room(count, request)
        cursor = answer.next_cursor
        if cursor is None:
            warnings += answer.warnings
            if not answer.complete:
                warnings.append("The query was stopped at its limit, so frame ranges are missing.")
            return [ChosenClip(*key, tuple(ranges)) for key, ranges in found.items()]


def _require_room(count: int, request: RangesRequest) -> None:
    require_rows(count * max(1, len(request.quantities)))


def require_rows(count: int) -> None:
    """Raise SizeError for more rows than an answer may have."""
    if count > MOST_ROWS:
        raise SizeError(
            f"More than {MOST_ROWS:,} rows would be measured (frame ranges times quantities).",
            remedy="Narrow the selection or the query, or ask for fewer quantities at a time.",
        )


def ranges_of_labels(spans: Sequence[StoredSpan], labels: Sequence[str]) -> Iterator[Range]:
    """Yield the occurrences of labels in a clip.

    A label whose occurrences are all of a single frame marks where cycles begin, so each ends at the next one.
    """
    for label in dict.fromkeys(labels):
        own = [(span.first, span.last) for span in spans if span.name == label]
        if own and all(first == last for first, last in own):
            places = sorted({first for first, _ in own})
            own = list(pairwise(places))
        for first, last in own:
            yield Range.of_frames(first, last, label)


def ranges_of_strides(gait: Gait, frames: int) -> Iterator[Range]:
    """Yield the strides of a clip that count: complete ones which no rule rejects, from strike to strike."""
    for stride in gait.strides:
        begin, end = stride.begin * gait.rate, stride.end * gait.rate
        first, last = int(np.ceil(begin - 1e-6)) + 1, int(np.floor(end + 1e-6)) + 1
        if not stride.rejected and 1 <= first < last <= frames:
            yield Range(first, last, begin, min(end, frames - 1.0), "", stride.side)
