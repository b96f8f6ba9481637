"""Pairs (index of a context node, reached node): the results of a step for an array of context nodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from mcml_service.xpath.nodes.numbering import Bools, Ints

Pairs: TypeAlias = tuple[Ints, Ints]
NONE: Pairs = (np.empty(0, np.int64), np.empty(0, np.int64))
MAX_PAIRS = 1_000_000
"""Limit of pairs in one step; more pairs need fewer contexts at a time (TooWideError)."""


class TooWideError(Exception):
    """A step from these contexts reaches more nodes than are held at once."""


def expand(counts: Ints) -> tuple[Ints, Ints]:
    """For counts 2, 0, 3: (0 0 2 2 2, 0 1 0 1 2): which one, and the number within it."""
    counts = np.asarray(counts, np.int64)
    source = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(source)) - np.repeat(np.cumsum(counts) - counts, counts)
    return source, within


def rows_and_columns(flags: Bools) -> tuple[Ints, Ints]:
    """Where a matrix (m, n) is true, row by row: as `np.nonzero`, which takes 15 times as long for two dimensions."""
    rows, columns = np.divmod(np.flatnonzero(flags), flags.shape[1])
    return rows, columns


def bounded(counts: Ints) -> Pairs:
    total = int(counts.sum())
    if total > MAX_PAIRS:
        raise TooWideError(total)
    return expand(counts)


def merge(parts: Sequence[Pairs]) -> Pairs:
    """Pairs of several sources, by context and in document order."""
    parts = [part for part in parts if len(part[0])]
    if not parts:
        return NONE
    if len(parts) == 1:
        source, nodes = parts[0]
    else:
        source, nodes = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
    if len(source) > MAX_PAIRS:
        raise TooWideError(len(source))
    later = (source[1:] > source[:-1]) | ((source[1:] == source[:-1]) & (nodes[1:] > nodes[:-1]))
    if later.all():
        return source, nodes
    order = np.lexsort((nodes, source))
    return source[order], nodes[order]


def where(which: Bools, function: Callable[[Ints], Pairs], nodes: Ints) -> Pairs:
    """The pairs that a function makes of some contexts."""
    index = np.flatnonzero(which)
    if not len(index):
        return NONE
    source, reached = function(nodes[index])
    return index[source], reached
