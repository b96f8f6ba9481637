"""Answers from columns: documents in groups, paths in slices of frames, so that memory grows with neither."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property

import numpy as np

from service.mcml.vocabulary import FRAME, FRAME_BONE, MOTION_NAME
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.engine.axes import SIBLINGS
from service.xpath.engine.columns import Columns
from service.xpath.engine.functions import as_booleans, kind_of
from service.xpath.engine.starts import Frames, Start, start_of
from service.xpath.language.reach import DOCUMENT, HeadPart, head_of, is_of_skeleton
from service.xpath.language.rules import after
from service.xpath.language.tree import Expression, Path, Step
from service.xpath.library.caches import Caches
from service.xpath.library.forest import Forest
from service.xpath.library.listing import Scope
from service.xpath.nodes.nodesets import NodeSets, ordered
from service.xpath.nodes.numbering import Ints, documents_of, first_of_documents
from service.xpath.nodes.pairs import TooWideError
from service.xpath.nodes.texts import Strings

SLICE_FRAMES = 4096
"""Frames that the rest of a path is walked from together; whole chunks, so that no track is read twice."""
LEAVING = frozenset({"following", "preceding"})
IN_FRAMES = frozenset({FRAME, MOTION_NAME, FRAME_BONE})


class ColumnSource:
    """An expression over the documents of a scope, evaluated on columns.

    check: called often; raises when the query must end. Every method may raise TooWideError or TooLongError where an
    intermediate result is larger than is held at once.
    """

    def __init__(
        self, tx: Transaction, tree: Expression, scope: Scope, caches: Caches, check: Callable[[], None]
    ) -> None:
        self.tx = tx
        self.tree = tree
        self.start = start_of(tree)
        self.frames = Frames(tx, self.start, scope)
        self._caches = caches
        self._check = check
        self._one_a_skeleton = is_of_skeleton(tree)

    @property
    def documents(self) -> Sequence[Listed]:
        """Those that can hold nodes of the answer, in its order."""
        return self.frames.documents

    def forests(self) -> Iterator[Forest]:
        """The documents in groups. Of what a question narrows, the first are small: often the first page is all that is
        wanted."""
        head_part = head_of(self.tree)
        for group in self.frames.groups:
            yield Forest(self.tx, group, self._caches, head_part=head_part)

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        """The nodes of the answer, in order, some at a time."""
        for forest in self.forests():
            yield from self._chunks(forest)

    def examples(self) -> Iterator[tuple[Forest, Ints]]:
        """Nodes that have all strings of the answer, in the order of the first of each; some at a time."""
        if not self._one_a_skeleton:
            yield from self.chunks()
            return
        for forest in self._examples():
            yield from self._chunks(forest)

    @cached_property
    def _skeletons(self) -> tuple[list[Listed], dict[int, int], Ints]:
        """The first document of each skeleton, how many have it, and which of these each document has."""
        documents = self.documents
        skeletons = np.array([listed.skeleton for listed in documents], np.int64)
        found, first, inverse, counts = np.unique(skeletons, return_index=True, return_inverse=True, return_counts=True)
        order = np.argsort(first)
        place = np.empty(len(order), np.int64)
        place[order] = np.arange(len(order))
        times = dict(zip(found.tolist(), counts.tolist(), strict=True))
        return [documents[number] for number in first[order].tolist()], times, place[inverse.reshape(-1)]

    def _examples(self) -> Iterator[Forest]:
        """These documents in groups."""
        for group in self._caches.listing.cut(self._skeletons[0]):
            yield Forest(self.tx, group, self._caches, head_part=HeadPart.ALL)

    def _times(self, forest: Forest) -> Ints:
        """How many documents have the skeleton of each."""
        return np.array([self._skeletons[1][listed.skeleton] for listed in forest.documents], np.int64)

    def _chunks(self, forest: Forest) -> Iterator[tuple[Forest, Ints]]:
        """Those of a group; where they are too many to be looked at together, of each half alone."""
        begun = False
        try:
            for nodes in self._walk(Columns(forest, self._check)):
                begun = True
                if len(nodes):
                    yield forest, nodes
        except TooWideError:
            if begun or len(forest) < 2:
                raise
        else:
            return
        for half in halves(forest):
            yield from self._chunks(half)

    def count(self) -> int:
        """How many nodes the documents have together."""
        if self.start is not None and self.start.only_frames and not self._narrowed():
            return self.frames.count()
        if self.start is not None and not self.start.indexed and not self.start.predicates and _all_bones(self.start):
            return sum(forest.shapes.total for forest in self.forests())
        if self._one_a_skeleton:
            return sum(int(self._times(forest)[documents_of(nodes)].sum()) for forest, nodes in self.examples())
        return sum(len(nodes) for _, nodes in self.chunks())

    def values(self) -> list[float | str | bool]:
        """The value of each document."""
        if self._one_a_skeleton:
            found = [value for forest in self._examples() for value in self._values(forest)]
            return [found[number] for number in self._skeletons[2].tolist()]
        return [value for forest in self.forests() for value in self._values(forest)]

    def _values(self, forest: Forest) -> list[float | str | bool]:
        columns = Columns(forest, self._check)
        try:
            found = columns.value(self.tree, columns.documents())
        except TooWideError:
            if len(forest) < 2:
                raise
            return [value for half in halves(forest) for value in self._values(half)]
        if isinstance(found, Strings):
            return list(found.list())
        if kind_of(found) == "boolean":
            return list(as_booleans(found).tolist())
        return list(np.asarray(found, np.float64).tolist())

    def _narrowed(self) -> bool:
        return self.start is not None and (self.start.position is not None or self.start.id is not None)

    def _walk(self, columns: Columns) -> Iterator[Ints]:
        tree = self.tree
        if not (isinstance(tree, Path) and tree.absolute):
            yield columns.nodes(tree, columns.documents()).flat()[0].nodes
            return
        if self.start is not None:
            nodes = self.frames.of(columns.forest)
            nodes = columns.filtered(documents_of(nodes), nodes, self.start.predicates)
            rest = self.start.steps
        else:
            split = frames_at(tree.steps)
            documents = first_of_documents(np.arange(len(columns.forest)))
            one = NodeSets(np.zeros(len(documents), np.int64), documents, 1)
            nodes, rest = columns.steps(one, tree.steps[:split]).nodes, tree.steps[split:]
        inner = steps_in_frames(rest)
        if inner == len(rest):
            yield from self._within(columns, nodes, rest)
            return
        reached = np.concatenate([*self._within(columns, nodes, rest[:inner]), np.empty(0, np.int64)])
        yield columns.steps(ordered(np.zeros(len(reached), np.int64), reached, 1), rest[inner:]).nodes

    def _within(self, columns: Columns, nodes: Ints, steps: tuple[Step, ...]) -> Iterator[Ints]:
        """Steps from frames that stay in them, some frames at a time."""
        if not steps:
            yield nodes
        for at in range(0, len(nodes), SLICE_FRAMES) if steps else ():
            yield from self._from_some(columns, nodes[at : at + SLICE_FRAMES], steps)

    def _from_some(self, columns: Columns, nodes: Ints, steps: tuple[Step, ...]) -> Iterator[Ints]:
        """The same from some frames; from too many, each half alone."""
        try:
            found = columns.steps(ordered(np.zeros(len(nodes), np.int64), nodes, 1), steps).nodes
        except TooWideError:
            if len(nodes) < 2:
                raise
            half = len(nodes) // 2
            yield from self._from_some(columns, nodes[:half], steps)
            yield from self._from_some(columns, nodes[half:], steps)
            return
        yield found


def halves(forest: Forest) -> tuple[Forest, Forest]:
    """Its documents in two groups."""
    middle = len(forest) // 2
    return forest.part(forest.documents[:middle]), forest.part(forest.documents[middle:])


def _all_bones(start: Start) -> bool:
    """Whether the path goes on to all frame_bones, and ends there."""
    return [(step.axis, step.name, step.predicates) for step in start.steps] == [("child", FRAME_BONE, ())]


def frames_at(steps: Sequence[Step]) -> int:
    """After how many steps a path has reached frames; all, if it never does."""
    types = frozenset({DOCUMENT})
    for number, step in enumerate(steps, start=1):
        types = after(types, step)
        if types == {FRAME}:
            return number
    return len(steps)


def steps_in_frames(steps: Sequence[Step]) -> int:
    """How many steps from a frame reach only it and what is in it: so far, frames can be looked at in slices."""
    types = frozenset({FRAME})
    for number, step in enumerate(steps):
        leaves = step.axis in LEAVING or (step.axis in SIBLINGS and FRAME in types)
        types = after(types, step)
        if leaves or not {found.lstrip("@#") for found in types} <= IN_FRAMES:
            return number
    return len(steps)
