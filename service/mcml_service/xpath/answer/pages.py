"""One page of an answer, and the cursor of the next page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from mcml.errors import LimitError
from mcml_schemas.querying.queries import NodeItem, QueryAnswer, QueryRequest, RunTotals, ValueItem
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.answer import sources
from mcml_service.xpath.answer.cursors import Cursor, question
from mcml_service.xpath.answer.items import Kind, node_item, plain, run_items
from mcml_service.xpath.answer.totals import MAX_RUNS, add_figures, counted
from mcml_service.xpath.engine.parts import Part, Parts
from mcml_service.xpath.engine.source import Source
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.nodes.node import Node, Run
from mcml_service.xpath.nodes.numbering import documents_of, frames_of


@dataclass(frozen=True)
class Page:
    """One page of nodes, runs or values. check: called often; raises when time is up."""

    caches: Caches
    request: QueryRequest
    limit: int
    cursor: Cursor | None
    check: Callable[[], None]

    @property
    def offset(self) -> int:
        return 0 if self.cursor is None else self.cursor.offset

    def of(self, tx: Transaction, source: Source, max_elements: int) -> QueryAnswer:
        if self.request.as_ == "runs":
            return self.of_runs(tx, sources.runs(source))
        return self.of_nodes(tx, *sources.page(source, self.offset, self.limit, max_elements))

    def of_parts(self, tx: Transaction, parts: Iterable[Part], max_elements: int) -> QueryAnswer:
        """A sequence that may hold nodes and values."""
        items: list[NodeItem | ValueItem] = []
        passed = 0
        for part in parts:
            wanted = self.limit + 1 - len(items)
            begin = max(0, self.offset - passed)
            passed += len(part)
            some = part.chosen(np.arange(min(begin, len(part)), min(len(part), begin + wanted)))
            if some.are_nodes:
                nodes, _ = sources.page(Parts([some]), 0, wanted, max_elements)
                items += map(node_item, nodes)
                if len(nodes) < len(some):
                    return self.of_items(tx, items, more=True)
            else:
                items += _values(tx, some)
            if len(items) > self.limit:
                break
        return self.of_items(tx, items[: self.limit], more=len(items) > self.limit)

    def of_items(self, tx: Transaction, items: Sequence[NodeItem | ValueItem], *, more: bool) -> QueryAnswer:
        """Nodes and values. more: whether others follow."""
        kind: Kind = "nodes" if items and all(isinstance(item, NodeItem) for item in items) else "values"
        return QueryAnswer(type=kind, items=list(items), next_cursor=self._next(tx, more, len(items)))

    def of_values(self, tx: Transaction, values: Sequence[float | str | bool]) -> QueryAnswer:
        some = values[self.offset : self.offset + self.limit]
        more = len(values) > self.offset + self.limit
        items = [ValueItem(value=plain(value)) for value in some]
        return QueryAnswer(type="strings", items=list(items), next_cursor=self._next(tx, more), total=len(values))

    def of_runs(self, tx: Transaction, found: Iterable[Run]) -> QueryAnswer:
        if self.offset + self.limit > MAX_RUNS:
            raise LimitError(f"The result has more than {MAX_RUNS} runs.", remedy="Narrow the query.")
        totals: RunTotals | None = None
        if "totals" in (self.request.with_ or ""):
            found, totals = counted(found)
        runs = list(islice(found, self.offset, self.offset + self.limit + 1))
        items = run_items(tx, self.caches, runs[: self.limit])
        ranged = "range" in (self.request.with_ or "")
        shown = runs[: self.limit]
        of = add_figures(tx, self.caches, self.request, shown, items, self.check) if ranged else None
        following = self._next(tx, len(runs) > self.limit)
        return QueryAnswer(type="runs", items=list(items), next_cursor=following, totals=totals, range_of=of)

    def of_nodes(self, tx: Transaction, nodes: list[Node], more: bool) -> QueryAnswer:
        items = [node_item(node) for node in nodes]
        return QueryAnswer(type="nodes", items=list(items), next_cursor=self._next(tx, more, len(items)))

    def _next(self, tx: Transaction, more: bool, shown: int | None = None) -> str | None:
        """Return the cursor of the next page. shown: number of items on this page, if not the requested number."""
        if not more:
            return None
        commit = min(tx.newest_commit(), tx.at)
        following = self.offset + (self.limit if shown is None else shown)
        return str(Cursor(commit, tx.pruning.whole_since(), following, question(self.request)))


def _values(tx: Transaction, part: Part) -> list[ValueItem]:
    """The values of a part, each with the frame that it is of."""
    values = map(plain, part.values())
    if part.of is None:
        return [ValueItem(value=value) for value in values]
    places, frames = documents_of(part.of), frames_of(part.of)
    of_frames = [part.forest.documents[place] for place in np.unique(places[frames > 0])]
    seconds = tx.heads.seconds_per_frame(of_frames)
    found = []
    for value, place, frame in zip(values, places.tolist(), frames.tolist(), strict=True):
        listed = part.forest.documents[place]
        each = seconds.get(listed.key)
        time = None if not frame or each is None else (frame - 1) * each
        found.append(ValueItem(value=value, document=listed.uuid, frame=frame or None, time=time))
    return found
