"""Text to tree, with errors that have a column.

elementpath parses; its tokens become our own tree, so that nothing else depends on it. The ordinary entry of
elementpath evaluates constants while parsing, which a hostile text makes last for minutes; `tdop.Parser.parse` only
parses. The text and its nesting are bounded before.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from elementpath import XPath1Parser, XPath2Parser
from elementpath.exceptions import ElementPathError
from elementpath.tdop import Parser

from service.errors import LimitError, Place, QueryError
from service.xpath.later import SAFE_FUNCTIONS, sequence
from service.xpath.meaning import bind, from_document, with_stored_names
from service.xpath.tokens import expression
from service.xpath.tree import (
    BOOLEAN_FUNCTIONS,
    LATER_FUNCTIONS,
    NEED_NODES,
    NODES_FUNCTIONS,
    NUMBER_FUNCTIONS,
    STRING_FUNCTIONS,
    Call,
    Expression,
    Filter,
    Operation,
    Path,
    Sequence,
    type_of,
    walk,
)
from service.xpath.unparse import unparse

MAX_LENGTH = 10_000
MAX_NESTING = 100
FUNCTIONS = NODES_FUNCTIONS | NUMBER_FUNCTIONS | STRING_FUNCTIONS | BOOLEAN_FUNCTIONS | LATER_FUNCTIONS
_KIND_TEST_BEFORE_SIGN = re.compile(
    r"""'[^']*'|"[^"]*"|\b((?:node|text|comment|processing-instruction)\(\s*\))(?=\s*[+*?])"""
)
_ATTRIBUTE_KIND_TEST = re.compile(r"""'[^']*'|"[^"]*"|(@)(?=\s*(?:node|text|comment|processing-instruction)\s*\()""")
_OF_STRINGS = frozenset({"string-length", "contains", "starts-with", "ends-with"})
_WHOLE = frozenset({"count", "position", "last", "string-length"})
_LONG_NUMBER = re.compile(r"""'[^']*'|"[^"]*"|([0-9]{301})""")


@dataclass(frozen=True, slots=True)
class Query:
    """A parsed expression.

    tree: motion names in comparisons are in the form in which they are stored, paths outside of predicates start at the
    document, which is the context node (`mcml` is `/mcml`), and variables are the values they are bound to.
    warnings: what the writer should know, such as a name that was a synonym.
    """

    tree: Expression
    warnings: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The tree as an expression."""
        return unparse(self.tree)

    @property
    def later(self) -> bool:
        """Whether it needs XPath 2.0."""
        return isinstance(self.tree, Sequence) or _is_later(self.tree)


def parse(text: str, variables: Mapping[str, str | float | bool] | None = None) -> Query:
    """Parses an XPath expression. variables: the values of `$name`.

    Raises QueryError with the column and a hint for what is none, LimitError for a text that is too long or nested
    too deeply.
    """
    _bound(text, MAX_LENGTH)
    text = readable(text)
    warnings: list[str] = []
    try:
        tree = _parse_tree(text, variables or {})
        tree = from_document(with_stored_names(tree, warnings, in_name=False))
    except RecursionError:
        raise LimitError("the expression is nested too deeply", remedy="Write it flatter.") from None
    return Query(tree, tuple(dict.fromkeys(warnings)))


def readable(text: str) -> str:
    """The expression as elementpath reads it rightly."""
    # It takes the + of `node() + 1` for an occurrence indicator of XPath 2.0; a predicate keeps them apart.
    text = _KIND_TEST_BEFORE_SIGN.sub(lambda match: match.group() + "[true()]" * bool(match.group(1)), text)
    # It knows `attribute::node()`, but not its abbreviation.
    return _ATTRIBUTE_KIND_TEST.sub(lambda match: "attribute::" if match.group(1) else match.group(), text)


def _parse_tree(text: str, variables: Mapping[str, str | float | bool]) -> Expression:
    _bound(text, MAX_LENGTH * 2)
    try:
        tree = expression(Parser.parse(XPath1Parser(), text))
    except (ElementPathError, QueryError) as error:
        return _parse_more(text, error, variables)
    tree = bind(tree, variables) if "$" in text else tree
    _check_types(tree)
    return _parse_later(text, variables) if _writes_numbers(tree) else tree


def _parse_later(text: str, variables: Mapping[str, str | float | bool]) -> Expression:
    return sequence(text, Parser.parse(XPath2Parser(), text), variables)


def _parse_more(
    text: str, error: ElementPathError | QueryError, variables: Mapping[str, str | float | bool]
) -> Expression:
    """What the parser of XPath 1.0 refuses: a path that starts with a function is XPath 1.0, the rest may be 2.0."""
    try:
        root = Parser.parse(XPath2Parser(), text)
    except ElementPathError as later:
        first = error if isinstance(error, QueryError) else _query_error(text, str(error))
        other = _query_error(text, str(later))
        # The parser that came further is the one that the writer had in mind.
        raise max(first, other, key=_column) from None
    if root.symbol == "+" and len(root) == 1 and isinstance(error, QueryError):
        raise error
    try:
        tree = expression(root)
        unknown = any(isinstance(part, Call) and part.function not in FUNCTIONS for part in walk(tree))
        if not unknown:
            tree = bind(tree, variables)
            _check_types(tree)
            if not _writes_numbers(tree):
                return tree
    except QueryError:
        # Our tree has no place for it.
        pass
    return sequence(text, root, variables)


def _column(error: QueryError) -> int:
    return error.at.column or 0 if error.at is not None else 0


def _writes_numbers(tree: Expression) -> bool:
    """Whether fractions become strings in an expression of XPath 2.0, which has other digits for them than 1.0."""
    return _is_later(tree) and any(
        type_of(argument) == "number" and not (isinstance(argument, Call) and argument.function in _WHOLE)
        for part in walk(tree)
        if isinstance(part, Call) and part.function in STRING_FUNCTIONS | _OF_STRINGS
        for argument in part.arguments[: 1 if part.function == "substring" else None]
    )


def _is_later(tree: Expression) -> bool:
    return any(isinstance(part, Call) and part.function in LATER_FUNCTIONS for part in walk(tree))


def _check_types(tree: Expression) -> None:
    """Refuses what XPath 1.0 gives no meaning: a predicate, path, union or count of something that is no node set."""
    for part in walk(tree):
        needed: tuple[Expression, ...] = ()
        if isinstance(part, Filter):
            needed = (part.operand,)
        elif isinstance(part, Path) and part.start is not None:
            needed = (part.start,)
        elif isinstance(part, Operation) and part.operator == "|":
            needed = part.operands
        elif isinstance(part, Call) and part.function in NEED_NODES:
            needed = part.arguments[:1]
        for operand in needed:
            if type_of(operand) != "nodes":
                raise QueryError(
                    f"this is a {type_of(operand)} where nodes are needed",
                    at=Place(column=operand.span[0] + 1),
                    remedy="Use a path here.",
                )


def _bound(text: str, max_length: int) -> None:
    """Refuses texts that are too long or nested too deeply, before anything recursive sees them."""
    if len(text) > max_length:
        raise LimitError(f"the expression has {len(text)} characters, the limit is {max_length}")
    if "\x00" in text:
        raise QueryError("an expression cannot hold the character U+0000", at=Place(column=text.index("\x00") + 1))
    depth = 0
    quote = ""
    for column, letter in enumerate(text, start=1):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in "([":
            depth += 1
            if depth > MAX_NESTING:
                raise LimitError(f"brackets are nested deeper than {MAX_NESTING}", at=Place(column=column))
        elif letter in ")]":
            depth -= 1
    for number in _LONG_NUMBER.finditer(text):
        if number.group(1):
            raise LimitError("a number has more than 300 digits", at=Place(column=number.start() + 1))
    if re.search(r"-(?:\s*-){100}", text):
        raise LimitError("more than 100 minus signs in a row")


def _query_error(text: str, message: str) -> QueryError:
    found = re.search(r"at line (\d+), column (\d+): (?:\[err:(\w+)\] )?(.*)", message, re.DOTALL)
    column = 1
    what = message
    if found:
        lines = text.split("\n")[: int(found.group(1)) - 1]
        column = sum(len(line) + 1 for line in lines) + int(found.group(2))
        what = found.group(4)
    return QueryError(what.rstrip("."), at=Place(column=column), remedy=_hint(text, what))


def _hint(text: str, what: str) -> str:
    if text.count("'") % 2 and text.count('"') % 2 == 0:
        return "A quotation mark is not closed."
    for opening, closing in ("[]", "()"):
        if text.count(opening) != text.count(closing):
            return f"The brackets {opening} {closing} do not match."
    unknown = re.search(r"unknown function '(?:fn:)?([\w.-]+)'", what)
    near = get_close_matches(unknown[1], sorted(SAFE_FUNCTIONS), 1, 0.5) if unknown else []
    if near:
        return f"Did you mean {near[0]}()?"
    if "prefix" in what:
        return "MCML has no namespaces: leave the prefix out."
    if "==" in text:
        return "Compare with a single = sign."
    if "&&" in text or "||" in text:
        return "Write `and` and `or`."
    return "Write XPath, such as //frame[motion_name='walk']."
