"""Evaluate expressions without columns over a scope, document by document."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from mcml.errors import QueryError
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.functions import AGGREGATES
from mcml_service.xpath.language.labels import without_index
from mcml_service.xpath.language.motion_functions import PREFIX, RUNS
from mcml_service.xpath.language.parse import Query
from mcml_service.xpath.language.reach import Projection, projection
from mcml_service.xpath.language.tree import Atomic, Call, Literal, Written
from mcml_service.xpath.language.types import type_of
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.language.xpath31.numeric import add_up
from mcml_service.xpath.language.xpath31.scope import Scope
from mcml_service.xpath.language.xpath31.written import find_projection, find_scope
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.node import Node, Run
from mcml_service.xpath.trees.body_values import BodyValues, Values
from mcml_service.xpath.trees.evaluate import NOTHING, Found, Items, Tree
from mcml_service.xpath.trees.projected import Xml, runs_of_nodes

PARTS = {
    Projection.HEAD: "without frames",
    Projection.FRAMES: "without the bones of frames",
    Projection.WHOLE: "whole",
}
MOST = 1_000_000
"""Limit of values of an expression without documents."""


@dataclass(frozen=True)
class Answer:
    """single: one value of each document. nodes: whether all items are."""

    items: list[Node | Atomic]
    nodes: bool
    single: list[tuple[Listed, Atomic]] | None = None


class Sequences:
    """The answer of an expression over a scope.

    together: whether all documents must be in memory at once. each: whether every document has its own answer.
    is_one: whether the expression has one value for all of them, not one for each. asked: the documents for each of
    which it is evaluated.
    """

    def __init__(
        self,
        tx: Transaction,
        caches: Caches,
        query: Query,
        groups: Sequence[Group],
        limits: Limits,
        *,
        per_document: bool = False,
    ) -> None:
        self.limits = limits
        self.compatible = query.compatible
        self.documents = list(chain.from_iterable(groups))
        inner, self.nth = without_index(query.tree)
        query = replace(query, tree=inner)
        self.tree = query.tree
        self.text = query.text
        self.xml = Xml(tx, limits, _projection(query))
        self.variables = dict(self.tree.variables) if isinstance(self.tree, Written) else {}
        self.bodies = BodyValues(tx, caches, groups, limits)
        scope = scope_of(query, len(self.documents), per_document=per_document)
        self.together, self.each = scope.together, scope.each
        self.is_one = self.together and not self.each
        self.asked = self.documents[:1] if self.is_one else self.documents
        self._last: tuple[Listed, Tree] | None = None

    @property
    def plan(self) -> str:
        """How the documents are read, for people."""
        order = "all together" if self.together else "one after the other"
        return f"the documents as trees, {order}, {PARTS[self.xml.projection]}"

    def aggregate(self) -> tuple[str, Atomic | list[Atomic] | None] | None:
        """(function, value) where the outermost function makes one value of all documents; None where it is another.

        The value is a list for distinct-values, and None for the least, greatest or mean of nothing.
        """
        function, arguments = self._call()
        if not function or self.each:
            return None
        if function in ("count", "sum", "exists", "empty"):
            each = [self._one(stored, self.text) for stored in self.asked]
            if function in ("count", "sum"):
                return function, float(add_up(float(value) for value in each))
            return function, any(each) if function == "exists" else all(each)
        if function == "avg":
            pairs = [self._all(stored, f"(sum({arguments[0]}), count({arguments[0]}))") for stored in self.asked]
            count = sum(float(pair[1]) for pair in pairs)
            return function, add_up(float(pair[0]) for pair in pairs) / count if count else None
        if function in ("min", "max"):
            values = [value for stored in self.asked for value in self._all(stored, self.text)]
            return function, _extreme(function, values)
        if function == "distinct-values":
            return function, list(dict.fromkeys(v for stored in self.asked for v in self._all(stored, self.text)))
        first = self.asked[:1] if len(arguments) > 1 else []
        between = "".join(str(self._one(stored, f"string({arguments[1]})")) for stored in first)
        texts = [self._all(stored, f"for $i in ({arguments[0]}) return string($i)") for stored in self.asked]
        return function, between.join(str(text) for some in texts for text in some)

    def page(self, offset: int, limit: int) -> Answer:
        """Items offset … offset + limit - 1 of all documents' sequences, one after the other."""
        if self.nth is not None:
            offset, limit = (self.nth - 1, 1) if offset == 0 else (0, 0)
        items: list[Node | Atomic] = []
        single: list[tuple[Listed, Atomic]] | None = [] if offset == 0 else None
        for stored in self.asked:
            found = self._evaluate(stored, self.text, offset, max(1, limit - len(items)))
            only = found.items[0] if found.total == 1 and found.items else None
            if single is not None and only is not None and not isinstance(only, Found):
                single.append((stored, only))
            else:
                single = None
            items += [self._shown(stored, item) for item in found.items][: limit - len(items)]
            offset = max(0, offset - found.total)
            if len(items) >= limit and single is None:
                break
        nodes = all(isinstance(item, Node) for item in items) if items else self._gives_nodes()
        return Answer(items, nodes, single or None)

    def runs(self) -> Iterator[Run]:
        """Yield maximal ranges of the nodes' frames."""
        return runs_of_nodes(self._nodes_by_document())

    def _nodes_by_document(self) -> Iterator[tuple[Listed, Sequence[Node | Found]]]:
        if self.nth is not None or self.together:
            found = self.page(0, 1 if self.nth is not None else self.limits.max_elements)
            of: dict[int, list[Node]] = {stored.key: [] for stored in self.documents}
            for node in found.items:
                if isinstance(node, Node):
                    of[node.stored.key].append(node)
            yield from ((stored, of[stored.key]) for stored in self.documents)
            return
        for stored in self.asked:
            each = self._evaluate(stored, self.text, 0, self.limits.max_elements)
            yield stored, [item for item in each.items if isinstance(item, Found)]

    def _gives_nodes(self) -> bool:
        return self.tree.nodes if isinstance(self.tree, Written) else type_of(self.tree) == "nodes"

    def _call(self) -> tuple[str, Sequence[str]]:
        """The outermost function, if it is an aggregate, and the texts of its arguments."""
        tree = self.tree
        if isinstance(tree, Written):
            return tree.function, tree.arguments
        if isinstance(tree, Call) and tree.function in AGGREGATES and self.nth is None:
            separator = tree.arguments[1:]
            if all(isinstance(each, Literal) for each in separator):
                return tree.function, [unparse(argument) for argument in tree.arguments]
        return "", ()

    def _one(self, stored: Listed, text: str) -> Atomic:
        return self._all(stored, text)[0]

    def _all(self, stored: Listed, text: str) -> list[Atomic]:
        found = self._evaluate(stored, text, 0, self.limits.max_elements)
        return [item for item in found.items if not isinstance(item, Found)]

    def _evaluate(self, stored: Listed, text: str, offset: int, limit: int) -> Items:
        self.limits.check()
        tree = self._tree(stored)
        place = self.documents.index(stored) if self.together else 0

        def ask(text: str, variables: Values) -> Items:
            return tree.items(
                text, variables=variables, offset=offset, limit=limit, compatible=self.compatible, document=place
            )

        return self.bodies.answer(ask, text, self.variables, self.documents if self.together else [stored])

    def _tree(self, stored: Listed) -> Tree:
        """Return the tree of a document, or of all; the last one is cached for repeated use."""
        if self._last is None or (self._last[0] is not stored and not self.together):
            self._last = stored, Tree(self.xml.of_all(self.documents if self.together else [stored]))
        return self._last[1]

    def _shown(self, stored: Listed, item: Found | Atomic) -> Node | Atomic:
        if not isinstance(item, Found):
            return item
        return Node(item.kind, self.documents[item.document] if self.together else stored, item.address, item.value)


def _projection(query: Query) -> Projection:
    if isinstance(query.tree, Written):
        return find_projection(query.text, compatible=query.compatible)
    return projection(query.tree)


def scope_of(query: Query, documents: int, *, per_document: bool) -> Scope:
    """The scope of an expression over this number of documents. Raises QueryError where an expression needs all of them
    for a value of each, or for runs, and has functions of bodies.
    """
    scope = find_scope(query.text, compatible=query.compatible)
    if documents < 2 or per_document:
        return replace(scope, together=False)
    if scope.together and PREFIX in query.text and (scope.each or RUNS in query.text):
        raise QueryError(
            "This combines all documents, but contains a function of bodies that is evaluated on one document at a "
            "time.",
            remedy="Ask with per=document, or one document; or write it without casts, maps and inline functions.",
            code="needs-one-document",
        )
    return scope


def value_of_nothing(query: Query) -> Items:
    """Return the value of an expression without documents."""
    assert query.constant is not None
    text, variables = query.constant.text, dict(query.constant.variables)
    return Tree([[NOTHING]]).items(text, variables=variables, offset=0, limit=MOST, compatible=query.compatible)


def _extreme(function: str, values: Sequence[Atomic]) -> Atomic | None:
    if not values:
        return None
    if any(isinstance(value, float) and math.isnan(value) for value in values):
        return math.nan
    chosen: Atomic = min(values) if function == "min" else max(values)
    return chosen
