"""What an expression means here: variables have values, paths start at the document, motion names are those stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from service.errors import Place, QueryError, VocabularyError
from service.mcml.motion_names import canonical
from service.mcml.vocabulary import MOTION_NAME
from service.xpath.language.tree import Call, Expression, Filter, Literal, Operation, Path, with_children

CONTEXT_FUNCTIONS = (
    "string", "number", "string-length", "normalize-space", "name", "local-name", "namespace-uri",
)  # fmt: skip
"""Functions that without an argument take the context node."""


def bind(expression: Expression, variables: Mapping[str, str | float | bool]) -> Expression:
    """The expression with the values of its variables in it."""
    if not isinstance(expression, Call) or not expression.function.startswith("$"):
        return with_children(expression, lambda child: bind(child, variables))
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


def from_document(expression: Expression) -> Expression:
    """Outside of predicates the context node is the document."""
    if isinstance(expression, Path):
        if expression.start is not None:
            return replace(expression, start=from_document(expression.start))
        return Path(expression.steps, True, None, expression.span)
    if isinstance(expression, Filter):
        return replace(expression, operand=from_document(expression.operand))
    if isinstance(expression, Call) and not expression.arguments and expression.function in CONTEXT_FUNCTIONS:
        return replace(expression, arguments=(Path((), absolute=True),))
    return with_children(expression, from_document)


def with_stored_names(expression: Expression, warnings: list[str], *, in_name: bool) -> Expression:
    """Motion names that are compared in the form in which they are stored. in_name: the context is a motion_name."""
    if isinstance(expression, Operation) and expression.operator in ("=", "!=") and len(expression.operands) == 2:
        one, other = expression.operands
        if _is_motion_name(other, in_name):
            expression = replace(expression, operands=(_stored_name(one, warnings), other))
        elif _is_motion_name(one, in_name):
            expression = replace(expression, operands=(one, _stored_name(other, warnings)))
    if not isinstance(expression, Path):
        return with_children(expression, lambda child: with_stored_names(child, warnings, in_name=in_name))
    start = expression.start
    steps = []
    for step in expression.steps:
        is_name = step.name == MOTION_NAME
        predicates = tuple(with_stored_names(each, warnings, in_name=is_name) for each in step.predicates)
        steps.append(step.where(predicates))
    if start is not None:
        start = with_stored_names(start, warnings, in_name=in_name)
    return Path(tuple(steps), expression.absolute, start, expression.span)


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
