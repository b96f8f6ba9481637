"""Text to tree, with errors that have a column.

elementpath parses; its tokens become our own tree, so that nothing else depends on it. The ordinary entry of
elementpath evaluates constants while parsing, which a hostile text makes last for minutes; `tdop.Parser.parse` only
parses. The text and its nesting are bounded before.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from elementpath import XPath1Parser, XPath2Parser
from elementpath.exceptions import ElementPathError
from elementpath.tdop import Parser

from service.errors import LimitError, Place, QueryError, VocabularyError
from service.mcml.motion_names import canonical
from service.mcml.vocabulary import MOTION_NAME
from service.xpath.tree import (
    AXES,
    BOOLEAN_FUNCTIONS,
    KIND_TESTS,
    LATER_FUNCTIONS,
    NEED_NODES,
    NODES_FUNCTIONS,
    NUMBER_FUNCTIONS,
    STRING_FUNCTIONS,
    Call,
    Expression,
    Filter,
    Literal,
    Operation,
    Path,
    Span,
    Step,
    type_of,
    walk,
    with_children,
)
from service.xpath.unparse import unparse

MAX_LENGTH = 10_000
MAX_NESTING = 100
OPERATORS = ("or", "and", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "div", "mod", "|")
FUNCTIONS = NODES_FUNCTIONS | NUMBER_FUNCTIONS | STRING_FUNCTIONS | BOOLEAN_FUNCTIONS | LATER_FUNCTIONS
CONTEXT_FUNCTIONS = (
    "string", "number", "string-length", "normalize-space", "name", "local-name", "namespace-uri",
)  # fmt: skip
"""Functions that without an argument take the context node."""

_KIND_TEST_BEFORE_SIGN = re.compile(
    r"""'[^']*'|"[^"]*"|\b((?:node|text|comment|processing-instruction)\(\s*\))(?=\s*[+*?])"""
)
_LONG_NUMBER = re.compile(r"""'[^']*'|"[^"]*"|([0-9]{301})""")
ANY_NODE = Step("descendant-or-self", "node()")


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
        return any(isinstance(part, Call) and part.function in LATER_FUNCTIONS for part in walk(self.tree))


def parse(text: str, variables: Mapping[str, str | float | bool] | None = None) -> Query:
    """Parses an XPath expression. variables: the values of `$name`.

    Raises QueryError with the column and a hint for what is none, LimitError for a text that is too long or nested
    too deeply.
    """
    _bound(text, MAX_LENGTH)
    # elementpath takes the + of `node() + 1` for an occurrence indicator of XPath 2.0; a predicate keeps them apart.
    text = _KIND_TEST_BEFORE_SIGN.sub(lambda match: match.group() + "[true()]" * bool(match.group(1)), text)
    warnings: list[str] = []
    try:
        tree = _bind(_parse_tree(text, MAX_LENGTH * 2), variables or {})
        _check_types(tree)
        tree = _from_document(_with_stored_names(tree, warnings, in_name=False))
    except RecursionError:
        raise LimitError("the expression is nested too deeply", remedy="Write it flatter.") from None
    return Query(tree, tuple(dict.fromkeys(warnings)))


def _parse_tree(text: str, max_length: int) -> Expression:
    _bound(text, max_length)
    try:
        return _expression(Parser.parse(XPath1Parser(), text))
    except ElementPathError as error:
        return _parse_more(text, error)


def _parse_more(text: str, error: ElementPathError) -> Expression:
    """What elementpath's parser of XPath 1.0 refuses though it is XPath 1.0: a path that starts with a function."""
    try:
        tree = _expression(Parser.parse(XPath2Parser(), text))
    except (ElementPathError, QueryError):
        raise _query_error(text, str(error)) from None
    if any(isinstance(part, Call) and part.function not in FUNCTIONS for part in walk(tree)):
        raise _query_error(text, str(error)) from None
    return tree


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
    if "prefix" in what:
        return "MCML has no namespaces: leave the prefix out."
    if "==" in text:
        return "Compare with a single = sign."
    if "&&" in text or "||" in text:
        return "Write `and` and `or`."
    try:
        Parser.parse(XPath2Parser(), text)
        return "This is XPath 2.0; only XPath 1.0 can be asked here."
    except (ElementPathError, RecursionError):
        return "Write XPath 1.0, such as //frame[motion_name='walk']."


def _expression(token: Any) -> Expression:
    symbol, operands = token.symbol, list(token)
    span = _span(token)
    if symbol in ("/", "//"):
        return _path(token)
    if symbol == "[":
        return _filter(token)
    if symbol == "(" and len(operands) == 1:
        return _expression(operands[0])
    if _is_step(token):
        return Path((_step(token),), span=span)
    if symbol == "(string)":
        return Literal(str(token.value), span)
    if symbol in ("(integer)", "(decimal)", "(float)"):
        return Literal(float(token.value), span)
    if symbol in ("-", "+") and len(operands) == 1:
        if symbol == "+":
            raise QueryError("XPath has no unary plus", at=Place(column=span[0] + 1), remedy="Leave it out.")
        return Operation("negate", (_expression(operands[0]),), span)
    if symbol in OPERATORS and len(operands) == 2:
        return _operation(token)
    if token.label in ("function", "constructor function") or symbol == "id":
        return Call(symbol, tuple(_expression(operand) for operand in operands), span)
    if symbol == "$":
        return Call(f"${token[0].value}", (), span)
    raise QueryError(f"{symbol!r} cannot be used here", at=Place(column=span[0] + 1))


def _operation(token: Any) -> Operation:
    """An operator with all operands it joins from the left: `1 + 2 + 3` is one node, without recursion."""
    symbol = token.symbol
    operands = []
    current = token
    while current.symbol == symbol and len(current) == 2:
        operands.append(_expression(current[1]))
        current = current[0]
    operands.append(_expression(current))
    first = operands[-1]
    if symbol == "|" and isinstance(first, Operation) and first.operator == "negate" and current.symbol == "-":
        # XPath 1.0 binds | more tightly than a minus sign, later versions do not.
        union = Operation("|", (*first.operands, *reversed(operands[:-1])), _span(token))
        return Operation("negate", (union,), _span(token))
    return Operation(symbol, tuple(reversed(operands)), _span(token))


def _path(token: Any) -> Path:
    """Steps from right to left, without recursion."""
    span = _span(token)
    steps: list[Step] = []
    current = token
    while current.symbol in ("/", "//"):
        operands = list(current)
        if operands:
            steps.extend(reversed(_steps(operands[-1])))
        if current.symbol == "//":
            steps.append(ANY_NODE)
        if len(operands) < 2:
            return Path(tuple(reversed(steps)), absolute=True, span=span)
        current = operands[0]
    start = _expression(current)
    if isinstance(start, Path) and start.start is None:
        return Path((*start.steps, *reversed(steps)), start.absolute, span=span)
    return Path(tuple(reversed(steps)), start=start, span=span)


def _steps(token: Any) -> list[Step]:
    """The right side of a slash."""
    predicates: list[Expression] = []
    current = token
    while current.symbol == "[":
        predicates.append(_expression(current[1]))
        current = current[0]
    if not _is_step(current):
        raise QueryError(
            f"{current.symbol!r} cannot follow a slash",
            at=Place(column=_span(current)[0] + 1),
            remedy="A path goes on with steps such as frame or @Rx.",
        )
    step = _step(current)
    return [Step(step.axis, step.name, tuple(reversed(predicates)), _span(token))]


def _filter(token: Any) -> Expression:
    predicates: list[Expression] = []
    current = token
    while current.symbol == "[":
        predicates.append(_expression(current[1]))
        current = current[0]
    if _is_step(current):
        return Path(tuple(_steps(token)), span=_span(token))
    return Filter(_expression(current), tuple(reversed(predicates)), _span(token))


def _is_step(token: Any) -> bool:
    symbol = token.symbol
    is_name = symbol == "(name)" or (symbol == "*" and not len(token))
    return is_name or symbol in (".", "..", "@", *KIND_TESTS) or (symbol in AXES and len(token) == 1)


def _step(token: Any) -> Step:
    span = _span(token)
    symbol = token.symbol
    if symbol == ".":
        return Step("self", "node()", span=span)
    if symbol == "..":
        return Step("parent", "node()", span=span)
    if symbol == "@":
        return Step("attribute", _test(token[0]), span=span)
    if symbol in AXES and len(token) == 1:
        return Step(symbol, _test(token[0]), span=span)
    return Step("child", _test(token), span=span)


def _test(token: Any) -> str:
    if token.symbol == "(name)":
        return str(token.value)
    if token.symbol in KIND_TESTS:
        inner = f"'{token[0].value}'" if len(token) else ""
        return f"{token.symbol}({inner})"
    if token.symbol == "*" and not len(token):
        return "*"
    raise QueryError(f"{token.symbol!r} is no node test", at=Place(column=_span(token)[0] + 1))


def _span(token: Any) -> Span:
    """From the first character of the whole expression to the last of the token that joins it."""
    first, last = token.span
    while len(token):
        token = token[0]
        first = min(first, token.span[0])
    return int(first), int(last)


def _bind(expression: Expression, variables: Mapping[str, str | float | bool]) -> Expression:
    """The expression with the values of its variables in it."""
    if not isinstance(expression, Call) or not expression.function.startswith("$"):
        return with_children(expression, lambda child: _bind(child, variables))
    name = expression.function[1:]
    if name not in variables:
        raise QueryError(
            f"the variable ${name} has no value",
            at=Place(column=expression.span[0] + 1),
            remedy="Give it one with the request, or write the value instead.",
        )
    value = variables[name]
    if isinstance(value, bool):
        return Call("true" if value else "false", (), expression.span)
    return Literal(value if isinstance(value, str) else float(value), expression.span)


def _from_document(expression: Expression) -> Expression:
    """Outside of predicates the context node is the document."""
    if isinstance(expression, Path):
        if expression.start is not None:
            return replace(expression, start=_from_document(expression.start))
        return replace(expression, absolute=True)
    if isinstance(expression, Filter):
        return replace(expression, operand=_from_document(expression.operand))
    if isinstance(expression, Call) and not expression.arguments and expression.function in CONTEXT_FUNCTIONS:
        return replace(expression, arguments=(Path((), absolute=True),))
    return with_children(expression, _from_document)


def _with_stored_names(expression: Expression, warnings: list[str], *, in_name: bool) -> Expression:
    """Motion names that are compared in the form in which they are stored. in_name: the context is a motion_name."""
    if isinstance(expression, Operation) and expression.operator in ("=", "!=") and len(expression.operands) == 2:
        one, other = expression.operands
        if _is_motion_name(other, in_name):
            expression = replace(expression, operands=(_stored_name(one, warnings), other))
        elif _is_motion_name(one, in_name):
            expression = replace(expression, operands=(one, _stored_name(other, warnings)))
    if not isinstance(expression, Path):
        return with_children(expression, lambda child: _with_stored_names(child, warnings, in_name=in_name))
    start = expression.start
    steps = []
    for step in expression.steps:
        is_name = step.name == MOTION_NAME
        predicates = tuple(_with_stored_names(each, warnings, in_name=is_name) for each in step.predicates)
        steps.append(replace(step, predicates=predicates))
    if start is not None:
        start = _with_stored_names(start, warnings, in_name=in_name)
    return replace(expression, start=start, steps=tuple(steps))


def _stored_name(expression: Expression, warnings: list[str]) -> Expression:
    if not isinstance(expression, Literal) or not isinstance(expression.value, str) or not expression.value.strip():
        return expression
    said = expression.value
    try:
        stored = canonical(said)
    except VocabularyError as error:
        warnings.append(f"no frame has this motion name: {error}")
        return expression
    if stored != said:
        warnings.append(f"motion name {said!r} is stored as {stored!r}; that was searched")
    return replace(expression, value=stored)


def _is_motion_name(expression: Expression, in_name: bool) -> bool:
    if not isinstance(expression, Path) or not expression.steps:
        return False
    names = [step.name for step in expression.steps if (step.axis, step.name) != ("self", "node()")]
    if names and names[-1] == "text()":
        names.pop()
    return names[-1:] == [MOTION_NAME] or (not names and in_name and expression.start is None)
