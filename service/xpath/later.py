"""What of XPath 2.0 has no tree of ours: it is checked here, and evaluated by Saxon as it is written.

Such an expression must not reach out of the document, so the functions it may call are listed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from service.errors import Place, QueryError
from service.xpath.tree import (
    BOOLEAN_FUNCTIONS,
    LATER_FUNCTIONS,
    NODES_FUNCTIONS,
    NUMBER_FUNCTIONS,
    STRING_FUNCTIONS,
    Sequence,
)

AGGREGATES = frozenset({"count", "sum", "min", "max", "avg", "exists", "empty", "distinct-values", "string-join"})
"""Functions that, around the whole expression, make one value of all documents together."""
SAFE_FUNCTIONS = (
    NODES_FUNCTIONS | NUMBER_FUNCTIONS | STRING_FUNCTIONS | BOOLEAN_FUNCTIONS | LATER_FUNCTIONS | AGGREGATES
) | {
    "matches", "replace", "tokenize", "index-of", "data", "reverse", "subsequence", "insert-before", "remove",
    "compare", "deep-equal", "codepoints-to-string", "string-to-codepoints", "round-half-to-even", "zero-or-one",
    "one-or-more", "exactly-one", "root", "unordered",
}  # fmt: skip
"""Functions that see nothing but their arguments and the document."""
TYPES = frozenset({"string", "double", "decimal", "integer", "boolean", "float"})
"""Types of `xs:` that may be named."""
_BINDERS = ("for", "some", "every")
_NODE_OPERATORS = ("union", "intersect", "except", "|")
_STEPS = ("@", "*", ".", "..")
_COMMENT = re.compile(r"""'[^']*'|"[^"]*"|(\(:)""")


def sequence(text: str, root: Any, variables: Mapping[str, str | float | bool]) -> Sequence:
    """The expression as a tree of one node. root: elementpath's tokens of it. QueryError for what may not be asked."""
    for comment in _COMMENT.finditer(text):
        if comment.group(1):
            raise QueryError("an expression cannot hold comments", at=Place(column=comment.start() + 1))
    for token in root.iter():
        _check(token)
    needed = _variables(root)
    for name, column in needed.items():
        if name not in variables:
            raise QueryError(
                f"the variable ${name} has no value",
                at=Place(column=column),
                remedy="Give it one with the request, or bind it with for, some or every.",
            )
    bound = tuple((name, variables[name]) for name in needed)
    inner = arguments(text) if root.label == "function" and root.symbol in AGGREGATES else []
    function = root.symbol if inner else ""
    return Sequence(text, bound, function, tuple(inner), _gives_nodes(root))


def _check(token: Any) -> None:
    column = token.span[0] + 1
    if token.symbol == ":":
        prefix, local = (getattr(part, "value", None) or part.symbol for part in (token[0], token[1]))
        local = token[1].symbol if token[1].label != "name" else local
        if (prefix == "fn" and token[1].label == "function") or (prefix == "xs" and local in TYPES):
            return
        raise QueryError(
            f"{prefix}: cannot be used here", at=Place(column=column), remedy="MCML has no namespaces: leave it out."
        )
    if token.label == "function" and token.symbol not in SAFE_FUNCTIONS:
        raise QueryError(
            f"the function {token.symbol}() is not offered",
            at=Place(column=column),
            remedy="Use the functions that docs/xpath.md lists.",
        )
    if token.label == "constructor function" and token.symbol not in TYPES | SAFE_FUNCTIONS:
        raise QueryError(f"the type {token.symbol} is not offered", at=Place(column=column))


def _gives_nodes(token: Any) -> bool:
    """Whether the value can only be nodes, as far as the syntax tells; asked where the value is empty."""
    symbol, operands = token.symbol, list(token)
    if symbol in _NODE_OPERATORS or token.label in ("axis", "kind test", "name") or symbol in _STEPS:
        return True
    if symbol in ("/", "//"):
        return not operands or _gives_nodes(operands[-1])
    if symbol == "[":
        return _gives_nodes(operands[0])
    if symbol == "if":
        return all(map(_gives_nodes, operands[1:]))
    if symbol == "for":
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


def arguments(text: str) -> list[str]:
    """The arguments of the call that a text is; none if it is more than one call."""
    inner = text[text.index("(") + 1 :].rstrip()
    result = [""]
    depth, quote = 1, ""
    for place, letter in enumerate(inner):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in "([":
            depth += 1
        elif letter in ")]":
            depth -= 1
            if depth == 0:
                return [part.strip() for part in result] if place == len(inner) - 1 else []
        elif letter == "," and depth == 1:
            result.append("")
            continue
        result[-1] += letter
    return []
