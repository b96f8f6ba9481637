"""FLWOR of XQuery 3.1 §3.12 for elementpath, which has `for` and `let` of XPath: a stream of tuples of variables.

Window clauses and types of variables are refused. In the mode compatible with XPath 1.0 a key may have several values:
orders compare them one after the other, and a tuple is in the group of each.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Set
from copy import copy
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import product
from typing import Any, TypeAlias

from elementpath.datatypes import UntypedAtomic

from mcml_service.xpath.language.xpath31.collations import Collations
from mcml_service.xpath.language.xpath31.ordering import Key, compare_keys, key_of

Variables: TypeAlias = dict[str, Any]
"""A tuple: values by the names of variables."""
Tuples: TypeAlias = Iterable[Variables]
Bound: TypeAlias = Callable[[Variables], Any]
"""A context with these variables."""
_CLAUSES = ("for", "let", "where", "order", "stable", "group", "count", "return")


class Clause(ABC):
    """A part of an expression before `return`. names: of the variables that it binds."""

    names: tuple[str, ...]

    @abstractmethod
    def operands(self) -> list[Any]:
        """Its expressions."""

    @abstractmethod
    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        """The tuples that it makes of others."""


@dataclass
class For(Clause):
    """`for $names[0] at $names[1] in source`. allows_empty: whether nothing is an item of an empty source."""

    names: tuple[str, ...]
    source: Any
    allows_empty: bool

    def operands(self) -> list[Any]:
        return [self.source]

    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        for variables in tuples:
            place = 0
            for place, item in enumerate(self.source.select(bound(variables)), 1):
                yield {**variables, **dict(zip(self.names, (item, place), strict=False))}
            if self.allows_empty and not place:
                yield {**variables, **dict(zip(self.names, ([], 0), strict=False))}


@dataclass
class Let(Clause):
    """`let $name := source`."""

    names: tuple[str, ...]
    source: Any

    def operands(self) -> list[Any]:
        return [self.source]

    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        for variables in tuples:
            yield {**variables, self.names[0]: self.source.evaluate(bound(variables))}


@dataclass
class Where(Clause):
    """`where test`."""

    test: Any
    names: tuple[str, ...] = ()

    def operands(self) -> list[Any]:
        return [self.test]

    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        for variables in tuples:
            if self.test.boolean_value(list(self.test.select(bound(variables)))):
                yield variables


@dataclass
class Count(Clause):
    """`count $name`: the place of a tuple."""

    names: tuple[str, ...]

    def operands(self) -> list[Any]:
        return []

    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        for place, variables in enumerate(tuples, 1):
            yield {**variables, self.names[0]: place}


@dataclass
class OrderKey:
    """A key of `order by`. is_greatest: whether nothing and NaN are greater than all values, else less."""

    source: Any
    is_descending: bool
    is_greatest: bool
    collation: str | None


@dataclass
class Order(Clause):
    """`order by key, …`. Tuples of equal keys keep their order."""

    keys: list[OrderKey]
    names: tuple[str, ...] = ()

    def operands(self) -> list[Any]:
        return [key.source for key in self.keys]

    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        held = list(tuples)
        for key in reversed(self.keys):
            held = _sort(key, held, bound)
        return held


@dataclass
class Group(Clause):
    """`group by $name := source, …`. sources: None where the variable is bound before. joined: names of the variables
    that have their values in all tuples of a group: those that this expression binds before it.
    """

    names: tuple[str, ...]
    sources: list[Any]
    collations: list[str | None]
    token: Any
    joined: set[str]

    def operands(self) -> list[Any]:
        return [source for source in self.sources if source is not None]

    def stream(self, tuples: Tuples, bound: Bound) -> Tuples:
        groups: dict[tuple[Key, ...], tuple[list[Any], list[Variables]]] = {}
        for variables in tuples:
            for keyed in product(*self._values(variables, bound)):
                keys = tuple(key for key, _ in keyed)
                groups.setdefault(keys, ([value for _, value in keyed], []))[1].append(variables)
        for values, members in groups.values():
            yield {**members[0], **_concatenate(members, self.joined), **dict(zip(self.names, values, strict=True))}

    def _values(self, variables: Variables, bound: Bound) -> Iterator[list[tuple[Key, Any]]]:
        """Yield the values of each key, with those to compare."""
        found = dict(variables)
        for name, source, stated in zip(self.names, self.sources, self.collations, strict=True):
            if source is not None:
                found[name] = source.evaluate(bound(found))
            values = _one(self.token, self.token.atomize_item(found[name]))
            with _collation(self.token, stated) as collation:
                keys = [(key_of(value, collation.strxfrm), _to_string(value)) for value in values]
            yield keys or [(("nothing", ""), [])]


class Flwor:
    """The methods of the tokens `for` and `let`, whose attribute `clauses` is read here."""

    # They follow other clauses, unlike in XPath.
    lbp = 0

    def nud(self: Any) -> Any:
        """Parse the clauses and the result. The operands are all expressions, that of the result last."""
        del self[:]
        parser = self.parser
        if parser.next_token.symbol != "$" and not _is_next(parser, "window"):
            return self.as_name()
        self.clauses = []
        word = self.symbol
        while word != "return":
            self.clauses += _READERS[word](self)
            if not _is_next(parser, *_CLAUSES):
                raise parser.next_token.wrong_syntax("'return' is missing")
            parser.advance()
            word = _word(parser.token)
        self.append(parser.expression(5))
        return self

    def select(self: Any, context: Any = None) -> Iterator[Any]:
        """The items of all tuples."""
        if context is None:
            raise self.missing_context()

        outer = copy(context)

        def bound(variables: Variables) -> Any:
            inner = copy(outer)
            inner.variables = variables
            return inner

        tuples: Tuples = [dict(context.variables)]
        for clause in self.clauses:
            tuples = clause.stream(tuples, bound)
        for variables in tuples:
            yield from self[-1].select(bound(variables))

    def bindings(self: Any) -> list[tuple[str, Any]]:
        """The sources of `for` and `let`, with the names of their variables."""
        return [(one.names[0], one.source) for one in self.clauses if isinstance(one, For | Let)]

    def binds(self: Any, clause: Clause) -> bool:
        """Whether a variable of a clause has the nodes of its source."""
        return isinstance(clause, For | Let)

    def is_ordered(self: Any) -> bool:
        """Whether more is asked than each tuple alone: their order, groups or places."""
        counted = any(isinstance(one, For) and (len(one.names) > 1 or one.allows_empty) for one in self.clauses)
        return counted or any(isinstance(one, Order | Group | Count) for one in self.clauses)


def _read_for(token: Any) -> list[Clause]:
    """`$a allowing empty at $i in …, $b in …`"""
    parser = token.parser
    clauses: list[Clause] = []
    while not clauses or _accept(parser, ","):
        names = [_variable(token)]
        allows_empty = _accept(parser, "allowing")
        if allows_empty:
            _require(parser, "empty")
        if _accept(parser, "at"):
            names.append(_variable(token))
            if names[0] == names[1]:
                raise token.error("XQST0089", "an item and its place need two names")
        parser.advance("in")
        clauses.append(For(tuple(names), _operand(token), allows_empty))
    return clauses


def _read_let(token: Any) -> list[Clause]:
    clauses: list[Clause] = []
    while not clauses or _accept(token.parser, ","):
        name = _variable(token)
        token.parser.advance(":=")
        clauses.append(Let((name,), _operand(token)))
    return clauses


def _read_order(token: Any) -> list[Clause]:
    """`by key descending empty greatest collation '…', …`"""
    parser = token.parser
    _require(parser, "by")
    keys: list[OrderKey] = []
    while not keys or _accept(parser, ","):
        source = _operand(token)
        is_descending = _accept(parser, "descending") or (_accept(parser, "ascending") and False)
        is_greatest = False
        if _accept(parser, "empty"):
            is_greatest = _accept(parser, "greatest")
            if not is_greatest:
                _require(parser, "least")
        keys.append(OrderKey(source, is_descending, is_greatest, _read_collation(parser)))
    return [Order(keys)]


def _read_stable(token: Any) -> list[Clause]:
    _require(token.parser, "order")
    return _read_order(token)


def _read_group(token: Any) -> list[Clause]:
    """`by $k := key collation '…', $l, …`"""
    parser = token.parser
    _require(parser, "by")
    names: list[str] = []
    sources: list[Any] = []
    collations: list[str | None] = []
    while not names or _accept(parser, ","):
        names.append(_variable(token))
        sources.append(_operand(token) if _accept(parser, ":=") else None)
        collations.append(_read_collation(parser))
    before = {name for clause in token.clauses for name in clause.names}
    return [Group(tuple(names), sources, collations, token, before)]


_READERS: dict[str, Callable[[Any], list[Clause]]] = {
    "for": _read_for,
    "let": _read_let,
    "where": lambda token: [Where(_operand(token))],
    "order": _read_order,
    "stable": _read_stable,
    "group": _read_group,
    "count": lambda token: [Count((_variable(token),))],
}


def _operand(token: Any) -> Any:
    token.append(token.parser.expression(5))
    return token[-1]


def _variable(token: Any) -> str:
    if token.parser.next_token.symbol != "$":
        raise token.parser.next_token.wrong_syntax("a variable is missing")
    return str(token.parser.expression(90)[0].value)


def _read_collation(parser: Any) -> str | None:
    if not _accept(parser, "collation"):
        return None
    parser.advance("(string)")
    return str(parser.token.value)


def _word(token: Any) -> Any:
    return token.value if token.symbol == "(name)" else token.symbol


def _is_next(parser: Any, *words: str) -> bool:
    return _word(parser.next_token) in words


def _accept(parser: Any, word: str) -> bool:
    is_next = _is_next(parser, word)
    if is_next:
        parser.advance()
    return is_next


def _require(parser: Any, word: str) -> None:
    if not _accept(parser, word):
        raise parser.next_token.wrong_syntax(f"{word!r} is missing")


def _collation(token: Any, stated: str | None) -> Collations:
    return Collations(stated or token.parser.default_collation, token)


def _one(token: Any, values: Iterable[Any]) -> list[Any]:
    """The values of a key. XPTY0004 for several in strict XPath."""
    found = list(values)
    if len(found) > 1 and not token.parser.compatibility_mode:
        raise token.error("XPTY0004", "a key has more than one value")
    return found


def _to_string(value: Any) -> Any:
    return str(value) if isinstance(value, UntypedAtomic) else value


def _concatenate(members: list[Variables], names: Set[str]) -> Variables:
    """Variables of a group: their values in all tuples, one after the other."""
    found: Variables = {name: [] for name in names}
    for variables in members:
        for name in names:
            value = variables[name]
            found[name] += value if isinstance(value, list) else [value]
    return {name: value[0] if len(value) == 1 else value for name, value in found.items()}


def _sort(key: OrderKey, tuples: list[Variables], bound: Bound) -> list[Variables]:
    token = key.source
    keyed: list[tuple[list[Key], Variables]] = []
    with _collation(token, key.collation) as collation:
        for variables in tuples:
            values = _one(token, token.atomize_item(token.evaluate(bound(variables))))
            found = [key_of(value, collation.strxfrm) for value in values]
            keyed.append(([_greatest(one) for one in found] if key.is_greatest else found, variables))

    def compare(one: tuple[list[Key], Variables], other: tuple[list[Key], Variables]) -> int:
        if key.is_greatest and bool(one[0]) != bool(other[0]):
            return 1 if other[0] else -1
        return compare_keys(token, one[0], other[0])

    # Tuples of equal keys keep their order, also in a descending one.
    held = sorted(reversed(keyed) if key.is_descending else keyed, key=cmp_to_key(compare))
    return [variables for _, variables in (reversed(held) if key.is_descending else held)]


def _greatest(key: Key) -> Key:
    """NaN as greater than all numbers."""
    kind, value = key
    return (kind, (math.inf, 0)) if kind == "number" and value == (0, 0) else key
