"""XPath 3.1 that columns cannot evaluate: it is checked here, and evaluated by elementpath as written."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.arity import check_arity
from mcml_service.xpath.language.calls import MOTION_CALL, argument_spans, written_calls
from mcml_service.xpath.language.functions import AGGREGATES, OF_CONTEXT, SAFE_FUNCTIONS
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, PREFIX, RUNS, WINDOW
from mcml_service.xpath.language.tree import Atomic, Written
from mcml_service.xpath.language.xpath31.parser import XPath31, read_tokens

_BINDERS = ("for", "let", "some", "every")
_NODE_OPERATORS = ("union", "intersect", "except", "|")
_STEPS = ("@", "*", ".", "..")
_KIND_TEST_BEFORE_SIGN = re.compile(
    r"""'[^']*'|"[^"]*"|\b((?:node|text|comment|processing-instruction)\(\s*\))(?=\s*[+*?])"""
)
_ATTRIBUTE_KIND_TEST = re.compile(r"""'[^']*'|"[^"]*"|(@)(?=\s*(?:node|text|comment|processing-instruction)\s*\()""")
_UNPREFIXED = "mo-"
"""Replacement for the prefix of functions of bodies in motion: elementpath allows none in names of functions."""
_OF_FRAMES = frozenset(name.replace(PREFIX, _UNPREFIXED) for name in (WINDOW, RUNS))


class _WithBodies(XPath31):
    """With functions of bodies in motion."""


for _function in MOTION_FUNCTIONS:
    # How many arguments they take is checked here.
    _WithBodies.function(_function.replace(PREFIX, _UNPREFIXED), nargs=(0, None))
_WithBodies.build()


def read_written(text: str, variables: Mapping[str, Atomic], *, compatible: bool = True) -> Written:
    """The expression as a tree of one node.

    compatible: in XPath 1.0 compatibility mode. Raises QueryError for invalid XPath 3.1, and for expressions that read
    files, the network or the environment.
    """
    text = spell_for_elementpath(text)
    root = read_tokens(MOTION_CALL.sub(_unprefixed, text), compatible=compatible, parser=_WithBodies)
    for token in _tokens(root):
        _check(token)
    needed = _variables(root)
    for name, column in needed.items():
        if name not in variables:
            raise QueryError(
                f"the variable ${name} has no value",
                at=Place(column=column),
                remedy="Pass a value in the request, or bind it with for, let, some or every.",
                xpath_error="XPST0008",
            )
    bound = tuple((name, variables[name]) for name in needed)
    inner = split_arguments(text) if root.label == "function" and root.symbol in AGGREGATES else []
    function = root.symbol if inner else ""
    spans = any(_is_of_sequences(token) for token in root.iter() if token is not root or not function)
    # A path from the root in an inline function or a map needs all documents; items of one document do not.
    spans = spans or any(_is_of_sequences(token) and _has_root(token) for token in _tokens(root) if token is not root)
    motion = tuple(found.call for found in written_calls(text, dict(bound)))
    constant = not motion and not _reads_document(root)
    return Written(text, bound, function, tuple(inner), _gives_nodes(root), spans, motion, constant)


def spell_for_elementpath(text: str) -> str:
    """The expression as elementpath reads it rightly."""
    # It takes the + of `node() + 1` for an occurrence indicator of XPath 2.0; a predicate keeps them apart.
    text = _KIND_TEST_BEFORE_SIGN.sub(lambda match: match.group() + "[true()]" * bool(match.group(1)), text)
    # It knows `attribute::node()`, but not its abbreviation.
    return _ATTRIBUTE_KIND_TEST.sub(lambda match: "attribute::" if match.group(1) else match.group(), text)


def _unprefixed(found: re.Match[str]) -> str:
    return found[0].replace(PREFIX, _UNPREFIXED) if found[1] else found[0]


def _check(token: Any) -> None:
    """Refuse functions of bodies with wrong arguments, unknown functions, and names in namespaces, which MCML does
    not have.
    """
    place = Place(column=token.span[0] + 1)
    if token.symbol == "Q{" and token[0].value and token[1].label not in ("function", "constructor function"):
        raise QueryError("MCML has no namespaces", at=place, remedy="Write Q{}, or leave it out.")
    named = {"=>": 1, "#": 0}.get(token.symbol)
    if named is not None and token[named].symbol == "(name)" and token[named].value not in XPath31.symbol_table:
        raise QueryError(f"unknown function {token[named].value!r}", at=place, xpath_error="XPST0017")
    if token.label == "function" and token.symbol.startswith(_UNPREFIXED):
        check_arity(token.symbol.replace(_UNPREFIXED, PREFIX, 1), len(token), token.span[0] + 1)


def _is_of_sequences(token: Any) -> bool:
    known = SAFE_FUNCTIONS.get(token.symbol) if token.label == "function" else None
    return token.symbol in ("some", "every") or (known is not None and known.takes_items)


_OF_TYPES = frozenset({"instance", "treat", "cast", "castable"})
_OF_NODE = frozenset({"id", "idref", "element-with-id", "lang"})
"""Functions that with one argument look at the document of the focus."""
_OF_FOCUS = OF_CONTEXT | _OF_NODE | {"position", "last", "data", "root", "path", "has-children", "node-name", "nilled"}
_OF_FOCUS |= {"base-uri", "document-uri", "generate-id"}
"""Functions that without an argument look at the focus."""


def _parts(token: Any) -> Iterator[Any]:
    """Yield the tokens in a token, also those that elementpath does not list."""
    yield from token
    yield from getattr(token, "_values", ()) if token.label == "map" else ()
    if token.label == "inline function":
        yield token.body


def _tokens(token: Any) -> Iterator[Any]:
    """Yield a token and all tokens in it, also those that elementpath does not list."""
    yield token
    for part in _parts(token):
        yield from _tokens(part)


def _has_root(token: Any) -> bool:
    """Whether an absolute path is in it."""
    return any(part.symbol in ("/", "//") and len(part) < 2 for part in _tokens(token))


def _reads_document(token: Any, *, is_outer: bool = True) -> bool:
    """Whether the value may depend on a document. is_outer: the focus is the document, no item of the expression."""
    symbol, label, operands = token.symbol, token.label, list(_parts(token))
    if symbol in ("/", "//") and len(operands) < 2:
        return True
    if symbol in ("[", "!", "/", "//") and label != "array" and len(operands) == 2:
        return _reads_document(operands[0], is_outer=is_outer) or _reads_document(operands[1], is_outer=False)
    if symbol in _OF_TYPES:
        return _reads_document(operands[0], is_outer=is_outer)
    if symbol == "?" and len(operands) == 2:
        inside = operands[1].symbol == "(" and _reads_document(operands[1], is_outer=is_outer)
        return inside or _reads_document(operands[0], is_outer=is_outer)
    if symbol in ("#", "$"):
        return False
    if symbol in (":", "Q{") and len(operands) == 2:
        operands = operands[1:]
        if operands and operands[0].symbol == "(name)":
            return is_outer
    if label == "function" and symbol in _OF_FOCUS and len(operands) == (symbol in _OF_NODE):
        return is_outer or any(_reads_document(one, is_outer=is_outer) for one in operands)
    is_step = symbol in ("@", ".", "..", "(name)") or label in ("axis", "kind test", "wildcard symbol")
    if is_step or (symbol == "*" and not operands):
        return is_outer
    return any(_reads_document(one, is_outer=is_outer) for one in operands)


def _gives_nodes(token: Any) -> bool:
    """Tell whether the value can only be nodes, by its syntax; used for empty values."""
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
    for token in _tokens(root):
        if token.label == "inline function":
            bound.update(token.varnames)
        if token.symbol in _BINDERS:
            bound.update(str(part[0].value) for part in list(token)[:-1:2] if part.symbol == "$")
    used: dict[str, int] = {}
    for token in _tokens(root):
        if token.symbol == "$" and token[0].value not in bound:
            used.setdefault(str(token[0].value), token.span[0] + 1)
    return used


def split_arguments(text: str) -> list[str]:
    """The arguments of the call that a text is; none if it is more than one call."""
    spans, end = argument_spans(text, text.index("(") + 1)
    return [text[start:stop] for start, stop in spans] if not text[end:].strip() else []
