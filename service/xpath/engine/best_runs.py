"""The best runs of frames of a scope: those of the greatest key, or the longest ones."""

from __future__ import annotations

from collections.abc import Iterator
from heapq import nlargest

import numpy as np

from service.xpath.engine.columns import Columns
from service.xpath.engine.context import Context
from service.xpath.engine.motions import closed_runs
from service.xpath.language.tree import Expression
from service.xpath.library.forest import Forest
from service.xpath.nodes.nodesets import one_set
from service.xpath.nodes.numbering import FRAME_SHIFT, Ints, documents_of, frames_of

TOGETHER = 32_768
"""Frames whose key is worked out together."""


class BestRuns:
    """Gathers frames, forest by forest in order of the answer. wanted: how many runs."""

    def __init__(self, wanted: int) -> None:
        self._wanted = wanted
        self._best: list[tuple[float, int, Forest, int, int]] = []
        self._seen = 0

    def add(self, columns: Columns, nodes: Ints, key: Expression | None) -> None:
        """Look at all frames (ascending) of the documents of some columns. key: asked of each frame; NaN counts for
        nothing."""
        forest, seconds = columns.forest, columns.motions.bodies.seconds
        _, first, last = closed_runs(one_set(nodes), seconds, 0.0)
        if not len(first):
            return
        if key is None:
            scores = (frames_of(last) - frames_of(first) + 1) * seconds[documents_of(first)]
        else:
            parts = [Context(nodes[at : at + TOGETHER]) for at in range(0, len(nodes), TOGETHER)]
            numbers = np.concatenate([columns.numbers(key, part) for part in parts])
            scores = np.fmax.reduceat(numbers, np.searchsorted(nodes, first))
        known = np.flatnonzero(~np.isnan(scores))
        known = known[np.argsort(-scores[known], kind="stable")][: self._wanted]
        found = [
            (float(scores[run]), -(self._seen + run), forest, int(first[run]), int(last[run])) for run in known.tolist()
        ]
        self._seen += len(first)
        # Of runs of the same score the first one.
        self._best = nlargest(self._wanted, [*self._best, *found], key=lambda run: run[:2])

    def runs(self) -> Iterator[tuple[Forest, Ints]]:
        """The best first, each as its frames."""
        for _, _, forest, first, last in self._best:
            yield forest, np.arange(first, last + 1, 1 << FRAME_SHIFT)
