"""The documents of a batch as columns: heads as arrays of nodes, frames as runs of equal structure."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from service.errors import StoreError
from service.mcml.lexical import escape, unescape
from service.motion.clip import Shape
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.heads import Head
from service.xpath.numbering import (
    BONE_WIDTH,
    BONES,
    DOCUMENT_SHIFT,
    FIRST_ATTRIBUTE,
    FIRST_CHANNEL,
    FRAME_SHIFT,
    IS_ELEMENT,
    MAX_DOCUMENTS,
    MAX_FRAMES,
    MOTION,
    NAME_WIDTH,
    NAMES_FROM,
    Bools,
    Ints,
    documents_of,
    frames_of,
    slots_of,
)
from service.xpath.shared import Shared
from service.xpath.texts import to_number


class Forest:
    """Documents side by side. Nodes are numbers (`numbering`); a document's place here is the number's first part.

    documents: in order of the answer. whole_heads: whether headers and skeletons can be asked for. All columns are read
    when they are first needed.
    """

    def __init__(self, tx: Transaction, documents: Sequence[Listed], shared: Shared, *, whole_heads: bool) -> None:
        if len(documents) > MAX_DOCUMENTS or any(stored.frames > MAX_FRAMES for stored in documents):
            raise StoreError("More documents or frames than nodes can be numbered for.")
        self.tx = tx
        self.documents = documents
        self.keys = [stored.key for stored in documents]
        self.frames: Ints = np.array([stored.frames for stored in documents], np.int64)
        self.shared = shared
        self._whole_heads = whole_heads
        self._head: HeadRows | None = None
        self._shapes: ShapeRuns | None = None
        self._labels: LabelRuns | None = None
        self._ids: IdRuns | None = None
        self._only: tuple[int, int] | None = None

    def __len__(self) -> int:
        return len(self.documents)

    @property
    def head(self) -> HeadRows:
        if self._head is None:
            self._head = HeadRows(self.shared.heads.read(self.tx, self.documents, whole=self._whole_heads))
        return self._head

    @property
    def shapes(self) -> ShapeRuns:
        if self._shapes is None:
            self._shapes = ShapeRuns(self.tx, self.keys)
        return self._shapes

    @property
    def labels(self) -> LabelRuns:
        if self._labels is None:
            self._labels = LabelRuns(self.tx, self.keys, self.frames, self._only)
        return self._labels

    def look_only_at(self, frames: Ints) -> None:
        """Say that of all frames only these are asked for anything, which spares reading the names of others."""
        positions = frames_of(frames)
        self._only = (int(positions.min()), int(positions.max())) if len(positions) else (1, 0)

    def shape(self, number: int) -> Shape:
        """One of the shapes, as the store has it."""
        start, stop = self.shapes.offsets[number], self.shapes.offsets[number + 1]
        return tuple(zip(self.shapes.bones[start:stop].tolist(), self.shapes.bits[start:stop].tolist(), strict=True))

    @property
    def ids(self) -> IdRuns:
        if self._ids is None:
            self._ids = IdRuns(self.tx, self.keys)
        return self._ids

    def all_frames(self, documents: Ints) -> tuple[Ints, Ints]:
        """(index into documents, frame element) of every frame of each document, in order."""
        source, position = expand(self.frames[documents])
        return source, (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)


class HeadRows:
    """The heads of a batch as one table: kinds, names, parents and ends by row; `nodes` are ascending."""

    def __init__(self, heads: Sequence[Head]) -> None:
        sizes = [len(head.part) for head in heads]
        self.starts: Ints = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        self.motions: Ints = self.starts[:-1] + np.array([head.motion for head in heads], np.int64)
        document = np.repeat(np.arange(len(heads)), sizes)
        within = np.arange(self.starts[-1]) - self.starts[document]
        motion = self.motions[document] - self.starts[document] if heads else within
        slot = np.where(within < motion, within, within - motion + MOTION)
        self.nodes: Ints = (document << DOCUMENT_SHIFT) | slot
        offset = self.starts[:-1].tolist()
        parts = [head.part for head in heads]
        self.kinds = _joined([part.kinds for part in parts], np.int8)
        self.names = _joined([part.names for part in parts], np.int16)
        # The document node is its own parent here; the parent axis leaves it out.
        self.parents = _joined([np.maximum(p.parents, 0) + o for p, o in zip(parts, offset, strict=True)], np.int64)
        self.ends = _joined([part.ends + start for part, start in zip(parts, offset, strict=True)], np.int64)
        self._parts = parts
        self._heads = heads
        self._named: dict[int, Ints] = {}
        self._by_parent: dict[int, tuple[Ints, Ints]] = {}

    def rows(self, nodes: Ints) -> Ints:
        documents, slots = documents_of(nodes), slots_of(nodes)
        base = np.where(slots < MOTION, self.starts[documents], self.motions[documents] - MOTION)
        return np.asarray(base + slots, np.int64)

    def texts(self, rows: Ints) -> list[str]:
        """The strings of attributes, texts and namespace nodes."""
        documents = np.searchsorted(self.starts, rows, side="right") - 1
        within = rows - self.starts[documents]
        parts = self._parts
        return [parts[d].texts[row] for d, row in zip(documents.tolist(), within.tolist(), strict=True)]

    def children_named(self, code: int, rows: Ints) -> tuple[Ints, Ints]:
        """(index into rows, row) of the children of a name, in order."""
        if code not in self._by_parent:
            named = self.named(code)
            order = np.argsort(self.parents[named], kind="stable")
            self._by_parent[code] = self.parents[named][order], named[order]
        parents, children = self._by_parent[code]
        begin = np.searchsorted(parents, rows, side="left")
        source, within = expand(np.searchsorted(parents, rows, side="right") - begin)
        return source, children[begin[source] + within]

    def address(self, row: int) -> str:
        """The canonical address of an element, attribute or text."""
        document = int(np.searchsorted(self.starts, row, side="right")) - 1
        return self._heads[document].address(row - int(self.starts[document]))

    def named(self, code: int) -> Ints:
        """The rows of all elements of a name, ascending."""
        if code not in self._named:
            self._named[code] = np.flatnonzero((self.names == code) & (self.kinds == IS_ELEMENT))
        return self._named[code]


class ShapeRuns:
    """Runs of frames of equal shape that lie in neighbouring slots, and the frame_bones of each shape.

    bones, bits, names: of all shapes one after the other, those of shape s from offsets[s]: number of the bone, its
    channels, and the number of its name in `texts`. Names are read when they are first asked for.
    """

    def __init__(self, tx: Transaction, keys: Sequence[int]) -> None:
        place = {key: number for number, key in enumerate(keys)}
        found = tx.columns.shapes(keys)
        number_of = {shape: number for number, shape in enumerate(found)}
        self._tx, self._keys_of = tx, list(keys)
        self._of_document: Ints = np.array([place[document] for document, _ in found], np.int64)
        self._names: tuple[list[str], Ints] | None = None
        lengths = [len(shape) for shape in found.values()]
        self.offsets: Ints = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        self.bones: Ints = np.array([bone for shape in found.values() for bone, _ in shape], np.int64)
        self.bits: Ints = np.array([bits for shape in found.values() for _, bits in shape], np.int64)
        self._by_bone: tuple[Ints, Ints] | None = None
        runs: list[tuple[int, int, int, int]] = []
        in_slots: dict[int, list[tuple[int, int, int]]] = {}
        for document, slot, count, shape in tx.columns.shape_runs(keys):
            in_slots.setdefault(document, []).append((slot, count, number_of[document, shape]))
        for document, first, slot, count in tx.columns.timelines(keys):
            for start, length, shape in in_slots.get(document, ()):
                begin, end = max(start, slot), min(start + length, slot + count)
                if begin < end:
                    key = (place[document] << (DOCUMENT_SHIFT - FRAME_SHIFT)) | (first + begin - slot)
                    runs.append((key, begin, end - begin, shape))
        runs.sort()
        table = np.array(runs, np.int64).reshape(-1, 4)
        self._keys, self._slots, self.counts, self.shape = table.T

    @property
    def texts(self) -> list[str]:
        return self._read_names()[0]

    @property
    def names(self) -> Ints:
        return self._read_names()[1]

    def _read_names(self) -> tuple[list[str], Ints]:
        if self._names is None:
            bone_names = self._tx.columns.bone_names(self._keys_of)
            texts = list(dict.fromkeys(escape(name) for name in bone_names.values()))
            codes = {text: code for code, text in enumerate(texts)}
            by_bone = {bone: codes[escape(name)] for bone, name in bone_names.items()}
            documents = np.repeat(self._of_document, np.diff(self.offsets)).tolist()
            entries = zip(documents, self.bones.tolist(), strict=True)
            names = [by_bone[self._keys_of[place], bone] for place, bone in entries]
            self._names = texts, np.array(names, np.int64)
        return self._names

    def total(self) -> int:
        """How many frame_bones all frames have."""
        return int((self.counts * (self.offsets[self.shape + 1] - self.offsets[self.shape])).sum())

    def run_of(self, nodes: Ints) -> Ints:
        """The run in which each node's frame lies."""
        return np.asarray(np.searchsorted(self._keys, nodes >> FRAME_SHIFT, side="right") - 1)

    def shape_of(self, nodes: Ints) -> Ints:
        return np.asarray(self.shape[self.run_of(nodes)], np.int64)

    def slot_of(self, nodes: Ints) -> Ints:
        """Where the values of each node's frame lie in its document."""
        runs = self.run_of(nodes)
        return np.asarray(self._slots[runs] + (nodes >> FRAME_SHIFT) - self._keys[runs], np.int64)

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
        numbers = self._tx.columns.bones_named(unescape(text), self._keys_of)
        wanted = np.array([numbers.get(key, -1) for key in self._keys_of], np.int64)
        matching = np.flatnonzero(self.bones == np.repeat(wanted[self._of_document], np.diff(self.offsets)))
        shape = np.searchsorted(self.offsets, matching, side="right") - 1
        number = matching - self.offsets[shape]
        shapes = self.shape_of(frames)
        begin, end = np.searchsorted(shape, shapes, side="left"), np.searchsorted(shape, shapes, side="right")
        source, within = expand(end - begin)
        return source, frames[source] + BONES + BONE_WIDTH * number[begin[source] + within]

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
            [np.ones((len(bones), 1), bool), (bits[:, None] >> np.arange(8) & 1).astype(bool)], axis=1
        )
        source, place = np.nonzero(present)
        return source, bones[source] + FIRST_ATTRIBUTE + place

    def channel(self, bones: Ints, channel: int) -> tuple[Ints, Ints]:
        """(index into bones, attribute) of one channel, where frame_bones have it."""
        source = np.flatnonzero(self.bits[self.entries(bones)] >> channel & 1)
        return source, bones[source] + FIRST_CHANNEL + channel


class LabelRuns:
    """Runs of frames that carry the same motion names; every frame is in one.

    names: of all runs one after the other, each its place in `stored`, and in `texts` as XML has it.
    """

    def __init__(self, tx: Transaction, keys: Sequence[int], frames: Ints, only: tuple[int, int] | None = None) -> None:
        spans: dict[int, list[tuple[int, int, str]]] = {}
        for document, first, last, name in tx.columns.spans(keys, only):
            spans.setdefault(document, []).append((first, last, name))
        self.stored: list[str] = []
        self.texts: list[str] = []
        codes: dict[str, int] = {}
        starts: list[int] = []
        lengths: list[int] = []
        names: list[int] = []
        for place, key in enumerate(keys):
            found = spans.get(key, [])
            ends = {1, *(first for first, _, _ in found), *(last + 1 for _, last, _ in found)}
            for start in sorted(end for end in ends if end <= max(1, int(frames[place]))):
                covering = [name for first, last, name in found if first <= start <= last]
                starts.append((place << (DOCUMENT_SHIFT - FRAME_SHIFT)) | start)
                lengths.append(len(covering))
                for name in covering:
                    code = codes.setdefault(name, len(codes))
                    if code == len(self.texts):
                        self.stored.append(name)
                        self.texts.append(escape(name))
                    names.append(code)
        self.starts: Ints = np.array(starts, np.int64)
        self.lengths: Ints = np.array(lengths, np.int64)
        self.offsets: Ints = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        self.names: Ints = np.array(names, np.int64)

    def run_of(self, nodes: Ints) -> Ints:
        return np.asarray(np.searchsorted(self.starts, nodes >> FRAME_SHIFT, side="right") - 1)

    def sizes(self, frames: Ints) -> Ints:
        """How many motion_names each frame has."""
        return np.asarray(self.lengths[self.run_of(frames)], np.int64)

    def of_frames(self, frames: Ints) -> list[tuple[str, ...]] | None:
        """The motion names of each frame as they are stored, None where none has any."""
        runs = self.run_of(frames)
        if not self.lengths[runs].any():
            return None
        names = {run: tuple(self.stored[code] for code in self._codes_of(run)) for run in np.unique(runs).tolist()}
        return [names[run] for run in runs.tolist()]

    def _codes_of(self, run: int) -> list[int]:
        return self.names[self.offsets[run] : self.offsets[run + 1]].tolist()  # type: ignore[no-any-return]

    def codes(self, nodes: Ints) -> Ints:
        """The place in `texts` of the name that each motion_name (or its text) holds."""
        number = (slots_of(nodes) - NAMES_FROM) // NAME_WIDTH
        return np.asarray(self.names[self.offsets[self.run_of(nodes)] + number], np.int64)

    def children(self, frames: Ints) -> tuple[Ints, Ints]:
        """(index into frames, motion_name) of all motion_names of each frame, in order."""
        source, number = expand(self.sizes(frames))
        return source, frames[source] + NAMES_FROM + NAME_WIDTH * number


class IdRuns:
    """Frame ids, as arithmetic where they are integers of equal steps."""

    def __init__(self, tx: Transaction, keys: Sequence[int]) -> None:
        place = {key: number for number, key in enumerate(keys)}
        rows = [
            ((place[document] << (DOCUMENT_SHIFT - FRAME_SHIFT)) | first, first_id or 0, step or 0, count, texts)
            for document, first, count, first_id, step, texts in tx.columns.frame_runs(keys)
        ]
        rows.sort(key=lambda row: row[0])
        self._texts = {number: json.loads(row[4]) for number, row in enumerate(rows) if row[4] is not None}
        table = np.array([row[:4] for row in rows], np.int64).reshape(-1, 4)
        self._keys, self._first, self._step, self._count = table.T
        self._is_text = np.isin(np.arange(len(rows)), list(self._texts))

    def find(self, wanted: str | float) -> Ints:
        """The frame elements whose id is a text, or has this number; ascending."""
        number = wanted if isinstance(wanted, float) else to_number(wanted)
        found = [np.empty(0, np.int64)]
        exact = not isinstance(wanted, str) or (number.is_integer() and str(int(number)) == wanted)
        if number.is_integer() and abs(number) < 2**53 and exact:
            distance = int(number) - self._first
            step = np.where(self._step == 0, 1, self._step)
            within = distance // step
            hit = (distance % step == 0) & (within >= 0) & (within < self._count) & ~self._is_text
            found.append(self._keys[hit] + within[hit])
        for run, texts in self._texts.items():
            places = [i for i, text in enumerate(texts) if text == wanted or to_number(text) == wanted]
            found.append(self._keys[run] + np.array(places, np.int64))
        return np.sort(np.concatenate(found)) << FRAME_SHIFT

    def numbers(self, nodes: Ints) -> tuple[Ints, dict[int, str]]:
        """The id of each node's frame as an integer; by index, those that are other texts."""
        keys = nodes >> FRAME_SHIFT
        run = np.searchsorted(self._keys, keys, side="right") - 1
        within = keys - self._keys[run]
        others: dict[int, str] = {}
        for number, texts in self._texts.items():
            for index in np.flatnonzero(run == number).tolist():
                others[index] = texts[within[index]]
        return np.asarray(self._first[run] + self._step[run] * within, np.int64), others


def expand(counts: Ints) -> tuple[Ints, Ints]:
    """For counts 2, 0, 3: (0 0 2 2 2, 0 1 0 1 2): which one, and the number within it."""
    counts = np.asarray(counts, np.int64)
    source = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(source)) - np.repeat(np.cumsum(counts) - counts, counts)
    return source, within


def in_frames(nodes: Ints) -> Bools:
    return np.asarray(frames_of(nodes) > 0)


def _joined(parts: list[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([*parts, np.empty(0, kind)]).astype(kind, copy=False)
