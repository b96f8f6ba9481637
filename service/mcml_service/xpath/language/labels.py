"""Names in predicates: motion names, and the frames that have them; bone names."""

from __future__ import annotations

from collections.abc import Sequence

from mcml.language.lexical import unescape
from mcml.language.vocabulary import FRAME_BONE, MOTION_NAME, NAME
from mcml_service.storage.documents.runs import intersection
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.positions import position_of
from mcml_service.xpath.language.tree import (
    Expression,
    Filter,
    Literal,
    Operation,
    Path,
    Step,
)

Groups = tuple[tuple[str, ...], ...]
"""((a, b), (c,)) means frames named (a or b) and c."""


def motion_name_groups(predicate: Expression) -> Groups | None:
    """Return the motion names in a predicate of frames, None if it has other conditions."""
    if isinstance(predicate, Operation) and predicate.operator == "and":
        groups = [motion_name_groups(operand) for operand in predicate.operands]
        return None if None in groups else tuple(group for found in groups if found for group in found)
    names = any_motion_name(predicate)
    return None if names is None else (names,)


def any_motion_name(predicate: Expression) -> tuple[str, ...] | None:
    """The names of `motion_name='a' or motion_name='b'`."""
    if isinstance(predicate, Operation) and predicate.operator == "or":
        names = [any_motion_name(operand) for operand in predicate.operands]
        return None if None in names else tuple(dict.fromkeys(name for found in names if found for name in found))
    compared = compared_text(predicate)
    if compared is not None:
        path, value = compared
        steps = without_self(path.steps)
        if steps and steps[-1].name == "text()" and steps[-1].axis == "child" and not steps[-1].predicates:
            steps = steps[:-1]
        return (value,) if _is_motion_name(steps) and not steps[0].predicates else None
    if isinstance(predicate, Path) and not predicate.absolute and predicate.start is None:
        # motion_name[.='X'] as a separate predicate
        steps = without_self(predicate.steps)
        if _is_motion_name(steps) and len(steps[0].predicates) == 1:
            inner = compared_text(steps[0].predicates[0])
            if inner is not None and without_self(inner[0].steps) in ((), (Step("child", "text()"),)):
                return (inner[1],)
    return None


def compared_text(predicate: Expression) -> tuple[Path, str] | None:
    """Path and string of `path = 'string'` or `'string' = path`, the path from the context node."""
    if not isinstance(predicate, Operation) or predicate.operator != "=" or len(predicate.operands) != 2:
        return None
    for one, other in (predicate.operands, predicate.operands[::-1]):
        is_path = isinstance(one, Path) and not one.absolute and one.start is None
        if is_path and isinstance(one, Path) and isinstance(other, Literal) and isinstance(other.value, str):
            return one, other.value
    return None


def named(predicate: Expression) -> str | None:
    """B of `@name='B'`."""
    compared = compared_text(predicate)
    if compared is None:
        return None
    steps = without_self(compared[0].steps)
    is_name = len(steps) == 1 and (steps[0].axis, steps[0].name, steps[0].predicates) == ("attribute", NAME, ())
    return compared[1] if is_name else None


def bone_name(step: Step) -> str | None:
    """B of `child::frame_bone[@name='B'][…]…`: such frame_bones are found without looking at the others."""
    is_bone = step.axis == "child" and step.name == FRAME_BONE and step.predicates
    return named(step.predicates[0]) if is_bone else None


def without_index(tree: Expression) -> tuple[Expression, int | None]:
    """`(…)[n]` around the whole counts over all documents: the expression inside, and n."""
    if isinstance(tree, Filter) and len(tree.predicates) == 1 and isinstance(tree.predicates[0], Literal):
        position = position_of(tree.predicates[0])
        if position is not None:
            return tree.operand, position
    return tree, None


def without_self(steps: Sequence[Step]) -> tuple[Step, ...]:
    """The steps but `self::node()`."""
    return tuple(step for step in steps if (step.axis, step.name, step.predicates) != ("self", "node()", ()))


def _is_motion_name(steps: Sequence[Step]) -> bool:
    return len(steps) == 1 and steps[0].axis in ("child", "descendant") and steps[0].name == MOTION_NAME


def ranges_of(tx: Transaction, groups: Groups, keys: Sequence[int] | None) -> dict[int, list[tuple[int, int]]]:
    """Ranges (first, last) of frames that carry a name of every group, by document key; only documents with any."""
    documents = None if keys is None else list(keys)
    found: dict[int, list[tuple[int, int]]] | None = None
    for group in groups:
        named = tx.spans.named([unescape(name) for name in group], documents)
        if found is None:
            found = named
            continue
        both = {key: intersection(ranges, named[key]) for key, ranges in found.items() if key in named}
        found = {key: ranges for key, ranges in both.items() if ranges}
    return found or {}
