"""XPath 3.1 that columns cannot evaluate: it is checked here, and evaluated by elementpath as written."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager
from typing import Any

from mcml.errors import LimitError, Place, QueryError
from mcml_service.xpath.language.arity import check_arity
from mcml_service.xpath.language.calls import MOTION_CALL, argument_spans, written_calls
from mcml_service.xpath.language.functions import AGGREGATES
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, PREFIX, RUNS, WINDOW
from mcml_service.xpath.language.reach import Projection
from mcml_service.xpath.language.tree import Atomic, Written
from mcml_service.xpath.language.xpath31.parser import XPath31, read_tokens
from mcml_service.xpath.language.xpath31.scope import (
    OF_BODIES,
    Scope,
    calls_of_all,
    free_names,
    gives_nodes,
    mark_scope,
    reads_document,
    tokens_of,
)
from mcml_service.xpath.language.xpath31.token_types import projection_of

_KIND_TEST_BEFORE_SIGN = re.compile(
    r"""'[^']*'|"[^"]*"|\b((?:node|text|comment|processing-instruction)\(\s*\))(?=\s*[+*?])"""
)
_ATTRIBUTE_KIND_TEST = re.compile(r"""'[^']*'|"[^"]*"|(@)(?=\s*(?:node|text|comment|processing-instruction)\s*\()""")
_OF_FRAMES = frozenset(name.replace(PREFIX, OF_BODIES) for name in (WINDOW, RUNS))


class _WithBodies(XPath31):
    """With functions of bodies in motion."""


for _function in MOTION_FUNCTIONS:
    # How many arguments they take is checked here.
    _WithBodies.function(_function.replace(PREFIX, OF_BODIES), nargs=(0, None))
_WithBodies.build()


@contextmanager
def _within_depth() -> Iterator[None]:
    """Raise LimitError for an expression that is parsed, and nested too deeply to be examined."""
    try:
        yield
    except RecursionError:
        raise LimitError("the expression is nested too deeply", remedy="Write it flatter.") from None


def read_written(text: str, variables: Mapping[str, Atomic], *, compatible: bool = True) -> Written:
    """The expression as a tree of one node.

    compatible: in XPath 1.0 compatibility mode. Raises QueryError for invalid XPath 3.1, and for expressions that read
    files, the network or the environment.
    """
    text = spell_for_elementpath(text)
    root = _read(text, compatible=compatible)
    for token in tokens_of(root):
        _check(token)
    needed: dict[str, int] = {}
    for name, token in free_names(root):
        needed.setdefault(name, token.span[0] + 1)
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
    motion = tuple(found.call for found in written_calls(text, dict(bound)))
    constant = not motion and not reads_document(root)
    return Written(text, bound, function, tuple(inner), gives_nodes(root, others=_OF_FRAMES), motion, constant)


@_within_depth()
def find_scope(text: str, *, compatible: bool) -> Scope:
    """Whether an expression needs several documents together, and whether each has its own answer."""
    return mark_scope(_read(text, compatible=compatible))


@_within_depth()
def with_values(written: Written, functions: Set[str], value_of: Callable[[str], str | None]) -> Written:
    """The expression with values in the place of calls of functions that have one for all documents.

    In the mode compatible with XPath 1.0. value_of: the value of a call as an expression; None where it stays.
    """
    text, variables = written.text, dict(written.variables)
    places = [token.span[0] for token in calls_of_all(_read(text, compatible=True), functions)]
    for start in sorted(places, reverse=True):
        _, end = argument_spans(text, text.index("(", start) + 1)
        value = None if text[:start].endswith(":") else value_of(text[start:end])
        if value is not None:
            text = f"{text[:start]}{value}{text[end:]}"
    return written if text == written.text else read_written(text, variables)


@_within_depth()
def find_projection(text: str, *, compatible: bool) -> Projection:
    """The least projection on which an expression has its value, nodes serialised."""
    return projection_of(_read(text, compatible=compatible))


def _read(text: str, *, compatible: bool) -> Any:
    return read_tokens(MOTION_CALL.sub(_unprefixed, text), compatible=compatible, parser=_WithBodies)


def spell_for_elementpath(text: str) -> str:
    """The expression as elementpath reads it rightly."""
    # It takes the + of `node() + 1` for an occurrence indicator of XPath 2.0; a predicate keeps them apart.
    text = _KIND_TEST_BEFORE_SIGN.sub(lambda match: match.group() + "[true()]" * bool(match.group(1)), text)
    # It knows `attribute::node()`, but not its abbreviation.
    return _ATTRIBUTE_KIND_TEST.sub(lambda match: "attribute::" if match.group(1) else match.group(), text)


def _unprefixed(found: re.Match[str]) -> str:
    return found[0].replace(PREFIX, OF_BODIES) if found[1] else found[0]


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
    if token.label == "function" and token.symbol.startswith(OF_BODIES):
        check_arity(token.symbol.replace(OF_BODIES, PREFIX, 1), len(token), token.span[0] + 1)


def split_arguments(text: str) -> list[str]:
    """The arguments of the call that a text is; none if it is more than one call."""
    spans, end = argument_spans(text, text.index("(") + 1)
    return [text[start:stop] for start, stop in spans] if not text[end:].strip() else []
