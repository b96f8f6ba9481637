"""Functions around a whole expression that make one value of the nodes of all documents together."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mcml.errors import LimitError
from mcml_service.xpath.engine.column_source import ColumnSource
from mcml_service.xpath.engine.functions import NotOnColumnsError
from mcml_service.xpath.engine.scan import Scan
from mcml_service.xpath.engine.values import MAX_TEXT, numbers, strings
from mcml_service.xpath.language.tree import Call, Expression, Literal
from mcml_service.xpath.language.types import distinct_of, type_of
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import Floats, Ints
from mcml_service.xpath.nodes.texts import Strings

NUMBER_AGGREGATES = frozenset({"count", "sum", "min", "max", "avg"})
TRUTH_AGGREGATES = frozenset({"exists", "empty"})


def aggregated(tree: Expression) -> Call | None:
    """The call, if the expression is an aggregate of a node set."""
    if not isinstance(tree, Call) or not tree.arguments:
        return None
    joins = tree.function == "string-join" and all(isinstance(each, Literal) for each in tree.arguments[1:])
    functions = NUMBER_AGGREGATES | TRUTH_AGGREGATES | {"distinct-values"}
    if joins or (tree.function in functions and len(tree.arguments) == 1):
        inner = distinct_of(tree) or tree.arguments[0]
        return tree if type_of(inner) == "nodes" else None
    return None


def value(call: Call, source: Scan | ColumnSource) -> float | str | bool | None:
    """The value of a call that is `aggregated`, but of distinct-values; None for the least, greatest or mean of
    nothing. source: of the nodes. NotOnColumnsError for the least and its like of texts that are no numbers."""
    if call.function == "string-join":
        return joined(call, source)
    if call.function in TRUTH_AGGREGATES:
        return exists(source) == (call.function == "exists")
    if distinct_of(call) is not None:
        return float(len(distinct(source)))
    found = _number(call.function, source)
    if found is not None and math.isnan(found) and call.function in ("min", "max", "avg"):
        raise NotOnColumnsError
    return found


def _number(function: str, source: Scan | ColumnSource) -> float | None:
    """`count`, `sum`, `min`, `max` or `avg`."""
    if function == "count":
        return float(source.count())
    sample = source.plan.sample if isinstance(source, Scan) else None
    if isinstance(source, Scan) and sample is not None and function in ("sum", "avg"):
        total, count = source.totals(sample)
        return total if function == "sum" else total / count if count else None
    total, count = 0.0, 0
    least, greatest = math.inf, -math.inf
    for found in _numbers(function, source):
        if not len(found):
            continue
        count += len(found)
        total += float(found.sum())
        # NaN stays NaN: a text that is no number spoils all.
        least, greatest = float(np.minimum(least, found.min())), float(np.maximum(greatest, found.max()))
    if function == "sum":
        return total
    if not count:
        return None
    return {"min": least, "max": greatest, "avg": total / count}[function]


def _numbers(function: str, source: Scan | ColumnSource) -> Iterator[Floats]:
    """The numbers of the nodes; for the least or the greatest of samples, that alone."""
    if isinstance(source, Scan) and source.plan.sample is not None:
        yield from source.extremes(source.plan.sample, greatest=function == "max")
        return
    for forest, nodes in source.chunks():
        yield numbers(forest, nodes)


def exists(source: Scan | ColumnSource) -> bool:
    return any(len(nodes) for _, nodes in _examples(source))


def _examples(source: Scan | ColumnSource) -> Iterator[tuple[Forest, Ints]]:
    return source.examples() if isinstance(source, ColumnSource) else source.chunks()


def distinct(source: Scan | ColumnSource) -> list[str]:
    """The different strings of the nodes, in order of their first node."""
    found: dict[str, None] = {}
    for forest, nodes in _examples(source):
        found.update(dict.fromkeys(_in_order(strings(forest, nodes))))
    return list(found)


def joined(call: Call, source: Scan | ColumnSource) -> str:
    """The strings of the nodes, or the different ones, one after the other."""
    between = call.arguments[1].value if len(call.arguments) > 1 and isinstance(call.arguments[1], Literal) else ""
    parts: list[str] = []
    size = 0
    once = distinct_of(call) is not None
    for some in [distinct(source)] if once else (strings(*chunk).list() for chunk in source.chunks()):
        size += sum(map(len, some)) + len(some) * len(str(between))
        if size > MAX_TEXT:
            raise LimitError("The text is too long.", remedy="Join fewer nodes.", code="query-too-large")
        parts += some
    return str(between).join(parts)


def _in_order(column: Strings) -> list[str]:
    codes, first = np.unique(column.codes, return_index=True)
    return [column.values[code] for code in codes[np.argsort(first)].tolist()]
