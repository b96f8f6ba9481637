"""The documents that the parts of an expression ask, by its tokens.

Outside of predicates an absolute path is one of all documents together where a sequence is taken, and one of each
document where one value is needed; then the whole expression has a value for each document, in which only functions of
sequences that hold no such path, and no variables of others, still ask all documents.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass
from typing import Any

from mcml_service.xpath.language.functions import AGGREGATES, FUNCTIONS, OF_CONTEXT
from mcml_service.xpath.language.motion_functions import PREFIX

_NODE_OPERATORS = ("union", "intersect", "except", "|")
_STEPS = ("@", "*", ".", "..")
OF_BODIES = "mo-"
"""Prefix of the functions of bodies in motion: elementpath allows no colon in names of functions."""
_OF_TYPES = frozenset({"instance", "treat", "cast", "castable"})
_OF_NODE = frozenset({"id", "idref", "element-with-id", "lang"})
"""Functions that with one argument look at the document of the focus."""
_OF_FOCUS = OF_CONTEXT | _OF_NODE | {"position", "last", "data", "root", "path", "has-children", "node-name", "nilled"}
_OF_FOCUS |= {"base-uri", "document-uri", "generate-id"}
"""Functions that without an argument look at the focus."""
_OF_ONE = frozenset({"zero-or-one", "exactly-one", "boolean", "not", "id", "idref", "element-with-id"})
"""Functions of one value, whose parameter is a sequence."""
_OF_TRUTH = frozenset(
    {
        *("=", "!=", "<", "<=", ">", ">=", "eq", "ne", "lt", "le", "gt", "ge", "is", "<<", ">>"),
        *("and", "or", "some", "every", "instance", "castable"),
    }
)
"""Operators that give a boolean."""


def parts_of(token: Any) -> Iterator[Any]:
    """Yield the tokens in a token, also those that elementpath does not list.

    A sequence yields its items: elementpath nests each comma in the next one, deeper than recursion may go.
    """
    if token.symbol == "," and len(token) == 2:
        items = []
        while token.symbol == "," and len(token) == 2:
            items.append(token[1])
            token = token[0]
        yield from (token, *reversed(items))
        return
    yield from token
    yield from getattr(token, "_values", ()) if token.label == "map" else ()
    if token.label == "inline function":
        yield token.body


def tokens_of(token: Any) -> Iterator[Any]:
    """Yield a token and all tokens in it."""
    yield token
    for part in parts_of(token):
        yield from tokens_of(part)


def calls_of_all(token: Any, functions: Set[str]) -> Iterator[Any]:
    """Yield the outermost calls of functions, outside of predicates, whose value is the same wherever they stand: they
    have an absolute path, and depend on no variable and no focus.
    """
    is_call = token.label == "function" and token.symbol in functions
    if is_call and _is_wide(token, frozenset()) and not _free(token) and not _reads(token, roots=False):
        yield token
        return
    for part in list(parts_of(token))[: 1 if _is_predicate(token) else None]:
        yield from calls_of_all(part, functions)


def _outside(token: Any) -> Iterator[Any]:
    """Yield a token and all tokens in it but those in predicates on nodes."""
    yield token
    parts = list(parts_of(token))
    for part in parts[:1] if _is_predicate(token) and gives_nodes(parts[0]) else parts:
        yield from _outside(part)


@dataclass(frozen=True)
class Scope:
    """together: whether documents cannot be evaluated one by one. each: whether every document has its own answer."""

    together: bool
    each: bool


def mark_scope(root: Any) -> Scope:
    """Set `is_whole` of the absolute paths that are of all documents, and `in_predicate` of those in predicates, where
    a path begins at the document of the node that is tested.
    """
    marked = _Marked(alone=False)
    marked.visit(root, many=True)
    each = bool(marked.own) or _reads(root, roots=False)
    if each:
        marked = _Marked(alone=True)
        marked.visit(root, many=True)
        together = bool(marked.whole)
    else:
        is_aggregate = root.label == "function" and root.symbol in AGGREGATES
        wide = _wide_names(root)
        together = any(_joins(part, wide) for part in _outside(root) if part is not root or not is_aggregate)
    for token in tokens_of(root):
        if _is_root(token):
            token.is_whole = id(token) in marked.whole
    return Scope(together, each)


def reads_document(root: Any) -> bool:
    """Whether the value may depend on a document."""
    return _reads(root, roots=True)


def gives_nodes(token: Any, *, others: frozenset[str] = frozenset()) -> bool:
    """Tell whether the value can only be nodes, by its syntax. others: further symbols that give nodes."""
    symbol, operands = token.symbol, list(token)
    if symbol in _NODE_OPERATORS or token.label in ("axis", "kind test", "name") or symbol in _STEPS:
        return True
    if symbol in ("/", "//"):
        return not operands or gives_nodes(operands[-1], others=others)
    if symbol == "[":
        return token.label != "array" and gives_nodes(operands[0], others=others)
    if symbol in others:
        return True
    if symbol == "if":
        return all(gives_nodes(part, others=others) for part in operands[1:])
    if symbol in ("for", "let", "!"):
        return gives_nodes(operands[-1], others=others)
    return symbol in ("(", ",") and bool(operands) and all(gives_nodes(part, others=others) for part in operands)


class _Marked:
    """Absolute paths outside of predicates on nodes: `whole` of all documents, `own` of each; identities of tokens."""

    def __init__(self, *, alone: bool) -> None:
        self._alone = alone
        self.whole: set[int] = set()
        self.own: set[int] = set()

    def visit(self, token: Any, *, many: bool) -> None:
        """many: any number of items may stand here."""
        if _is_root(token):
            (self.whole if many and not self._alone else self.own).add(id(token))
            for part in token:
                self._predicates(part)
            return
        if self._alone and _takes_all(token):
            together = _Marked(alone=False)
            together.visit(token, many=many)
            if not together.own and not _free(token):
                self.whole |= together.whole
                return
        for part, takes_many in _places(token, many=many):
            if _is_predicate(token) and part is token[1]:
                self._predicate(token)
            else:
                self.visit(part, many=takes_many)

    def _predicate(self, token: Any) -> None:
        inner = _Marked(alone=self._alone)
        inner.visit(token[1], many=False)
        for part in tokens_of(token[1]):
            if _is_root(part):
                part.in_predicate = True
        self.whole |= inner.whole
        if _gives_values(token[0]):
            self.own |= inner.own

    def _predicates(self, token: Any) -> None:
        """Visit those in the steps of a path."""
        for part in tokens_of(token):
            if _is_predicate(part):
                self._predicate(part)


def _is_root(token: Any) -> bool:
    return token.symbol in ("/", "//") and len(token) < 2


def _is_predicate(token: Any) -> bool:
    return bool(token.symbol == "[" and token.label != "array")


def _takes_all(token: Any) -> bool:
    """Whether it is a function of sequences, or a quantifier."""
    is_function = token.label == "function" and any(_takes_many(token, place) for place in range(len(token)))
    return is_function or token.symbol in ("some", "every")


def _takes_many(token: Any, place: int) -> bool:
    """Whether an argument of a function may be any number of items."""
    known = FUNCTIONS.get(token.symbol.replace(OF_BODIES, PREFIX, 1))
    if known is not None:
        return known.takes_items and place == known.place
    if token.symbol in _OF_ONE:
        return False
    types = token.sequence_types or ()
    return place < len(types) - 1 and types[place].endswith(("*", "+"))


def _places(token: Any, *, many: bool) -> Iterator[tuple[Any, bool]]:
    """Yield the tokens in a token, and whether any number of items may stand there."""
    symbol, label = token.symbol, token.label
    parts = list(parts_of(token))
    if label == "function":
        yield from ((part, _takes_many(token, place)) for place, part in enumerate(parts))
    elif symbol in ("for", "let"):
        sources = {id(source) for _, source in token.bindings()}
        yield from ((part, id(part) in sources or (many and part is parts[-1])) for part in parts)
    elif symbol in ("some", "every"):
        yield from ((part, part is not parts[-1]) for part in parts)
    elif symbol == "if":
        yield from ((part, many and place > 0) for place, part in enumerate(parts))
    elif symbol in ("#", "$") or symbol in _OF_TYPES:
        yield from ((part, False) for part in parts[:1])
    elif symbol == "=>":
        yield from _arrow_places(token)
    elif (symbol == "(" and len(parts) > 1) or label in ("array", "map", "inline function"):
        yield from ((part, True) for part in parts)
    else:
        passes = symbol in ("(", ",", "!", "/", "//", "[", "?", *_NODE_OPERATORS)
        yield from ((part, many and passes) for part in parts)


def _arrow_places(token: Any) -> Iterator[tuple[Any, bool]]:
    """The places of `argument => function(others)`."""
    named, others = token[1], [part for part in token[2:] if part.symbol != "(" or len(part)]
    known = FUNCTIONS.get(named.value if named.symbol == "(name)" else named.symbol)
    yield token[0], known is None or (known.takes_items and known.place == 0)
    yield from ((part, known is None) for part in others)


def _wide_names(root: Any) -> frozenset[str]:
    """Names of variables that may hold items of all documents."""
    wide: set[str] = set()
    for token in tokens_of(root):
        if token.symbol == "let" or (token.symbol == "for" and token.is_ordered()):
            wide |= {name for name, source in token.bindings() if _is_wide(source, wide)}
        if token.label == "inline function":
            wide |= set(map(str, token.varnames))
    return frozenset(wide)


def _joins(token: Any, wide: Set[str]) -> bool:
    """Whether it combines the items of all documents, or asks them all again for each item. wide: variables that hold
    them.
    """
    symbol, label = token.symbol, token.label
    parts = list(parts_of(token))
    if symbol == "for":
        return any(_is_wide(part, wide) for part in (parts if token.is_ordered() else parts[1:]))
    if symbol in ("!", "/", "//"):
        is_counted = len(parts) > 1 and _asks_position(parts[1]) and _is_wide(parts[0], wide)
        return is_counted or (len(parts) > 1 and _is_wide(parts[1], wide))
    if _is_predicate(token):
        is_counted = _may_count(parts[1]) and _is_wide(parts[0], wide)
        compares = any(part.symbol == "$" and len(part) and part[0].value in wide for part in tokens_of(parts[1]))
        return is_counted or compares or (not gives_nodes(parts[0]) and _is_wide(parts[1], wide))
    several = symbol == "," or (symbol == "(" and len(parts) > 1) or symbol in ("=>", "some", "every")
    if several or label in ("array", "map", "inline function"):
        return any(_is_wide(part, wide) for part in parts)
    if label != "function" or symbol.startswith(OF_BODIES):
        # Runs are of each document.
        return False
    takes_many = (part for place, part in enumerate(parts) if _takes_many(token, place))
    return any(_is_wide(part, wide) for part in takes_many)


def _is_wide(token: Any, wide: Set[str]) -> bool:
    """Whether an absolute path is in it, outside of predicates on nodes, or a variable that holds items of one."""
    if _is_root(token) or (token.symbol == "$" and len(token) and token[0].value in wide):
        return True
    parts = list(parts_of(token))
    inside = parts[:1] if _is_predicate(token) and gives_nodes(parts[0]) else parts
    return any(_is_wide(part, wide) for part in inside)


def _asks_position(token: Any) -> bool:
    """Whether the position of the item in focus, or their number, is asked."""
    if token.label == "function" and token.symbol in ("position", "last"):
        return True
    parts = list(parts_of(token))
    has_own_focus = len(parts) > 1 and (_is_predicate(token) or token.symbol in ("!", "/", "//"))
    return any(map(_asks_position, parts[:1] if has_own_focus else parts))


def _may_count(predicate: Any) -> bool:
    """Whether the truth of a predicate may depend on the position of an item."""
    if _asks_position(predicate):
        return True
    while predicate.symbol == "(" and len(predicate) == 1:
        predicate = predicate[0]
    types = getattr(predicate, "sequence_types", None) or ("",)
    is_text = predicate.label == "function" and types[-1].rstrip("?") in ("xs:boolean", "xs:string")
    return not (is_text or predicate.symbol in _OF_TRUTH or gives_nodes(predicate))


def _gives_values(token: Any) -> bool:
    """Whether the value can be no node, by its syntax."""
    if token.label == "literal" or token.symbol == "to":
        return True
    return token.symbol in ("(", ",") and bool(len(token)) and all(map(_gives_values, token))


def _free(token: Any) -> set[str]:
    """Names of variables that are bound outside of it."""
    return {name for name, _ in free_names(token)}


def free_names(token: Any, bound: frozenset[str] = frozenset()) -> Iterator[tuple[str, Any]]:
    """Yield the names of variables that are bound outside, with their tokens."""
    parts = list(parts_of(token))
    if token.symbol == "$" and parts and parts[0].symbol == "(name)":
        if parts[0].value not in bound:
            yield str(parts[0].value), token
        return
    if token.symbol in ("for", "let"):
        for clause in token.clauses:
            for source in clause.operands():
                yield from free_names(source, bound)
            bound |= frozenset(clause.names)
        yield from free_names(parts[-1], bound)
        return
    if token.symbol in ("some", "every"):
        for name, source in zip(parts[:-1:2], parts[1:-1:2], strict=True):
            yield from free_names(source, bound)
            bound |= {str(name[0].value)}
        yield from free_names(parts[-1], bound)
        return
    if token.label == "inline function":
        yield from free_names(token.body, bound | frozenset(map(str, token.varnames)))
        return
    for part in parts:
        yield from free_names(part, bound)


def _reads(token: Any, *, roots: bool, is_outer: bool = True) -> bool:
    """Whether the value may depend on the outer focus, which is the document. roots: or on absolute paths. is_outer:
    the focus is the document, no item of the expression.
    """
    symbol, label, operands = token.symbol, token.label, list(parts_of(token))

    def reads(part: Any, *, outer: bool = is_outer) -> bool:
        return _reads(part, roots=roots, is_outer=outer)

    if _is_root(token):
        return roots
    if symbol in ("[", "!", "/", "//") and label != "array" and len(operands) == 2:
        return reads(operands[0]) or reads(operands[1], outer=False)
    if symbol in _OF_TYPES:
        return reads(operands[0])
    if symbol == "?" and len(operands) == 2:
        return (operands[1].symbol == "(" and reads(operands[1])) or reads(operands[0])
    if symbol in ("#", "$"):
        return False
    if symbol in (":", "Q{") and len(operands) == 2:
        operands = operands[1:]
        if operands and operands[0].symbol == "(name)":
            return is_outer
    if symbol == "=>" and operands[1].symbol == "(name)":
        operands = [operands[0], *operands[2:]]
    if label == "function" and symbol in _OF_FOCUS and len(operands) == (symbol in _OF_NODE):
        return is_outer or any(map(reads, operands))
    is_step = symbol in ("@", ".", "..", "(name)") or label in ("axis", "kind test", "wildcard symbol")
    if is_step or (symbol == "*" and not operands):
        return is_outer
    return any(map(reads, operands))
