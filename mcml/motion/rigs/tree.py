"""A rig's joints as a tree with positions, to compare their order and distances."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcml.motion.skeleton import Array


@dataclass(frozen=True)
class Tree:
    """names: of joints. parents: index of each one's parent, which comes before it, -1 at a root.

    places: (J, 3) of the rest pose, in any unit. tips: (joint, place) of the ends of chains.
    """

    names: Sequence[str]
    parents: Sequence[int]
    places: Array
    tips: Sequence[tuple[int, Array]] = ()

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def has_lengths(self) -> bool:
        """Whether the rest pose has any extent."""
        return (
            bool(len(self.places)) and bool(np.isfinite(self.places).all()) and bool(np.ptp(self.places, axis=0).any())
        )

    @cached_property
    def children(self) -> list[list[int]]:
        found: list[list[int]] = [[] for _ in self.parents]
        for index, parent in enumerate(self.parents):
            if parent >= 0:
                found[parent].append(index)
        return found

    @cached_property
    def depth(self) -> list[int]:
        found: list[int] = []
        for parent in self.parents:
            found.append(found[parent] + 1 if parent >= 0 else 0)
        return found

    @cached_property
    def _spans(self) -> list[tuple[int, int]]:
        """Of each joint the first and last number of its subtree, counted parents first."""
        size = [1] * len(self)
        for index in range(len(self) - 1, -1, -1):
            if self.parents[index] >= 0:
                size[self.parents[index]] += size[index]
        spans: list[tuple[int, int]] = []
        after: dict[int, int] = {}
        for index, parent in enumerate(self.parents):
            start = after.get(parent, 0 if parent < 0 else spans[parent][0] + 1)
            spans.append((start, start + size[index] - 1))
            after[parent] = start + size[index]
        return spans

    @cached_property
    def is_flat(self) -> bool:
        """Whether it is no tree: joints hang from one root, or from none."""
        return len(self) > 4 and max(self.depth, default=0) <= 1

    def is_above(self, upper: int, lower: int) -> bool:
        """Tell whether a joint is another one or above it."""
        first, last = self._spans[upper]
        return first <= self._spans[lower][0] <= last

    def way_up(self, index: int) -> list[int]:
        """The joint and all above it, the nearest first."""
        way = []
        while index >= 0:
            way.append(index)
            index = self.parents[index]
        return way

    def between(self, upper: int, lower: int) -> list[int]:
        """Joints below one and above another that hangs from it, from the top; nothing where it does not."""
        if not self.is_above(upper, lower) or upper == lower:
            return []
        way = self.way_up(lower)
        return way[1 : way.index(upper)][::-1]

    def common(self, joints: Iterable[int]) -> int:
        """The lowest joint that is above all of some, or one of them; -1 for none."""
        some = list(joints)
        if not some:
            return -1
        for above in self.way_up(some[0]):
            if all(self.is_above(above, each) for each in some):
                return above
        return -1

    def distance(self, first: int, second: int) -> float:
        """Between two joints of the rest pose."""
        return float(np.linalg.norm(self.places[first] - self.places[second]))

    def tips_of(self, index: int) -> list[Array]:
        """Places of the ends of chains at a joint."""
        return self._tips.get(index, [])

    @cached_property
    def _tips(self) -> dict[int, list[Array]]:
        found: dict[int, list[Array]] = {}
        for joint, place in self.tips:
            found.setdefault(joint, []).append(place)
        return found
