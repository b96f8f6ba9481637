"""Functions of bodies in motion (`mo:height('left_hand')`) for many frames at once: each is a column over all frames
of the documents, computed once; the queried frames select their numbers from it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any, Protocol, TypeVar

import numpy as np

from mcml.errors import QueryError, RequestError, VocabularyError
from mcml.language.vocabulary import NAME
from mcml.motion.bodies.local_fit import rate
from mcml.motion.bodies.quantities import QUANTITIES
from mcml_service.xpath.engine.context import Context, Value
from mcml_service.xpath.engine.functions import NotOnColumnsError
from mcml_service.xpath.language.motion_functions import (
    DISTANCES,
    KNOWN,
    OF_DOCUMENT,
    OF_FRAME_SETS,
    PREFIX,
    RATE,
    RUNS,
    TRUTHS,
    WINDOW,
)
from mcml_service.xpath.language.tree import Call, Expression, Path, Step, free_variables
from mcml_service.xpath.language.types import type_of
from mcml_service.xpath.library.bodies import Bodies
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.likeness import Asked
from mcml_service.xpath.nodes.nodesets import NodeSets, ordered
from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Floats, Ints, documents_of, frames_of
from mcml_service.xpath.nodes.pairs import bounded, expand
from mcml_service.xpath.nodes.texts import Strings, first_filled

NEARLY = 1e-6
"""Of a frame: times are rounded in files, and a second is 120 frames of 0.0083333."""


Kept = TypeVar("Kept")


class Columns(Protocol):
    """The evaluator of arguments."""

    forest: Forest

    @property
    def check(self) -> Callable[[], None]: ...

    def numbers(self, expression: Expression, context: Context) -> Floats: ...

    def strings(self, expression: Expression, context: Context) -> Strings: ...

    def nodes(self, expression: Expression, context: Context) -> NodeSets: ...


class Motions:
    """Of the documents of some columns."""

    def __init__(self, columns: Columns) -> None:
        self._columns = columns
        self._known: dict[object, tuple[Ints, Ints, Any]] = {}

    @cached_property
    def bodies(self) -> Bodies:
        return Bodies(self._columns.forest, self._columns.check)

    def value(self, call: Call, context: Context) -> Value:
        """The value of a call for each context."""
        name, arguments = call.function, call.arguments
        if not len(self._columns.forest) and name not in OF_FRAME_SETS:
            unknown = np.full(len(context), np.nan)
            return unknown == 1 if type_of(call) == "boolean" else unknown
        if name == WINDOW:
            return self._window(call, context)
        if name == RUNS:
            return self.runs(self._columns.nodes(arguments[0], context), arguments[1:])
        if name == RATE:
            return self._rate(arguments[0], context)
        if name == KNOWN:
            return ~np.isnan(self._asked_number(arguments[0], context))
        if name in DISTANCES:
            return self._distance(call, context)
        if name.removeprefix(PREFIX) not in QUANTITIES:
            raise NotOnColumnsError
        found = self._number(call, context)
        return found == 1 if type_of(call) == "boolean" else found

    def _asked_number(self, expression: Expression, context: Context) -> Floats:
        """Evaluate the argument of `mo:known`: truths stay numbers here."""
        if isinstance(expression, Call) and expression.function in TRUTHS:
            return self._number(expression, context)
        return self._columns.numbers(expression, context)

    def _number(self, call: Call, context: Context) -> Floats:
        """Of a quantity: NaN where it is unknown, a truth 1 or 0."""
        found = np.full(len(context), np.nan)
        for which, texts in self._combined([self._name(each, context) for each in call.arguments], len(context)):
            nodes = context.nodes if which is None else context.nodes[which]
            found[slice(None) if which is None else which] = self._taken(call, texts, nodes)
        return found

    def everywhere(self, key: object, evaluate: Callable[[Context], Kept], nodes: Ints) -> tuple[Kept, Ints, Ints]:
        """Return the values of all frames of the nodes' documents, these frames, and for each node the index of the
        first frame of its document. Values for one slice of nodes are reused for the next ones.
        """
        documents, index = np.unique(documents_of(nodes), return_inverse=True)
        known = self._known.get(key)
        if known is None or not np.array_equal(known[0], documents):
            frames = self._columns.forest.all_frames(documents)[1]
            known = self._known[key] = documents, frames, evaluate(Context(frames))
        counts = self._columns.forest.frames[documents]
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
        return known[2], known[1], starts[index.reshape(-1)]

    def reach(self, call: Call, nodes: Ints) -> tuple[Ints, Ints]:
        """Of a window around each node: the first and the last position of its frames; none where the last is less."""
        low, high = (self._constant(each) for each in call.arguments[:2])
        documents, frames = documents_of(nodes), frames_of(nodes)
        seconds = np.ones(len(nodes))
        if len(call.arguments) < 3:
            seconds = self.bodies.seconds[documents]
        elif self._text(call.arguments[2]) != "frames":
            raise QueryError("A window is of seconds, or of 'frames'.", remedy="Write mo:window(-1, 0, 'frames').")
        known = (frames > 0) & (seconds > 0) & (low == low) & (high == high)
        if not known.all():
            seconds = np.where(known, seconds, 1.0)
        least, most = 1 - frames, self._columns.forest.frames[documents] - frames
        first, last = np.nan_to_num([low / seconds, high / seconds], posinf=np.inf, neginf=-np.inf)
        first = np.clip(np.ceil(first - NEARLY), least, most + 1.0).astype(np.int64)
        last = np.clip(np.floor(last + NEARLY), least - 1.0, most).astype(np.int64)
        return frames + first, np.where(known, frames + last, frames + first - 1)

    def _window(self, call: Call, context: Context) -> NodeSets:
        first, last = self.reach(call, context.nodes)
        source, within = bounded(np.maximum(last - first + 1, 0))
        documents = documents_of(context.nodes)[source] << DOCUMENT_SHIFT
        return NodeSets(source, documents | ((first[source] + within) << FRAME_SHIFT), len(context))

    def runs(self, sets: NodeSets, bounds: tuple[Expression, ...]) -> NodeSets:
        """The frames of runs in node sets. bounds: how long a run is at least, and a gap at most."""
        sets, _ = sets.flat()
        sets = ordered(sets.groups, sets.nodes, sets.count)  # Nodes of a sequence keep the order of the sequence.
        least, gap = self.lengths(bounds)
        groups, first, last = closed_runs(sets, self.bodies.seconds, gap)
        seconds = self.bodies.seconds[documents_of(first)]
        long = (frames_of(last) - frames_of(first) + 1 + NEARLY) * seconds >= least
        groups, first, last = groups[long], first[long], last[long]
        source, within = expand(frames_of(last) - frames_of(first) + 1)
        return NodeSets(groups[source], first[source] + (within << FRAME_SHIFT), sets.count)

    def lengths(self, bounds: tuple[Expression, ...]) -> tuple[float, float]:
        """Seconds that a run is long at least, and a gap at most."""
        return self._constant(bounds[0]), self._constant(bounds[1]) if len(bounds) > 1 else 0.0

    def _rate(self, expression: Expression, context: Context) -> Floats:
        if free_variables(expression):
            raise NotOnColumnsError

        def rates(around: Context) -> Floats:
            documents = documents_of(around.nodes)
            numbers = self._columns.numbers(expression, around)
            edges = np.flatnonzero(np.diff(documents)) + 1
            seconds = self.bodies.seconds
            parts = zip(np.split(numbers, edges), np.split(documents, edges), strict=True)
            return np.concatenate([rate(part, _known(seconds[own[0]])) for part, own in parts if len(part)])

        frames = frames_of(context.nodes)
        found = np.full(len(context), np.nan)
        inside = np.flatnonzero(frames > 0)
        if len(inside):
            numbers, _, starts = self.everywhere((RATE, expression), rates, context.nodes[inside])
            found[inside] = numbers[starts + frames[inside] - 1]
        return found

    def asked(self, call: Call) -> Asked:
        """The pose, or the motion, that a call compares with."""
        return self.bodies.asked(*self._compared(call))

    def _distance(self, call: Call, context: Context) -> Floats:
        """The distance to a pose, or to a motion."""
        column = self.bodies.distances(*self._compared(call))
        rows = self.bodies.rows(context.nodes)
        return np.where(rows >= 0, column[rows], np.nan) if len(column) else np.full(len(context), np.nan)

    def _compared(self, call: Call) -> tuple[str, float, float | None]:
        document = self._columns.strings(call.arguments[0], Context(np.zeros(1, np.int64))).list()[0]
        first, *last = (self._constant(each) for each in call.arguments[1:])
        if not np.isfinite([first, *last]).all():
            raise QueryError("Frames have numbers.", remedy="Write their positions in the document, from 1.")
        return document, first, last[0] if last else None

    def _taken(self, call: Call, texts: tuple[str, ...], nodes: Ints) -> Floats:
        """The numbers that nodes have of a quantity."""
        name = call.function.removeprefix(PREFIX)
        if call.function in OF_DOCUMENT:
            return self.bodies.of_documents(name)[documents_of(nodes)]
        try:
            column = self.bodies.quantity(name, texts)
        except (RequestError, VocabularyError) as error:
            raise QueryError(error.what, remedy=error.remedy) from None
        return self.bodies.at(column, nodes)

    def _name(self, argument: Expression, context: Context) -> Strings:
        """Return the name in an argument: for a node its attribute or child `name`, else its text."""
        if not (isinstance(argument, Path) or type_of(argument) == "nodes"):
            return self._columns.strings(argument, context)
        steps = (Path((Step(axis, NAME),), start=argument) for axis in ("attribute", "child"))
        found = self._columns.strings(next(steps), context)
        for other in (*steps, argument):
            if found.test(bool).all():
                break
            found = first_filled(found, self._columns.strings(other, context))
        return found

    def _combined(self, arguments: list[Strings], count: int) -> Iterator[tuple[Ints | None, tuple[str, ...]]]:
        """Contexts (None: all) of which the arguments have the same texts, and these."""
        if all((each.codes == each.codes[:1]).all() for each in arguments):
            if count:
                yield None, tuple(each.values[int(each.codes[0])] for each in arguments)
            return
        kinds, kind_of = np.unique(np.stack([each.codes for each in arguments]), axis=1, return_inverse=True)
        for number, codes in enumerate(kinds.T.tolist()):
            texts = tuple(each.values[code] for each, code in zip(arguments, codes, strict=True))
            yield np.flatnonzero(kind_of.reshape(-1) == number), texts

    def _constant(self, argument: Expression) -> float:
        """The number that an argument is in every context."""
        return float(self._columns.numbers(argument, Context(np.zeros(1, np.int64)))[0])

    def _text(self, argument: Expression) -> str:
        return self._columns.strings(argument, Context(np.zeros(1, np.int64))).list()[0]


def closed_runs(sets: NodeSets, seconds: Floats, gap: float) -> tuple[Ints, Ints, Ints]:
    """Runs of frames of node sets that are flat: the group, the first frame and the last one of each.

    seconds: a frame of each document. gap: seconds that the frames between two runs that become one last at most.
    """
    groups, nodes = sets.groups, sets.nodes
    if not len(nodes):
        return groups, nodes, nodes
    frames = frames_of(nodes)
    if (frames == 0).any() or (nodes & ((1 << FRAME_SHIFT) - 1)).any():
        raise QueryError("Runs are of frames.", remedy="Select frames, such as //frame[motion_name='walk'].")
    documents = documents_of(nodes)
    between = np.diff(frames) - 1
    far = between > most_between(gap, seconds[documents[:-1]])
    apart = (np.diff(groups) != 0) | (np.diff(documents) != 0) | far
    starts = np.concatenate([[0], np.flatnonzero(apart) + 1])
    ends = np.concatenate([starts[1:] - 1, [len(nodes) - 1]])
    return groups[starts], nodes[starts], nodes[ends]


def most_between(gap: float, seconds: Floats) -> Floats:
    """Return the limit of frames between two runs that become one. gap: in seconds. seconds: frame time."""
    return np.maximum(np.nan_to_num(gap / seconds + NEARLY, nan=0.0, posinf=0.0), 0.0)


def _known(seconds: float) -> float | None:
    return float(seconds) if seconds > 0 else None
