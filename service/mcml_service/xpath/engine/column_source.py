"""Answers from columns: documents in groups, paths in slices of frames, so that memory grows with neither."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property

import numpy as np

from mcml.language.vocabulary import FRAME, FRAME_BONE, MCML, MOTION, MOTION_NAME
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine.axes import SIBLINGS
from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.samples.any_attribute import any_attribute, attributes
from mcml_service.xpath.engine.sequences import items_of
from mcml_service.xpath.engine.starts import Frames, Start, start_of
from mcml_service.xpath.language.labels import bone_name
from mcml_service.xpath.language.reach import DOCUMENT, HeadPart, head_of, is_of_skeleton
from mcml_service.xpath.language.rules import after
from mcml_service.xpath.language.tree import Expression, Path, Step
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.library.motion_notes import BodyScope
from mcml_service.xpath.nodes.items import Items
from mcml_service.xpath.nodes.nodesets import NodeSets, ordered
from mcml_service.xpath.nodes.numbering import Ints, documents_of, first_of_documents
from mcml_service.xpath.nodes.pairs import TooWideError
from mcml_service.xpath.nodes.texts import Strings

SLICE_FRAMES = 4096
"""Frames that the rest of a path is walked from together; whole chunks, so that no track is read twice."""
LEAVING = frozenset({"following", "preceding"})
IN_FRAMES = frozenset({FRAME, MOTION_NAME, FRAME_BONE})
ONE_EACH = ((Step("child", MCML),), (Step("child", MCML), Step("child", MOTION)))
"""Steps from the document to an element that each has one of."""


class ColumnSource:
    """An expression over the documents of a scope, evaluated on columns.

    bodies: leaves out documents in which a measurement of the query is unknown. check: called often; raises
    when the query must end. head_part: the least of the documents' heads, for all that a query asks of the nodes.
    Every method may raise TooWideError or TooLongError where an intermediate result is larger than is held at once.
    """

    def __init__(
        self,
        tx: Transaction,
        tree: Expression,
        scope: Scope,
        caches: Caches,
        check: Callable[[], None],
        bodies: BodyScope | None = None,
        head_part: HeadPart = HeadPart.MOTION,
        *,
        is_later: bool = False,
    ) -> None:
        self.tx = tx
        self.tree = tree
        self.start = start_of(tree)
        self.frames = Frames(tx, self.start, scope)
        self._caches = caches
        self._bodies = bodies
        self._check = check
        self._is_later = is_later
        self._head_part = head_part
        self._any = any_attribute(tree)
        self._one_a_skeleton = is_of_skeleton(tree)

    @property
    def documents(self) -> Sequence[Listed]:
        """Documents that can have nodes of the answer, in its order."""
        return [listed for group in self._groups() for listed in group]

    def _groups(self) -> Iterable[Group]:
        groups = self.frames.groups
        return groups if self._bodies is None else self._bodies.select(groups)

    def forests(self, *, counted: bool = False) -> Iterator[Forest]:
        """Yield the documents in groups.

        For queries with conditions, the first groups are small: often only the first page is needed. counted: only the
        number of nodes is needed.
        """
        head_part = max(head_of(self.tree, counted=counted), self._head_part)
        for group in self._groups():
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
        """Those of a group; where they are too many to be bodies at together, of each half alone."""
        begun = False
        try:
            for nodes in self._walk(self._columns(forest)):
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
        if self.start is not None and self.start.only_frames and not self._asks_bodies:
            return self._count_frames(self.start)
        if self.start is not None and not self.start.indexed and not self.start.predicates:
            bones = _bones_asked(self.start)
            if bones is not None:
                return sum(forest.shapes.counted(bones) for forest in self.forests())
        if isinstance(self.tree, Path) and self.tree.absolute and self.tree.steps in ONE_EACH:
            return len(self.documents)
        if self._one_a_skeleton:
            return sum(int(self._times(forest)[documents_of(nodes)].sum()) for forest, nodes in self.examples())
        return sum(len(nodes) for forest in self.forests(counted=True) for _, nodes in self._chunks(forest))

    def items(self) -> Iterator[tuple[Forest, Items]]:
        """The sequence of each document, some documents at a time."""
        for forest in self.forests():
            yield from self._items(forest)

    def values(self) -> list[float | str | bool] | None:
        """The value of each document; None where one has none, several, or a node."""
        found: list[float | str | bool] = []
        forests = self._examples() if self._one_a_skeleton else self.forests()
        for _, items in (each for forest in forests for each in self._items(forest)):
            if items.kind == "nodes" or len(items) != items.count or (np.diff(items.groups) != 1).any():
                return None
            found += items.column.list() if isinstance(items.column, Strings) else items.column.tolist()
        return [found[number] for number in self._skeletons[2].tolist()] if self._one_a_skeleton else found

    def _items(self, forest: Forest) -> Iterator[tuple[Forest, Items]]:
        columns = self._columns(forest)
        try:
            found = items_of(columns.value(self.tree, columns.documents()))
        except TooWideError:
            if len(forest) < 2:
                raise
            for half in halves(forest):
                yield from self._items(half)
            return
        yield forest, found

    def _columns(self, forest: Forest) -> Columns:
        return Columns(forest, self._check, is_later=self._is_later)

    @property
    def _asks_bodies(self) -> bool:
        return self._bodies is not None and bool(self._bodies.calls)

    def _count_frames(self, start: Start) -> int:
        if start.numbers is None:
            return self.frames.count()
        total = 0
        for forest in self.forests(counted=True):
            columns = self._columns(forest)
            counted = self.frames.count_in(columns)
            total += len(self.frames.of(columns)) if counted is None else counted
        return total

    def _walk(self, columns: Columns) -> Iterator[Ints]:
        tree = self.tree
        if not (isinstance(tree, Path) and tree.absolute):
            yield columns.nodes(tree, columns.documents()).flat()[0].nodes
            return
        found = None if self._any is None else attributes(columns, self._any)
        if found is not None:
            yield found
            return
        if self.start is not None:
            nodes = self.frames.of(columns)
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


def _bones_asked(start: Start) -> str | None:
    """Return the name of the frame_bones at the end of the path, "" for all of them; None for other paths."""
    step = start.steps[0] if len(start.steps) == 1 else None
    if step is None or (step.axis, step.name) != ("child", FRAME_BONE) or len(step.predicates) > 1:
        return None
    return bone_name(step) if step.predicates else ""


def frames_at(steps: Sequence[Step]) -> int:
    """After how many steps a path has reached frames; all, if it never does."""
    types = frozenset({DOCUMENT})
    for number, step in enumerate(steps, start=1):
        types = after(types, step)
        if types == {FRAME}:
            return number
    return len(steps)


def steps_in_frames(steps: Sequence[Step]) -> int:
    """Return the number of steps from a frame that stay inside it: for these, frames can be processed in slices."""
    types = frozenset({FRAME})
    for number, step in enumerate(steps):
        leaves = step.axis in LEAVING or (step.axis in SIBLINGS and FRAME in types)
        types = after(types, step)
        if leaves or not {found.lstrip("@#") for found in types} <= IN_FRAMES:
            return number
    return len(steps)
