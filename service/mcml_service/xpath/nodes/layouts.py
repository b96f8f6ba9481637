"""The frame_bones in the frames of documents and the place of their values: runs of frames with equal shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TypeVar

import numpy as np

from mcml.language.lexical import escape, unescape
from mcml.motion.clip import Shape
from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.nodes.numbering import (
    BONE_WIDTH,
    BONES,
    DOCUMENT_SHIFT,
    FIRST_ATTRIBUTE,
    FIRST_CHANNEL,
    FRAME_SHIFT,
    Bools,
    Ints,
    slots_of,
)
from mcml_service.xpath.nodes.pairs import expand
from mcml_service.xpath.nodes.stored import Stored

Same = TypeVar("Same", tuple[str, ...], Shape)


@dataclass(frozen=True, slots=True)
class Layout:
    """One document. names: of bones by their numbers, "" for those without one. numbers: the other way round.

    shapes: as the store has them. lengths: of each, how many frame_bones it has. bones, bits: of all shapes one after
    the other, number of the bone and its channels. runs: (n, 4) first position, first slot, frames, shape; ascending,
    each frame in one.
    """

    names: tuple[str, ...]
    numbers: dict[str, int]
    shapes: tuple[Shape, ...]
    lengths: Ints
    bones: Ints
    bits: Ints
    runs: Ints

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 256 * len(self.names) + self.lengths.nbytes + self.bones.nbytes + self.bits.nbytes + self.runs.nbytes


def read_layouts(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Layout]:
    """The layout of each document by its key."""
    keys = [listed.key for listed in documents]
    names: dict[int, dict[int, str]] = {key: {} for key in keys}
    for (key, bone), name in tx.columns.bone_names(keys).items():
        names[key][bone] = name
    shapes: dict[int, dict[int, Shape]] = {key: {} for key in keys}
    for (key, number), shape in sorted(tx.columns.shapes(keys).items()):
        shapes[key][number] = shape
    in_slots: dict[int, list[tuple[int, int, int]]] = {key: [] for key in keys}
    for key, slot, count, shape_number in tx.columns.shape_runs(keys):
        in_slots[key].append((slot, count, shape_number))
    pieces: dict[int, list[tuple[int, int, int]]] = {key: [] for key in keys}
    for key, first, slot, count in tx.columns.timelines(keys):
        pieces[key].append((first, slot, count))
    return {key: _layout(names[key], shapes[key], in_slots[key], pieces[key]) for key in keys}


def _layout(
    names: dict[int, str],
    shapes: dict[int, Shape],
    in_slots: Sequence[tuple[int, int, int]],
    pieces: Sequence[tuple[int, int, int]],
) -> Layout:
    place = {number: index for index, number in enumerate(shapes)}
    runs: list[tuple[int, int, int, int]] = []
    for first, slot, count in pieces:
        for start, length, number in in_slots:
            begin, end = max(start, slot), min(start + length, slot + count)
            if begin < end:
                runs.append((first + begin - slot, begin, end - begin, place[number]))
    runs.sort()
    entries = np.array([pair for shape in shapes.values() for pair in shape], np.int64).reshape(-1, 2)
    last = max([*names, *entries[:, 0].tolist()], default=-1)
    every = _same(tuple([names.get(number, "") for number in range(last + 1)]))
    return Layout(
        every,
        _numbers_of(every, tuple(names)),
        tuple(_same(shape) for shape in shapes.values()),
        np.array([len(shape) for shape in shapes.values()], np.int64),
        np.ascontiguousarray(entries[:, 0]),
        np.ascontiguousarray(entries[:, 1]),
        np.array(runs, np.int64).reshape(-1, 4),
    )


@lru_cache(maxsize=4096)
def _numbers_of(names: tuple[str, ...], numbers: tuple[int, ...]) -> dict[str, int]:
    """The numbers of named bones by name, one dictionary for all documents that have the same."""
    return {names[number]: number for number in numbers}


@lru_cache(maxsize=4096)
def _same(found: Same) -> Same:
    """Return the equal object of other documents: identical objects are compared fast."""
    return found


class ShapeRuns(Stored):
    """The layouts of a batch of documents as one table.

    bones, bits: of all shapes one after the other, those of shape s from offsets[s].
    """

    STORED = (
        "of_document", "offsets", "bones", "bits", "slots", "counts", "places", "keys", "shape", "namings", "naming_of",
    )  # fmt: skip

    of_document: Ints
    offsets: Ints
    bones: Ints
    bits: Ints
    slots: Ints
    counts: Ints
    places: Ints
    keys: Ints
    shape: Ints
    namings: list[tuple[list[str], list[int]]]
    """The different names and numbers of bones that documents have."""
    naming_of: Ints
    """Of each document, which of these."""

    def __init__(self, layouts: Sequence[Layout]) -> None:
        namings: dict[tuple[tuple[str, ...], tuple[int, ...]], int] = {}
        naming_of = [namings.setdefault((each.names, tuple(each.numbers.values())), len(namings)) for each in layouts]
        self.namings = [(list(names), list(numbers)) for names, numbers in namings]
        self.naming_of = np.array(naming_of, np.int64)
        # Shapes are numbered through, document by document.
        shapes = np.array([len(layout.lengths) for layout in layouts], np.int64)
        self.of_document = np.repeat(np.arange(len(layouts)), shapes)
        self.offsets = np.concatenate([[0], np.cumsum(_joined([layout.lengths for layout in layouts]))])
        self.bones = _joined([layout.bones for layout in layouts])
        self.bits = _joined([layout.bits for layout in layouts])
        runs = np.concatenate([np.empty((0, 4), np.int64), *(layout.runs for layout in layouts)])
        first, self.slots, self.counts, shape = runs.T
        self.places = np.repeat(np.arange(len(layouts)), [len(layout.runs) for layout in layouts])
        self.keys = (self.places << (DOCUMENT_SHIFT - FRAME_SHIFT)) | first
        self.shape = shape + (np.cumsum(shapes) - shapes)[self.places]
        self._begin()

    def _begin(self) -> None:
        self._by_bone: tuple[Ints, Ints] | None = None
        self._names: tuple[list[str], Ints] | None = None
        self._numbers: dict[str, Ints] = {}
        self._named: dict[str, tuple[Ints, Ints]] = {}

    @cached_property
    def numbered_shapes(self) -> list[Shape]:
        """All shapes; equal ones are one object."""
        pairs = list(zip(self.bones.tolist(), self.bits.tolist(), strict=True))
        return [_same(tuple(pairs[start:stop])) for start, stop in pairwise(self.offsets.tolist())]

    @cached_property
    def _names_by_number(self) -> list[tuple[str, ...]]:
        return [_same(tuple(names)) for names, _ in self.namings]

    @cached_property
    def _numbers_by_name(self) -> list[dict[str, int]]:
        return [_numbers_of(tuple(names), tuple(numbers)) for names, numbers in self.namings]

    def names_of(self, place: int) -> tuple[str, ...]:
        """Return the stored names of the bones of a document by their numbers."""
        return self._names_by_number[int(self.naming_of[place])]

    @property
    def texts(self) -> list[str]:
        """All names of bones, as XML has them."""
        return self._read_names()[0]

    @property
    def names(self) -> Ints:
        """For each of `bones` the place of its name in `texts`."""
        return self._read_names()[1]

    def _read_names(self) -> tuple[list[str], Ints]:
        if self._names is None:
            codes: dict[str, int] = {}
            by_bone = [codes.setdefault(name, len(codes)) for names, _ in self.namings for name in names]
            widths = np.array([len(names) for names, _ in self.namings], np.int64)
            namings = np.repeat(self.naming_of[self.of_document], np.diff(self.offsets))
            names = np.array(by_bone, np.int64)[(np.cumsum(widths) - widths)[namings] + self.bones]
            self._names = [escape(name) for name in codes], names
        return self._names

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes, including values computed on use."""
        arrays = (self.of_document, self.offsets, self.slots, self.counts, self.places, self.keys, self.shape)
        return 32 * len(self.bones) + sum(array.nbytes for array in arrays) + 100 * len(self.naming_of)

    def numbers_of(self, name: str) -> Ints:
        """Return the number of the bone with a stored name in each document, -1 if there is none."""
        if name not in self._numbers:
            by_naming = np.array([numbers.get(name, -1) for numbers in self._numbers_by_name], np.int64)
            self._numbers[name] = by_naming[self.naming_of]
        return self._numbers[name]

    def counted(self, text: str) -> int:
        """How many frame_bones of a name all frames have; of any name, where it is empty."""
        if not text:
            return int((self.counts * (self.offsets[self.shape + 1] - self.offsets[self.shape])).sum())
        shapes, _ = self._places(text)
        return int((self.counts * np.bincount(shapes, minlength=len(self.offsets) - 1)[self.shape]).sum())

    @cached_property
    def in_order(self) -> Bools:
        """Which shapes have their frame_bones in the order of their bones' numbers."""
        back = np.flatnonzero(np.diff(self.bones) <= 0) + 1
        broken = np.searchsorted(self.offsets, np.setdiff1d(back, self.offsets), side="right") - 1
        found = np.ones(len(self.offsets) - 1, bool)
        found[broken] = False
        return found

    def run_of(self, nodes: Ints) -> Ints:
        """Return the run of each node's frame."""
        return np.asarray(np.searchsorted(self.keys, nodes >> FRAME_SHIFT, side="right") - 1)

    def shape_of(self, nodes: Ints) -> Ints:
        return np.asarray(self.shape[self.run_of(nodes)], np.int64)

    def slot_of(self, nodes: Ints) -> Ints:
        """Return the slot of each node's frame in its document."""
        runs = self.run_of(nodes)
        return np.asarray(self.slots[runs] + (nodes >> FRAME_SHIFT) - self.keys[runs], np.int64)

    def sizes(self, frames: Ints) -> Ints:
        """How many frame_bones each frame has."""
        shapes = self.shape_of(frames)
        return np.asarray(self.offsets[shapes + 1] - self.offsets[shapes], np.int64)

    def entries(self, nodes: Ints) -> Ints:
        """The place in `bones`, `bits`, `names` of each frame_bone that nodes are or belong to."""
        return np.asarray(self.offsets[self.shape_of(nodes)] + ((slots_of(nodes) - BONES) // BONE_WIDTH), np.int64)

    def children(self, frames: Ints) -> tuple[Ints, Ints]:
        """(index into frames, frame_bone) of all frame_bones of each frame, in order."""
        source, number = expand(self.sizes(frames))
        return source, frames[source] + BONES + BONE_WIDTH * number

    def named(self, frames: Ints, text: str) -> tuple[Ints, Ints]:
        """(index into frames, frame_bone) of the frame_bones of a name."""
        shape, number = self._places(text)
        shapes = self.shape_of(frames)
        begin, end = np.searchsorted(shape, shapes, side="left"), np.searchsorted(shape, shapes, side="right")
        source, within = expand(end - begin)
        return source, frames[source] + BONES + BONE_WIDTH * number[begin[source] + within]

    def _places(self, text: str) -> tuple[Ints, Ints]:
        """(shape, number in it) of the bones of a name."""
        if text not in self._named:
            wanted = self.numbers_of(unescape(text))
            matching = np.flatnonzero(self.bones == np.repeat(wanted[self.of_document], np.diff(self.offsets)))
            shape = np.searchsorted(self.offsets, matching, side="right") - 1
            self._named[text] = shape, matching - self.offsets[shape]
        return self._named[text]

    def numbered(self, frames: Ints, bones: Ints) -> Ints:
        """The frame_bone of each frame that belongs to the bone of a number; every frame has it."""
        if self._by_bone is None:
            shape = np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))
            keys = (shape << 32) | self.bones
            order = np.argsort(keys)
            self._by_bone = keys[order], np.arange(len(keys))[order] - self.offsets[shape[order]]
        keys, numbers = self._by_bone
        found = numbers[np.searchsorted(keys, (self.shape_of(frames) << 32) | bones)]
        return np.asarray(frames + BONES + BONE_WIDTH * found, np.int64)

    def attributes(self, bones: Ints) -> tuple[Ints, Ints]:
        """(index into bones, attribute) of all attributes of each frame_bone, in order."""
        bits = self.bits[self.entries(bones)]
        present = np.concatenate(
            [np.ones((len(bones), 1), bool), (bits[:, None] >> np.arange(len(CHANNELS)) & 1).astype(bool)], axis=1
        )
        source, place = np.nonzero(present)
        return source, bones[source] + FIRST_ATTRIBUTE + place

    def channel(self, bones: Ints, channel: int) -> tuple[Ints, Ints]:
        """(index into bones, attribute) of one channel, where frame_bones have it."""
        source = np.flatnonzero(self.bits[self.entries(bones)] >> channel & 1)
        return source, bones[source] + FIRST_CHANNEL + channel


def _joined(parts: Sequence[Ints]) -> Ints:
    return np.concatenate([np.empty(0, np.int64), *parts])
