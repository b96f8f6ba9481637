"""Node tests: kind and name of nodes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import (
    IS_ATTRIBUTE,
    IS_ELEMENT,
    IS_NAMESPACE,
    IS_TEXT,
    Bools,
    Ints,
    frame_kinds,
    in_frames,
    name_codes,
    slots_of,
)


def kinds_and_names(forest: Forest, nodes: Ints) -> tuple[NDArray[Any], NDArray[Any]]:
    """Kind and name code of each node."""
    framed = in_frames(nodes)
    if framed.all():
        return frame_kinds(slots_of(nodes))
    if not framed.any():
        rows = forest.head.rows(nodes)
        return forest.head.kinds[rows], forest.head.names[rows]
    kinds, names = np.empty(len(nodes), np.int8), np.empty(len(nodes), np.int16)
    kinds[framed], names[framed] = frame_kinds(slots_of(nodes[framed]))
    rows = forest.head.rows(nodes[~framed])
    kinds[~framed], names[~framed] = forest.head.kinds[rows], forest.head.names[rows]
    return kinds, names


def passes(forest: Forest, nodes: Ints, axis: str, test: str) -> Bools:
    """Which nodes pass a node test on an axis."""
    if test == "node()":
        return np.ones(len(nodes), bool)
    if test.endswith(")") and test != "text()":
        return np.zeros(len(nodes), bool)
    kinds, names = kinds_and_names(forest, nodes)
    if test == "text()":
        return np.asarray(kinds == IS_TEXT)
    wanted = {"attribute": IS_ATTRIBUTE, "namespace": IS_NAMESPACE}.get(axis, IS_ELEMENT)
    if test == "*":
        return np.asarray(kinds == wanted)
    return np.asarray((kinds == wanted) & (names == name_codes().get(test, -1)))
