"""Resolve the meaning of an expression: variables get values, paths start at the document, motion names get their
stored form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mcml.errors import Place, QueryError, VocabularyError
from mcml.language.motion_names import canonical
from mcml.language.vocabulary import MOTION_NAME
from mcml_service.xpath.language.functions import OF_CONTEXT
from mcml_service.xpath.language.motion_functions import TOP
from mcml_service.xpath.language.tree import (
    Call,
    Each,
    Expression,
    Filter,
    For,
    Function,
    Let,
    Literal,
    Operation,
    Path,
    Quantified,
    Sequence,
    Step,
    Variable,
    with_children,
)
from mcml_service.xpath.language.types import is_integer, item_type, type_of

CONTEXT = Path((Step("self", "node()"),))
ITEM = "."
"""The name of the variable that a context item is which is no node."""


def bind(
    expression: Expression, variables: Mapping[str, str | float | bool], types: Mapping[str, Variable] | None = None
) -> Expression:
    """Replace variables in an expression by their values, and set the types of those that it binds itself.

    types: of variables bound around it. Context items other than nodes become variables too.
    """
    types = {} if types is None else types
    if isinstance(expression, Variable):
        return _bound(expression, variables, types)
    if isinstance(expression, For | Let | Quantified):
        source = bind(expression.source, variables, types)
        own = _item(expression.variable, source)
        if isinstance(expression, Let):
            own = replace(own, type=type_of(source))
        bound = {expression.variable: own}
        if isinstance(expression, For) and expression.position:
            bound[expression.position] = Variable(expression.position, "number", is_integer=True)
        body = bind(expression.body, variables, {**types, **bound})
        return replace(expression, source=source, body=body)
    if isinstance(expression, Function):
        # Its type is known where the function is called.
        return expression
    if isinstance(expression, Each):
        source = bind(expression.source, variables, types)
        return replace(expression, source=source, body=_with_items(expression.body, source, variables, types))
    if isinstance(expression, Filter):
        operand = bind(expression.operand, variables, types)
        predicates = tuple(_with_items(each, operand, variables, types) for each in expression.predicates)
        return Filter(operand, predicates, expression.span)
    if isinstance(expression, Call) and expression.function == "sort" and len(expression.arguments) == 3:
        return _sort(expression, variables, types)
    return with_children(expression, lambda child: bind(child, variables, types))


def _bound(
    variable: Variable, variables: Mapping[str, str | float | bool], types: Mapping[str, Variable]
) -> Expression:
    if variable.name in types:
        return replace(types[variable.name], span=variable.span)
    if variable.name not in variables:
        raise QueryError(
            f"the variable ${variable.name} has no value",
            at=Place(column=variable.span[0] + 1),
            remedy="Pass a value in the request, or bind it with for, let, some or every.",
        )
    value = variables[variable.name]
    if isinstance(value, bool):
        return Call("true" if value else "false", (), variable.span)
    return Literal(value if isinstance(value, str) else float(value), variable.span)


def _item(name: str, source: Expression) -> Variable:
    """Return a variable for each item."""
    found = item_type(source)
    return Variable(name, "sequence" if found == "any" else found, is_integer(source))


def _with_items(
    body: Expression, source: Expression, variables: Mapping[str, str | float | bool], types: Mapping[str, Variable]
) -> Expression:
    """Bind expressions that are evaluated with each item of a source as context."""
    found = _item(ITEM, source)
    if found.type == "nodes":
        return bind(body, variables, types)
    return bind(_of_context_item(body), variables, {**types, ITEM: found})


def _sort(call: Call, variables: Mapping[str, str | float | bool], types: Mapping[str, Variable]) -> Expression:
    source, collation, key = call.arguments
    source = bind(source, variables, types)
    if isinstance(key, Function):
        key = replace(key, body=bind(key.body, variables, {**types, key.variable: _item(key.variable, source)}))
    return Call("sort", (source, collation, key), call.span)


def _of_context_item(expression: Expression) -> Expression:
    """Replace the context item, which is not a node here, by a variable."""
    item = Variable(ITEM, span=expression.span)
    if expression == CONTEXT:
        return item
    if isinstance(expression, Path):
        return expression if expression.start is None else replace(expression, start=_of_context_item(expression.start))
    if isinstance(expression, Filter):
        return replace(expression, operand=_of_context_item(expression.operand))
    if isinstance(expression, Each):
        return replace(expression, source=_of_context_item(expression.source))
    if isinstance(expression, Call) and not expression.arguments and expression.function in OF_CONTEXT:
        return replace(expression, arguments=(item,))
    return with_children(expression, _of_context_item)


def from_document(expression: Expression) -> Expression:
    """Outside of predicates the context node is the document."""
    if isinstance(expression, Path):
        if expression.start is not None:
            return replace(expression, start=from_document(expression.start))
        return Path(expression.steps, True, None, expression.span)
    if isinstance(expression, Filter):
        return replace(expression, operand=from_document(expression.operand))
    if isinstance(expression, Each):
        return replace(expression, source=from_document(expression.source))
    if isinstance(expression, Function):
        return expression
    if isinstance(expression, Call) and not expression.arguments and expression.function in OF_CONTEXT:
        return replace(expression, arguments=(Path((), absolute=True),))
    if isinstance(expression, Call) and expression.function == TOP:
        # Its key is evaluated for frames.
        arguments = tuple(from_document(each) if n < 2 else each for n, each in enumerate(expression.arguments))
        return replace(expression, arguments=arguments)
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
    if isinstance(expression, Sequence):
        return with_children(expression, lambda item: _stored_name(item, warnings))
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
