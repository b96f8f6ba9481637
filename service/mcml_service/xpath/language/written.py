"""What of XPath 2.0 has no tree of ours: it is checked here, and evaluated by Saxon as it is written.

Such an expression must not reach out of the document, so the functions it may call are listed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from elementpath.exceptions import ElementPathError
from elementpath.tdop import Parser
from elementpath.xpath31 import XPath31Parser

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.arity import check_arity
from mcml_service.xpath.language.calls import MOTION_CALL, argument_spans, written_calls
from mcml_service.xpath.language.functions import AGGREGATES, OF_CONTEXT, SAFE_FUNCTIONS
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, PREFIX, RUNS, WINDOW
from mcml_service.xpath.language.tree import Written

TYPES = frozenset({"string", "double", "decimal", "integer", "boolean", "float"})
"""Types of `xs:` that may be named."""
_BINDERS = ("for", "let", "some", "every")
_REFUSED = {
    "inline function": "a function cannot stand here",
    "map": "maps are not offered",
    "array": "arrays are not offered",
}
"""Kinds of tokens in which others are that are not looked at, and why they are refused."""
_NODE_OPERATORS = ("union", "intersect", "except", "|")
_STEPS = ("@", "*", ".", "..")
_KIND_TEST_BEFORE_SIGN = re.compile(
    r"""'[^']*'|"[^"]*"|\b((?:node|text|comment|processing-instruction)\(\s*\))(?=\s*[+*?])"""
)
_ATTRIBUTE_KIND_TEST = re.compile(r"""'[^']*'|"[^"]*"|(@)(?=\s*(?:node|text|comment|processing-instruction)\s*\()""")
_COMMENT = re.compile(r"""'[^']*'|"[^"]*"|(\(:)""")
_UNPREFIXED = "mo-"
"""What stands for the prefix of functions of bodies in motion: elementpath has none in the names of functions."""
_OF_FRAMES = frozenset(name.replace(PREFIX, _UNPREFIXED) for name in (WINDOW, RUNS))


class _XPath3(XPath31Parser):
    """XPath 2.0 with functions of bodies in motion."""


for _function in MOTION_FUNCTIONS:
    # How many arguments they take is checked here.
    _XPath3.function(_function.replace(PREFIX, _UNPREFIXED), nargs=(0, None))
_XPath3.build()


def read_xpath2(text: str, variables: Mapping[str, str | float | bool]) -> Written:
    """The expression as a tree of one node.

    elementpath parses it. Its ordinary entry evaluates constants while parsing, which a hostile text makes last for
    minutes; `tdop.Parser.parse` only parses. Raises QueryError for what is no XPath 2.0, or may not be asked.
    """
    text = spell_for_elementpath(text)
    try:
        root = Parser.parse(_XPath3(), MOTION_CALL.sub(_unprefixed, text))
    except ElementPathError as error:
        raise _query_error(text, str(error)) from None
    for comment in _COMMENT.finditer(text):
        if comment.group(1):
            raise QueryError("an expression cannot hold comments", at=Place(column=comment.start() + 1))
    for token in root.iter():
        _check(token, _name(token, text))
    needed = _variables(root)
    for name, column in needed.items():
        if name not in variables:
            raise QueryError(
                f"the variable ${name} has no value",
                at=Place(column=column),
                remedy="Give it one with the request, or bind it with for, some or every.",
            )
    bound = tuple((name, variables[name]) for name in needed)
    inner = split_arguments(text) if root.label == "function" and root.symbol in AGGREGATES else []
    function = root.symbol if inner else ""
    spans = any(_is_of_sequences(token) for token in root.iter() if token is not root or not function)
    motion = tuple(found.call for found in written_calls(text, dict(bound)))
    constant = not motion and not any(map(_is_of_nodes, _with_parents(root)))
    return Written(text, bound, function, tuple(inner), _gives_nodes(root), spans, motion, constant)


def spell_for_elementpath(text: str) -> str:
    """The expression as elementpath reads it rightly."""
    # It takes the + of `node() + 1` for an occurrence indicator of XPath 2.0; a predicate keeps them apart.
    text = _KIND_TEST_BEFORE_SIGN.sub(lambda match: match.group() + "[true()]" * bool(match.group(1)), text)
    # It knows `attribute::node()`, but not its abbreviation.
    return _ATTRIBUTE_KIND_TEST.sub(lambda match: "attribute::" if match.group(1) else match.group(), text)


def _unprefixed(found: re.Match[str]) -> str:
    return found[0].replace(PREFIX, _UNPREFIXED) if found[1] else found[0]


def _query_error(text: str, message: str) -> QueryError:
    found = re.search(r"at line (\d+), column (\d+): (?:\[err:(\w+)\] )?(.*)", message, re.DOTALL)
    column = 1
    what = message
    if found:
        lines = text.split("\n")[: int(found.group(1)) - 1]
        column = sum(len(line) + 1 for line in lines) + int(found.group(2))
        what = found.group(4)
    return QueryError(what.rstrip("."), at=Place(column=column))


def _name(token: Any, text: str) -> str:
    """What the writer calls a function."""
    name = str(token.symbol)
    is_motion = token.label == "function" and text.startswith(PREFIX, token.span[0])
    return name.replace(_UNPREFIXED, PREFIX, 1) if is_motion else name


def _check(token: Any, name: str) -> None:
    column = token.span[0] + 1
    if token.label in _REFUSED or token.symbol in ("#", "?"):
        what = _REFUSED.get(token.label, f"{token.symbol} is not offered")
        raise QueryError(f"{what}, beside what only Saxon evaluates", at=Place(column=column))
    if token.symbol == "Q{" and token[0].value:
        raise QueryError("MCML has no namespaces", at=Place(column=column), remedy="Write Q{}, or leave it out.")
    if token.symbol == "=>" and token[1].symbol in ("(name)", "$", "("):
        raise QueryError("the function behind => is not offered", at=Place(column=column))
    if token.symbol == ":":
        prefix, local = (getattr(part, "value", None) or part.symbol for part in (token[0], token[1]))
        local = token[1].symbol if token[1].label != "name" else local
        is_function = token[1].label == "function"
        if (prefix == "fn" and is_function) or (prefix == "xs" and local in TYPES) or prefix == "*":
            return
        if prefix == "math" and is_function and f"math:{local}" in SAFE_FUNCTIONS:
            return
        raise QueryError(
            f"{prefix}: cannot be used here", at=Place(column=column), remedy="MCML has no namespaces: leave it out."
        )
    name = f"math:{name}" if token.label == "function" and f"math:{name}" in SAFE_FUNCTIONS else name
    if token.label == "function" and name not in SAFE_FUNCTIONS:
        raise QueryError(
            f"the function {name}() is not offered",
            at=Place(column=column),
            remedy="Use the functions that docs/xpath.md lists.",
        )
    if token.label == "function":
        check_arity(name, len(token), column)
    if token.label == "constructor function" and token.symbol not in TYPES | set(SAFE_FUNCTIONS):
        raise QueryError(f"the type {token.symbol} is not offered", at=Place(column=column))


def _is_of_sequences(token: Any) -> bool:
    known = SAFE_FUNCTIONS.get(token.symbol) if token.label == "function" else None
    return token.symbol in ("some", "every") or (known is not None and known.takes_items)


def _with_parents(root: Any) -> Iterator[tuple[Any, Any]]:
    """All tokens, each with that in which it is."""
    waiting = [(root, None)]
    while waiting:
        token, parent = waiting.pop()
        yield token, parent
        waiting += [(child, token) for child in token]


def _is_of_nodes(pair: tuple[Any, Any]) -> bool:
    """Whether a token is a step, or looks at the context."""
    token, parent = pair
    if token.symbol == "(name)":
        return parent is None or parent.symbol not in ("$", ":")
    if token.label == "function" and token.symbol in OF_CONTEXT | {"position", "last", "id", "lang", "root"}:
        return True
    is_step = token.symbol in ("/", "//", "@", ".", "..") or token.label in ("axis", "kind test", "wildcard symbol")
    return is_step or (token.symbol == "*" and not len(token))


def _gives_nodes(token: Any) -> bool:
    """Whether the value can only be nodes, as far as the syntax tells; asked where the value is empty."""
    symbol, operands = token.symbol, list(token)
    if symbol in _NODE_OPERATORS or token.label in ("axis", "kind test", "name") or symbol in _STEPS:
        return True
    if symbol in ("/", "//"):
        return not operands or _gives_nodes(operands[-1])
    if symbol == "[":
        return _gives_nodes(operands[0])
    if symbol in _OF_FRAMES:
        return True
    if symbol == "if":
        return all(map(_gives_nodes, operands[1:]))
    if symbol in ("for", "let", "!"):
        return _gives_nodes(operands[-1])
    return symbol in ("(", ",") and bool(operands) and all(map(_gives_nodes, operands))


def _variables(root: Any) -> dict[str, int]:
    """Names of variables that the expression does not bind itself, each with the column of its first use."""
    bound: set[str] = set()
    for token in root.iter():
        if token.symbol in _BINDERS:
            bound.update(str(part[0].value) for part in list(token)[:-1:2] if part.symbol == "$")
    used: dict[str, int] = {}
    for token in root.iter():
        if token.symbol == "$" and token[0].value not in bound:
            used.setdefault(str(token[0].value), token.span[0] + 1)
    return used


def split_arguments(text: str) -> list[str]:
    """The arguments of the call that a text is; none if it is more than one call."""
    spans, end = argument_spans(text, text.index("(") + 1)
    return [text[start:stop] for start, stop in spans] if not text[end:].strip() else []
