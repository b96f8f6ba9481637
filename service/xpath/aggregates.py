"""Functions around a whole expression that make one value of the nodes of all documents together."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from service.xpath.columnar import Columnar
from service.xpath.numbering import Floats
from service.xpath.scan import Scan
from service.xpath.texts import Strings
from service.xpath.tree import Call, Expression, type_of
from service.xpath.values import numbers, strings

NUMBER_AGGREGATES = frozenset({"count", "sum", "min", "max", "avg"})
TRUTH_AGGREGATES = frozenset({"exists", "empty"})


def aggregated(tree: Expression) -> Call | None:
    """The call, if the expression is an aggregate of a node set."""
    functions = NUMBER_AGGREGATES | TRUTH_AGGREGATES | {"distinct-values"}
    if isinstance(tree, Call) and tree.function in functions and len(tree.arguments) == 1:
        return tree if type_of(tree.arguments[0]) == "nodes" else None
    return None


def number(function: str, source: Scan | Columnar) -> float | None:
    """`count`, `sum`, `min`, `max` or `avg`; None for the least, greatest or mean of nothing."""
    if function == "count":
        return float(source.count())
    total, count = 0.0, 0
    least, greatest = math.inf, -math.inf
    for found in _numbers(source):
        count += len(found)
        total += float(found.sum())
        # NaN stays NaN: a text that is no number spoils all.
        least, greatest = float(np.minimum(least, found.min())), float(np.maximum(greatest, found.max()))
    if function == "sum":
        return total
    if not count:
        return None
    return {"min": least, "max": greatest, "avg": total / count}[function]


def _numbers(source: Scan | Columnar) -> Iterator[Floats]:
    sample = source.plan.sample if isinstance(source, Scan) else None
    if isinstance(source, Scan) and sample is not None:
        yield from source.samples(sample)
        return
    for forest, nodes in source.chunks():
        yield numbers(forest, nodes)


def exists(source: Scan | Columnar) -> bool:
    return any(len(nodes) for _, nodes in source.chunks())


def distinct(source: Scan | Columnar) -> list[str]:
    """The different strings of the nodes, in order of their first node."""
    found: dict[str, None] = {}
    for forest, nodes in source.chunks():
        found.update(dict.fromkeys(_in_order(strings(forest, nodes))))
    return list(found)


def _in_order(column: Strings) -> list[str]:
    codes, first = np.unique(column.codes, return_index=True)
    return [column.values[code] for code in codes[np.argsort(first)].tolist()]
