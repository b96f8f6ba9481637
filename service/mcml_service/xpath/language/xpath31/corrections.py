"""Where elementpath differs from the specifications (XPath 3.1, Functions and Operators 3.1), corrected.

Each has its clause. Tests compare with Saxon and the W3C's cases (`tests/xpath`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, MutableMapping
from copy import copy
from decimal import Decimal
from typing import Any

from elementpath import XPathContext
from elementpath.namespaces import XML_LANG, XPATH_ARRAY_FUNCTIONS_NAMESPACE, XPATH_FUNCTIONS_NAMESPACE
from elementpath.xpath31 import XPath31Parser
from elementpath.xpath_nodes import (
    AttributeNode,
    CommentNode,
    ElementNode,
    NamespaceNode,
    ProcessingInstructionNode,
    TextNode,
    XPathNode,
)
from elementpath.xpath_tokens import XPathArray, XPathFunction, XPathToken

from mcml.errors import LimitError
from mcml_service.xpath.language.xpath31.arithmetic import OPERATORS, arithmetic
from mcml_service.xpath.language.xpath31.flwor import Flwor
from mcml_service.xpath.language.xpath31.numeric import NUMERIC, number_argument
from mcml_service.xpath.language.xpath31.ordering import distinct_values, sort, sort_array

LONGEST_RANGE = 10_000_000
"""Items of a range."""
_call_array = XPathArray.__call__


def _call(self: XPathArray, *arguments: Any, context: Any = None) -> Any:
    """Array lookup by a call (XPath 3.1 §3.11.3): a sequence of one integer is that integer."""
    if len(arguments) == 1 and isinstance(arguments[0], list) and len(arguments[0]) == 1:
        arguments = (arguments[0][0],)
    return _call_array(self, *arguments, context=context)


XPathArray.__call__ = _call  # type: ignore[method-assign]


_string_value = XPathToken.string_value


def _string(self: XPathToken, value: Any) -> str:
    """A double or float as text (F&O 3.1 §19.1.2.2): from 10^-6 up to 10^6 as a decimal, else with an exponent."""
    if not isinstance(value, float) or not math.isfinite(value) or value == 0 or 1e-6 <= abs(value) < 1e6:
        return _string_value(self, value)
    digits, _, exponent = f"{Decimal(str(value)).normalize():E}".partition("E")
    return f"{digits if '.' in digits else digits + '.0'}E{int(exponent)}"


XPathToken.string_value = _string  # type: ignore[assignment, method-assign]


class Context(XPathContext):
    """The dynamic context of an expression.

    scope: the document nodes at which absolute paths outside of predicates begin; none: they begin at the root.
    """

    scope: tuple[Any, ...] = ()

    def iter_siblings(self, axis: str | None = None) -> Iterator[Any]:
        """Yield the siblings (XPath 3.1 §3.3.2.1): attributes and namespaces have none."""
        return iter(()) if isinstance(self.item, AttributeNode | NamespaceNode) else super().iter_siblings(axis)

    def iter_attributes(self) -> Iterator[Any]:
        """Yield the attributes of an element; other nodes have none."""
        return super().iter_attributes() if isinstance(self.item, ElementNode) else iter(())

    def iter_preceding(self) -> Iterator[Any]:
        """Yield the preceding axis; that of an attribute or namespace is that of its element."""
        status = self.item
        if isinstance(status, AttributeNode | NamespaceNode) and status.parent is not None:
            self.item = status.parent
        yield from super().iter_preceding()
        self.item = status

    def iter_followings(self) -> Iterator[Any]:
        """Yield the following axis (XPath 3.1 §3.3.2.1).

        The content of an element follows its attributes and namespaces. Texts and comments have followers too.
        """
        text = self.item
        if isinstance(text, TextNode | CommentNode | ProcessingInstructionNode) and text.parent is not None:
            status = self.item, self.axis
            root: Any = text.parent
            while isinstance(root.parent, ElementNode) and root is not self.root:
                root = root.parent
            for item in root.iter_descendants(with_self=False):
                if item.position > text.position:
                    self.item, self.axis = item, "following"
                    yield item
            self.item, self.axis = status
            return
        if isinstance(self.item, AttributeNode | NamespaceNode) and isinstance(self.item.parent, ElementNode):
            status = self.item, self.axis
            parent = self.item.parent
            for item in parent.iter_descendants(with_self=False):
                self.item, self.axis = item, "following"
                yield item
            self.item, self.axis = parent, status[1]
            yield from super().iter_followings()
            self.item, self.axis = status
            return
        yield from super().iter_followings()


def _round(number: float) -> float:
    """fn:round of a double: the closest integer, of two the greater."""
    return math.floor(number + 0.5) if math.isfinite(number) else number


def _substring(self: Any, context: Any = None) -> str:
    """fn:substring (F&O 3.1 §5.4.3): the characters at positions p with round(start) <= p < round(start) +
    round(length), also for infinite values and NaN.
    """
    context = self.context or context
    text: str = self.get_argument(context, default="", cls=str)
    first, length = (
        math.inf if place >= len(self) else self.number_value(self.get_argument(context, index=place, required=True))
        for place in (1, 2)
    )
    start = _round(first)
    end = start + _round(length)
    if math.isnan(end) or math.isnan(start):
        return ""
    return "".join(letter for place, letter in enumerate(text, 1) if start <= place < end)


def _path(self: Any, context: Any = None) -> Iterator[Any]:
    """A path of two operands (XPath 3.1 §3.3): nodes without duplicates in document order, or values as they come."""
    if len(self) < 2 or context is None:
        for one in _at_roots(self, _needed(self, context)):
            yield from super(type(self), self).select(one)
        return
    values: list[Any] = []
    nodes: dict[Any, None] = {}
    for _ in self[0].select_with_focus(context):
        if not isinstance(context.item, XPathNode):
            raise self.error("XPTY0019", "a step is applied to a value, which is not a node")
        for _ in context.iter_descendants() if self.symbol == "//" else (None,):
            for found in self[1].select(context):
                if isinstance(found, XPathNode):
                    nodes[found] = None
                else:
                    values.append(found)
    if values and nodes:
        raise self.error("XPTY0018", "a path gives nodes and values")
    yield from values or sorted(nodes, key=lambda node: node.position)


def _top(node: Any) -> Any:
    while node.parent is not None:
        node = node.parent
    return node


def _is_before(self: Any, context: Any = None) -> Any:
    """`<<` and `>>` (XPath 3.1 §3.7.3), also of nodes of several documents."""
    nodes = [list(operand.select(copy(context))) for operand in self]
    if not all(nodes):
        return []
    if any(len(some) > 1 or not isinstance(some[0], XPathNode) for some in nodes):
        raise self.error("XPTY0004", f"an operand of {self.symbol} is not a single node")
    first, second = (some[0].position for some in nodes)
    return first < second if self.symbol == "<<" else first > second


def _node(self: Any, context: Any = None) -> Iterator[Any]:
    """The kind test node(), which any document passes."""
    for item in _needed(self, context).iter_children_or_self():
        if isinstance(item, XPathNode):
            yield item


def _root(self: Any, context: Any = None) -> Any:
    """fn:root: the document of a node, also of one of several."""
    context = self.context or _needed(self, context)
    node = self.get_argument(context, default_to_context=True)
    if node is None:
        return []
    if not isinstance(node, XPathNode):
        raise self.error("XPTY0004", "root() needs a node")
    return _top(node)


def _namespaces(self: Any, context: Any = None) -> Iterator[Any]:
    """The namespace axis (XPath 3.1 §3.3.2.1), whose nodes node() is true for as well."""
    element, test = _needed(self, context).item, self[0]
    for item in element.namespace_nodes if isinstance(element, ElementNode) else ():
        if test.symbol in ("node", "namespace-node", "*") or (test.symbol == "(name)" and test.value == item.prefix):
            context.item = item
            yield item


def _path_of(self: Any, context: Any = None) -> Any:
    """fn:path: in the document of its node."""
    context = copy(self.context or _needed(self, context))
    node = self.get_argument(context, default_to_context=True)
    if isinstance(node, XPathNode):
        context.root = _top(node)
    return _PATH(self, context)


def _at_roots(token: Any, context: Any) -> Iterator[Any]:
    """Yield the context at the documents in which an absolute path begins (`scope.mark_scope`)."""
    if not context.scope:
        yield context
        return
    roots = context.scope if token.is_whole else (context.document,)
    if token.in_predicate and isinstance(context.item, XPathNode):
        roots = (_top(context.item),)
    for root in roots:
        one = copy(context)
        one.root = one.document = one.item = root
        yield one


def _bound(self: Any, context: Any) -> Iterator[Any]:
    """A context for each choice of the variables of a loop or quantifier (XPath 3.1 §3.9): the sequence of the
    second variable is evaluated in the focus of the whole expression, not in the focus left by the first.
    """
    waiting = [(0, context)]
    while waiting:
        place, outer = waiting.pop()
        if place == len(self) - 1:
            yield outer
            continue
        inner = []
        for item in self[place + 1].select(copy(outer)):
            bound = copy(outer)
            bound.variables = {**outer.variables, self[place][0].value: item}
            inner.append((place + 2, bound))
        waiting += reversed(inner)


def _some(self: Any, context: Any = None) -> bool:
    return any(self.boolean_value(self[-1].select(copy(bound))) for bound in _bound(self, _needed(self, context)))


def _every(self: Any, context: Any = None) -> bool:
    return all(self.boolean_value(self[-1].select(copy(bound))) for bound in _bound(self, _needed(self, context)))


def _ends(token: Any, context: Any) -> tuple[int, int] | None:
    """The ends of a range, None where it is empty.

    In the mode compatible with XPath 1.0 all arithmetic gives doubles: `1 to 2 + 1` has an end of 3.0, which counts.
    """
    first, last = token.get_operands(context, cls=(int, float) if token.parser.compatibility_mode else int)
    if any(isinstance(end, float) and not end.is_integer() for end in (first, last)):
        raise token.error("XPTY0004", "the end of a range is no integer")
    return None if first is None or last is None or last < first else (int(first), int(last))


def _range(self: Any, context: Any = None) -> Iterator[int]:
    """A range (XPath 3.1 §3.4.2) of as many items as can be listed."""
    ends = _ends(self, context)
    if ends is None:
        return
    first, last = ends
    if last - first >= LONGEST_RANGE:
        raise LimitError(
            f"The range has {last - first + 1:,} items, the limit is {LONGEST_RANGE:,}.",
            remedy="Compare with both of its ends instead.",
            code="query-too-large",
        )
    yield from range(first, last + 1)


def _count(self: Any, context: Any = None) -> int:
    """fn:count: of a range without listing it."""
    context = self.context or context
    operand = self[0]
    while operand.symbol == "(" and len(operand) == 1:
        operand = operand[0]
    if operand.symbol != "to":
        return sum(1 for _ in self[0].select(context))
    ends = _ends(operand, context)
    return 0 if ends is None else ends[1] - ends[0] + 1


def _lang(self: Any, context: Any = None) -> bool:
    """fn:lang (F&O 3.1 §13.4): of any node, by the attribute xml:lang of the nearest element that has one."""
    context = self.context or _needed(self, context)
    node = self.get_argument(context, 1, default_to_context=True) if len(self) > 1 else context.item
    if not isinstance(node, XPathNode):
        raise self.error("XPTY0004", "lang() needs a node")
    asked = (self.get_argument(context, cls=str) or "").lower()
    while node is not None:
        stated = [one.value for one in getattr(node, "attributes", None) or () if one.name == XML_LANG]
        if stated:
            return f"{stated[0].lower()}-".startswith(f"{asked}-")
        node = node.parent
    return False


def _needed(token: Any, context: Any) -> Any:
    if context is None:
        raise token.missing_context()
    return context


_PATH: Any = XPath31Parser.symbol_table["path"].evaluate


def _rounded(name: str) -> Any:
    """floor, ceiling, round or abs: of nothing, in the mode compatible with 1.0, no number (XPath 3.1 §3.1.5.2)."""
    evaluate: Any = XPath31Parser.symbol_table[name].evaluate

    def corrected(self: Any, context: Any = None) -> Any:
        found = evaluate(self, context)
        if found == 0 and name != "abs":
            # Of a negative double the result is negative zero (F&O 3.1 §4.4.2 to §4.4.4).
            value = self.get_argument(self.context or context)
            number = value if isinstance(value, float) else math.nan
            return -0.0 if number == number and math.copysign(1, number) < 0 else found
        return math.nan if found == [] and self.parser.compatibility_mode else found

    return corrected


def _zero(self: Any, context: Any = None, index: int = 0, **options: Any) -> Any:
    """An argument of a fold: the second one is any sequence (F&O 3.1 §16.2.3), also none, which was an item."""
    if index != 1:
        return XPathFunction.get_argument(self, context, index, **options)
    values = list(self[1].select(copy(context)))
    return values[0] if len(values) == 1 else values


METHODS: dict[str, dict[str, Any]] = {
    **{symbol: arithmetic(symbol) for symbol in OPERATORS},
    **NUMERIC,
    **{
        name: {"evaluate": _rounded(name), "get_argument": number_argument}
        for name in ("floor", "ceiling", "round", "abs")
    },
    "substring": {"evaluate": _substring},
    "count": {"evaluate": _count},
    "lang": {"evaluate": _lang},
    "distinct-values": {"select": distinct_values},
    f"{{{XPATH_FUNCTIONS_NAMESPACE}}}sort": {"evaluate": sort},
    f"{{{XPATH_ARRAY_FUNCTIONS_NAMESPACE}}}sort": {"evaluate": sort_array},
    **{
        f"{{{namespace}}}fold-{way}": {"get_argument": _zero}
        for namespace in (XPATH_FUNCTIONS_NAMESPACE, XPATH_ARRAY_FUNCTIONS_NAMESPACE)
        for way in ("left", "right")
    },
    # A kind test in a path takes no occurrence indicator (XPath 3.1 §3.3.2.2): `node() + 1` is a sum.
    "node": {"nud": XPathFunction.nud, "select": _node},
    "namespace": {"select": _namespaces},
    "path": {"evaluate": _path_of},
    "root": {"evaluate": _root},
    **{symbol: {"evaluate": _is_before} for symbol in ("<<", ">>")},
    "to": {"evaluate": lambda self, context=None: list(_range(self, context)), "select": _range},
    **{symbol: {"select": _path, "is_whole": False, "in_predicate": False} for symbol in ("/", "//")},
    **{symbol: {k: v for k, v in vars(Flwor).items() if not k.startswith("__")} for symbol in ("for", "let")},
    "some": {"evaluate": _some},
    "every": {"evaluate": _every},
}
"""By symbol: methods of its tokens."""


_WITHOUT_FOCUS = frozenset({"(integer)", "(decimal)", "(float)", "(string)", "$", "."})
"""Tokens that move no focus."""


def correct(table: MutableMapping[str, type[Any]]) -> None:
    """Put the corrections into a table of symbols."""
    for symbol, kind in list(table.items()):
        methods = METHODS.get(symbol, {})
        if issubclass(kind, XPathToken) and symbol not in _WITHOUT_FOCUS:
            select = methods.get("select") or kind.select
            table[symbol] = type(kind.__name__, (kind,), methods | {"select": _with_own_focus(select)})


def _with_own_focus(select: Callable[..., Iterator[Any]]) -> Callable[..., Iterator[Any]]:
    """Select with a copy of the context, so that the focus of others stays (XPath 3.1 §2.1.2).

    Paths move it, so `.` after another operand of an inline function, of `insert-before` or of a map was the last node
    of that operand.
    """

    def select_apart(self: XPathToken, context: XPathContext | None = None) -> Iterator[Any]:
        if context is None:
            return select(self, context)
        own = copy(context)
        own.axis = context.axis
        return select(self, own)

    return select_apart
