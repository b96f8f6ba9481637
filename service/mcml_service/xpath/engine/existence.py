"""Existence of nodes before or after a node, without listing them for each node.

`frame[following-sibling::frame[motion_name='walk']]` compares n frames with about n²/2 others. But a frame has such a
sibling exactly if the last of them comes after it, so the last (or first) one under each parent, or in each document,
decides for all context nodes together.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcml_service.xpath.engine.axes import parents, step
from mcml_service.xpath.engine.node_tests import kinds_and_names
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import (
    BONE_WIDTH,
    BONES,
    DOCUMENT_SHIFT,
    IS_ATTRIBUTE,
    IS_NAMESPACE,
    NAME_WIDTH,
    NAMES_FROM,
    SLOT_MASK,
    Bools,
    Ints,
    documents_of,
    in_frames,
    slots_of,
)


class Beyond:
    """The answer for one step.

    kept: mask of the reachable nodes that match. For slices of context nodes, nodes under the same parents, or of the
    same documents, are read only once.
    """

    def __init__(self, forest: Forest, axis: str, test: str, kept: Callable[[Ints], Bools]) -> None:
        self._forest = forest
        self._axis = axis
        self._test = test
        self._kept = kept
        self._holders = np.empty(0, np.int64)
        self._extremes = np.empty(0, np.int64)

    def exists(self, nodes: Ints) -> Bools:
        """Tell for each context node whether a matching node is on the axis."""
        kinds, _ = kinds_and_names(self._forest, nodes)
        inner = (kinds == IS_ATTRIBUTE) | (kinds == IS_NAMESPACE)
        if self._axis.endswith("-sibling"):
            above = parents(self._forest, nodes)
            found = np.zeros(len(nodes), bool)
            index = np.flatnonzero(~inner & (above >= 0))
            found[index] = self._compare(nodes[index], above[index])
            return found
        if inner.any():
            nodes = np.where(inner, parents(self._forest, nodes), nodes)
        return self._compare(nodes, documents_of(nodes) << DOCUMENT_SHIFT)

    def _compare(self, nodes: Ints, holders: Ints) -> Bools:
        unique, index = np.unique(holders, return_inverse=True)
        if not np.array_equal(unique, self._holders):
            self._holders, self._extremes = unique, self._look(unique)
        extremes = self._extremes[index.reshape(-1)]
        if self._axis == "following-sibling":
            return np.asarray(extremes > nodes)
        if self._axis == "following":
            return np.asarray(extremes > ends(self._forest, nodes))
        return np.asarray((extremes >= 0) & (extremes < nodes))

    def _look(self, holders: Ints) -> Ints:
        """Under each holder the last node that counts; for preceding axes the first, or the end that comes first."""
        axis = "child" if self._axis.endswith("-sibling") else "descendant"
        source, reached = step(self._forest, holders, axis, self._test)
        keep = self._kept(reached)
        source, reached = source[keep], reached[keep]
        extremes = np.full(len(holders), -1, np.int64)
        if self._axis.startswith("following"):
            extremes[source] = reached
        elif self._axis == "preceding-sibling":
            extremes[source[::-1]] = reached[::-1]
        else:
            first = np.full(len(holders), np.iinfo(np.int64).max)
            np.minimum.at(first, source, ends(self._forest, reached))
            extremes = np.where(first < np.iinfo(np.int64).max, first, -1)
        return extremes


def ends(forest: Forest, nodes: Ints) -> Ints:
    """The greatest number that a node inside each node can have, or its own."""
    slots = slots_of(nodes)
    width = np.where(slots >= BONES, BONE_WIDTH, np.where(slots >= NAMES_FROM, NAME_WIDTH, SLOT_MASK + 1))
    inside = np.where(slots % width == 0, nodes + width - 1, nodes)
    framed = in_frames(nodes)
    if framed.all():
        return np.asarray(inside, np.int64)
    head = forest.head
    rows = head.rows(nodes[~framed])
    last = head.nodes(head.ends[rows])
    motion = head.motions[documents_of(nodes[~framed])]
    holds_frames = (rows <= motion) & (head.ends[rows] >= motion)
    inside[~framed] = np.where(holds_frames, ((documents_of(nodes[~framed]) + 1) << DOCUMENT_SHIFT) - 1, last)
    return np.asarray(inside, np.int64)
