"""Find the frames that a path must read by an index: by motion names, or by conditions on ids or positions alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcml.language.vocabulary import FRAME, MCML, MOTION, MOTION_NAME
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.encoding import is_plain_integer
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.context import Bound, Context
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.labels import Groups, motion_name_groups, ranges_of, without_self
from mcml_service.xpath.language.positions import counts, position_of
from mcml_service.xpath.language.tree import TURNED, Call, Expression, Literal, Operation, Path, Step, Variable, walk
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.nodes.number_runs import EXACT, NumberRuns, NumberTable, runs_of_positions
from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints, documents_of
from mcml_service.xpath.nodes.pairs import expand
from mcml_service.xpath.nodes.texts import to_number

NUMBER = Variable("number", "number")
"""The id or the position of a frame, in a condition on it alone."""
_ARITHMETIC = frozenset({"+", "-", "*", "div", "mod", "negate"})
_ID = Path((Step("attribute", "id"),))


@dataclass(frozen=True)
class Numbers:
    """Predicates of frames that ask for ids alone, or for positions alone. condition: the same on NUMBER, for ids that
    are integers."""

    by_id: bool
    condition: Expression
    predicates: tuple[Expression, ...]


@dataclass(frozen=True)
class Start:
    """Where `/mcml/motion/frame[…]…` begins.

    groups: motion names that frames must carry. numbers: conditions on their ids or positions. predicates: those of the
    frames that are left to be looked at. steps: the rest of the path.
    """

    groups: Groups
    numbers: Numbers | None
    predicates: tuple[Expression, ...]
    steps: tuple[Step, ...]

    @property
    def indexed(self) -> bool:
        """Whether fewer frames than all are looked at."""
        return bool(self.groups) or self.numbers is not None

    @property
    def named_only(self) -> bool:
        """Whether only frames that carry motion names matter."""
        first = self.steps[0] if self.steps and not self.predicates else None
        return first is not None and (first.axis, first.name) == ("child", MOTION_NAME)

    @property
    def only_frames(self) -> bool:
        return not self.predicates and not self.steps


def start_of(tree: Expression) -> Start | None:
    """Return the start of a path in the form of `rules.normal`; None for a path that does not begin with frames."""
    if not isinstance(tree, Path) or not tree.absolute or len(tree.steps) < 3:
        return None
    ways = [(step.axis, step.name) for step in tree.steps[:3]]
    if ways != [("child", MCML), ("child", MOTION), ("child", FRAME)] or any(s.predicates for s in tree.steps[:2]):
        return None
    predicates, steps = tree.steps[2].predicates, tree.steps[3:]
    at = _position_condition(predicates[0]) if predicates else None
    if at is not None:
        return Start((), Numbers(False, at, predicates[:1]), predicates[1:], steps)
    groups: list[tuple[str, ...]] = []
    rest: list[Expression] = []
    ids: list[tuple[Expression, Expression]] = []
    for number, predicate in enumerate(predicates):
        if counts(tree.steps[2].where((predicate,))):
            # Positions count what the predicates before leave over: from here on, order matters.
            rest += predicates[number:]
            break
        found, condition = motion_name_groups(predicate), _condition(predicate, lambda part: _is_path(part, _ID.steps))
        if found is not None:
            groups += found
        elif condition is not None:
            ids.append((condition, predicate))
        else:
            rest.append(predicate)
    numbers = None
    if ids:
        conditions, asked = zip(*ids, strict=True)
        numbers = Numbers(True, conditions[0] if len(ids) == 1 else Operation("and", conditions), asked)
    return Start(tuple(groups), numbers, tuple(rest), steps)


def _position_condition(predicate: Expression) -> Expression | None:
    """Return a predicate that asks for position() alone as a condition on NUMBER, None for others."""
    place = position_of(predicate)
    if place is not None:
        return Operation("=", (NUMBER, Literal(float(place))))
    return _condition(predicate, lambda part: part == Call("position"))


def _condition(predicate: Expression, is_number: Callable[[Expression], bool]) -> Expression | None:
    """Return a predicate that asks for one number alone as a condition on NUMBER, None for others.

    is_number: tells which expressions are that number, position() or the node of an id.
    """
    found = _convert(predicate, is_number)
    return found if found is not None and NUMBER in walk(found) else None


def _convert(predicate: Expression, is_number: Callable[[Expression], bool]) -> Expression | None:
    if isinstance(predicate, Call) and predicate.function in ("not", "boolean"):
        (inner,) = predicate.arguments
        found = _of_chosen_id(inner) if isinstance(inner, Path) and is_number(_ID) else _convert(inner, is_number)
        return None if found is None else Call(predicate.function, (found,))
    if not isinstance(predicate, Operation):
        return None
    if predicate.operator in ("and", "or"):
        return _convert_all(predicate.operator, predicate.operands, is_number)
    if predicate.operator not in TURNED or len(predicate.operands) != 2:
        return None
    if _is_of_text(predicate, is_number):
        # No integer is written so.
        return Operation("!=" if predicate.operator == "=" else "=", (NUMBER, NUMBER))
    left, right = (_operand(*pair, is_number) for pair in (predicate.operands, predicate.operands[::-1]))
    if left is None or right is None:
        return None
    if isinstance(left, Literal):
        return Operation(TURNED[predicate.operator], (right, left))
    return Operation(predicate.operator, (left, right))


def _convert_all(
    operator: str, predicates: tuple[Expression, ...], is_number: Callable[[Expression], bool]
) -> Expression | None:
    """Return several conditions as one, None without any."""
    found = tuple(made for each in predicates if (made := _convert(each, is_number)) is not None)
    if not found or len(found) < len(predicates):
        return None
    return found[0] if len(found) == 1 else Operation(operator, found)


def _of_chosen_id(path: Path) -> Expression | None:
    """Return the condition in `@id[. > 7 and . < 90]`, that there is such an id."""
    if len(path.steps) != 1 or not _is_path(Path((path.steps[0].where(()),), path.absolute, path.start), _ID.steps):
        return None
    return _convert_all("and", path.steps[0].predicates, lambda part: _is_path(part, ()))


def _is_of_text(comparison: Operation, is_number: Callable[[Expression], bool]) -> bool:
    """Whether an id is compared with a text that no integer below 2^53 has."""
    if comparison.operator not in ("=", "!="):
        return False
    for one, other in (comparison.operands, comparison.operands[::-1]):
        if isinstance(one, Literal) and isinstance(one.value, str) and isinstance(other, Path) and is_number(other):
            return not (is_plain_integer(one.value) and abs(int(one.value)) < EXACT)
    return False


def _operand(expression: Expression, other: Expression, is_number: Callable[[Expression], bool]) -> Expression | None:
    """One side of a comparison as a number; a text only beside an id."""
    if isinstance(expression, Literal) and isinstance(expression.value, str):
        return Literal(to_number(expression.value)) if isinstance(other, Path) and is_number(other) else None
    return _number(expression, is_number)


def _number(expression: Expression, is_number: Callable[[Expression], bool]) -> Expression | None:
    if is_number(expression):
        return NUMBER
    if isinstance(expression, Literal):
        return expression if isinstance(expression.value, float) else None
    if isinstance(expression, Operation) and expression.operator in _ARITHMETIC:
        parts: tuple[Expression, ...] = expression.operands
    elif isinstance(expression, Call) and expression.arguments and _is_of_numbers(expression.function):
        parts = expression.arguments
    else:
        return None
    found = tuple(made for part in parts if (made := _number(part, is_number)) is not None)
    if len(found) < len(parts):
        return None
    if isinstance(expression, Operation):
        return Operation(expression.operator, found)
    return Call(expression.function, found)


def _is_of_numbers(function: str) -> bool:
    signature = SAFE_FUNCTIONS.get(function)
    return function == "number" or (signature is not None and signature.of_numbers is not None)


def _is_path(expression: Expression, steps: tuple[Step, ...]) -> bool:
    """Whether it is a path from the context node by these steps."""
    if not isinstance(expression, Path) or expression.absolute or expression.start is not None:
        return False
    return without_self(expression.steps) == steps


class Frames:
    """The frames of a start in the documents of a scope."""

    def __init__(self, tx: Transaction, start: Start | None, scope: Scope) -> None:
        self.start = start
        self._tx = tx
        self._scope = scope
        self._table = NumberTable()
        self._ranges: dict[int, list[tuple[int, int]]] | None = None
        if start is not None and start.groups:
            self._ranges = ranges_of(tx, start.groups, scope.narrowed())

    @cached_property
    def groups(self) -> list[Group]:
        """Return the documents with such frames by the index on names, in order of the answer."""
        if self._ranges is None:
            return self._scope.groups()
        return self._scope.groups(self._scope.documents(list(self._ranges)))

    @property
    def documents(self) -> list[Listed]:
        """The same, one after the other."""
        return [listed for group in self.groups for listed in group]

    def count(self) -> int:
        """How many frames these are, where only motion names or nothing narrows them."""
        if self._ranges is None:
            return sum(int(group.frames.sum()) for group in self.groups)
        return sum(last - first + 1 for ranges in self._ranges.values() for first, last in ranges)

    def count_in(self, columns: Columns) -> int | None:
        """How many frames of the documents of a batch these are, where conditions on numbers alone narrow them; None
        where they must be looked at."""
        numbers = None if self.start is None or self._ranges is not None else self.start.numbers
        found = None if numbers is None else self._hits(columns, numbers)
        if numbers is None or found is None:
            return None
        runs, hits = found
        return runs.count_of(hits) + len(self._of_texts(columns, numbers))

    def of(self, columns: Columns) -> Ints:
        """The frame elements of the documents of a batch, ascending."""
        start, forest = self.start, columns.forest
        if start is not None and not start.indexed and start.named_only:
            return forest.labels.named_frames(forest.frames)
        numbers = None if start is None else start.numbers
        found = None if numbers is None else self._hits(columns, numbers)
        if numbers is None or found is None:
            nodes = self._find_named(forest)
            return nodes if numbers is None else _filter(columns, nodes, numbers)
        runs, hits = found
        nodes, others = runs.frames_of(hits), self._of_texts(columns, numbers)
        if len(others):
            nodes = np.sort(np.concatenate([nodes, others]))
        return nodes if self._ranges is None else np.intersect1d(self._find_named(forest), nodes)

    def _find_named(self, forest: Forest) -> Ints:
        """The frames that carry the motion names, all where none are asked for."""
        if self._ranges is None:
            return forest.all_frames(np.arange(len(forest)))[1]
        table = [(place, *ends) for place, key in enumerate(forest.keys) for ends in self._ranges[key]]
        places, first, last = np.array(table, np.int64).reshape(-1, 3).T
        source, within = expand(last - first + 1)
        return (places[source] << DOCUMENT_SHIFT) | ((first[source] + within) << FRAME_SHIFT)

    def _hits(self, columns: Columns, numbers: Numbers) -> tuple[NumberRuns, Ints] | None:
        """The runs of numbers, and which numbers fulfil the condition; None where they must be looked at one by one."""

        def holds(values: Floats) -> Bools:
            context = Context(np.zeros(len(values), np.int64), variables={NUMBER.name: Bound(values)})
            return columns.kept(numbers.condition, context)

        forest = columns.forest
        runs = forest.ids.of_numbers if numbers.by_id else runs_of_positions(forest.frames)
        hits = self._table.hits(runs, holds)
        return None if hits is None else (runs, hits)

    def _of_texts(self, columns: Columns, numbers: Numbers) -> Ints:
        """The frames whose ids are other texts, as far as they fulfil the predicates."""
        nodes = columns.forest.ids.of_texts if numbers.by_id else np.empty(0, np.int64)
        return _filter(columns, nodes, numbers) if len(nodes) else nodes


def _filter(columns: Columns, nodes: Ints, numbers: Numbers) -> Ints:
    return columns.filtered(documents_of(nodes), nodes, numbers.predicates)
