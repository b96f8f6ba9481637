"""Data of all documents for lists, as columns in the order of names. They never change: a commit makes new ones."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml_service.listing.vocabulary import Codes, Mask, Numbering, Properties, PropertyColumns, Vocabulary
from mcml_service.storage.lists.list_rows import ListRows, Row

Column: TypeAlias = NDArray[Any]
Numbers: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True)
class Vocabularies:
    """Of all states of a library. texts: names, descriptions, names of files, motion names."""

    texts: Vocabulary[str] = field(default_factory=Vocabulary)
    projects: Numbering[str] = field(default_factory=Numbering)
    formats: Numbering[str] = field(default_factory=Numbering)
    skeletons: Numbering[int] = field(default_factory=Numbering)
    seconds: Numbering[float | None] = field(default_factory=Numbering)
    lengths: Numbering[float | None] = field(default_factory=Numbering)
    properties: Properties = field(default_factory=Properties)

    def characters(self) -> int:
        return self.texts.characters + self.properties.characters

    def values(self) -> int:
        return len(self.texts) + len(self.properties) + len(self.lengths)


@dataclass(frozen=True)
class Pairs:
    """Pairs of documents and values.

    places: indices of documents in the columns. codes: of the values, in their vocabulary.
    """

    places: Codes
    codes: Codes

    def move(self, to: Codes) -> Pairs:
        """The same where documents have other places. to: by place, -1 for documents that are gone."""
        places = to[self.places]
        kept = places >= 0
        return Pairs(places[kept], self.codes[kept])

    def join(self, others: Pairs) -> Pairs:
        return Pairs(np.concatenate([self.places, others.places]), np.concatenate([self.codes, others.codes]))

    def having(self, wanted: Mask, documents: int) -> Mask:
        """Return a mask of the documents that have one of the requested codes."""
        mask = np.zeros(documents, np.bool_)
        mask[self.places[wanted[self.codes]]] = True
        return mask

    def counts(self, among: Mask, codes: int) -> Numbers:
        """Return the number of documents for each code."""
        codes_of = self.codes if among.all() else self.codes[among[self.places]]
        return np.bincount(codes_of, minlength=codes)


_NONE = Pairs(np.empty(0, np.int32), np.empty(0, np.int32))

_KINDS: dict[str, Any] = {
    "keys": np.int64,
    "uuids": "S36",
    "names": object,
    "projects": np.int32,
    "formats": np.int32,
    "created": np.int64,
    "there": np.bool_,
    "skeletons": np.int64,
    "frames": np.int64,
    "seconds": np.float64,
    "revisions": np.int64,
    "modified": np.int64,
}
"""Columns of each document, in the order of `ListRows.documents`."""

_COUNTED = {"codes of skeletons": np.int32, "codes of seconds": np.int32, "codes of lengths": np.int32}
"""Additional columns, for counts."""


@dataclass(frozen=True)
class Columns:
    """The library at a commit. whole_since: the commit since which its history was complete.

    table: columns of `_KINDS`, by name, then key. said: texts for word search. named: motion names. having: properties,
    with details in `properties`. kept: cached derived data, by key.
    """

    commit: int
    whole_since: int
    words: Vocabularies
    table: dict[str, Column]
    said: Pairs = _NONE
    named: Pairs = _NONE
    having: Pairs = _NONE
    properties: PropertyColumns = field(default_factory=lambda: Properties().columns())
    kept: dict[Any, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.table["keys"])

    def __getitem__(self, name: str) -> Column:
        return self.table[name]

    def once(self, name: Any, make: Callable[[], Any]) -> Any:
        """Return derived data, computed on first use."""
        value = self.kept.get(name)
        if value is None:
            value = self.kept[name] = make()
        return value

    def place_behind(self, name: str, key: int) -> int:
        """Return the number of documents up to a name and key."""
        return _place(self.table["names"], self.table["keys"], (name, key + 1))

    def update(self, commit: int, whole_since: int, gone: Sequence[int], facts: ListRows) -> Columns:
        """Return the columns at another commit. gone: changed or deleted documents. facts: of changed and new ones."""
        rows = sorted(facts.documents, key=lambda row: (row[2], row[0]))
        kept = ~np.isin(self.table["keys"], np.array(gone, np.int64))
        table = {name: column[kept] for name, column in self.table.items()}
        before = np.array([_place(table["names"], table["keys"], (row[2], row[0])) for row in rows], np.int64)
        for (name, kind), values in zip((_KINDS | _COUNTED).items(), self._values(rows), strict=True):
            table[name] = np.insert(table[name], before, np.array(values, kind))
        stay = np.arange(np.count_nonzero(kept))
        to = np.full(len(kept), -1, np.int32)
        to[kept] = stay + np.searchsorted(before, stay, side="right")
        places = {row[0]: int(place) + number for number, (row, place) in enumerate(zip(rows, before, strict=True))}
        texts = self.words.texts
        said = [(places[row[0]], row[2]) for row in rows] + _find_place(facts.said, places)
        having = [(places[key], (name, number, text)) for key, name, number, text in facts.having if key in places]
        return Columns(
            commit,
            whole_since,
            self.words,
            table,
            self.said.move(to).join(_pairs(said, texts)),
            self.named.move(to).join(_pairs(_find_place(facts.named, places), texts)),
            self.having.move(to).join(_pairs(having, self.words.properties)),
            self.words.properties.columns(),
        )

    def _values(self, rows: list[Row]) -> list[Any]:
        """Rows as columns, with codes for values that many documents share."""
        words = self.words
        values: dict[str, Any] = dict(zip(_KINDS, zip(*rows, strict=True) if rows else [()] * len(_KINDS), strict=True))
        timed = zip(values["frames"], values["seconds"], strict=True)
        values["projects"] = words.projects.codes(values["projects"])
        values["formats"] = words.formats.codes(values["formats"])
        return [
            *values.values(),
            words.skeletons.codes(values["skeletons"]),
            words.seconds.codes(values["seconds"]),
            words.lengths.codes(None if each is None else frames * each for frames, each in timed),
        ]


def no_columns() -> Columns:
    """Of an empty library."""
    return Columns(0, 0, Vocabularies(), {name: np.empty(0, kind) for name, kind in (_KINDS | _COUNTED).items()})


def _place(names: Column, keys: Column, wanted: tuple[str, int]) -> int:
    return bisect_left(range(len(names)), wanted, key=lambda at: (names[at], keys[at]))


def _find_place(rows: Iterable[Row], places: dict[int, int]) -> list[tuple[int, Any]]:
    return [(places[key], value) for key, value in rows if key in places]


def _pairs(found: list[tuple[int, Any]], vocabulary: Numbering[Any]) -> Pairs:
    return Pairs(np.array([place for place, _ in found], np.int32), vocabulary.codes(value for _, value in found))
