"""Queries of a repository, and their answers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mcml.client.client import Client
from mcml.errors import QueryError
from mcml_schemas.documents import DocumentSummary
from mcml_schemas.querying.queries import NodeItem, QueryAnswer, RunItem, ScalarItem, ValueItem

_IN_FRAME = re.compile(r"/mcml(?:\[1\])?/motion(?:\[1\])?/frame\[(\d+)\]")


@dataclass(frozen=True)
class Run:
    """A maximal range of frames that an expression finds: positions from 1, both ends included."""

    document: str
    name: str
    first: int
    last: int

    @property
    def frames(self) -> int:
        return self.last - self.first + 1


class Query:
    """A query; each method that returns an answer runs it again."""

    def __init__(self, client: Client, expression: str, asked: dict[str, Any]) -> None:
        self._client = client
        self._expression = expression
        self._asked = asked
        self._times: dict[str, float | None] = {}

    def __repr__(self) -> str:
        return f"<Query {self._expression!r}>"

    def runs(self) -> list[Run]:
        """Maximal ranges of frames that it finds."""
        runs = (item for page in self._pages("runs") for item in page.items or () if isinstance(item, RunItem))
        return [Run(item.document, item.name, item.first, item.last) for item in runs]

    def nodes(self) -> Iterator[NodeItem]:
        """Nodes with their addresses, as they come."""
        for page in self._pages("json"):
            yield from (item for item in page.items or () if isinstance(item, NodeItem))

    def value(self) -> Any:
        """Return its number, text or boolean; for a query of each document, the values by the documents' ids.

        Several values, such as those of distinct-values(), are a list.
        """
        pages = list(self._pages("json"))
        first = pages[0]
        if first.value is not None:
            return first.value
        if first.type in ("strings", "values"):
            return [item.value for page in pages for item in page.items or () if isinstance(item, ValueItem)]
        if first.type in ("number", "string", "boolean"):
            items = [item for page in pages for item in page.items or ()]
            return {item.document: item.value for item in items if isinstance(item, ScalarItem)}
        raise QueryError(
            "The result is nodes, not a value.", remedy="Take nodes(), runs() or count(), or write string() around it."
        )

    def count(self) -> int:
        """How many nodes it finds."""
        number = Query(self._client, f"count({self._expression})", self._asked).value()
        return int(sum(number.values()) if isinstance(number, dict) else number)

    def to_pandas(self, **quantities: str) -> Any:
        """Return a DataFrame of its frames, nodes or values: document, frame, time (seconds since frame 1, NaN where
        unknown), and the values. Needs pandas.

        Values have a column `value`; nodes have kind, address and value. quantities: additional columns, each an
        expression evaluated for every frame: repo.xpath("//frame").to_pandas(speed="mo:speed('right_hand')").
        """
        import pandas as pd

        items = [item for page in self._pages("json") for item in page.items or () if not isinstance(item, RunItem)]
        rows = [item.model_dump() | ({} if isinstance(item, ValueItem) else self._place(item)) for item in items]
        first = ("document", "frame", "time")
        names = dict.fromkeys((*first, *(name for row in rows for name in row)))
        table = pd.DataFrame(rows, columns=list(names))
        for name in ("frame", "time"):
            table[name] = pd.to_numeric(table[name])
        for name, expression in quantities.items():
            asked = Query(self._client, f"({self._expression})/({expression})", self._asked)
            nodes = [item for page in asked._pages("json") for item in page.items or () if isinstance(item, ValueItem)]
            known = {(item.document, item.frame): item.value for item in nodes}
            values = [known.get((row["document"], row.get("frame"))) for row in rows]
            table[name] = pd.to_numeric(pd.Series(values, dtype=object), errors="coerce")
        return table

    def _place(self, item: NodeItem | ScalarItem) -> dict[str, Any]:
        """Return the frame of a node, and its time."""
        match = _IN_FRAME.match(item.address) if isinstance(item, NodeItem) else None
        if match is None:
            return {}
        frame = int(match[1])
        if item.document not in self._times:
            summary: DocumentSummary = self._client.call("get_document", id=item.document)
            self._times[item.document] = summary.seconds_per_frame
        seconds = self._times[item.document]
        return {"frame": frame, "time": None if seconds is None else (frame - 1) * seconds}

    def _pages(self, form: str) -> Iterator[QueryAnswer]:
        cursor: str | None = None
        while True:
            asked = {"q": self._expression, "cursor": cursor, "limit": 1000, **self._asked, "as": form}
            page: QueryAnswer = self._client.call("post_query", request=asked)
            yield page
            cursor = page.next_cursor
            if cursor is None:
                return
