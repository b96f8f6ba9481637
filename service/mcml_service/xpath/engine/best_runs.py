"""The best runs of frames of a scope: those of the greatest key, or the longest ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import nlargest

import numpy as np

from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.context import Context
from mcml_service.xpath.engine.motion.motions import closed_runs
from mcml_service.xpath.language.tree import Expression
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.nodesets import one_set
from mcml_service.xpath.nodes.numbering import FRAME_SHIFT, Floats, Ints, documents_of, frames_of

TOGETHER = 32_768
"""Number of frames whose key is computed together."""


@dataclass(frozen=True, eq=False)
class Runs:
    """The runs of a forest, in order. first, last: frames of each. before: number of runs in the previous forests."""

    columns: Columns
    first: Ints
    last: Ints
    before: int


class BestRuns:
    """Collects frames, forest by forest in order of the answer.

    wanted: number of runs. key: evaluated for each frame; NaN is ignored; None: the length of runs.
    """

    def __init__(self, wanted: int, key: Expression | None) -> None:
        self._wanted = wanted
        self._key = key
        self._best: list[tuple[float, int, Forest, int, int]] = []
        self._seen = 0

    def add(self, columns: Columns, nodes: Ints) -> None:
        """Look at all frames (ascending) of the documents of some columns."""
        _, first, last = closed_runs(one_set(nodes), columns.motions.bodies.seconds, 0.0)
        runs = Runs(columns, first, last, self._seen)
        self._seen += len(first)
        if len(first):
            self._look_at(runs, nodes)

    def best(self) -> Iterator[tuple[Forest, Ints]]:
        """The best first, each as its frames."""
        for _, _, forest, first, last in self._best:
            yield forest, np.arange(first, last + 1, 1 << FRAME_SHIFT)

    def _look_at(self, runs: Runs, nodes: Ints) -> None:
        if self._key is None:
            seconds = runs.columns.motions.bodies.seconds
            scores = (frames_of(runs.last) - frames_of(runs.first) + 1) * seconds[documents_of(runs.first)]
        else:
            parts = [Context(nodes[at : at + TOGETHER]) for at in range(0, len(nodes), TOGETHER)]
            numbers = np.concatenate([runs.columns.numbers(self._key, part) for part in parts])
            scores = np.fmax.reduceat(numbers, np.searchsorted(nodes, runs.first))
        self._take(runs, np.arange(len(scores)), scores)

    @property
    def _least(self) -> float:
        """The score that another run needs."""
        return self._best[-1][0] if len(self._best) == self._wanted else -np.inf

    def _take(self, runs: Runs, which: Ints, scores: Floats) -> None:
        known = np.flatnonzero(~np.isnan(scores))
        known = known[np.argsort(-scores[known], kind="stable")][: self._wanted]
        found = [
            (score, -(runs.before + run), runs.columns.forest, int(runs.first[run]), int(runs.last[run]))
            for score, run in zip(scores[known].tolist(), which[known].tolist(), strict=True)
        ]
        # Of runs of the same score the first one.
        self._best = nlargest(self._wanted, [*self._best, *found], key=lambda run: run[:2])
