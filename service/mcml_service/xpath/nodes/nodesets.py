"""Node sets for many context nodes at once, and their aggregates: counts, truth, first nodes, extremes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.numerics.runs import find_equal, find_starts
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import MAX_PAIRS, TooWideError, expand


@dataclass(frozen=True, slots=True)
class NodeSets:
    """A set of nodes for each of `count` groups, and which group belongs to which context node.

    groups: the group of each node, ascending; nodes: ascending within a group, each once.
    index: for each context node its group; None where groups are context nodes. Context nodes that must have the same
    set, such as all of one document for `//frame`, share a group.
    """

    groups: Ints
    nodes: Ints
    count: int
    index: Ints | None = None

    @property
    def size(self) -> int:
        """The number of context nodes."""
        return self.count if self.index is None else len(self.index)

    def spread(self, of_groups: np.ndarray) -> np.ndarray:
        """A value of each group as one of each context node."""
        return of_groups if self.index is None else of_groups[self.index]

    def counts(self) -> Floats:
        return np.asarray(self.spread(np.bincount(self.groups, minlength=self.count).astype(np.float64)))

    def exist(self) -> Bools:
        found = np.zeros(self.count, bool)
        found[self.groups] = True
        return np.asarray(self.spread(found))

    def sums(self, numbers: Floats) -> Floats:
        """The sum of a number of each node."""
        return np.asarray(
            self.spread(np.bincount(self.groups, weights=numbers, minlength=self.count).astype(np.float64))
        )

    def any(self, which: Bools) -> Bools:
        """Whether one of the nodes is marked."""
        found = np.zeros(self.count, bool)
        found[self.groups[which]] = True
        return np.asarray(self.spread(found))

    def least(self, numbers: Floats) -> Floats:
        """The least number of each set, NaN aside; NaN for a set without any."""
        return self._reduced(np.fmin, numbers)

    def greatest(self, numbers: Floats) -> Floats:
        return self._reduced(np.fmax, numbers)

    def _reduced(self, function: np.ufunc, numbers: Floats) -> Floats:
        result = np.full(self.count, np.nan)
        if len(self.groups):
            starts = find_starts(self.groups)
            result[self.groups[starts]] = function.reduceat(numbers, starts)
        return np.asarray(self.spread(result))

    def first(self) -> Ints:
        """The first node of each set in document order, -1 for an empty one."""
        result = np.full(self.count, -1, np.int64)
        result[self.groups[::-1]] = self.nodes[::-1]
        return np.asarray(self.spread(result))

    def flat(self) -> tuple[NodeSets, Ints]:
        """The same with a group for each context node, and for each node its place in `self.nodes`."""
        if self.index is None:
            return self, np.arange(len(self.nodes))
        begin = np.searchsorted(self.groups, self.index, "left")
        counts = np.searchsorted(self.groups, self.index, "right") - begin
        if int(counts.sum()) > MAX_PAIRS:
            raise TooWideError
        source, within = expand(counts)
        place = begin[source] + within
        return NodeSets(source, self.nodes[place], len(self.index)), place


def one_set(nodes: Ints) -> NodeSets:
    """Nodes, ascending, as the set of one group."""
    return NodeSets(np.zeros(len(nodes), np.int64), nodes, 1)


def ordered(groups: Ints, nodes: Ints, count: int) -> NodeSets:
    """Pairs in any order, repeated or not, as node sets."""
    if len(nodes) > 1:
        step, same = np.diff(nodes), np.diff(groups)
        if not ((same > 0) | ((same == 0) & (step > 0))).all():
            order = np.lexsort((nodes, groups)) if same.any() else np.argsort(nodes, kind="stable")
            groups, nodes = groups[order], nodes[order]
            kept = np.concatenate([[True], (np.diff(nodes) != 0) | (np.diff(groups) != 0)])
            groups, nodes = groups[kept], nodes[kept]
    return NodeSets(groups, nodes, count)


def union(one: NodeSets, other: NodeSets) -> NodeSets:
    """The nodes of either set."""
    if one.index is not None or other.index is not None:
        one, other = one.flat()[0], other.flat()[0]
    return ordered(np.concatenate([one.groups, other.groups]), np.concatenate([one.nodes, other.nodes]), one.count)


def shared_nodes(one: NodeSets, other: NodeSets, *, wanted: bool) -> NodeSets:
    """Nodes of one set that are in the other, or that are not."""
    one, other = (ordered(sets.groups, sets.nodes, sets.count) for sets in (one.flat()[0], other.flat()[0]))
    codes = np.unique(np.concatenate([one.nodes, other.nodes]), return_inverse=True)[1].reshape(-1)
    width = int(codes.max(initial=0)) + 1
    first = one.groups * width + codes[: len(one.nodes)]
    kept = np.isin(first, other.groups * width + codes[len(one.nodes) :]) == wanted
    return NodeSets(one.groups[kept], one.nodes[kept], one.count)


def positions_of(groups: Ints, *, reverse: bool) -> tuple[Floats, Floats]:
    """Position and size of the list for each candidate; lists are neighbours, in document order."""
    sizes = np.diff(find_equal(groups)).reshape(-1)
    _, within = expand(sizes)
    size = np.repeat(sizes, sizes).astype(np.float64)
    return np.asarray(size - within if reverse else within + 1.0, np.float64), size
