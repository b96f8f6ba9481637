"""The tracks of all bones of a group of documents as matrices: a row for each bone, a column for each frame.

Tracks keep their lengths, one after the other, so that a query about all bones is a few operations on whole arrays.
Units (the tracks of a document over one chunk) of as many bones make one matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml_service.storage.core.schema import CHUNK
from mcml_service.xpath.library.zones import BONE, CHUNK_NUMBER, FRAMES, GAPS, Table
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.timeline import Timeline

Codes: TypeAlias = NDArray[np.uint16]

ABSENT, LOWEST, HIGHEST, BEYOND = 0, 1, 65_534, 65_535
"""Codes of a missing sample, of the least and the greatest sample of a track; a code that no sample has."""


@dataclass(frozen=True)
class Stack:
    """One matrix. begin: where it begins among the samples of the group. units: which of the group's units, ascending.
    offsets: the column at which each of them begins, and the end. tracks: (bones, units)."""

    begin: int
    units: Ints
    offsets: Ints
    tracks: Ints

    @property
    def width(self) -> int:
        """How many bones each frame has."""
        return len(self.tracks)

    @property
    def columns(self) -> int:
        return int(self.offsets[-1])

    def view(self, values: NDArray[Any]) -> NDArray[Any]:
        """(bones, columns): the matrix among the samples of the group."""
        return values[self.begin : self.begin + self.width * self.columns].reshape(self.width, self.columns)


class Stacks:
    """The layout of the samples of a table of tracks.

    size: number of samples in a channel. starts: of each track. units: key (place << 32 | chunk) of each unit,
    ascending. even: mask of units whose tracks have one length and all samples in each frame.
    """

    def __init__(self, table: Table) -> None:
        about = table.about
        keys = (table.places << 32) | about[CHUNK_NUMBER]
        order = np.lexsort((about[BONE], keys))
        self.units, first, widths = np.unique(keys[order], return_index=True, return_counts=True)
        self._lengths = np.zeros(0, np.int64)
        self.even = np.zeros(0, bool)
        if len(order):
            frames = about[FRAMES][order]
            self._lengths = np.maximum.reduceat(frames, first)
            same = np.minimum.reduceat(frames, first) == self._lengths
            self.even = same & (np.bitwise_or.reduceat(about[GAPS][order], first) == 0)
            self.is_padded = not bool(same.all())
        else:
            self.is_padded = False
        self.stacks: list[Stack] = []
        self.starts = np.zeros(len(table), np.int64)
        self._stack_of = np.zeros(len(self.units), np.int64)
        self._column_of = np.zeros(len(self.units), np.int64)
        begin = 0
        for number, width in enumerate(np.unique(widths).tolist()):
            own = np.flatnonzero(widths == width)
            offsets = np.concatenate([[0], np.cumsum(self._lengths[own])])
            tracks = order[first[own] + np.arange(width)[:, None]]
            stack = Stack(begin, own, offsets, tracks)
            self.stacks.append(stack)
            self.starts[tracks] = begin + np.arange(width)[:, None] * stack.columns + offsets[:-1]
            self._stack_of[own], self._column_of[own] = number, offsets[:-1]
            begin += width * stack.columns
        self.size = begin

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes, including values computed on use."""
        return 24 * len(self.starts) + 48 * len(self.units) + sum(stack.columns for stack in self.stacks)

    def found(self, places: Ints, slots: Ints) -> tuple[Ints, Ints, Ints]:
        """Return for each slot the stack, the column and the unit; -1 for the stack if no track covers it."""
        if not len(self.units):
            return np.full(len(slots), -1), np.zeros(len(slots), np.int64), np.zeros(len(slots), np.int64)
        keys = (places << 32) | (slots // CHUNK)
        unit = np.minimum(np.searchsorted(self.units, keys), len(self.units) - 1)
        within = slots % CHUNK
        there = (self.units[unit] == keys) & (within < self._lengths[unit])
        return np.where(there, self._stack_of[unit], -1), self._column_of[unit] + within, unit

    def slots(self, units: Ints, offsets: Ints) -> tuple[Ints, Ints]:
        """Return (place, slot) of frames by their units and their indices in these."""
        keys = self.units[units]
        return keys >> 32, (keys & 0xFFFFFFFF) * CHUNK + offsets

    def here(self, timeline: Timeline) -> list[Bools | None]:
        """Of each stack, over which columns the documents have a frame; None for all."""
        if self._here is None:
            self._here = [self._alive(stack, timeline) for stack in self.stacks]
        return self._here

    _here: list[Bools | None] | None = None

    def _alive(self, stack: Stack, timeline: Timeline) -> Bools | None:
        lengths = np.diff(stack.offsets)
        within = np.arange(stack.columns) - np.repeat(stack.offsets[:-1], lengths)
        found = timeline.positions(*self.slots(np.repeat(stack.units, lengths), within)) > 0
        return None if found.all() else found


class StackedSamples:
    """A channel of the tracks of a group, read as far as queries needed it: exactly, or by codes of 16 bits.

    values: of all tracks; those that are not filled are NaN, or of code LOWEST. Tracks are filled by several threads,
    always with the same.
    """

    def __init__(self, size: int, tracks: int, *, coded: bool) -> None:
        self.values: NDArray[Any] = np.full(size, LOWEST, np.uint16) if coded else np.full(size, np.nan)
        self.filled: Bools = np.zeros(tracks, bool)

    @property
    def nbytes(self) -> int:
        return self.values.nbytes + self.filled.nbytes


@dataclass(frozen=True)
class Coding:
    """Codes of the samples of tracks: of two samples of a track the greater one never has the smaller code, for
    subtraction and product never make it so. least, greatest: of each track."""

    least: Floats
    greatest: Floats

    @cached_property
    def scale(self) -> Floats:
        with np.errstate(all="ignore"):
            width = self.greatest - self.least
            scale = (HIGHEST - LOWEST) / width
        return np.where(np.isfinite(scale) & np.isfinite(width), scale, 0.0)

    def codes(self, numbers: Floats, tracks: Ints) -> Codes:
        """The code of each number in a track."""
        with np.errstate(all="ignore"):
            steps = (numbers - self.least[tracks]) * self.scale[tracks]
        steps = np.fmin(np.fmax(steps, 0.0), HIGHEST - LOWEST)
        return np.where(np.isnan(numbers), ABSENT, steps + LOWEST).astype(np.uint16)
