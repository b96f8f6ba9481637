"""Questions to answers: parse, plan, and run in one read transaction, a page at a time."""

from __future__ import annotations

import base64
import binascii
import math
import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import orjson

from schemas.queries import Explain, NodeItem, QueryAnswer, QueryRequest, RunItem, ScalarItem
from service.errors import LimitError, QueryError
from service.settings import Settings
from service.storage.database import LATEST, Database, Transaction
from service.storage.documents import StoredDocument
from service.xpath import sources
from service.xpath.axes import TooWideError
from service.xpath.columnar import Columnar
from service.xpath.evaluate import Evaluator, Scalar
from service.xpath.heads import Heads
from service.xpath.indexed import Indexed, scope_documents
from service.xpath.nodes import Node, Run, Scope
from service.xpath.parse import Query, parse
from service.xpath.plan import COUNT, Plan, plan
from service.xpath.projected import Projected
from service.xpath.rules import normal
from service.xpath.sources import Nth, Source
from service.xpath.tree import Call, Expression, Filter, Literal, is_constant, type_of
from service.xpath.values import TooLongError

MAX_RUNS = 100_000


@dataclass(frozen=True, slots=True)
class _Cursor:
    """commit: the state that is read. offset: items on the pages before. check: of the question it belongs to."""

    commit: int
    offset: int
    check: int


class Queries:
    """The query engine of one process: the store, the limits, and the pool of evaluating processes."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self.database = database
        self.settings = settings
        self.evaluator = Evaluator(seconds=settings.query_seconds, memory_bytes=settings.query_memory_mib << 20)
        self.heads = Heads()

    def close(self) -> None:
        self.evaluator.close()

    def answer(self, request: QueryRequest) -> QueryAnswer:
        """A page of the answer.

        Raises QueryError (with column and hint) for what is no XPath or a cursor of another question, NotFoundError
        for a document or project that does not exist, LimitError for what exceeds the limits.
        """
        start = time.perf_counter()
        query = parse(request.q)
        cursor = _read_cursor(request)
        with self.database.read(LATEST if cursor is None else cursor.commit) as tx:
            scope = _scope(tx, request)
            found = plan(query.tree)
            limit = min(request.limit, self.settings.page_limit)
            kind = type_of(query.tree)
            if request.as_ != "json" and kind != "nodes":
                raise QueryError(f"The answer is a {kind}, not a node set.", remedy="Ask for it with as=json.")
            way = "index"
            if is_constant(query.tree):
                answer = self._constant(query)
            elif cursor is None and found is not None and found.aggregate != "nodes":
                answer = _aggregate(tx, found, scope)
            else:
                page = _Page(request, limit, cursor or _Cursor(-1, 0, _check(request)))
                if found is not None:
                    answer = page.of(Indexed(tx, found, scope), tx)
                else:
                    way, answer = self._evaluated(tx, query, scope, page)
            answer.warnings += query.warnings
            if request.explain:
                answer.explain = _explain(query, found, way, scope, (time.perf_counter() - start) * 1000)
        return answer

    def _evaluated(self, tx: Transaction, query: Query, scope: Scope, page: _Page) -> tuple[str, QueryAnswer]:
        """On columns; on the documents as XML where an intermediate result is too large for that."""
        check = Deadline(self.settings.query_seconds).check
        tree, nth = without_index(normal(query.tree))
        documents = scope_documents(tx, scope)
        try:
            source = Columnar(tx, tree, documents, self.heads, check)
            if type_of(tree) == "nodes":
                nodes = source if nth is None else Nth(source, nth)
                return "columns", page.of_nodes(nodes, tx, self.settings.query_elements)
            if isinstance(tree, Call) and tree.function in ("count", "sum"):
                inner = Columnar(tx, tree.arguments[0], documents, self.heads, check)
                return "columns", QueryAnswer(type="number", value=_plain(inner.total(tree.function)))
            return "columns", scalars(type_of(tree), documents, source.values())
        except (TooWideError, TooLongError):
            return "projection", page.of(Projected(self, tx, query, scope), tx)

    def _constant(self, query: Query) -> QueryAnswer:
        """A value that no document can change, such as `1 + 1`: said once."""
        if isinstance(query.tree, Literal):
            value: float | str | bool = query.tree.value
        else:
            found = self.evaluator.evaluate(query, [b"<mcml/>"])
            value = found.value if isinstance(found, Scalar) else ""
        kind = type_of(query.tree)
        return QueryAnswer(type=kind, value=_plain(value))


def _scope(tx: Transaction, request: QueryRequest) -> Scope:
    keys = [tx.documents.get(uuid).key for uuid in dict.fromkeys(request.document)] if request.document else None
    project = tx.projects.get(request.project) if request.project else None
    return Scope(keys, project, request.project)


def _aggregate(tx: Transaction, found: Plan, scope: Scope) -> QueryAnswer:
    """A count is one number for all documents; whether there is any node is said for each."""
    source = Indexed(tx, replace(found, aggregate="nodes"), scope)
    if found.aggregate == COUNT:
        return QueryAnswer(type="number", value=float(source.count()))
    having = {run.stored.key for run in source.runs()}
    documents = scope_documents(tx, scope)
    if len(documents) == 1:
        return QueryAnswer(type="boolean", value=documents[0].key in having)
    items = [
        ScalarItem(document=stored.uuid, revision=stored.revision, value=stored.key in having) for stored in documents
    ]
    return QueryAnswer(type="boolean", items=list(items))


class _Page:
    """One page of a source of nodes, runs or scalars."""

    def __init__(self, request: QueryRequest, limit: int, cursor: _Cursor) -> None:
        self.request = request
        self.limit = limit
        self.cursor = cursor

    def of(self, source: Indexed | Projected, tx: Transaction) -> QueryAnswer:
        offset = self.cursor.offset
        if isinstance(source, Projected) and source.type != "nodes":
            return self._scalars(source)
        if self.request.as_ == "runs":
            return self._runs(source.runs(), tx)
        return self._nodes(source.nodes(offset, self.limit + 1), tx)

    def of_nodes(self, source: Source, tx: Transaction, max_elements: int) -> QueryAnswer:
        if self.request.as_ == "runs":
            return self._runs(sources.runs(source), tx)
        return self._nodes(sources.page(source, self.cursor.offset, self.limit + 1, max_elements), tx)

    def _runs(self, found: Iterator[Run], tx: Transaction) -> QueryAnswer:
        runs = list(_page_of(found, self.cursor.offset, self.limit + 1))
        items = [_run_item(tx, run) for run in runs[: self.limit]]
        return QueryAnswer(type="runs", items=list(items), next_cursor=self._next(tx, len(runs) > self.limit))

    def _nodes(self, nodes: list[Node], tx: Transaction) -> QueryAnswer:
        shown = [_node_item(node) for node in nodes[: self.limit]]
        return QueryAnswer(type="nodes", items=list(shown), next_cursor=self._next(tx, len(nodes) > self.limit))

    def _scalars(self, source: Projected) -> QueryAnswer:
        kind, value, each = source.scalars()
        if value is not None:
            return QueryAnswer(type=kind, value=_plain(value))
        return scalars(kind, [stored for stored, _ in each], [item for _, item in each])

    def _next(self, tx: Transaction, more: bool) -> str | None:
        if not more:
            return None
        commit = self.cursor.commit if self.cursor.commit >= 0 else tx.newest_commit()
        parts = [commit, self.cursor.offset + self.limit, self.cursor.check]
        return base64.urlsafe_b64encode(orjson.dumps(parts)).decode().rstrip("=")


def scalars(kind: str, documents: Sequence[StoredDocument], found: Sequence[float | str | bool]) -> QueryAnswer:
    """One value of one document, or a value of each."""
    if len(documents) == 1:
        return QueryAnswer(type=kind, value=_plain(found[0]))
    items = [
        ScalarItem(document=stored.uuid, revision=stored.revision, value=_plain(value))
        for stored, value in zip(documents, found, strict=True)
    ]
    return QueryAnswer(type=kind, items=list(items))


def without_index(tree: Expression) -> tuple[Expression, int | None]:
    """`(…)[n]` around the whole counts over all documents: the expression inside, and n."""
    if isinstance(tree, Filter) and len(tree.predicates) == 1 and isinstance(tree.predicates[0], Literal):
        value = tree.predicates[0].value
        if isinstance(value, float) and value >= 1 and value.is_integer():
            return tree.operand, int(value)
    return tree, None


class Deadline:
    """seconds: how long a query may take."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._end = time.monotonic() + seconds

    def check(self) -> None:
        """LimitError once the time is up."""
        if time.monotonic() > self._end:
            raise LimitError(
                f"The query took longer than {self._seconds:g} s.",
                remedy="Ask fewer documents, or ask for a motion name first.",
                code="query-timeout",
            )


def _page_of(runs: Iterator[Run], offset: int, limit: int) -> Iterator[Run]:
    for number, run in enumerate(runs):
        if number >= offset + limit:
            return
        if number >= MAX_RUNS:
            raise LimitError(f"The answer has more than {MAX_RUNS} runs.", remedy="Narrow the question.")
        if number >= offset:
            yield run


def _run_item(tx: Transaction, run: Run) -> RunItem:
    ids = tx.tracks.frame_ids(run.stored.key, run.first, run.first)
    last_ids = tx.tracks.frame_ids(run.stored.key, run.last, run.last)
    return RunItem(
        document=run.stored.uuid,
        name=run.stored.name,
        revision=run.stored.revision,
        first=run.first,
        last=run.last,
        first_id=str(ids[0]),
        last_id=str(last_ids[0]),
        frames=run.last - run.first + 1,
    )


def _node_item(node: Node) -> NodeItem:
    return NodeItem(
        kind=node.kind,
        document=node.stored.uuid,
        revision=node.stored.revision,
        address=node.address,
        value=node.value,
    )


def _plain(value: float | str | bool) -> float | str | bool:
    """JSON has no NaN and no infinities: they are the texts that XPath's string() gives."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value


def _check(request: QueryRequest) -> int:
    return zlib.crc32(orjson.dumps([request.q, request.document, request.project, request.as_]))


def _read_cursor(request: QueryRequest) -> _Cursor | None:
    if request.cursor is None:
        return None
    try:
        text = request.cursor + "=" * (-len(request.cursor) % 4)
        commit, offset, check = (int(part) for part in orjson.loads(base64.urlsafe_b64decode(text)))
    except (binascii.Error, ValueError, TypeError, OverflowError):
        commit, offset, check = -1, -1, -1
    if check != _check(request) or not (0 <= commit < LATEST and 0 <= offset < LATEST):
        raise QueryError("This cursor belongs to another question.", remedy="Begin again without a cursor.")
    return _Cursor(commit, offset, check)


def _explain(query: Query, found: Plan | None, way: str, scope: Scope, milliseconds: float) -> Explain:
    asked = 0 if scope.keys is None else len(scope.keys)
    if found is None and way == "columns":
        return Explain(way="columns", plan=["the expression on columns"], documents=asked, milliseconds=milliseconds)
    if found is None:
        steps = ["the documents as XML, without what the expression cannot touch", "libxml2 evaluates the expression"]
        return Explain(way="projection", plan=steps, documents=asked, milliseconds=milliseconds)
    steps = []
    for group in found.motion_names:
        steps.append(f"spans named {' or '.join(repr(name) for name in group)}, by the index on names")
    if not found.motion_names:
        steps.append("all frames, by the timeline")
    if found.position is not None:
        steps.append(f"the frame at position {found.position}")
    if found.nth is not None:
        steps.append(f"the frame number {found.nth} of these")
    if found.bones:
        which = f"named {found.bone!r}" if found.bone else f"number {found.ordinal}" if found.ordinal else "all"
        steps.append(f"their frame_bones ({which}), by the shapes of the frames")
    if found.attribute:
        steps.append(f"their attribute {found.attribute}")
    if found.aggregate != "nodes":
        steps.append(f"{found.aggregate}, by arithmetic on ranges: no track is read")
    else:
        steps.append("tracks of the frames and bones on the page")
    return Explain(way="index", plan=steps, documents=asked, milliseconds=milliseconds)
