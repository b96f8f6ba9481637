"""What is probably wrong with an expression that is right but finds nothing."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches

from service.mcml.content import declarations
from service.xpath.projection import DOCUMENT, Types, types_of
from service.xpath.rules import after
from service.xpath.tree import Call, Expression, Filter, Operation, Path, Step


def unknown_names(tree: Expression) -> list[str]:
    """For each step that can reach nothing in any document, why, and the nearest name that could."""
    return list(dict.fromkeys(_walk(tree, frozenset({DOCUMENT}))))


def _walk(expression: Expression, context: Types) -> Iterator[str]:
    if isinstance(expression, Path):
        types = frozenset({DOCUMENT}) if expression.absolute else context
        if expression.start is not None:
            yield from _walk(expression.start, context)
            types = types_of(expression.start, context)
        for step in expression.steps:
            reached = after(types, step)
            if types and not reached:
                yield from _hint(types, step)
                return
            for predicate in step.predicates:
                yield from _walk(predicate, reached)
            types = reached
    elif isinstance(expression, Filter):
        yield from _walk(expression.operand, context)
        for predicate in expression.predicates:
            yield from _walk(predicate, types_of(expression.operand, context))
    elif isinstance(expression, Call | Operation):
        for inner in expression.arguments if isinstance(expression, Call) else expression.operands:
            yield from _walk(inner, context)


def _hint(types: Types, step: Step) -> Iterator[str]:
    is_attribute = step.axis == "attribute"
    if step.name in ("*", "node()") or step.name.endswith(")"):
        return
    said = f"@{step.name}" if is_attribute else step.name
    owners = {name: declared.attributes for name, declared in declarations().items()}
    known = {name for attributes in owners.values() for name in attributes} if is_attribute else set(owners)
    if step.name not in known:
        near = _by_letters(step.name, known) or get_close_matches(step.name, sorted(known), 1, 0.5)
        what = "attribute" if is_attribute else "element"
        yield f"MCML has no {what} {said}" + (f"; did you mean {'@' * is_attribute}{near[0]}?" if near else "")
        return
    places = " or ".join(sorted(name for name in types if name[0] not in "#@")) or "there"
    if is_attribute:
        holders = ", ".join(sorted(name for name, attributes in owners.items() if step.name in attributes))
        yield f"{places} has no attribute {said}; it is one of {holders}"
    elif step.axis in ("child", "descendant"):
        holders = ", ".join(sorted(name for name, declared in declarations().items() if _holds(declared.steps, step)))
        yield f"{places} holds no {said}" + (f"; it stands in {holders}" if holders else "")


def _by_letters(name: str, known: set[str]) -> list[str]:
    """The same name in other letters: `Frame_Bone`, `rx`."""
    return [other for other in sorted(known) if other.lower() == name.lower()]


def _holds(steps: object, step: Step) -> bool:
    return any(step.name in state for state in steps)  # type: ignore[attr-defined]
