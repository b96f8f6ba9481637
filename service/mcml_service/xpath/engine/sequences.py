"""Functions of node sets and sequences on columns, for the items of each context.

XPath 1.0 §4.1, §4.4; XPath 2.0 and 3.1 Functions and Operators §14.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mcml_service.xpath.engine import values
from mcml_service.xpath.engine.context import Value
from mcml_service.xpath.engine.functions import NotOnColumnsError, arithmetic, as_numbers, as_strings
from mcml_service.xpath.language import regular
from mcml_service.xpath.language.functions import round_half_up
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.items import Column, Items
from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import MAX_PAIRS, TooWideError, bounded, expand
from mcml_service.xpath.nodes.samples import Samples
from mcml_service.xpath.nodes.texts import Strings, of_numbers, of_texts


def items_of(value: Value) -> Items:
    """The items of each context."""
    if isinstance(value, Items):
        return value
    if isinstance(value, NodeSets):
        flat, _ = value.flat()
        return Items(flat.groups, flat.nodes, flat.count)
    if isinstance(value, Samples):
        raise NotOnColumnsError
    return Items(np.arange(len(value)), value, len(value))


def value_of(items: Items) -> Value:
    """Return the items as a value; nodes become a node set, which keeps their order."""
    if items.kind == "nodes" and not isinstance(items.column, Strings):
        return NodeSets(items.groups, items.column.astype(np.int64, copy=False), items.count)
    return items


def texts(forest: Forest, items: Items, write: Callable[[Floats], Strings] = of_numbers) -> Strings:
    """Each item as a text. write: numbers."""
    if isinstance(items.column, Strings):
        return items.column
    if items.kind == "nodes":
        return values.strings(forest, _nodes(items))
    return write(_floats(items)) if items.kind == "number" else as_strings(forest, items.column.astype(bool))


def numbers(forest: Forest, items: Items) -> Floats:
    """Each item as a number, as comparisons have it."""
    if items.kind == "nodes":
        return values.numbers(forest, _nodes(items))
    return as_numbers(forest, items.column)  # type: ignore[arg-type]  # no node


def call(forest: Forest, name: str, arguments: Sequence[Value]) -> Value:
    """A function whose first argument is a sequence."""
    first = arguments[0]
    if isinstance(first, NodeSets) and name in ("count", "exists", "empty", "sum"):
        # A set that several contexts share is looked at once.
        if name == "count":
            return first.counts()
        if name == "sum":
            return first.sums(values.numbers(forest, first.nodes))
        return first.exist() if name == "exists" else ~first.exist()
    if isinstance(first, NodeSets) and name in _EXTREMES:
        return _of_set(forest, name, first)
    return _FUNCTIONS[name](forest, items_of(first), arguments[1:])


def call_on_bodies(forest: Forest, name: str, arguments: Sequence[Value]) -> Value:
    """The same for numbers of bodies in motion: the least or greatest of unknown values is NaN.

    Elsewhere NaN may mean an XPath error, or an empty sequence.
    """
    items = items_of(arguments[0])
    if name not in ("min", "max") or items.kind != "number":
        return call(forest, name, arguments)
    sets, found = items.sets, _added(forest, items)
    extremes = sets.least(found) if name == "min" else sets.greatest(found)
    return some_of(np.where(sets.any(np.isnan(found)), np.nan, extremes), sets.exist())


def takes(name: str) -> bool:
    """Whether it is such a function."""
    return name in _FUNCTIONS


def _of_set(forest: Forest, name: str, sets: NodeSets) -> Value:
    """`min`, `max`, `avg` of nodes. A text that is no number is an error there."""
    found = values.numbers(forest, sets.nodes)
    if np.isnan(found).any():
        raise NotOnColumnsError
    if name == "avg":
        return some_of(arithmetic("div", sets.sums(found), sets.counts()), sets.exist())
    return some_of(sets.least(found) if name == "min" else sets.greatest(found), sets.exist())


def some_of(found: Floats, exist: Bools) -> Value:
    """A number for each context; nothing for those of an empty sequence."""
    return found if exist.all() else Items(np.flatnonzero(exist), found[exist], len(exist))


def _count(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return items.sets.counts()


def _exists(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return items.sets.exist()


def _empty(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return ~items.sets.exist()


def _sum(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return items.sets.sums(_added(forest, items))


def _avg(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    sets = items.sets
    return some_of(arithmetic("div", sets.sums(_added(forest, items)), sets.counts()), sets.exist())


def _added(forest: Forest, items: Items) -> Floats:
    if len(items) and items.kind not in ("number", "nodes"):
        raise NotOnColumnsError
    return numbers(forest, items)


def _extreme(forest: Forest, items: Items, *, least: bool) -> Value:
    sets = items.sets
    if isinstance(items.column, Strings):
        ordered = sorted(set(items.column.values))
        place = {text: number for number, text in enumerate(ordered)}
        ranks = np.array([place[text] for text in items.column.values], np.float64)[items.column.codes]
        found = sets.least(ranks) if least else sets.greatest(ranks)
        exist = np.flatnonzero(sets.exist())
        return Items(exist, Strings(found[exist].astype(np.int64), ordered), items.count)
    found = _added(forest, items)
    if np.isnan(found).any():
        raise NotOnColumnsError
    return some_of(sets.least(found) if least else sets.greatest(found), sets.exist())


def _distinct(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    column: Column = values.strings(forest, _nodes(items)) if items.kind == "nodes" else items.column
    chosen = Items(items.groups, column, items.count)
    if isinstance(column, Strings):
        codes = of_texts(column.values).codes[column.codes] if len(column) else column.codes
    else:
        # Equal numbers are one value; so are 0 and -0, and all NaN.
        codes = np.unique(column, return_inverse=True)[1].reshape(-1)
    key = items.groups * (int(codes.max(initial=0)) + 1) + codes
    return chosen.chosen(np.sort(np.unique(key, return_index=True)[1]))


def _joined(forest: Forest, items: Items, others: Sequence[Value]) -> Value:
    between = as_strings(forest, others[0]).list() if others else [""] * items.count
    parts: list[list[str]] = [[] for _ in range(items.count)]
    for group, text in zip(items.groups.tolist(), texts(forest, items).list(), strict=True):
        parts[group].append(text)
    return of_texts([between[group].join(part) for group, part in enumerate(parts)])


def _data(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    if items.kind != "nodes":
        return items
    return Items(items.groups, values.strings(forest, _nodes(items)), items.count)


def _reverse(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return value_of(items.chosen(np.lexsort((-np.arange(len(items)), items.groups))))


def _head(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return value_of(items.chosen(items.positions()[0] == 1))


def _tail(forest: Forest, items: Items, _: Sequence[Value]) -> Value:
    return value_of(items.chosen(items.positions()[0] > 1))


def _subsequence(forest: Forest, items: Items, others: Sequence[Value]) -> Value:
    at = items.positions()[0]
    begin = round_half_up(as_numbers(forest, others[0]))
    kept = at >= begin[items.groups]
    if len(others) > 1:
        kept &= at < arithmetic("+", begin, round_half_up(as_numbers(forest, others[1])))[items.groups]
    return value_of(items.chosen(kept))


def _remove(forest: Forest, items: Items, others: Sequence[Value]) -> Value:
    return value_of(items.chosen(items.positions()[0] != as_numbers(forest, others[0])[items.groups]))


def _index_of(forest: Forest, items: Items, others: Sequence[Value]) -> Value:
    wanted = items_of(others[0])
    kinds = {"string" if each.kind == "nodes" else each.kind for each in (items, wanted) if len(each)}
    if len(kinds) > 1 or len(wanted) != wanted.count:
        raise NotOnColumnsError
    if kinds == {"number"}:
        equal = _floats(items) == _floats(wanted)[items.groups]
    else:
        sought = np.array(texts(forest, wanted).list(), object)
        equal = np.array(texts(forest, items).list(), object) == sought[items.groups]
    found = items.chosen(np.asarray(equal, bool))
    return Items(found.groups, items.positions()[0][np.asarray(equal, bool)], items.count)


def sorted_by(forest: Forest, items: Items, key: Value) -> Value:
    """The items of each context in the order of their keys, each of which is one item or nothing, which comes first."""
    keys = items_of(key)
    if (np.diff(keys.groups) == 0).any() or keys.kind == "boolean":
        raise NotOnColumnsError
    rank = np.full(len(items), -1.0)
    if keys.kind == "number":
        # NaN comes before other numbers.
        found = np.unique(np.nan_to_num(_floats(keys), nan=-np.inf), return_inverse=True)[1].reshape(-1)
    else:
        column = texts(forest, keys)
        ordered = {text: place for place, text in enumerate(sorted(set(column.values)))}
        found = np.array([ordered[text] for text in column.values], np.int64)[column.codes]
    rank[keys.groups] = found
    return value_of(items.chosen(np.lexsort((rank, items.groups))))


def ranges(low: Floats, high: Floats) -> Items:
    """`low to high`."""
    ends = np.concatenate([low, high])
    if not (np.isfinite(ends).all() and (ends == np.floor(ends)).all()):
        raise NotOnColumnsError
    counts = np.maximum(0.0, high - low + 1)
    # Beyond these whole numbers are no numbers of arrays.
    if counts.sum() > MAX_PAIRS or (np.abs(ends) > MOST_WHOLE).any():
        raise TooWideError(MAX_PAIRS + 1)
    source, within = expand(counts.astype(np.int64))
    return Items(source, low[source] + within, len(low))


def tokens(forest: Forest, arguments: Sequence[Value], check: Callable[[], None]) -> Value:
    """`tokenize`. check: raises when the query must end."""
    columns = [as_strings(forest, argument) for argument in arguments]
    rows = list(zip(*(column.list() for column in columns), strict=True))
    made: dict[tuple[str, ...], list[str]] = {}
    for row in set(rows):
        check()
        made[row] = regular.tokenize(*row)
    source, _ = bounded(np.array([len(made[row]) for row in rows], np.int64))
    return Items(source, of_texts([part for row in rows for part in made[row]]), len(rows))


def _nodes(items: Items) -> Ints:
    return np.asarray(items.column, np.int64)


def _floats(items: Items) -> Floats:
    return np.asarray(items.column, np.float64)


MOST_WHOLE = 2.0**53
_EXTREMES = frozenset({"min", "max", "avg"})
_FUNCTIONS: dict[str, Callable[[Forest, Items, Sequence[Value]], Value]] = {
    "count": _count, "exists": _exists, "empty": _empty, "sum": _sum, "avg": _avg,
    "min": lambda forest, items, _: _extreme(forest, items, least=True),
    "max": lambda forest, items, _: _extreme(forest, items, least=False),
    "distinct-values": _distinct, "string-join": _joined, "data": _data, "reverse": _reverse, "head": _head,
    "tail": _tail, "subsequence": _subsequence, "remove": _remove, "index-of": _index_of,
}  # fmt: skip
