"""What frames carry beside their bones, as runs of equal frames: motion names and ids."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from service.mcml.lexical import escape
from service.storage.database import Transaction
from service.xpath.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, NAME_WIDTH, NAMES_FROM, Ints, slots_of
from service.xpath.pairs import expand
from service.xpath.texts import to_number


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
