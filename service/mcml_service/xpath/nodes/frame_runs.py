"""Data of frames other than their bones, as runs of equal frames: motion names and ids."""

from __future__ import annotations

import json
from bisect import insort
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from mcml.language.lexical import escape
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.encoding import is_plain_integer
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.nodes.number_runs import NumberRuns
from mcml_service.xpath.nodes.numbering import (
    DOCUMENT_SHIFT,
    FRAME_SHIFT,
    NAME_WIDTH,
    NAMES_FROM,
    Bools,
    Ints,
    slots_of,
)
from mcml_service.xpath.nodes.pairs import expand
from mcml_service.xpath.nodes.stored import Stored
from mcml_service.xpath.nodes.texts import to_number


@dataclass(frozen=True, slots=True)
class Labels:
    """One document. starts: first frames of runs that carry the same motion names, the first one 1; names: theirs."""

    starts: list[int]
    names: list[tuple[str, ...]]

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 256 + 128 * len(self.starts)


def read_labels(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Labels]:
    """The motion names of each document by its key."""
    spans: dict[int, list[tuple[int, int, str]]] = {}
    for key, first, last, name in tx.columns.spans([listed.key for listed in documents]):
        spans.setdefault(key, []).append((first, last, name))
    return {listed.key: _labels(spans.get(listed.key, []), listed.frames) for listed in documents}


def _labels(spans: Sequence[tuple[int, int, str]], frames: int) -> Labels:
    """spans: (first, last, name) in the order in which a frame that several cover has their names."""
    begins: dict[int, list[int]] = {1: []}
    ends: dict[int, list[int]] = {}
    for number, (first, last, _) in enumerate(spans):
        begins.setdefault(first, []).append(number)
        ends.setdefault(last + 1, []).append(number)
    starts = sorted(start for start in {*begins, *ends} if start <= max(1, frames))
    names: list[tuple[str, ...]] = []
    covering: list[int] = []
    for start in starts:
        for number in ends.get(start, ()):
            covering.remove(number)
        for number in begins.get(start, ()):
            insort(covering, number)
        names.append(tuple(spans[number][2] for number in covering))
    return Labels(starts, names)


class LabelRuns(Stored):
    """Runs of frames that carry the same motion names; every frame is in one.

    names: of all runs one after the other, each its place in `stored_names`, and in `texts` as XML has it.
    """

    STORED = ("starts", "lengths", "names", "stored_names")

    starts: Ints
    lengths: Ints
    names: Ints
    stored_names: list[str]

    def __init__(self, labels: Sequence[Labels]) -> None:
        codes: dict[str, int] = {}
        places = np.repeat(np.arange(len(labels)), [len(each.starts) for each in labels])
        starts = np.array([start for each in labels for start in each.starts], np.int64)
        of_runs = [names for each in labels for names in each.names]
        self.starts = (places << (DOCUMENT_SHIFT - FRAME_SHIFT)) | starts
        self.lengths = np.array([len(names) for names in of_runs], np.int64)
        self.names = np.array([codes.setdefault(name, len(codes)) for names in of_runs for name in names], np.int64)
        self.stored_names = list(codes)

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 100 * len(self.starts) + 80 * len(self.names)

    @cached_property
    def offsets(self) -> Ints:
        """Where in `names` those of each run begin."""
        return np.concatenate([[0], np.cumsum(self.lengths)])

    @cached_property
    def texts(self) -> list[str]:
        """All names, as XML has them."""
        return [escape(name) for name in self.stored_names]

    @cached_property
    def _of_runs(self) -> list[tuple[str, ...]]:
        names = [self.stored_names[code] for code in self.names.tolist()]
        return [tuple(names[start:stop]) for start, stop in pairwise(self.offsets.tolist())]

    def run_of(self, nodes: Ints) -> Ints:
        return np.asarray(np.searchsorted(self.starts, nodes >> FRAME_SHIFT, side="right") - 1)

    def named_frames(self, frames: Ints) -> Ints:
        """The frame elements that carry motion names, in order. frames: how many each document has."""
        documents = self.starts >> (DOCUMENT_SHIFT - FRAME_SHIFT)
        ends = (documents << (DOCUMENT_SHIFT - FRAME_SHIFT)) + frames[documents] + 1
        following = np.append(self.starts[1:], ends[-1:])
        counts = np.minimum(following, ends) - self.starts
        runs = np.flatnonzero(self.lengths)
        source, within = expand(counts[runs])
        return np.asarray((self.starts[runs][source] + within) << FRAME_SHIFT, np.int64)

    def sizes(self, frames: Ints) -> Ints:
        """How many motion_names each frame has."""
        return np.asarray(self.lengths[self.run_of(frames)], np.int64)

    def of_frames(self, frames: Ints) -> list[tuple[str, ...]] | None:
        """Return the stored motion names of each frame, None if no frame has any."""
        runs = self.run_of(frames)
        if not self.lengths[runs].any():
            return None
        return [self._of_runs[run] for run in runs.tolist()]

    def codes(self, nodes: Ints) -> Ints:
        """The place in `texts` of the name that each motion_name (or its text) holds."""
        number = (slots_of(nodes) - NAMES_FROM) // NAME_WIDTH
        return np.asarray(self.names[self.offsets[self.run_of(nodes)] + number], np.int64)

    def children(self, frames: Ints) -> tuple[Ints, Ints]:
        """(index into frames, motion_name) of all motion_names of each frame, in order."""
        source, number = expand(self.sizes(frames))
        return source, frames[source] + NAMES_FROM + NAME_WIDTH * number


@dataclass(frozen=True, slots=True)
class Ids:
    """One document. runs: (n, 4) first position, first id, step, frames. texts: the ids of runs that are no integers,
    by the number of the run."""

    runs: Ints
    texts: dict[int, list[str]]

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 256 + self.runs.nbytes + 64 * sum(map(len, self.texts.values()))


def read_ids(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Ids]:
    """The ids of the frames of each document by its key."""
    runs: dict[int, list[tuple[int, int, int, int]]] = {listed.key: [] for listed in documents}
    texts: dict[int, dict[int, list[str]]] = {listed.key: {} for listed in documents}
    for key, first, count, first_id, step, text in tx.columns.frame_runs(list(runs)):
        if text is not None:
            texts[key][len(runs[key])] = json.loads(text)
        runs[key].append((first, first_id or 0, step or 0, count))
    return {key: Ids(np.array(found, np.int64).reshape(-1, 4), texts[key]) for key, found in runs.items()}


class IdRuns(Stored):
    """Frame ids, as arithmetic where they are integers of equal steps."""

    STORED = ("_keys", "_first", "_step", "_count", "others")

    _keys: Ints
    _first: Ints
    _step: Ints
    _count: Ints
    others: list[tuple[int, list[str]]]
    """The ids of runs that are no integers, by the number of the run."""

    def __init__(self, ids: Sequence[Ids]) -> None:
        lengths = [len(each.runs) for each in ids]
        offsets = np.cumsum(lengths) - lengths
        runs = np.concatenate([np.empty((0, 4), np.int64), *(each.runs for each in ids)])
        first, self._first, self._step, self._count = runs.T
        self._keys = (np.repeat(np.arange(len(ids)), lengths) << (DOCUMENT_SHIFT - FRAME_SHIFT)) | first
        self.others = [
            (offset + number, texts)
            for offset, each in zip(offsets.tolist(), ids, strict=True)
            for number, texts in each.texts.items()
        ]

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 50 * len(self._keys) + 64 * sum(len(texts) for _, texts in self.others)

    @cached_property
    def _texts(self) -> dict[int, list[str]]:
        return dict(self.others)

    @cached_property
    def _is_text(self) -> Bools:
        return np.isin(np.arange(len(self._keys)), list(self._texts))

    @cached_property
    def of_numbers(self) -> NumberRuns:
        """The runs whose ids are integers."""
        runs = np.flatnonzero(~self._is_text)
        return NumberRuns(self._keys[runs], self._first[runs], self._step[runs], self._count[runs])

    @cached_property
    def of_texts(self) -> Ints:
        """The frame elements whose ids are no integers, ascending."""
        keys = [self._keys[run] + np.arange(len(texts)) for run, texts in sorted(self.others)]
        return np.concatenate([*keys, np.empty(0, np.int64)]) << FRAME_SHIFT

    def find(self, wanted: str | float) -> Ints:
        """The frame elements whose id is a text, or has this number; ascending."""
        found = [self._of_text(wanted) if isinstance(wanted, str) else self._of_number(wanted)]
        for run, texts in self._texts.items():
            places = [i for i, text in enumerate(texts) if text == wanted or to_number(text) == wanted]
            found.append(self._keys[run] + np.array(places, np.int64))
        return np.sort(np.concatenate(found)) << FRAME_SHIFT

    def _of_text(self, wanted: str) -> Ints:
        return self._hits(int(wanted)) if is_plain_integer(wanted) else np.empty(0, np.int64)

    def _of_number(self, wanted: float) -> Ints:
        if abs(wanted) < 2**53:
            return self._hits(int(wanted)) if wanted.is_integer() else np.empty(0, np.int64)
        # Several integers beyond are one and the same double.
        within = [np.arange(count) for count in self._count.tolist()]
        return np.concatenate(
            [
                np.empty(0, np.int64),
                *(
                    self._keys[run] + inner[(self._first[run] + self._step[run] * inner).astype(np.float64) == wanted]
                    for run, inner in enumerate(within)
                    if not self._is_text[run]
                ),
            ]
        )

    def _hits(self, wanted: int) -> Ints:
        """The frames whose id is an integer, as keys."""
        distance = wanted - self._first
        equal = self._step == 0
        step = np.where(equal, 1, self._step)
        within = distance // step
        hit = np.where(equal, distance == 0, (distance % step == 0) & (within >= 0) & (within < self._count))
        runs = np.flatnonzero(hit & ~self._is_text)
        # In a run of equal ids all frames have the one that is wanted.
        source, inner = expand(np.where(equal[runs], self._count[runs], 1))
        return np.asarray(self._keys[runs][source] + np.where(equal[runs], 0, within[runs])[source] + inner, np.int64)

    def numbers(self, nodes: Ints) -> tuple[Ints, dict[int, str]]:
        """Return the id of each node's frame as an integer; and other texts, by index."""
        keys = nodes >> FRAME_SHIFT
        run = np.searchsorted(self._keys, keys, side="right") - 1
        within = keys - self._keys[run]
        others: dict[int, str] = {}
        for number, texts in self._texts.items():
            for index in np.flatnonzero(run == number).tolist():
                others[index] = texts[within[index]]
        return np.asarray(self._first[run] + self._step[run] * within, np.int64), others
