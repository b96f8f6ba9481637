"""libxml2's answers, and the comparison of the engine's with them.

libxml2 reads decimals with an error of up to some units in the last place; the engine reads them exactly. Where the
answers differ, libxml2 is asked again with numbers that are read exactly (`exact`): everything but `number()` is still
its own, so only a difference that lies in those last places is excused.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any

from lxml import etree

from mcml_schemas.querying.queries import NodeItem, QueryAnswer, QueryRequest, RunItem, ScalarItem
from mcml_service.xpath.language.labels import without_index
from mcml_service.xpath.language.parse import Query, parse
from mcml_service.xpath.language.scopes import is_node_set
from mcml_service.xpath.language.tree import (
    Call,
    Expression,
    Filter,
    Later,
    Literal,
    Operation,
    Path,
    Written,
    children,
    walk,
    with_children,
)
from mcml_service.xpath.language.types import type_of
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.nodes.texts import to_number
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.trees.evaluate import Addresses
from tests.xpath.libxml2 import describe, namespace_owners

Trees = Mapping[str, Any]
WIDE = ("descendant", "descendant-or-self", "following", "preceding", "following-sibling", "preceding-sibling")
ARITHMETIC = ("+", "-", "*", "div", "mod", "negate")
RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
_NAMESPACE = "urn:exact"


class DifferenceError(AssertionError):
    """The engine's answer is not libxml2's."""


@dataclass(frozen=True)
class Outcome:
    """way: as explained. filled: the answer is not empty. excused: only the last places of numbers decide."""

    way: str
    filled: bool
    excused: bool = False


def width(expression: Expression) -> int:
    """How often the work of libxml2 may multiply with the length of a document."""
    own = 0
    if isinstance(expression, Path):
        own = max(int(expression.absolute), sum(step.axis in WIDE for step in expression.steps))
    return own + max((width(child) for child in children(expression)), default=0)


def most_elements(expression: Expression) -> int:
    """How large a document may be, so that libxml2 answers in seconds, not in hours."""
    return {0: 10**9, 1: 10**9, 2: 1200, 3: 130, 4: 60, 5: 30}.get(width(expression), 25)


def check(
    engine: Queries, trees: Trees, text: str, random: Random, *, relative: bool = False, whole: bool = False
) -> Outcome | None:
    """Compares the answers over documents, in pages and as runs. None where libxml2 refuses the expression.

    relative: whether paths in the text start at the document without a slash, which libxml2 must be told. whole: the
    documents are all there are, and the engine is asked without naming them.
    """
    query = parse(text)
    if counts_over_all(query.tree):
        # libxml2 knows one document, so it is asked about one.
        trees, whole = dict([random.choice(list(trees.items()))]), False
    asked = query.text if relative or query.warnings else text
    try:
        together = _together(query.tree, trees) if len(trees) > 1 else query.tree
        if together != query.tree:
            query = Query(together, query.warnings)
            asked = query.text
        wanted = _answer(query, trees, asked)
    except etree.XPathError:
        return None
    uuids = [] if whole else list(trees)
    explained = engine.answer(QueryRequest(q=text, document=uuids, limit=1, explain=True)).explain
    way = explained.way if explained is not None else ""
    try:
        filled = _compare(engine, query, text, uuids, wanted, random)
    except DifferenceError:
        wanted = _answer(query, trees, unparse(exact(query.tree)), _extensions())
        return Outcome(way, _compare(engine, query, text, uuids, wanted, random), excused=True)
    return Outcome(way, filled)


def counts_over_all(tree: Expression) -> bool:
    """Whether a predicate behind parentheses counts the nodes of all documents, other than one number around all."""
    inner, _ = without_index(tree)
    filters = [part for part in walk(inner) if isinstance(part, Filter)]
    return any(is_node_set(each.operand) and not is_node_set(each) for each in filters)


# -- what libxml2 says -------------------------------------------------------------------------------------------------


def _answer(query: Query, trees: Trees, text: str, extensions: Any = None) -> list[tuple[str, Any]]:
    """Of each document its value, or (kind, address, value) of each node."""
    ask = etree.XPath(text, extensions=extensions, namespaces={"m": _NAMESPACE} if extensions else None)
    result: list[tuple[str, Any]] = []
    for uuid, tree in trees.items():
        value: Any = ask(tree)
        if isinstance(value, list):
            addresses = Addresses()
            owners = namespace_owners(tree, query.text) if any(isinstance(node, tuple) for node in value) else iter(())
            value = [tuple(describe(node, addresses, owners)) for node in value]
        result.append((uuid, value))
    inner, nth = without_index(query.tree)
    if nth is not None and len(trees) > 1:
        # The position counts over all documents together.
        return _nth(inner, nth, trees)
    return result


def _together(tree: Expression, trees: Trees, *, inside: bool = False) -> Expression:
    """With the counts and sums of all documents in the place of those that stand in it, predicates aside.

    Raises XPathError for a sum of fractions, whose last places depend on the order of its summands.
    """
    if isinstance(tree, Path | Filter):
        return tree
    if inside and isinstance(tree, Call) and tree.function in ("count", "sum") and not is_constant(tree):
        found = [float(each.xpath(unparse(tree))) for each in trees.values()]
        if not all(value.is_integer() and abs(value) < 2**50 for value in found):
            raise etree.XPathEvalError("a sum of fractions")
        return Literal(sum(found))
    return with_children(tree, lambda part: _together(part, trees, inside=True))


def _nth(inner: Expression, nth: int, trees: Trees) -> list[tuple[str, Any]]:
    left = nth
    for uuid, tree in trees.items():
        found = tree.xpath(unparse(inner))
        total = int(tree.xpath(f"count({unparse(inner)})"))
        if left <= total:
            # lxml leaves the document node, always the first, out of its lists.
            left -= total - len(found)
            return [(uuid, [tuple(describe(found[left - 1], Addresses()))] if left else [])]
        left -= total
    return []


def exact(expression: Expression) -> Expression:
    """The expression with numbers read exactly, wherever it makes numbers of strings or compares them."""
    if isinstance(expression, Literal):
        fraction = isinstance(expression.value, float) and not expression.value.is_integer()
        return Call("m:literal", (Literal(repr(expression.value)),)) if fraction else expression
    if isinstance(expression, Operation) and expression.operator in RELATIONS:
        first, *others = (exact(operand) for operand in expression.operands)
        for other in others:
            first = Call("m:compare", (Literal(expression.operator), first, other))
        return first
    kinds = [type_of(child) for child in children(expression)]
    made = with_children(expression, exact)
    if isinstance(made, Operation) and made.operator in ARITHMETIC:
        return Operation(made.operator, tuple(map(_number, made.operands, kinds)))
    if isinstance(made, Call) and made.function in ("number", "floor", "ceiling", "round"):
        argument = _number(made.arguments[0], kinds[0]) if kinds else _number(Path(()), "nodes")
        return Call(made.function, (argument,))
    if isinstance(made, Call) and made.function == "sum":
        return Call("m:sum", made.arguments)
    if isinstance(made, Call) and made.function == "substring":
        return Call("substring", (made.arguments[0], *map(_number, made.arguments[1:], kinds[1:])))
    return made


def _number(expression: Expression, kind: str) -> Expression:
    if kind not in ("nodes", "string"):
        return expression
    return Call("m:number", (Call("string", (expression,)),))


def _extensions() -> dict[tuple[str, str], Callable[..., Any]]:
    return {
        (_NAMESPACE, "number"): lambda _, text: to_number(str(text)),
        (_NAMESPACE, "literal"): lambda _, text: float(text),
        (_NAMESPACE, "sum"): lambda _, nodes: float(sum(to_number(_string(node)) for node in nodes)),
        (_NAMESPACE, "compare"): lambda _, sign, one, other: _holds(str(sign), one, other),
    }


def _string(node: Any) -> str:
    if isinstance(node, tuple):
        return str(node[1])
    return str(node) if isinstance(node, str) else "".join(node.itertext())


def _holds(sign: str, one: Any, other: Any) -> bool:
    """XPath 1.0 §3.4."""
    if isinstance(one, bool) or isinstance(other, bool):
        if sign in ("=", "!="):
            return RELATIONS[sign](bool(one), bool(other))
        one = float(bool(one)) if isinstance(one, bool | list) else one
        other = float(bool(other)) if isinstance(other, bool | list) else other
    left = [_string(node) for node in one] if isinstance(one, list) else [one]
    right = [_string(node) for node in other] if isinstance(other, list) else [other]
    texts = sign in ("=", "!=") and all(isinstance(value, str) for value in (*left, *right))
    if not texts:
        left = [to_number(value) if isinstance(value, str) else value for value in left]
        right = [to_number(value) if isinstance(value, str) else value for value in right]
    return any(RELATIONS[sign](a, b) for a in left for b in right)


# -- what the engine says ----------------------------------------------------------------------------------------------


def _compare(
    engine: Queries, query: Query, text: str, uuids: list[str], wanted: list[tuple[str, Any]], random: Random
) -> bool:
    """Whether the answer, which is the one wanted, is not empty."""
    if type_of(query.tree) != "nodes":
        return _compare_values(engine, query, text, uuids, wanted)
    nodes = [(uuid, *node) for uuid, value in wanted for node in value]
    limit = random.choice([1, 2, 5, 13, 1000]) if len(nodes) < 40 else random.choice([60, 500, 1000])
    items = [item for answer in pages(engine, text, uuids, limit) for item in answer.items or []]
    got = [(i.document, i.kind, i.address, plain(i.kind, i.value)) for i in items if isinstance(i, NodeItem)]
    found = [item for item in got if item[1] != "document"]
    nodes = [(uuid, kind, address, plain(kind, value)) for uuid, kind, address, value in nodes]
    if "namespace::" in query.text:
        # libxml2 does not know where namespace nodes stand, nor what it reaches from them.
        found, nodes = sorted(found), sorted(nodes)
    same(found, nodes, text)
    if got and all(address.startswith("/mcml/motion/frame[") for _, _, address, _ in got):
        _compare_runs(engine, text, uuids, [(uuid, address) for uuid, _, address, _ in got], limit)
    return bool(got)


def _compare_values(engine: Queries, query: Query, text: str, uuids: list[str], wanted: list[tuple[str, Any]]) -> bool:
    answer = engine.answer(QueryRequest(q=text, document=uuids))
    values = [value for _, value in wanted]
    tree = query.tree
    if len(wanted) > 1 and isinstance(tree, Call) and tree.function in ("count", "sum") and not is_constant(tree):
        same_value(number(answer.value), float(sum(values)), text)
        return True
    if answer.items is None:
        # One document, or a value that is the same in all.
        for value in values:
            same_value(number(answer.value) if isinstance(value, float) else answer.value, value, text)
    else:
        found = [(item.document, item.value) for item in answer.items if isinstance(item, ScalarItem)]
        same([uuid for uuid, _ in found], [uuid for uuid, _ in wanted], text)
        for (_, got), value in zip(found, values, strict=True):
            same_value(number(got) if isinstance(value, float) else got, value, text)
    return any(
        value == value if isinstance(value, float) and not isinstance(value, bool) else value for value in values
    )


def _compare_runs(engine: Queries, text: str, uuids: list[str], inside: list[tuple[str, str]], limit: int) -> None:
    runs = [item for answer in pages(engine, text, uuids, limit, "runs") for item in answer.items or []]
    hit = {(uuid, int(address.split("[")[1].split("]")[0])) for uuid, address in inside}
    covered = [(r.document, n) for r in runs if isinstance(r, RunItem) for n in range(r.first, r.last + 1)]
    same(sorted(covered), sorted(hit), text)
    same([r for r in runs if isinstance(r, RunItem) and (r.document, r.last + 1) in hit], [], text)


def pages(
    engine: Queries, text: str, uuids: list[str], limit: int, form: str = "json", per: str | None = None
) -> list[QueryAnswer]:
    """The answers of all pages."""
    result: list[QueryAnswer] = []
    cursor = None
    while not result or cursor is not None:
        answer = engine.answer(
            QueryRequest(q=text, document=uuids, limit=limit, cursor=cursor, per=per, **{"as": form})
        )
        same(len(answer.items or []) <= limit or answer.type not in ("nodes", "runs"), True, text)
        result.append(answer)
        cursor = answer.next_cursor
    return result


def plain(kind: str, value: str) -> str:
    if kind not in ("element", "document"):
        return value
    return etree.tostring(etree.fromstring(value), method="c14n2").decode()


def number(value: Any) -> Any:
    """A number of an answer; NaN and infinities are texts there."""
    special = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
    return special.get(value, value) if isinstance(value, str) else value


def same(got: Any, wanted: Any, text: str) -> None:
    if got != wanted:
        size = ""
        if isinstance(got, list) and isinstance(wanted, list):
            size = f" ({len(got)} and {len(wanted)} items)"
            start = next((n for n, pair in enumerate(zip(got, wanted, strict=False)) if pair[0] != pair[1]), 0)
            got, wanted = got[start : start + 5], wanted[start : start + 5]
        raise DifferenceError(f"{text}{size}\n  the engine: {str(got)[:600]}\n  the oracle: {str(wanted)[:600]}")


def same_value(got: Any, wanted: Any, text: str) -> None:
    if isinstance(got, float) and isinstance(wanted, float) and not isinstance(got, bool):
        close = got == wanted or abs(got - wanted) <= 1e-12 * max(abs(got), abs(wanted))
        if close or (got != got and wanted != wanted):
            return
    if isinstance(got, bool) != isinstance(wanted, bool) or isinstance(got, str) != isinstance(wanted, str):
        raise DifferenceError(f"{text}: {got!r} and {wanted!r} are of two types")
    same(got, wanted, text)


def is_constant(expression: Expression) -> bool:
    """Whether the value is the same in every document: no path, and no function that looks at the context node."""
    return not any(
        isinstance(part, Path | Filter | Written | Later)
        or (isinstance(part, Call) and (part.function in {"id", "lang", "position", "last"} or not _given(part)))
        for part in walk(expression)
    )


def _given(call: Call) -> bool:
    return bool(call.arguments) or call.function in ("true", "false")
