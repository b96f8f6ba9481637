"""Find the frames that a path must read by an index: by motion names, by an id, or at a position."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcml.language.vocabulary import FRAME, MCML, MOTION, MOTION_NAME
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.labels import Groups, compared_text, motion_name_groups, ranges_of, without_self
from mcml_service.xpath.language.positions import counts, position_of
from mcml_service.xpath.language.tree import Expression, Literal, Operation, Path, Step
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Ints
from mcml_service.xpath.nodes.pairs import expand


@dataclass(frozen=True)
class Start:
    """Where `/mcml/motion/frame[…]…` begins.

    groups: motion names that frames must carry. position: only the frame there. ids: only frames of one of these ids
    (texts), or of an id that is one of these numbers. predicates: those of the frames that are left to be looked at.
    steps: the rest of the path.
    """

    groups: Groups
    position: int | None
    ids: tuple[str | float, ...] | None
    predicates: tuple[Expression, ...]
    steps: tuple[Step, ...]

    @property
    def indexed(self) -> bool:
        """Whether fewer frames than all are looked at."""
        return bool(self.groups) or self.position is not None or self.ids is not None

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
    if predicates and (position := position_of(predicates[0])) is not None:
        return Start((), position, None, predicates[1:], steps)
    groups: list[tuple[str, ...]] = []
    rest: list[Expression] = []
    wanted: tuple[str | float, ...] | None = None
    for number, predicate in enumerate(predicates):
        if counts(tree.steps[2].where((predicate,))):
            # Positions count what the predicates before leave over: from here on, order matters.
            rest += predicates[number:]
            break
        found, ids = motion_name_groups(predicate), _frame_ids(predicate)
        if found is not None:
            groups += found
        elif ids is not None and wanted is None:
            wanted = ids
        else:
            rest.append(predicate)
    return Start(tuple(groups), None, wanted, tuple(rest), steps)


def _frame_ids(predicate: Expression) -> tuple[str | float, ...] | None:
    """Those of one `@id=…`, or of several with `or` between them."""
    is_any = isinstance(predicate, Operation) and predicate.operator == "or"
    operands = predicate.operands if is_any and isinstance(predicate, Operation) else (predicate,)
    found = [_frame_id(operand) for operand in operands]
    return None if None in found else tuple(each for each in found if each is not None)


def _frame_id(predicate: Expression) -> str | float | None:
    """N of `@id=N` or `@id='N'`."""
    text = compared_text(predicate)
    if text is not None:
        return text[1] if _is_id(text[0]) else None
    if isinstance(predicate, Operation) and predicate.operator == "=" and len(predicate.operands) == 2:
        for one, other in (predicate.operands, predicate.operands[::-1]):
            if isinstance(one, Path) and isinstance(other, Literal) and isinstance(other.value, float):
                return other.value if _is_id(one) else None
    return None


def _is_id(path: Path) -> bool:
    return not path.absolute and path.start is None and without_self(path.steps) == (Step("attribute", "id"),)


class Frames:
    """The frames of a start in the documents of a scope."""

    def __init__(self, tx: Transaction, start: Start | None, scope: Scope) -> None:
        self.start = start
        self._tx = tx
        self._scope = scope
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

    def of(self, forest: Forest) -> Ints:
        """The frame elements of the documents of a batch, ascending."""
        start = self.start
        if start is not None and start.position is not None:
            places = np.flatnonzero(forest.frames >= start.position)
            return np.asarray((places << DOCUMENT_SHIFT) | (start.position << FRAME_SHIFT), np.int64)
        if start is not None and not start.indexed and start.named_only:
            return forest.labels.named_frames(forest.frames)
        found = None if start is None or start.ids is None else self._of_ids(forest, start.ids)
        if self._ranges is None:
            return forest.all_frames(np.arange(len(forest)))[1] if found is None else found
        table = [(place, *ends) for place, key in enumerate(forest.keys) for ends in self._ranges[key]]
        places, first, last = np.array(table, np.int64).reshape(-1, 3).T
        source, within = expand(last - first + 1)
        named = (places[source] << DOCUMENT_SHIFT) | ((first[source] + within) << FRAME_SHIFT)
        return named if found is None else np.intersect1d(named, found)

    def _of_ids(self, forest: Forest, ids: tuple[str | float, ...]) -> Ints:
        found = [forest.ids.find(each) for each in ids]
        return found[0] if len(found) == 1 else np.unique(np.concatenate(found))
