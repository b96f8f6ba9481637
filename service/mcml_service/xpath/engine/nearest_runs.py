"""Find the runs of frames in a scope that are most similar to a pose or a motion, with exact comparison only of
candidates.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml_service.xpath.engine.best_runs import BestRuns, Runs
from mcml_service.xpath.language.motion_functions import DISTANCES
from mcml_service.xpath.language.tree import Call, Expression, Operation
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.likeness import Asked, nearest_first
from mcml_service.xpath.nodes.numbering import Floats, Ints, documents_of, frames_of


def best_runs(wanted: int, key: Expression | None) -> BestRuns:
    """Return an object that finds the best runs.

    wanted: number of runs. key: as in `BestRuns`; if it is the distance to a pose or a motion, such as
    `-mo:pose-distance('walk', 20)`, an index finds them.
    """
    if isinstance(key, Operation) and key.operator == "negate":
        (operand,) = key.operands
        if isinstance(operand, Call) and operand.function in DISTANCES:
            return NearestRuns(wanted, operand)
    return BestRuns(wanted, key)


class NearestRuns(BestRuns):
    """As `BestRuns` does with a distance as key. distance: a call of one of DISTANCES."""

    def __init__(self, wanted: int, distance: Call) -> None:
        super().__init__(wanted, None)
        self._distance = distance
        self._groups: list[Runs] = []

    def best(self) -> Iterator[tuple[Forest, Ints]]:
        if self._groups and self._wanted:
            self._compare(self._groups[0].columns.motions.asked(self._distance))
        yield from super().best()

    def _look_at(self, runs: Runs, nodes: Ints) -> None:
        self._groups.append(runs)

    def _compare(self, asked: Asked) -> None:
        bounds = [_least_distances(runs, asked) for runs in self._groups]
        columns = self._groups[0].columns
        forest = columns.forest
        for near in nearest_first(bounds, lambda: -self._least):
            places = [(group, int(documents_of(self._groups[group].first[run]))) for group, run in near]
            documents = {place: self._groups[place[0]].columns.forest.documents[place[1]] for place in places}
            found = asked.unlike(forest.tx, forest.caches, list(documents.values()), columns.check)
            unlike = dict(zip(documents, found, strict=True))
            scores: dict[int, list[tuple[int, float]]] = {}
            for (group, run), place in zip(near, places, strict=True):
                runs = self._groups[group]
                frames = slice(int(frames_of(runs.first[run])) - 1, int(frames_of(runs.last[run])))
                scores.setdefault(group, []).append((run, -float(np.fmin.reduce(unlike[place][frames]))))
            for group, known in scores.items():
                which, numbers = zip(*known, strict=True)
                self._take(self._groups[group], np.array(which, np.int64), np.array(numbers))


def _least_distances(runs: Runs, asked: Asked) -> Floats:
    """Return the least possible distance of each run from the given pose or motion."""
    bodies = runs.columns.motions.bodies
    index = bodies.pose_index()
    documents = documents_of(runs.first)
    ends = [index.segments(documents, frames_of(frames) - 1) for frames in (runs.first, runs.last)]
    # The last segment is followed by one that is far from everything.
    least = np.append(asked.least(index, bodies.seconds, bodies.frames), np.float32(np.inf))
    inside: Ints = np.stack([ends[0], ends[1] + 1], axis=1).reshape(-1)
    return np.minimum.reduceat(least, inside)[::2].astype(np.float64)
