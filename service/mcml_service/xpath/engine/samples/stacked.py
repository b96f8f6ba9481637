"""Conditions on frame_bones, answered for all bones of many frames at once.

A comparison with a constant is decided by 16 bits a sample: where a track holds samples on both sides, those of the
same code as the constant are looked up, and no others. A quarter of the memory of the samples, and exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.numerics.runs import find_equal
from mcml_service.storage.documents.encoding import channels_of
from mcml_service.xpath.engine.comparisons import compare_numbers
from mcml_service.xpath.engine.samples.condition import Condition
from mcml_service.xpath.engine.samples.kernel import Columns, fulfilled
from mcml_service.xpath.language.conditions import Sample, sample
from mcml_service.xpath.language.tree import Expression, Variable
from mcml_service.xpath.library.intervals import Verdict
from mcml_service.xpath.library.stacks import ABSENT, BEYOND, Coding, Stack, StackedSamples
from mcml_service.xpath.library.zones import BITS, FRAMES, GAPS, rows_of
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import rows_and_columns

TOGETHER = 2048
"""Tracks that are decoded before anything else may happen."""


@dataclass(frozen=True)
class Some:
    """Some frames of a stack. columns: where they are; None for all, in order."""

    stack: Stack
    columns: Ints | None = None

    def __len__(self) -> int:
        return self.stack.columns if self.columns is None else len(self.columns)

    @cached_property
    def _span(self) -> slice | None:
        """The columns, if they follow one another."""
        if self.columns is None:
            return slice(0, self.stack.columns)
        first, last = int(self.columns[0]), int(self.columns[-1])
        follow = last - first == len(self.columns) - 1 and bool((np.diff(self.columns) == 1).all())
        return slice(first, last + 1) if follow else None

    @cached_property
    def _unit_of(self) -> tuple[Ints, Ints]:
        """The units of columns that do not follow one another, ascending, and of each column its unit among them."""
        columns = np.arange(len(self)) if self.columns is None else self.columns
        place = np.searchsorted(self.stack.offsets, columns, side="right") - 1
        units, index = np.unique(place, return_inverse=True)
        return units, index.reshape(-1)

    @cached_property
    def units(self) -> Ints:
        """The units of the columns, ascending."""
        offsets, span = self.stack.offsets, self._span
        if span is None:
            return self._unit_of[0]
        first = int(np.searchsorted(offsets, span.start, side="right")) - 1
        return np.arange(first, int(np.searchsorted(offsets, span.stop, side="left")))

    @cached_property
    def tracks(self) -> Ints:
        """(bones, units)."""
        return self.stack.tracks[:, self.units]

    def of(self, values: NDArray[Any]) -> NDArray[Any]:
        """(bones, frames): a channel of the group in these frames."""
        view = self.stack.view(values)
        return view[:, self.columns if self._span is None else self._span]

    def spread(self, of_tracks: NDArray[Any]) -> NDArray[Any]:
        """Expand values of tracks, (bones, units), to values of their frames."""
        if self._span is None:
            return of_tracks[:, self._unit_of[1]]
        edges = np.clip(self.stack.offsets, self._span.start, self._span.stop)
        return np.repeat(of_tracks, np.diff(edges)[self.units], axis=1)

    def slots(self, places: Ints) -> tuple[Ints, Ints]:
        """(unit, offset in its tracks) of frames by their places among these; the unit by its place in `units`."""
        columns = places if self.columns is None else self.columns[places]
        unit = np.searchsorted(self.stack.offsets, columns, side="right") - 1
        return np.searchsorted(self.units, unit), columns - self.stack.offsets[unit]


class StackedBones:
    """All bones of the group of some columns."""

    def __init__(self, columns: Columns) -> None:
        self.forest = columns.forest
        self.stacks = self.forest.stacks
        self._columns = columns
        self._table = self.forest.tracks
        self.tracks_read = 0
        self._verdicts: dict[Expression, Verdict] = {}

    def fits(self, *, coded: bool) -> bool:
        """Tell whether samples of the group fit in the cache, as codes or exactly."""
        return not self.stacks.is_padded and self.forest.caches.samples.takes(self.stacks.size * (2 if coded else 8))

    def takes(self, condition: Condition) -> bool:
        """Tell whether a condition depends only on the samples of a frame_bone, and can be evaluated here."""
        if any(sample.bone is not None for sample in condition.samples):
            return False
        return self.fits(coded=all(leaf.bound is not None for leaf in condition.leaves.values()))

    def may(self, condition: Condition) -> bool:
        """Whether any frame_bone may fulfil a condition, as zone maps tell."""
        return bool(self._judge(condition).may.any())

    def truth(self, condition: Condition, some: Some) -> Bools:
        """Return (bones, frames): the frame_bones that fulfil a condition; values for missing ones are undefined if
        it requires no sample.
        """
        known: dict[Variable, Bools] = {}

        def decided(leaf: Expression) -> Expression:
            variable = Variable(str(len(known)), "boolean")
            known[variable] = self._leaf(condition.leaves[leaf], some)
            return variable

        return fulfilled(self._columns, condition.combining(decided), known)

    def _leaf(self, condition: Condition, some: Some) -> Bools:
        """The same of one comparison."""
        verdict = self._judge(condition)
        may, must = verdict.may[some.tracks], verdict.must[some.tracks]
        unsure = may & ~must
        if condition.bound is not None:
            return self._bound(condition.bound, some, unsure, must)
        if not unsure.any():
            return np.asarray(some.spread(must))
        channels = sorted(sample.channel for sample in condition.samples)
        read = zip(channels, self.filled(channels, some.tracks[unsure]), strict=True)
        block: dict[Variable, Floats] = {sample(None, channel): some.of(found.values) for channel, found in read}
        return np.asarray(fulfilled(self._columns, condition.tree, block) & some.spread(unsure) | some.spread(must))

    def samples(self, channel: int, some: Some) -> Floats:
        """(bones, frames), NaN where a frame has none."""
        (held,) = self.filled([channel], some.tracks.ravel())
        return np.asarray(some.of(held.values), np.float64)

    def filled(self, channels: list[int], tracks: Ints) -> list[StackedSamples]:
        """Channels, exactly, in which these tracks at least are filled."""
        found = [self.forest.stacked(channel, coded=False) for channel in channels]
        missing = np.zeros(len(self._table), bool)
        for samples in found:
            missing[tracks[~samples.filled[tracks]]] = True
        for channel, some in self._read(channels, np.flatnonzero(missing)):
            samples = found[channels.index(channel)]
            starts = self.stacks.starts[[track for track, _ in some]].tolist()
            for start, (_, values) in zip(starts, some, strict=True):
                samples.values[start : start + len(values)] = values
        for samples in found:
            samples.filled[missing] = True
        return found

    def _judge(self, condition: Condition) -> Verdict:
        """Return the verdict of zone maps for each track of the group."""
        found = self._verdicts.get(condition.tree)
        if found is None:
            frames = self._table.about[FRAMES]
            ends = {sample: self._table.ends(sample.channel, frames) for sample in condition.samples}
            found = self._verdicts[condition.tree] = condition.judge(ends)
        return found

    def _bound(self, bound: tuple[Sample, str, float], some: Some, unsure: Bools, must: Bools) -> Bools:
        (channel, operator, number), tracks = (bound[0].channel, *bound[1:]), some.tracks
        coding = Coding(self._table.least[channel], self._table.greatest[channel])
        codes = self._coded(channel, coding, tracks[unsure])
        own = np.full(tracks.shape, BEYOND, np.uint16)
        own[unsure] = coding.codes(np.full(int(unsure.sum()), number), tracks[unsure])
        view = some.of(codes.values)
        if operator in (">", ">="):
            limit = np.where(must, np.uint16(ABSENT), own)
            found = view > (limit if limit.size == 1 else some.spread(limit))
        elif operator in ("<", "<="):
            limit = np.where(unsure, own, np.where(must, np.uint16(BEYOND), np.uint16(ABSENT)))
            found = view < some.spread(limit)
            if self._has_gaps(channel):
                found &= view != ABSENT
        else:
            found = np.zeros(view.shape, bool)
        if unsure.any():
            self._look_up(view == some.spread(own), bound, some, found)
        return found

    def _look_up(self, close: Bools, bound: tuple[Sample, str, float], some: Some, found: Bools) -> None:
        """Compare the exact samples where codes do not decide."""
        bones, frames = rows_and_columns(close)
        if not len(bones):
            return
        sample, operator, number = bound
        unit, offset = some.slots(frames)
        tracks = some.tracks[bones, unit]
        order = np.argsort(tracks, kind="stable")
        numbers = np.empty(len(order))
        runs = find_equal(tracks[order])
        wanted = tracks[order[runs[:, 0]]]
        place = dict(zip(wanted.tolist(), runs.tolist(), strict=True))
        for _, tracks_read in self._read([sample.channel], wanted):
            for track, values in tracks_read:
                start, stop = place[track]
                numbers[order[start:stop]] = values[offset[order[start:stop]]]
        found[bones, frames] = compare_numbers(operator, numbers, number)

    def _has_gaps(self, channel: int) -> bool:
        """Whether a frame_bone lacks the channel."""
        about = self._table.about
        bits = about[BITS] & ~about[GAPS]
        return not bool((bits >> channel & 1).all())

    def _coded(self, channel: int, coding: Coding, tracks: Ints) -> StackedSamples:
        """The codes of a channel, in which these tracks at least are filled."""
        codes = self.forest.stacked(channel, coded=True)
        missing = np.unique(tracks[~codes.filled[tracks]])
        for _, some in self._read([channel], missing):
            numbers = np.array([track for track, _ in some])
            lengths = np.array([len(values) for _, values in some])
            found = coding.codes(np.concatenate([values for _, values in some]), np.repeat(numbers, lengths))
            ends = np.cumsum(lengths).tolist()
            for start, end, length in zip(self.stacks.starts[numbers].tolist(), ends, lengths.tolist(), strict=True):
                codes.values[start : start + length] = found[end - length : end]
            codes.filled[numbers] = True
        return codes

    def _read(self, channels: list[int], tracks: Ints) -> Iterator[tuple[int, list[tuple[int, Floats]]]]:
        """Yield channels of tracks in batches: (channel, (track, samples)) of those that have it."""
        for at in range(0, len(tracks), TOGETHER):
            self._columns.check()
            some = tracks[at : at + TOGETHER]
            self.tracks_read += len(some)
            rows = rows_of(self._table.about[:, some])
            data = self.forest.caches.tracks.read(self.forest.tx, rows)
            held = [channels_of(row[4]) for row in rows]
            for channel in channels:
                has = [channel in each for each in held]
                found = [
                    (track, values[each.index(channel)])
                    for track, values, each, there in zip(some.tolist(), data, held, has, strict=True)
                    if there
                ]
                if found:
                    yield channel, found
