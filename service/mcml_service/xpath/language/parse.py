"""Text to tree, with errors that have a column. The text and its nesting are bounded before anything reads it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from difflib import get_close_matches

from mcml.errors import LimitError, McmlError, Place, QueryError
from mcml.motion.bodies.quantities import QUANTITIES
from mcml_service.xpath.language.arity import ArityError
from mcml_service.xpath.language.certain import certain, certain_text, require_certain
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.grammar import read
from mcml_service.xpath.language.meaning import bind, from_document, with_stored_names
from mcml_service.xpath.language.motion_functions import CONSTANT, MOTION_FUNCTIONS, OF_FRAMES, PREFIX
from mcml_service.xpath.language.scopes import asks_each, asks_scope
from mcml_service.xpath.language.tree import (
    OF_NODES,
    VALUE_COMPARISONS,
    Atomic,
    Call,
    Expression,
    Filter,
    Function,
    Later,
    Literal,
    Operation,
    Path,
    Written,
    children,
    walk,
)
from mcml_service.xpath.language.types import depends_on_position, is_of_document, is_of_variables, item_type, type_of
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.language.xpath31.written import read_written

_LATER_OPERATORS = frozenset({*VALUE_COMPARISONS, "||", "to", "idiv", "intersect", "except"})
MAX_LENGTH = 10_000
MAX_NESTING = 100
MAX_DEPTH = 150
"""Greatest depth of nested expressions; evaluation is recursive."""
_LONG_NUMBER = re.compile(r"""'[^']*'|"[^"]*"|([0-9]{301})""")


@dataclass(frozen=True, slots=True)
class Query:
    """A parsed expression.

    tree: motion names in comparisons are in the form in which they are stored, paths outside of predicates start at the
    document, which is the context node (`mcml` is `/mcml`), and variables are the values they are bound to.
    warnings: messages for the user, such as a name that was a synonym. compatible: in XPath 1.0 compatibility mode.
    constant: the expression as written, if its value does not depend on documents.
    """

    tree: Expression
    warnings: tuple[str, ...] = ()
    compatible: bool = True
    constant: Written | None = None

    @property
    def text(self) -> str:
        """The tree as an expression."""
        return unparse(self.tree)

    @property
    def is_later(self) -> bool:
        """Whether it needs more than XPath 1.0."""
        return isinstance(self.tree, Written) or uses_later(self.tree)

    @property
    def has_columns(self) -> bool:
        """Whether columns may evaluate it: it is in the grammar; and it does not need `following` of attributes and
        namespaces as in XPath 2.0 and later, where the content of an element follows them, unlike in 1.0 and on
        columns.
        """
        if isinstance(self.tree, Written) or not self.is_later:
            return not isinstance(self.tree, Written)
        axes = {step.axis for part in walk(self.tree) if isinstance(part, Path) for step in part.steps}
        return "following" not in axes or axes.isdisjoint({"attribute", "namespace"})


def parse(text: str, variables: Mapping[str, Atomic] | None = None, *, strict: bool = False) -> Query:
    """Parses an XPath expression.

    variables: the values of `$name`. strict: plain XPath 3.1, without XPath 1.0 compatibility mode. Raises QueryError
    with the column and a hint for an invalid expression, LimitError for a text that is too long or nested too deeply.
    """
    _bound(text)
    warnings: list[str] = []
    try:
        tree = read_written(text, variables or {}, compatible=False) if strict else _tree(text, variables or {})
        _bound_depth(tree)
        tree = certain(from_document(with_stored_names(tree, warnings, in_name=False)))
        constant = find_constant(text, tree, variables or {}, strict=strict)
    except RecursionError:
        raise LimitError("the expression is nested too deeply", remedy="Write it flatter.") from None
    return Query(tree, tuple(dict.fromkeys(warnings)), compatible=not strict, constant=constant)


def _tree(text: str, variables: Mapping[str, Atomic]) -> Expression:
    """Return the tree of an expression that columns can evaluate; other XPath 3.1, and expressions without
    documents, have a tree of one node.
    """
    try:
        tree = bind(read(text), variables)
    except QueryError as error:
        return _read_written(text, error, variables)
    _check_types(tree)
    return tree


def find_constant(text: str, tree: Expression, variables: Mapping[str, Atomic], *, strict: bool) -> Written | None:
    """The expression as XPath 3.1 if its value does not depend on documents, else None; see `Query`.

    Values on columns are doubles without types, so elementpath evaluates expressions that consist only of values.
    """
    if isinstance(tree, Written):
        return tree if tree.constant else None
    if asks_each(tree) or asks_scope(tree):
        return None
    # Syntax that only XPath 1.0 allows (`1 = 1 = 1`, `1div 2`), and FLWOR, is XPath 3.1 after serialisation.
    for spelling in (text, unparse(tree)):
        with suppress(QueryError, RecursionError):
            written = read_written(spelling, variables, compatible=not strict)
            return written if written.constant else None
    return None


def _read_written(text: str, error: QueryError, variables: Mapping[str, Atomic]) -> Expression:
    """Parse the expression as XPath 3.1. error: the error of the project's own grammar."""
    try:
        tree = read_written(text, variables)
        sure = certain_text(text)
        tree = tree if sure == text else read_written(sure, variables)
    except QueryError as other:
        if isinstance(error, ArityError):
            raise error from None
        # The parser that came further is the one that the writer had in mind. Variables are looked up at the end.
        is_parsed = other.details.get("xpath_error") == "XPST0008"
        chosen = other if is_parsed else max(error, other, key=_column)
        remedy = chosen.remedy or _hint(text, chosen.what)
        raise QueryError(chosen.what, at=chosen.at, remedy=remedy, **chosen.details) from None
    require_certain(sure)
    for part in walk(tree):
        if isinstance(part, Call):
            _check_motion(part)
    return tree


def _column(error: QueryError) -> int:
    return error.at.column or 0 if error.at is not None else 0


def uses_later(tree: Expression) -> bool:
    """Whether anything came after XPath 1.0."""
    return any(
        isinstance(part, Later)
        or (isinstance(part, Call) and SAFE_FUNCTIONS[part.function].is_later)
        or (isinstance(part, Operation) and part.operator in _LATER_OPERATORS)
        for part in walk(tree)
    )


def _check_types(tree: Expression) -> None:
    """Refuses what has no meaning: a path or union of something that are no nodes; in XPath 1.0 a predicate or count of
    a value too."""
    is_later = uses_later(tree)
    for part in walk(tree):
        needed: tuple[Expression, ...] = ()
        if isinstance(part, Path) and part.start is not None:
            needed = (part.start,)
        elif isinstance(part, Operation) and part.operator in OF_NODES:
            needed = part.operands
        elif isinstance(part, Operation) and part.operator == "to" and len(part.operands) > 2:
            column = part.operands[2].span[0] + 1
            raise QueryError(
                "a range has two ends", at=Place(column=column), remedy="Write (a to b) to c with brackets."
            )
        elif not is_later and isinstance(part, Filter):
            needed = (part.operand,)
        elif isinstance(part, Call):
            _check_functions(part)
            _check_motion(part)
            signature = SAFE_FUNCTIONS[part.function]
            if signature.of_node or (signature.takes_items and (not is_later or part.function in MOTION_FUNCTIONS)):
                needed = part.arguments[signature.place : signature.place + 1]
        for operand in needed:
            if item_type(operand) not in ("nodes", "any"):
                raise QueryError(
                    f"this is a {type_of(operand)} where nodes are needed",
                    at=Place(column=operand.span[0] + 1),
                    remedy="Use a path here.",
                )


def _check_functions(call: Call) -> None:
    """Refuses a function as argument, but the key of a sort."""
    for place, argument in enumerate(call.arguments):
        is_key = call.function == "sort" and place == 2
        if isinstance(argument, Function) and not is_key:
            raise QueryError(
                "no function is allowed here",
                at=Place(column=argument.span[0] + 1),
                remedy="The key is the third argument of sort: sort(//frame, (), function($f) { … }).",
            )


def _check_motion(call: Call) -> None:
    """Refuse unknown angles and axes, and arguments that vary by frame where they must be constant."""
    for argument, parameter in zip(call.arguments, _parameters(call), strict=False):
        place = Place(column=argument.span[0] + 1)
        if parameter in CONSTANT and not is_of_variables(argument):
            remedy = "Write a number, a text or a $variable."
            raise QueryError(f"{call.function} takes the same {parameter} in every frame", at=place, remedy=remedy)
        if parameter == "n" and not is_of_document(argument):
            raise QueryError("how many runs are wanted depends on a node", at=place, remedy="Write a number.")
        if parameter in OF_FRAMES and depends_on_position(argument):
            remedy = "Ask for mo:time(), or for @id."
            raise QueryError(
                f"the {parameter} of {call.function} cannot ask for position() or last()", at=place, remedy=remedy
            )
    quantity = QUANTITIES.get(call.function.removeprefix(PREFIX)) if call.function in MOTION_FUNCTIONS else None
    texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
    if quantity is None or len(texts) < len(call.arguments):
        return
    try:
        quantity.joints(texts)
    except McmlError as error:
        raise QueryError(error.what, at=Place(column=call.span[0] + 1), remedy=error.remedy) from None


def _parameters(call: Call) -> tuple[str, ...]:
    """The names of its parameters, of functions of bodies in motion."""
    known = MOTION_FUNCTIONS.get(call.function)
    return () if known is None else tuple(each.rstrip("?") for each in known.parameters)


def _bound_depth(tree: Expression) -> None:
    """Refuses a tree that is too deep, such as one of minus and plus signs in turn, without recursion."""
    depth, level = 0, [tree]
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise LimitError(f"expressions are nested deeper than {MAX_DEPTH}", remedy="Write it flatter.")
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


_REMEDIES = (
    (r"(?s).*\bgroup\s+by\s+\$[\w.-]+\s*/", "Name the key: group by $k := $m/header/filename."),
    (r"unexpected '(tumbling|sliding)'", "Windows are not supported. Use mo:window(), or positions."),
    (r"(?i)\s*select\s", "This is XPath, not SQL: for $m in /mcml where … order by … return $m/header/filename."),
    (r"\s*(for|let|some|every)\s+\w", "Names of variables begin with $, such as: for $m in /mcml return …"),
    (r"unexpected '(desc|asc)'", "Write descending or ascending after the key."),
    (r"unexpected '(sort|sorted|orderby)'", "Write order by before the key."),
    (r"unexpected 'as'", "Variables have no types here: leave out `as` and the type."),
    (r"'by' is missing", "Write order by or group by."),
    (r"':=' is missing", "Write := between a variable and its value, such as: let $n := …, group by $k := …"),
    (r"'\$' is missing|a variable is missing", "Names of variables begin with $."),
    (r"'return' is missing", "End the loop with return, such as: for $m in /mcml return $m/header/filename."),
)
"""Remedies for an error, by a pattern of its message or of the beginning of the expression."""


def _hint(text: str, what: str) -> str:
    if text.count("'") % 2 and text.count('"') % 2 == 0:
        return "A quotation mark is not closed."
    for opening, closing in ("[]", "()"):
        if text.count(opening) != text.count(closing):
            return f"The brackets {opening} {closing} do not match."
    unknown = re.search(r"unknown function '(?:fn:)?([\w.:-]+)'", what)
    near = get_close_matches(unknown[1], sorted(SAFE_FUNCTIONS), 1, 0.5) if unknown else []
    if unknown:
        return f"Did you mean {near[0]}()?" if near else "Use the functions that docs/xpath.md lists."
    if "prefix" in what:
        return "MCML has no namespaces: leave the prefix out."
    if "==" in text:
        return "Compare with a single = sign."
    if "&&" in text:
        return "Write `and` and `or`."
    for pattern, remedy in _REMEDIES:
        if re.search(pattern, what) or re.match(pattern, text):
            return remedy
    return "Write XPath, such as //frame[motion_name='walk']."
