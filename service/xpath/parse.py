"""Text to tree, with errors that have a column.

elementpath parses; its tokens become our own tree, so that nothing else depends on it. The ordinary entry of
elementpath evaluates constants while parsing, which a hostile text makes last for minutes; `tdop.Parser.parse` only
parses. The text and its nesting are bounded before.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
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
    children,
    type_of,
    walk,
)

MAX_LENGTH = 10_000
MAX_NESTING = 100
OPERATORS = ("or", "and", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "div", "mod", "|")
FUNCTIONS = NODES_FUNCTIONS | NUMBER_FUNCTIONS | STRING_FUNCTIONS | BOOLEAN_FUNCTIONS
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

    text: as evaluated: motion names in comparisons are in the form in which they are stored, and paths outside of
    predicates start at the document, which is the context node: `mcml` is `/mcml`. tree: of that text.
    warnings: what the writer should know, such as a name that was a synonym.
    """

    text: str
    tree: Expression
    warnings: tuple[str, ...] = ()


def parse(text: str) -> Query:
    """Parses an XPath 1.0 expression.

    Raises QueryError with the column and a hint for what is none, LimitError for a text that is too long or nested
    too deeply.
    """
    _bound(text, MAX_LENGTH)
    # elementpath takes the + of `node() + 1` for an occurrence indicator of XPath 2.0; a predicate keeps them apart.
    text = _KIND_TEST_BEFORE_SIGN.sub(lambda match: match.group() + "[true()]" * bool(match.group(1)), text)
    tree = _parse_tree(text, MAX_LENGTH * 2)
    changes, warnings = _stored_names(text, tree)
    changes += [(place, place, "/") for place in _relative_places(text, tree)]
    if not changes:
        return Query(text, tree, warnings)
    changed = text
    for first, last, replacement in sorted(changes, reverse=True):
        changed = changed[:first] + replacement + changed[last:]
    return Query(changed, _parse_tree(changed, MAX_LENGTH * 4), warnings)


def _parse_tree(text: str, max_length: int) -> Expression:
    _bound(text, max_length)
    try:
        try:
            tree = _expression(Parser.parse(XPath1Parser(), text))
        except ElementPathError as error:
            tree = _parse_more(text, error)
        _check_types(tree)
    except RecursionError:
        raise LimitError("the expression is nested too deeply", remedy="Write it flatter.") from None
    return tree


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
        elif isinstance(part, Call) and part.function in ("count", "sum", "name", "local-name", "namespace-uri"):
            needed = part.arguments
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
        raise QueryError(
            "there are no variables", at=Place(column=span[0] + 1), remedy="Write the value instead of $name."
        )
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


def _relative_places(text: str, tree: Expression) -> list[int]:
    """Where a path, or a function of the context node, outside of predicates needs a slash to start at the document."""
    places = []
    stack = [tree]
    while stack:
        current = stack.pop()
        if isinstance(current, Path):
            if current.start is not None:
                stack.append(current.start)
            elif not current.absolute:
                places.append(current.steps[0].span[0])
        elif isinstance(current, Filter):
            stack.append(current.operand)
        elif isinstance(current, Call) and not current.arguments and current.function in CONTEXT_FUNCTIONS:
            places.append(text.index("(", current.span[0]) + 1)
        else:
            stack.extend(children(current))
    return places


def _stored_names(text: str, tree: Expression) -> tuple[list[tuple[int, int, str]], tuple[str, ...]]:
    """Changes (first, last, new text) that put motion names in comparisons in the form in which they are stored."""
    changes: list[tuple[int, int, str]] = []
    warnings: list[str] = []
    for literal in _compared_names(tree, in_name=False):
        said = str(literal.value)
        try:
            stored = canonical(said) if said.strip() else said
        except VocabularyError as error:
            warnings.append(f"no frame has this motion name: {error}")
            continue
        if stored != said:
            first, last = literal.span
            changes.append((first, last, text[first] + stored + text[last - 1]))
            warnings.append(f"motion name {said!r} is stored as {stored!r}; that was searched")
    return list(dict.fromkeys(changes)), tuple(dict.fromkeys(warnings))


def _compared_names(expression: Expression, *, in_name: bool) -> list[Literal]:
    """String literals that are compared with a motion name. in_name: the context node is a motion_name."""
    found: list[Literal] = []
    if isinstance(expression, Operation) and expression.operator in ("=", "!=") and len(expression.operands) == 2:
        for one, other in (expression.operands, expression.operands[::-1]):
            if isinstance(other, Literal) and isinstance(other.value, str) and _is_motion_name(one, in_name):
                found.append(other)
    if isinstance(expression, Path):
        if expression.start is not None:
            found += _compared_names(expression.start, in_name=in_name)
        for step in expression.steps:
            for predicate in step.predicates:
                found += _compared_names(predicate, in_name=step.name == MOTION_NAME)
        return found
    for child in children(expression):
        found += _compared_names(child, in_name=in_name)
    return found


def _is_motion_name(expression: Expression, in_name: bool) -> bool:
    if not isinstance(expression, Path) or not expression.steps:
        return False
    names = [step.name for step in expression.steps if (step.axis, step.name) != ("self", "node()")]
    if names and names[-1] == "text()":
        names.pop()
    return names[-1:] == [MOTION_NAME] or (not names and in_name and expression.start is None)
