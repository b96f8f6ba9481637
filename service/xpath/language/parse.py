"""Text to tree, with errors that have a column. The text and its nesting are bounded before anything reads it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from service.errors import LimitError, Place, QueryError
from service.xpath.language.functions import FUNCTIONS, SAFE_FUNCTIONS
from service.xpath.language.grammar import ArityError, read
from service.xpath.language.meaning import bind, from_document, with_stored_names
from service.xpath.language.tree import (
    STRING_FUNCTIONS,
    Call,
    Expression,
    Filter,
    Operation,
    Path,
    Written,
    children,
    distinct_of,
    type_of,
    walk,
)
from service.xpath.language.unparse import unparse
from service.xpath.language.written import read_xpath2

MAX_LENGTH = 10_000
MAX_NESTING = 100
MAX_DEPTH = 150
"""Of expressions in expressions; what evaluates them calls itself for each."""
_OF_STRINGS = frozenset({"string-length", "contains", "starts-with", "ends-with"})
_WHOLE = frozenset({"count", "position", "last", "string-length"})
_OF_XPATH_3 = (
    (r"\blet\s+\$", "`let` is XPath 3. Write `for $x in … return …`, or the expression in place of the variable."),
    (r"\|\|", "`||` is XPath 3. Write concat(…) to join texts, `or` between conditions."),
    (r"=>", "`=>` is XPath 3. Write the function around its first argument."),
    (r"!(?!=)", "`!` is XPath 3. Write a slash, or `for $x in … return …`; not(…) negates."),
)
"""What a text may hold that only XPath 3 has, and what to write instead."""
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
    def needs_xpath2(self) -> bool:
        """Whether it needs XPath 2.0."""
        return isinstance(self.tree, Written) or _uses_xpath2(self.tree)

    @property
    def only_saxon(self) -> bool:
        """Whether Saxon alone can answer it: in XPath 2.0 what stands in an element follows its attributes and
        namespaces, which libxml2, and with it our columns, has otherwise."""
        if not self.needs_xpath2:
            return False
        axes = {step.axis for part in walk(self.tree) if isinstance(part, Path) for step in part.steps}
        return "following" in axes and not axes.isdisjoint({"attribute", "namespace"})


def parse(text: str, variables: Mapping[str, str | float | bool] | None = None) -> Query:
    """Parses an XPath expression. variables: the values of `$name`.

    Raises QueryError with the column and a hint for what is none, LimitError for a text that is too long or nested
    too deeply.
    """
    _bound(text)
    warnings: list[str] = []
    try:
        tree = _tree(text, variables or {})
        _bound_depth(tree)
        tree = from_document(with_stored_names(tree, warnings, in_name=False))
    except RecursionError:
        raise LimitError("the expression is nested too deeply", remedy="Write it flatter.") from None
    return Query(tree, tuple(dict.fromkeys(warnings)))


def _tree(text: str, variables: Mapping[str, str | float | bool]) -> Expression:
    """What is XPath 1.0, with functions of 2.0 on columns, has a tree of ours. The rest may be XPath 2.0."""
    try:
        tree = read(text)
        tree = bind(tree, variables) if "$" in text else tree
    except QueryError as error:
        return _read_xpath2(text, error, variables)
    try:
        _check_types(tree)
    except QueryError as error:
        if not _uses_xpath2(tree):
            raise
        return _read_xpath2(text, error, variables)
    return read_xpath2(unparse(read(text)), variables) if _writes_numbers(tree) else tree


def _read_xpath2(text: str, error: QueryError, variables: Mapping[str, str | float | bool]) -> Expression:
    """The expression as XPath 2.0. error: why it is no XPath 1.0."""
    if isinstance(error, ArityError) or text.lstrip().startswith("+"):
        raise error
    try:
        return read_xpath2(text, variables)
    except QueryError as other:
        # The parser that came further is the one that the writer had in mind.
        chosen = max(error, other, key=_column)
        raise QueryError(chosen.what, at=chosen.at, remedy=chosen.remedy or _hint(text, chosen.what)) from None


def _column(error: QueryError) -> int:
    return error.at.column or 0 if error.at is not None else 0


def _writes_numbers(tree: Expression) -> bool:
    """Whether fractions become strings in an expression of XPath 2.0, which has other digits for them than 1.0."""
    return _uses_xpath2(tree) and any(
        type_of(argument) == "number" and not (isinstance(argument, Call) and argument.function in _WHOLE)
        for part in walk(tree)
        if isinstance(part, Call) and part.function in STRING_FUNCTIONS | _OF_STRINGS
        for argument in part.arguments[: 1 if part.function == "substring" else None]
    )


def _uses_xpath2(tree: Expression) -> bool:
    return any(isinstance(part, Call) and FUNCTIONS[part.function].is_xpath2 for part in walk(tree))


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
        elif isinstance(part, Call) and FUNCTIONS[part.function].of_nodes:
            # Around the whole, the different strings of the nodes are counted by columns too.
            different = distinct_of(part) if part is tree else None
            needed = part.arguments[:1] if different is None else (different,)
        for operand in needed:
            if type_of(operand) != "nodes":
                raise QueryError(
                    f"this is a {type_of(operand)} where nodes are needed",
                    at=Place(column=operand.span[0] + 1),
                    remedy="Use a path here.",
                )


def _bound_depth(tree: Expression) -> None:
    """Refuses a tree that is too deep, such as one of minus and plus signs in turn, without recursion."""
    depth, level = 0, [tree]
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise LimitError(f"expressions stand in each other deeper than {MAX_DEPTH}", remedy="Write it flatter.")
        level = [inner for part in level for inner in children(part)]


def _bound(text: str) -> None:
    """Refuses texts that are too long or nested too deeply, before anything recursive sees them."""
    if len(text) > MAX_LENGTH:
        raise LimitError(f"the expression has {len(text)} characters, the limit is {MAX_LENGTH}")
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


def _hint(text: str, what: str) -> str:
    if text.count("'") % 2 and text.count('"') % 2 == 0:
        return "A quotation mark is not closed."
    for opening, closing in ("[]", "()"):
        if text.count(opening) != text.count(closing):
            return f"The brackets {opening} {closing} do not match."
    for sign, instead in _OF_XPATH_3:
        if re.search(sign, text):
            return instead
    unknown = re.search(r"unknown function '(?:fn:)?([\w.-]+)'", what)
    near = get_close_matches(unknown[1], sorted(SAFE_FUNCTIONS), 1, 0.5) if unknown else []
    if near:
        return f"Did you mean {near[0]}()?"
    if "prefix" in what:
        return "MCML has no namespaces: leave the prefix out."
    if "==" in text:
        return "Compare with a single = sign."
    if "&&" in text:
        return "Write `and` and `or`."
    return "Write XPath, such as //frame[motion_name='walk']."
