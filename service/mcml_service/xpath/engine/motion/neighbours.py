"""Facts about the neighbours of nodes, without listing them for each: their existence, the number of frames in a
window, the number of children.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from mcml.language.vocabulary import FRAME, FRAME_BONE
from mcml_service.xpath.engine.axes import are_frames, children_of
from mcml_service.xpath.engine.context import Context, own_set
from mcml_service.xpath.engine.existence import Beyond
from mcml_service.xpath.engine.motion.windows import Windows
from mcml_service.xpath.language.positions import is_window, window_of
from mcml_service.xpath.language.tree import Expression, Path, free_variables
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints


class Columns(Protocol):
    """The evaluator of predicates and paths."""

    forest: Forest

    def sliced(self, predicate: Expression, context: Context) -> Bools: ...

    def nodes(self, expression: Expression, context: Context) -> NodeSets: ...


class Neighbours:
    """Neighbours in the documents of some columns; results for one slice of context nodes are reused for the others."""

    def __init__(self, columns: Columns) -> None:
        self._columns = columns
        self._asked: dict[Path, Beyond] = {}
        self._near: dict[Path, Windows] = {}

    def beyond(self, path: Path, nodes: Ints) -> Bools:
        """Whether a path that begins on a sibling, following or preceding axis reaches anything."""
        first, rest = path.steps[0], path.steps[1:]
        if path not in self._asked:
            asked = (*first.predicates, *([Path(rest)] if rest else []))
            self._asked[path] = Beyond(
                self._columns.forest, first.axis, first.name, lambda found: self._kept(found, asked)
            )
        return self._asked[path].exists(nodes)

    def window(self, path: Path, frames: Ints) -> Ints:
        """Return for each frame the number of frames in a window that match the rest of the path."""
        first, rest = path.steps[0], path.steps[1:]
        window = window_of(first)
        if path not in self._near and window is not None:
            asked = (*first.predicates[1:], *([Path(rest)] if rest else []))
            self._near[path] = Windows(self._columns.forest, first, window, lambda found: self._kept(found, asked))
        return self._near[path].counts(frames)

    def counted(self, path: Path, context: Context) -> Floats | None:
        """How many nodes a path reaches, where that is known without listing them; None for others."""
        if not path.steps:
            return None
        *before, last = path.steps
        if not before and is_window(path) and are_frames(context.nodes) and not free_variables(path):
            return self.window(path, context.nodes).astype(np.float64)
        if last.axis != "child" or last.predicates or last.name not in (FRAME, FRAME_BONE):
            return None
        above = replace(path, steps=tuple(before))
        is_own = not before and not path.absolute and path.start is None
        holders = own_set(context) if is_own else self._columns.nodes(above, context)
        return holders.sums(children_of(self._columns.forest, holders.nodes, last.name))

    def _kept(self, nodes: Ints, predicates: tuple[Expression, ...]) -> Bools:
        keep = np.ones(len(nodes), bool)
        for predicate in predicates:
            index = np.flatnonzero(keep)
            keep[index] = self._columns.sliced(predicate, Context(nodes[index]))
        return keep
