"""Static properties of an expression: its type, the type of its items, and its dependencies."""

from __future__ import annotations

from functools import lru_cache

from mcml_service.xpath.language.functions import OF_CONTEXT, SAFE_FUNCTIONS
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, OF_DOCUMENT
from mcml_service.xpath.language.tree import (
    OF_NODES,
    Call,
    Each,
    Expression,
    Filter,
    For,
    Function,
    If,
    Later,
    Let,
    Literal,
    Operation,
    Path,
    Quantified,
    Sequence,
    Variable,
    Written,
    children,
    free_variables,
)


def type_of(expression: Expression) -> str:
    """Type of the value: "nodes", "number", "string", "boolean" or "strings"; "sequence" where it may have any number
    of items, or only its evaluation can tell."""
    if isinstance(expression, Literal):
        return "string" if isinstance(expression.value, str) else "number"
    if isinstance(expression, Path):
        return "nodes"
    if isinstance(expression, Filter):
        return "nodes" if type_of(expression.operand) == "nodes" else "sequence"
    if isinstance(expression, Call):
        return SAFE_FUNCTIONS[expression.function].result
    if isinstance(expression, Operation):
        return _type_of_operation(expression.operator)
    if isinstance(expression, Variable):
        return expression.type or "sequence"
    if isinstance(expression, Quantified):
        return "boolean"
    if isinstance(expression, Let):
        return type_of(expression.body)
    if isinstance(expression, If):
        types = {type_of(expression.then), type_of(expression.otherwise)}
        return types.pop() if len(types) == 1 else "sequence"
    is_path = isinstance(expression, Each) and expression.is_step
    return "nodes" if is_path and isinstance(expression, Each) and item_type(expression.body) == "nodes" else "sequence"


def _type_of_operation(operator: str) -> str:
    if operator in OF_NODES:
        return "nodes"
    if operator in ("||", "to"):
        return "string" if operator == "||" else "sequence"
    return "number" if operator in ("+", "-", "*", "div", "idiv", "mod", "negate") else "boolean"


def item_type(expression: Expression) -> str:
    """Type of each item of the value: "nodes", "number", "string" or "boolean"; "any" if they differ or are unknown."""
    if isinstance(expression, Sequence | If):
        parts = expression.items if isinstance(expression, Sequence) else (expression.then, expression.otherwise)
        types = {item_type(part) for part in parts if part != Sequence(())}
        return types.pop() if len(types) == 1 else "any"
    if isinstance(expression, For | Each | Let):
        return item_type(expression.body)
    if isinstance(expression, Filter):
        return item_type(expression.operand)
    if isinstance(expression, Operation) and expression.operator == "to":
        return "number"
    if isinstance(expression, Call):
        signature = SAFE_FUNCTIONS[expression.function]
        if signature.items:
            return signature.items
        if signature.selects and len(expression.arguments) > signature.place:
            return item_type(expression.arguments[signature.place])
    found = type_of(expression)
    return found if found in ("nodes", "number", "string", "boolean") else "any"


def is_integer(expression: Expression) -> bool:
    """Whether the numbers that an expression gives are integers of XPath, which are written without an exponent.

    Arithmetic makes doubles, as everything here is in 1.0-compatibility mode (XPath 2.0 §3.4).
    """
    if isinstance(expression, Literal):
        return isinstance(expression.value, float) and expression.value.is_integer()
    if isinstance(expression, Variable):
        return expression.is_integer
    if isinstance(expression, Operation):
        return expression.operator in ("to", "idiv")
    if isinstance(expression, For | Each | Let):
        return is_integer(expression.body)
    if isinstance(expression, Filter):
        return is_integer(expression.operand)
    if isinstance(expression, Sequence):
        return all(map(is_integer, expression.items))
    if isinstance(expression, If):
        return is_integer(expression.then) and is_integer(expression.otherwise)
    if not isinstance(expression, Call):
        return False
    signature = SAFE_FUNCTIONS[expression.function]
    keeps = signature.selects or expression.function in _KEEPS_INTEGERS
    return signature.is_integer or (keeps and bool(expression.arguments) and is_integer(expression.arguments[0]))


_KEEPS_INTEGERS = frozenset({"floor", "ceiling", "round", "abs", "sum", "min", "max", "distinct-values", "data"})


def depends_on_position(expression: Expression) -> bool:
    """Tell whether position() or last() of the context itself are used, not those of inner predicates."""
    if isinstance(expression, Call):
        if expression.function in ("position", "last"):
            return True
        return any(depends_on_position(argument) for argument in expression.arguments)
    if isinstance(expression, Path):
        return expression.start is not None and depends_on_position(expression.start)
    if isinstance(expression, Filter):
        return depends_on_position(expression.operand)
    if isinstance(expression, Each | Function):
        # In the body positions are those of its items.
        return isinstance(expression, Each) and depends_on_position(expression.source)
    return any(depends_on_position(part) for part in children(expression))


def distinct_of(call: Call) -> Expression | None:
    """The nodes of `count(distinct-values(nodes))`, or of `string-join` of them; None for others."""
    inner = call.arguments[0] if call.arguments else None
    is_distinct = isinstance(inner, Call) and inner.function == "distinct-values" and len(inner.arguments) == 1
    takes = call.function in ("count", "string-join")
    return inner.arguments[0] if takes and is_distinct and isinstance(inner, Call) else None


@lru_cache(maxsize=4096)
def is_of_variables(expression: Expression) -> bool:
    """Whether the value is arithmetic, comparisons and logic of variables and constants, and never an error."""
    if isinstance(expression, Literal | Variable):
        return True
    if isinstance(expression, Call):
        signature = SAFE_FUNCTIONS[expression.function]
        is_simple = signature.of_numbers is not None or expression.function in ("boolean", "not", "number")
        return is_simple and all(map(is_of_variables, expression.arguments))
    if not isinstance(expression, Operation) or expression.operator not in _OF_TWO:
        return False
    return all(map(is_of_variables, expression.operands))


_OF_TWO = frozenset({"and", "or", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "div", "mod", "negate"})


def is_of_document(expression: Expression) -> bool:
    """Whether the value depends on nothing but the document of the context node."""
    if free_variables(expression):
        return False
    if isinstance(expression, Literal):
        return True
    if isinstance(expression, Path):
        return expression.absolute or (expression.start is not None and is_of_document(expression.start))
    if isinstance(expression, Filter):
        return is_of_document(expression.operand)
    if isinstance(expression, Written | Later):
        return False
    if isinstance(expression, Call):
        is_of_frame = expression.function in MOTION_FUNCTIONS and expression.function not in OF_DOCUMENT
        own = (
            is_of_frame
            or expression.function in ("position", "last", "lang")
            or (not expression.arguments and expression.function in OF_CONTEXT)
        )
        return not own and all(is_of_document(argument) for argument in expression.arguments)
    return all(is_of_document(operand) for operand in expression.operands)
