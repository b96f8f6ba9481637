"""The documents of a batch as columns: heads as arrays of nodes, frames as runs of equal structure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from service.errors import StoreError
from service.mcml.lexical import escape, unescape
from service.motion.clip import Shape
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.frame_runs import IdRuns, LabelRuns
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
    Ints,
    documents_of,
    frames_of,
    slots_of,
)
from service.xpath.pairs import expand
from service.xpath.shared import Shared


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
        self.whole_heads = whole_heads
        self._head: HeadRows | None = None
        self._shapes: ShapeRuns | None = None
        self._labels: LabelRuns | None = None
        self._ids: IdRuns | None = None
        self._only: tuple[int, int] | None = None
        self._bone_names: list[dict[int, str]] | None = None

    def __len__(self) -> int:
        return len(self.documents)

    @property
    def head(self) -> HeadRows:
        if self._head is None:
            self._head = HeadRows(self.shared.heads.read(self.tx, self.documents, whole=self.whole_heads))
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

    def bone_names(self, document: int) -> list[str]:
        """The names of bones by their numbers, as `write_frames` takes them."""
        if self._bone_names is None:
            self._bone_names = [{} for _ in self.keys]
            place = {key: number for number, key in enumerate(self.keys)}
            for (key, bone), name in self.tx.columns.bone_names(self.keys).items():
                self._bone_names[place[key]][bone] = name
        names = self._bone_names[document]
        return [names.get(number, "") for number in range(max(names, default=-1) + 1)]

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
        self.heads = heads
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
        return self.heads[document].address(row - int(self.starts[document]))

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


def _joined(parts: list[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([*parts, np.empty(0, kind)]).astype(kind, copy=False)
