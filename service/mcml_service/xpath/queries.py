"""Evaluate queries: parse, choose a source for the nodes, and run in one read transaction, a page at a time."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import replace
from typing import Literal

from mcml.errors import LimitError, QueryError
from mcml_schemas.querying.queries import Explain, QueryAnswer, QueryRequest, ValueItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import LATEST, Transaction
from mcml_service.xpath.answer.cursors import read_cursor
from mcml_service.xpath.answer.explain import body_steps, steps_of
from mcml_service.xpath.answer.items import Kind, kind_of_value, node_item, plain, scalars
from mcml_service.xpath.answer.pages import Page
from mcml_service.xpath.answer.streams import Answer, Shown, collect
from mcml_service.xpath.engine import aggregates
from mcml_service.xpath.engine.column_source import ColumnSource
from mcml_service.xpath.engine.functions import NotOnColumnsError
from mcml_service.xpath.engine.parts import Part, Parts
from mcml_service.xpath.engine.scan import Scan
from mcml_service.xpath.engine.scan_plan import plan_scan
from mcml_service.xpath.engine.source import Source
from mcml_service.xpath.engine.values import TooLongError
from mcml_service.xpath.engine.whole import Whole
from mcml_service.xpath.language.certain import conditions
from mcml_service.xpath.language.complete import Completion, complete
from mcml_service.xpath.language.hints import hints
from mcml_service.xpath.language.labels import without_index
from mcml_service.xpath.language.parse import Query, find_constant, parse
from mcml_service.xpath.language.reach import head_of
from mcml_service.xpath.language.rules import normal
from mcml_service.xpath.language.scopes import asks_each, is_node_set
from mcml_service.xpath.language.tree import Call, Expression, Written
from mcml_service.xpath.language.types import distinct_of, is_integer, item_type, type_of
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.language.values import to_xpath31
from mcml_service.xpath.language.xpath31.written import with_values
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.disk.part_file import path_of
from mcml_service.xpath.library.disk.sidecar import Sidecar
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.library.motion_notes import BodyScope, motion_calls, refuse_top, without_guesses
from mcml_service.xpath.limits import Limits, Running, no_such_question
from mcml_service.xpath.nodes.node import Node
from mcml_service.xpath.nodes.pairs import TooWideError
from mcml_service.xpath.trees.evaluate import Found
from mcml_service.xpath.trees.sequences import Sequences, scope_of, value_of_nothing

DEFAULT_LIMIT = 100
MOST_BY_TREES = 100_000
"""Nodes of an answer that is written out document by document."""
ONE_VALUE = aggregates.NUMBER_AGGREGATES | aggregates.TRUTH_AGGREGATES
LAST_SECONDS = 2.0
"""That a process may take at its end to write what the next one reads."""


class Queries:
    """The query engine of one process: the store, the limits, and the caches."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self.database = database
        self.settings = settings
        place = path_of(database, settings.cache_dir)
        sidecar = None if place is None else Sidecar(place, settings.cache_disk_mib << 20)
        self.caches = Caches(settings.query_cache_mib << 20, sidecar)

    def on(self, database: Database) -> Queries:
        """Return the same for a store with a limited view."""
        if database is self.database:
            return self
        other = copy(self)
        other.database = database
        return other

    def close(self) -> None:
        if self.caches.sidecar is not None:
            self.caches.sidecar.close(LAST_SECONDS)

    def answer(self, request: QueryRequest, limits: Limits | None = None) -> QueryAnswer:
        """Return a page of the answer.

        limits: by default from the settings; another thread may cancel through them. Raises QueryError (with column and
        hint) for invalid XPath or a cursor of another query, NotFoundError for a document or project that does not
        exist, LimitError beyond the limits.
        """
        start = time.perf_counter()
        limits = limits or self.limits()
        query = parse(request.q, request.variables, strict=request.strict)
        cursor = read_cursor(request)
        kind = type_of(query.tree)
        if request.as_ != "json" and kind not in ("nodes", "sequence"):
            raise QueryError(f"The result is a {kind}, not a node set.", remedy="Ask for it with as=json.")
        with self.database.read(self._commit(request) if cursor is None else cursor.commit) as tx:
            if cursor is not None:
                tx.pruning.require_whole_since(cursor.whole_since)
            scope = Scope(tx, self.caches.listing, request.document, request.project)
            asking = _Asking(self, tx, query, scope, limits, per=request.per, wants_explain=request.explain)
            asking.leave_out_guesses(request.guesses)
            most = min(request.limit or DEFAULT_LIMIT, self.settings.page_limit)
            page = Page(self.caches, request, most, cursor, limits.check)
            try:
                answer = asking.answer(page)
            except LimitError as error:
                by_trees = asking.explain.way == "projection"
                if asking.motion and not by_trees and error.details.get("code") == "query-timeout":
                    error.remedy = "Derive the bodies once for all queries: mcml db derive."
                if request.explain:
                    error.details["explain"] = asking.explained((time.perf_counter() - start) * 1000).model_dump()
                raise
            if request.explain:
                answer.explain = asking.explained((time.perf_counter() - start) * 1000)
            answer.warnings += [*query.warnings, *hints(query.tree), *scope.unused_names(query.tree)]
            answer.warnings += asking.bodies.notes()
        return answer

    def stream(self, request: QueryRequest, limits: Limits | None = None) -> Answer | Shown:
        """All nodes of an answer (or the first `limit`), to be shown bit by bit. Raises as `answer` does."""
        limits = limits or self.limits()
        query = parse(request.q, request.variables, strict=request.strict)
        kind = type_of(query.tree)
        if kind not in ("nodes", "sequence"):
            raise QueryError(f"The result is a {kind}, not a node set.", remedy="Ask for it with as=json.")
        with self.database.read(self._commit(request)) as tx:
            scope = Scope(tx, self.caches.listing, request.document, request.project)
            asking = _Asking(self, tx, query, scope, limits, per=request.per, wants_explain=False)
            asking.leave_out_guesses(request.guesses)
            commit, since = scope.state.commit, tx.pruning.whole_since()
            try:
                found = collect(asking.nodes(), request.limit)
            except (TooWideError, TooLongError, NotOnColumnsError):
                refuse_top(asking.motion)
                documents = [one for group in asking.bodies.select(asking.scope.groups()) for one in group]
            else:
                return Answer(self.database, self.caches, commit, since, found)
        asked = scope_of(query, len(documents), per_document=request.per is not None)
        at_once = asked.together or without_index(query.tree)[1] is not None
        parts = [documents] if at_once else [[stored] for stored in documents]
        return Shown(self._by_trees(query, parts, commit, since, limits, request.limit or MOST_BY_TREES))

    def _by_trees(
        self, query: Query, parts: list[list[Listed]], commit: int, since: int, limits: Limits, limit: int
    ) -> Iterator[list[Node]]:
        """The nodes of an answer, some documents at a time, each batch in a separate transaction."""
        for documents in parts:

            def found_in(tx: Transaction, some: list[Listed] = documents, most: int = limit) -> list[Node]:
                tx.pruning.require_whole_since(since)
                answer = Sequences(tx, self.caches, query, [self.caches.listing.group(some)], limits)
                items = answer.page(0, most).items
                nodes = [item for item in items if isinstance(item, Node)]
                if len(nodes) < len(items):
                    raise QueryError("The result contains values, not only nodes.", remedy="Ask for it with as=json.")
                return nodes

            found = self.database.ask(found_in, commit)
            yield found
            limit -= len(found)
            if limit <= 0:
                return

    def _commit(self, request: QueryRequest) -> int:
        """Return the commit of the query: the newest, or the one of a revision of the document."""
        if request.revision is None:
            return LATEST
        if len(request.document) != 1:
            raise QueryError("A revision is one of a document.", remedy="Name exactly one document.")
        with self.database.read() as tx:
            return tx.documents.commit_of(tx.documents.get(request.document[0]).key, request.revision)

    def completions(
        self, text: str, at: int, documents: Sequence[str], project: str | None
    ) -> tuple[int, list[Completion]]:
        """(first character that is replaced, completions) at a place in an expression, over a scope."""
        with self.database.read() as tx:
            scope = Scope(tx, self.caches.listing, documents, project)
            return complete(text, at, lambda: scope.used_counts("span"), lambda: scope.used_counts("bone"))

    def limits(self, client: str = "", author: str = "") -> Limits:
        """Return the limits of a query that begins now. client: key in fair queues; author: name of the user."""
        return Limits(self.settings.query_seconds, self.settings.query_elements, client, author)

    def running(self) -> list[Running]:
        """Return running queries of clients, oldest first; only on a server."""
        return []

    def end(self, number: int) -> None:
        """Cancel a query, as if its client had disconnected.

        Raises NotFoundError if no query with this number is running.
        """
        raise no_such_question(number)


class _Asking:
    """One query in one transaction."""

    def __init__(
        self,
        engine: Queries,
        tx: Transaction,
        query: Query,
        scope: Scope,
        limits: Limits,
        *,
        per: str | None,
        wants_explain: bool,
    ) -> None:
        self.per = per
        self.wants_explain = wants_explain
        self.engine = engine
        self.tx = tx
        self.query = query
        self.scope = scope
        self.limits = limits
        self.motion = motion_calls(query.tree)
        self.bodies = BodyScope(tx, engine.caches, self.motion, conditions(query.tree), limits.check)
        self.explain = Explain(way="columns", plan=[], documents=0, milliseconds=0)
        self._scan: Scan | None = None
        self.is_later = query.is_later
        self.whole = Whole(tx, engine.caches, self.source, limits.check, is_later=self.is_later)

    def answer(self, page: Page) -> QueryAnswer:
        try:
            return self._on_columns(normal(self.query.tree), page)
        except (TooWideError, TooLongError, NotOnColumnsError):
            tree = self.query.tree
            constant = find_constant(unparse(tree), tree, {}, strict=not self.query.compatible)
            if constant is not None and self.per is None:
                # It holds the values of the scope, so every document would give the same answer again.
                self.query = replace(self.query, constant=constant)
                return self._constant(page)
            self.explain.way = "projection"
            refuse_top(self.motion)
            return self._by_trees(page)

    def leave_out_guesses(self, guesses: str) -> None:
        """On request, exclude documents in which a value for a function of bodies is guessed."""
        if guesses == "no" and self.motion:
            groups = self.scope.groups()
            self.scope.narrow(without_guesses(self.tx, self.engine.caches, groups, self.motion, self.limits.check))

    def _on_columns(self, tree: Expression, page: Page) -> QueryAnswer:
        if self.query.constant is not None and self.per is None:
            self.explain.plan.append("a value that no document can change")
            return self._constant(page)
        if isinstance(tree, Written) and self.per is None:
            self._put_values(tree)
        if not self.query.has_columns:
            raise NotOnColumnsError
        if self.per == "document":
            return self._of_each(tree, page)
        call = aggregates.aggregated(tree)
        if call is not None and is_node_set(distinct_of(call) or call.arguments[0]):
            return self._aggregate(call, page)
        tree = self.whole.reduced(tree)
        # From here on, expressions that columns cannot answer contain the values of the whole scope.
        self.query = replace(self.query, tree=tree)
        if type_of(tree) == "nodes":
            return page.of(self.tx, self._nodes(tree), self.limits.max_elements)
        if asks_each(tree):
            return self._of_each(tree, page)
        parts = self.whole.parts(tree)
        if type_of(tree) in ("number", "string", "boolean"):
            values = [value for part in parts for value in part.values()]
            return QueryAnswer(type=_kind(tree), value=plain(values[0]) if values else None)
        if isinstance(tree, Call) and tree.function == "distinct-values":
            return page.of_values(self.tx, [value for part in parts for value in part.values()])
        return self._sequence(tree, parts, page)

    def _put_values(self, tree: Written) -> None:
        """Put the values of all documents that columns have into an expression that they do not answer."""
        asked = self.query

        def value_of(text: str) -> str | None:
            self.query = parse(text, dict(tree.variables))
            with suppress(TooWideError, TooLongError, NotOnColumnsError):
                value = self.whole.reduced(normal(self.query.tree))
                return to_xpath31(value, is_integer=is_integer(self.query.tree))
            return None

        if asked.compatible:
            self.query = replace(asked, tree=with_values(tree, ONE_VALUE, value_of))

    def _sequence(self, tree: Expression, parts: Iterable[Part], page: Page) -> QueryAnswer:
        if item_type(tree) == "nodes" or page.request.as_ != "json":
            return page.of(self.tx, Parts(parts), self.limits.max_elements)
        return page.of_parts(self.tx, parts, self.limits.max_elements)

    def _of_each(self, tree: Expression, page: Page) -> QueryAnswer:
        """One value a document, or its sequence."""
        found = self._column_source(tree)
        if type_of(tree) == "nodes":
            return page.of(self.tx, found, self.limits.max_elements)
        values = found.values()
        if values is not None:
            kind = kind_of_value(values[0]) if values else _kind(tree)
            return scalars(kind, found.documents, values)
        return self._sequence(tree, (Part(forest, items.column) for forest, items in found.items()), page)

    def explained(self, milliseconds: float) -> Explain:
        """How the answer came about."""
        self.explain.milliseconds = milliseconds
        if self.motion:
            self.explain.plan += body_steps(self.motion, self.bodies.documents)
        if self._scan is not None:
            self.explain.tracks_read = self._scan.tracks_read
            self.explain.tracks_skipped = self._scan.all_tracks() - self._scan.tracks_read
        return self.explain

    def nodes(self) -> Source:
        """The nodes of the whole expression."""
        tree = normal(self.query.tree)
        if self.per == "document":
            return self._column_source(tree)
        return self._nodes(self.whole.reduced(tree))

    def _nodes(self, tree: Expression) -> Source:
        alone = is_node_set(without_index(tree)[0])
        return self.whole.nodes(tree) if alone else Parts(self.whole.parts(tree))

    def source(self, tree: Expression) -> Scan | ColumnSource:
        """Where the nodes of an expression come from."""
        plan = None if self.motion else plan_scan(tree)
        if plan is None:
            return self._column_source(tree)
        scan = Scan(self.tx, plan, self.scope, self.engine.caches, self.limits.check, head_of(self.query.tree))
        self._explained("index", scan)
        return scan

    def _column_source(self, tree: Expression) -> ColumnSource:
        if not self.query.has_columns:
            raise NotOnColumnsError
        caches, check, whole = self.engine.caches, self.limits.check, head_of(self.query.tree)
        found = ColumnSource(self.tx, tree, self.scope, caches, check, self.bodies, whole, is_later=self.is_later)
        indexed = found.start is not None and found.start.indexed
        self._explained("index" if indexed else "columns", found)
        return found

    def _explained(self, way: Literal["index", "columns"], source: Scan | ColumnSource) -> None:
        if self.wants_explain:
            self._scan = source if isinstance(source, Scan) else None
            self.explain = Explain(way=way, plan=steps_of(source), documents=len(source.documents), milliseconds=0)

    def _aggregate(self, call: Call, page: Page) -> QueryAnswer:
        """A function around the whole, of all documents together."""
        different = distinct_of(call)
        source = self.source(different or call.arguments[0])
        self.explain.plan.append(f"{call.function} of {'the different ones' if different else 'them'}")
        if call.function == "distinct-values":
            return page.of_values(self.tx, aggregates.distinct(source))
        found = aggregates.value(call, source)
        return QueryAnswer(type=_kind(call), value=None if found is None else plain(found))

    def _constant(self, page: Page) -> QueryAnswer:
        """Return the value of an expression without documents."""
        found = value_of_nothing(self.query)
        values = [item for item in found.items if not isinstance(item, Found)]
        if found.total == 1 and values:
            return QueryAnswer(type=kind_of_value(values[0]), value=plain(values[0]))
        return page.of_values(self.tx, values)

    def _by_trees(self, page: Page) -> QueryAnswer:
        groups = list(self.bodies.select(self.scope.groups()))
        caches, alone = self.engine.caches, self.per == "document"
        source = Sequences(self.tx, caches, self.query, groups, self.limits, per_document=alone)
        self.explain.plan, self.explain.documents = [source.plan], len(source.documents)
        if page.request.as_ == "runs":
            return page.of_runs(self.tx, source.runs())
        if page.request.as_ == "json" and page.request.per is None:
            whole = source.aggregate()
            if whole is not None:
                return self._of_aggregate(*whole, page)
        found = source.page(page.offset, page.limit + 1)
        if found.single is not None:
            kind = kind_of_value(found.single[0][1])
            documents, values = [stored for stored, _ in found.single], [value for _, value in found.single]
            return QueryAnswer(type=kind, value=plain(values[0])) if source.is_one else scalars(kind, documents, values)
        some = found.items[: page.limit]
        items = [node_item(item) if isinstance(item, Node) else ValueItem(value=plain(item)) for item in some]
        answer = page.of_items(self.tx, items, more=len(found.items) > page.limit)
        return answer if items else answer.model_copy(update={"type": "nodes" if found.nodes else "values"})

    def _of_aggregate(self, function: str, value: object, page: Page) -> QueryAnswer:
        if isinstance(value, list):
            return page.of_values(self.tx, value)
        single: float | str | bool | None = value  # type: ignore[assignment]  # no list
        kind: Kind = "number" if single is None else kind_of_value(single)
        return QueryAnswer(type=kind, value=None if single is None else plain(single))


def _kind(tree: Expression) -> Kind:
    return type_of(tree)  # type: ignore[return-value]  # of a value
