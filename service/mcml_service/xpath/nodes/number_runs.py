"""Frames whose numbers fulfil a condition. Numbers are ids or positions, which follow one another in long runs, so that
a condition is looked up once for each number, not for each frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import expand

MOST_NUMBERS = 1 << 20
"""Different numbers that a condition is looked up for; beyond them, frames are looked at one by one."""
EXACT = 2**53
"""From here on several integers are one and the same double."""
_TOGETHER = 1 << 12
"""Numbers that are looked up together at least: the next documents have others of them."""


@dataclass(frozen=True)
class NumberRuns:
    """Runs of frames. keys: of the first frame of each, a node without its slot, ascending. first: its number. step:
    from a frame to the next. count: of frames."""

    keys: Ints
    first: Ints
    step: Ints
    count: Ints

    @cached_property
    def ends(self) -> tuple[int, int] | None:
        """The least and the greatest number, None without frames."""
        some = self.count > 0
        if not some.any():
            return None
        first = self.first[some]
        last = first + self.step[some] * (self.count[some] - 1)
        return int(min(first.min(), last.min())), int(max(first.max(), last.max()))

    def count_of(self, hits: Ints) -> int:
        """How many frames have one of these numbers, which are ascending."""
        return int(sum((stop - start).sum() for _, start, stop in self._of_steps(hits))) + len(self._of_others(hits))

    def frames_of(self, hits: Ints) -> Ints:
        """The frame elements that have one of these numbers, ascending."""
        found = [self._of_others(hits)]
        for runs, start, stop in self._of_steps(hits):
            source, within = expand(stop - start)
            found.append((self.keys[runs] - self.first[runs])[source] + hits[start[source] + within])
        keys = np.concatenate(found)
        return (np.sort(keys) if len(found[0]) else keys) << FRAME_SHIFT

    def _of_steps(self, hits: Ints) -> list[tuple[Ints, Ints, Ints]]:
        """Runs in which numbers rise by one, and which of the hits are in each: (runs, first, one after the last)."""
        runs = np.flatnonzero(self.step == 1)
        first = self.first[runs]
        return [(runs, np.searchsorted(hits, first), np.searchsorted(hits, first + self.count[runs]))]

    def _of_others(self, hits: Ints) -> Ints:
        """The keys of frames of other runs."""
        runs = np.flatnonzero(self.step != 1)
        source, within = expand(self.count[runs])
        numbers = self.first[runs][source] + self.step[runs][source] * within
        return (self.keys[runs][source] + within)[np.isin(numbers, hits)]


def runs_of_positions(frames: Ints) -> NumberRuns:
    """The positions of the frames of documents, from 1. frames: how many each has."""
    ones = np.ones(len(frames), np.int64)
    keys = (np.arange(len(frames)) << (DOCUMENT_SHIFT - FRAME_SHIFT)) + 1
    return NumberRuns(keys, ones, ones, frames)


class NumberTable:
    """Which numbers fulfil a condition."""

    def __init__(self) -> None:
        self._low = self._end = 0
        self._hits = np.empty(0, np.int64)

    def hits(self, runs: NumberRuns, holds: Callable[[Floats], Bools]) -> Ints | None:
        """The numbers that do, ascending, among all that the runs have; None where these are too many, or too large.

        holds: tells it for some numbers.
        """
        if runs.ends is None:
            return np.empty(0, np.int64)
        low, high = runs.ends
        if high - low >= MOST_NUMBERS or max(-low, high) >= EXACT:
            return None
        if not self._low <= low <= high < self._end:
            self._low = low - low % _TOGETHER
            self._end = high + _TOGETHER - high % _TOGETHER
            self._hits = self._low + np.flatnonzero(holds(np.arange(self._low, self._end, dtype=np.float64)))
        return self._hits
