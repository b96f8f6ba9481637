"""Rewrite features after XPath 1.0 into XPath 1.0, so that indexes and columns can evaluate them.

1. A comparison with a sequence is one with any of its items: `a = ('x', 'y')` is `a = 'x' or a = 'y'`.
2. `a = 1 to 9` matches integers: `a[. >= 1 and . <= 9 and . mod 1 = 0]` of nodes, or the same of a number.
3. `some $x in nodes satisfies t` is `exists(nodes[t])` with the context node for $x, if nothing else in t uses the
context; `every` is `empty(nodes[not(t)])`.
4. `@a eq 'x'` is `@a = 'x'`: an element has no two attributes of a name.
5. `a || b` is `concat(a, b)`.
6. `max(frame_bone/@a) > 1` is `frame_bone/@a > 1`: some channel is, exactly if the greatest is. So for `>=`, and for
   `min` and `<`, `<=`; and `max(frame_bone/@a) < 1` is `frame_bone/@a and not(frame_bone/@a >= 1)`: there is one, and
   none that is not.
7. `a[p] except a[p][q]` is `a[p][not(q)]`, and `intersect` is `a[p][q]`, where q counts no positions.
"""

from __future__ import annotations

from mcml.language.vocabulary import FRAME_BONE
from mcml.motion.skeleton import CHANNEL_INDEX
from mcml_service.xpath.language.functions import OF_CONTEXT
from mcml_service.xpath.language.meaning import CONTEXT
from mcml_service.xpath.language.positions import counts
from mcml_service.xpath.language.tree import (
    TURNED,
    VALUE_COMPARISONS,
    Call,
    Each,
    Expression,
    Filter,
    Function,
    Literal,
    Operation,
    Path,
    Quantified,
    Sequence,
    Variable,
    children,
    free_variables,
    with_children,
)
from mcml_service.xpath.language.types import item_type, type_of

_GENERAL = frozenset(VALUE_COMPARISONS.values())
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<"}
FEW_ITEMS = 100
"""Of a range that becomes as many comparisons, which an index may answer."""
MOST_ITEMS = 1000
"""Of a sequence that becomes as many comparisons."""


def of_later(expression: Operation | Quantified) -> Expression:
    """The expression rewritten at its top, or itself."""
    if isinstance(expression, Quantified):
        return _quantified(expression) or expression
    operator, operands = expression.operator, expression.operands
    if operator == "||":
        return Call("concat", operands, expression.span)
    if len(operands) != 2:
        return expression
    left, right = operands
    if operator in ("except", "intersect"):
        return _some_of(left, right, kept=operator == "intersect") or expression
    if operator in _GENERAL:
        return _with_sequence(expression) or _with_range(expression) or _with_extreme(expression) or expression
    if operator in VALUE_COMPARISONS and _is_one_text(left) and _is_one_text(right):
        general = VALUE_COMPARISONS[operator]
        # Texts are less than others by their letters, which XPath 1.0 does not know.
        return Operation(general, operands, expression.span) if general in ("=", "!=") else expression
    return expression


def _with_sequence(comparison: Operation) -> Expression | None:
    for place, operand in enumerate(comparison.operands):
        if isinstance(operand, Sequence) and len(operand.items) <= MOST_ITEMS:
            other = comparison.operands[1 - place]
            if type_of(other) == "boolean" or any(type_of(item) == "boolean" for item in operand.items):
                # The truth of a whole sequence is compared then.
                return None
            parts = tuple(
                Operation(comparison.operator, (item, other) if place == 0 else (other, item), comparison.span)
                for item in operand.items
            )
            if not parts:
                return Call("false", (), comparison.span)
            return parts[0] if len(parts) == 1 else Operation("or", parts, comparison.span)
    return None


def _with_range(comparison: Operation) -> Expression | None:
    if comparison.operator != "=":
        return None
    for place, operand in enumerate(comparison.operands):
        other = comparison.operands[1 - place]
        if not isinstance(operand, Operation) or operand.operator != "to":
            continue
        ends = [end.value for end in operand.operands if isinstance(end, Literal)]
        if len(ends) < 2 or not all(isinstance(end, float) and end.is_integer() for end in ends):
            continue
        low, high = (int(float(end)) for end in ends)
        if type_of(other) == "nodes" and high - low < FEW_ITEMS:
            items = tuple(Literal(float(number)) for number in range(low, high + 1))
            sides = (other, Sequence(items)) if place else (Sequence(items), other)
            return _with_sequence(Operation("=", sides, comparison.span))
        if isinstance(other, Path) and other.steps:
            *steps, last = other.steps
            asked = last.where((*last.predicates, _between(CONTEXT, operand)))
            return Call("boolean", (Path((*steps, asked), other.absolute, other.start, other.span),), comparison.span)
        if type_of(other) == "number":
            return _between(other, operand)
    return None


def _with_extreme(comparison: Operation) -> Expression | None:
    left, right = comparison.operands
    for operator, one, other in ((comparison.operator, left, right), (TURNED[comparison.operator], right, left)):
        if not isinstance(one, Call) or one.function not in ("min", "max") or not _is_constant(other):
            continue
        path = one.arguments[0]
        if not isinstance(path, Path) or path.absolute or path.start is not None or len(path.steps) != 2:
            continue
        bone, last = path.steps
        if (bone.axis, bone.name, last.axis) != ("child", FRAME_BONE, "attribute") or last.name not in CHANNEL_INDEX:
            continue
        outward = (">", ">=") if one.function == "max" else ("<", "<=")
        if operator in outward:
            return Operation(operator, (path, other), comparison.span)
        if operator in _OPPOSITE:
            none = Call("not", (Operation(_OPPOSITE[operator], (path, other), comparison.span),))
            return Operation("and", (Call("boolean", (path,)), none), comparison.span)
    return None


def _is_constant(expression: Expression) -> bool:
    if isinstance(expression, Operation) and expression.operator == "negate":
        return _is_constant(expression.operands[0])
    return (
        isinstance(expression, Literal) and isinstance(expression.value, float) and expression.value == expression.value
    )


def _between(value: Expression, ends: Operation) -> Operation:
    low, high = ends.operands
    parts = [Operation(">=", (value, low)), Operation("<=", (value, high))]
    if not (isinstance(value, Call) and value.function in ("position", "last", "count")):
        parts.append(Operation("=", (Operation("mod", (value, Literal(1.0))), Literal(0.0))))
    return Operation("and", tuple(parts), ends.span)


def _some_of(left: Expression, right: Expression, *, kept: bool) -> Expression | None:
    if (
        not isinstance(left, Path)
        or not isinstance(right, Path)
        or not left.steps
        or len(left.steps) != len(right.steps)
    ):
        return None
    last, other = left.steps[-1], right.steps[-1]
    same = (left.absolute, left.start, left.steps[:-1], last.axis, last.name)
    count = len(last.predicates)
    if same != (right.absolute, right.start, right.steps[:-1], other.axis, other.name):
        return None
    tests = other.predicates[count:]
    if other.predicates[:count] != last.predicates or not tests or counts(other.where(tests)):
        return None
    test = tests[0] if len(tests) == 1 else Operation("and", tests)
    predicates = (*last.predicates, test if kept else Call("not", (test,)))
    return Path((*left.steps[:-1], last.where(predicates)), left.absolute, left.start, left.span)


def _is_one_text(expression: Expression) -> bool:
    if isinstance(expression, Literal):
        return isinstance(expression.value, str)
    if not isinstance(expression, Path) or expression.absolute or expression.start is not None:
        return False
    return len(expression.steps) == 1 and expression.steps[0].axis == "attribute" and expression.steps[0].name != "*"


def _quantified(asked: Quantified) -> Expression | None:
    if item_type(asked.source) != "nodes" or type_of(asked.source) != "nodes":
        return None
    if not _looks_only_at(asked.body, asked.variable):
        return None
    test: Expression = _of_context(asked.body, asked.variable)
    is_some = asked.quantifier == "some"
    if not is_some:
        test = Call("not", (test,))
    elif type_of(test) != "boolean":
        test = Call("boolean", (test,))
    source = asked.source
    if isinstance(source, Path) and source.steps:
        *steps, last = source.steps
        found: Expression = Path(
            (*steps, last.where((*last.predicates, test))), source.absolute, source.start, source.span
        )
    else:
        found = Filter(source, (test,), source.span)
    return Call("exists" if is_some else "empty", (found,), asked.span)


def _looks_only_at(expression: Expression, variable: str) -> bool:
    """Tell whether an expression selects nodes only by a variable, and uses that one in no other context."""
    if isinstance(expression, Path):
        inner = [predicate for step in expression.steps for predicate in step.predicates]
        if expression.start is None or any(variable in free_variables(predicate) for predicate in inner):
            return False
        return _looks_only_at(expression.start, variable)
    if isinstance(expression, Filter | Each | Function):
        return False
    if isinstance(expression, Call):
        if expression.function in ("position", "last", "lang", "id"):
            return False
        if not expression.arguments and expression.function in OF_CONTEXT:
            return False
    return all(_looks_only_at(part, variable) for part in children(expression))


def _of_context(expression: Expression, variable: str) -> Expression:
    """With the context node for a variable."""
    if isinstance(expression, Variable):
        return CONTEXT if expression.name == variable else expression
    if isinstance(expression, Path) and isinstance(expression.start, Variable) and expression.start.name == variable:
        return Path(expression.steps, span=expression.span)
    return with_children(expression, lambda part: _of_context(part, variable))
