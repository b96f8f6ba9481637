"""Checksums of what rows mean: made when a row is written, compared when it is read and by `mcml db check`.

A row's checksum covers its columns but for the keys that the database gives. The commits between which it is valid come
in as a sum, so that closing, copying and bringing back rows in SQL changes it by a known difference. It has 53 bits at
most, which arrays of doubles hold. Tracks have two: of their data, and of all else (their zone map too).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from operator import itemgetter
from typing import Any, Final, TypeAlias

import numpy as np
import orjson
from numpy.typing import NDArray
from sqlalchemy import Column, ColumnElement, Select, Table
from xxhash import xxh3_64_intdigest

from mcml.errors import DamageError
from mcml_service.storage.core import tables
from mcml_service.storage.core.schema import CHANNEL_ENDS, COVERED, CURRENT, metadata

Row: TypeAlias = tuple[Any, ...]

SPARE = 12
"""Bits of a digest that a checksum leaves away: with the commits it has 53."""

PRIME = 2147483629
"""Commits count modulo this. A bit that flips changes a number by a power of two, which no odd prime divides."""

REMEDY = "Run `mcml db check`, and restore the document from a backup or its file."

TRACK_FACTS = ("document", "chunk", "bone", "count", "channels", "has_missing", "codec", "data_checksum", *CHANNEL_ENDS)
"""What the second checksum of a track covers, in this order."""


@dataclass(frozen=True)
class Seal:
    """What the checksum of a table's rows covers: these columns, in this order. last: the type of the last one's
    values, where JSON has none for them, or databases have several."""

    table: Table
    columns: tuple[str, ...]
    last: type[bytes | bool] | None = None

    @cached_property
    def is_revisioned(self) -> bool:
        """Whether rows are valid between commits."""
        return "from_commit" in self.table.c

    @property
    def read(self) -> list[Column[Any]]:
        """What a statement must read to compare: the columns, the two commits if there are any, the checksum."""
        commits = ("from_commit", "to_commit") if self.is_revisioned else ()
        return [self.table.c[name] for name in (*self.columns, *commits, "checksum")]

    def of(self, values: Row) -> int:
        """The checksum of the values of the columns."""
        if self.last is bytes:
            return xxh3_64_intdigest(values[-1], xxh3_64_intdigest(orjson.dumps(values[:-1]))) >> SPARE
        if self.last is bool:
            values = (*values[:-1], int(values[-1]))
        return xxh3_64_intdigest(orjson.dumps(values)) >> SPARE

    def holds(self, row: Row) -> bool:
        """Whether what was read (`read`) has the checksum that stands with it."""
        # A bit that flips can change the type of a value.
        with suppress(TypeError, ValueError):
            if self.is_revisioned:
                return bool(self.of(row[:-3]) + visible(row[-3], row[-2]) == row[-1])
            return bool(self.of(row[:-1]) == row[-1])
        return False


class _Seals(Mapping[Table, Seal]):
    """The seals of all tables that say what their checksums cover (`schema.cover`)."""

    def __getitem__(self, table: Table) -> Seal:
        return _seal_of(table)

    def __contains__(self, table: object) -> bool:
        return isinstance(table, Table) and COVERED in table.info

    def __iter__(self) -> Iterator[Table]:
        return (table for table in metadata.tables.values() if table in self)

    def __len__(self) -> int:
        return sum(1 for _ in self)


@cache
def _seal_of(table: Table) -> Seal:
    return Seal(table, *table.info[COVERED])


SEALS: Final[Mapping[Table, Seal]] = _Seals()
"""Tables whose rows have one checksum. What is left out: tracks, which have two; elements of skeletons, whose hash is
one; uploads, whose SHA-256 is one; receipts, whose compressed form has one; numbers of properties, which their texts
say; jobs, events and webhooks, which end."""


@lru_cache(maxsize=4096)
def visible(begin: int, end: int) -> int:
    """What the commits between which a row is valid add to its checksum."""
    return 2 * (begin % PRIME) + end % PRIME


def closing(table: Table, end: int) -> dict[str, Any]:
    """The values with which an update closes current rows at a commit."""
    return {"to_commit": end, "checksum": table.c.checksum + (visible(0, end) - visible(0, CURRENT))}


def carry_checksum(table: Table, begin: int) -> ColumnElement[int]:
    """The checksum of a copy of a row that is valid from another commit on, and current."""
    was = 2 * (table.c.from_commit % PRIME) + table.c.to_commit % PRIME
    checksum: ColumnElement[int] = table.c.checksum - was + visible(begin, CURRENT)
    return checksum


def damage(whose: str, what: str) -> DamageError:
    """The error for something that is not what was written."""
    return DamageError(f"{whose} is damaged in the store: {what}.", remedy=REMEDY)


# -- writing -----------------------------------------------------------------------------------------------------------


def add_checksums(table: Table, names: tuple[str, ...], rows: Sequence[Row]) -> tuple[tuple[str, ...], Sequence[Row]]:
    """Names and rows with the checksums that the table has."""
    if table is tables.track:
        return _add_track_checksums(names, rows)
    if table not in SEALS:
        return names, rows
    seal, pick, commits = SEALS[table], *_places(table, names)
    if commits is None:
        return (*names, "checksum"), [(*row, seal.of(pick((*row, None)))) for row in rows]
    begin, end = commits
    made = [(*row, seal.of(pick((*row, None))) + visible(row[begin], row[end])) for row in rows]
    return (*names, "checksum"), made


@cache
def _places(table: Table, names: tuple[str, ...]) -> tuple[Callable[[Row], Row], tuple[int, int] | None]:
    """What picks the columns of a seal out of rows of these names, None for what they lack; where the commits stand."""
    seal = SEALS[table]
    pick = itemgetter(*(names.index(name) if name in names else -1 for name in seal.columns))
    return pick, (names.index("from_commit"), names.index("to_commit")) if seal.is_revisioned else None


def _add_track_checksums(names: tuple[str, ...], rows: Sequence[Row]) -> tuple[tuple[str, ...], Sequence[Row]]:
    place = {name: index for index, name in enumerate(names)}
    begin, end, codec, data = (place[name] for name in ("from_commit", "to_commit", "codec", "data"))
    checks = [data_checksum(row[codec], row[data]) for row in rows]
    picked = itemgetter(*(place[name] for name in TRACK_FACTS if name in place))
    facts: list[Sequence[Any]] = list(zip(*map(picked, rows), strict=True))
    facts.insert(_INTEGERS - 1, checks)
    sums = track_checksums(np.array(facts[:_INTEGERS], np.int64), np.array(facts[_INTEGERS:], np.float64))
    made = [
        (*row, check, total + visible(row[begin], row[end]))
        for row, check, total in zip(rows, checks, sums.tolist(), strict=True)
    ]
    return (*names, "data_checksum", "checksum"), made


# -- tracks ------------------------------------------------------------------------------------------------------------


def data_checksum(codec: int, data: bytes) -> int:
    """Of the data of a track. What they are the data of, the other checksum says."""
    return xxh3_64_intdigest(data) >> SPARE ^ codec


def unsound(rows: Sequence[Row], codec: int) -> Row | None:
    """The first of some tracks whose data are not those that were written.

    codec: where the codec stands in a row; the data and their checksum follow it.
    """
    data, checksum = codec + 1, codec + 2
    with suppress(TypeError):
        if [xxh3_64_intdigest(row[data]) >> SPARE ^ row[codec] for row in rows] == [row[checksum] for row in rows]:
            return None
    return next(row for row in rows if not _is_sound(*row[codec : checksum + 1]))


def _is_sound(codec: int, data: bytes, checksum: int) -> bool:
    with suppress(TypeError):
        return data_checksum(codec, data) == checksum
    return False


_INTEGERS = 8
_ODD: NDArray[np.uint64] = np.array(
    [xxh3_64_intdigest(f"{name}".encode()) | 1 for name in TRACK_FACTS], np.uint64
).reshape(-1, 1)


def track_checksums(integers: NDArray[np.int64], ends: NDArray[np.float64]) -> NDArray[np.int64]:
    """Of each track the checksum without its commits.

    integers: (8, n), what `TRACK_FACTS` begins with. ends: (2 * channels, n) of the zone maps, NaN for none.
    A sum of products with odd numbers, modulo 2^64: arrays do it for thousands of tracks at once, as zone maps are
    read.
    """
    # Databases know no negative zero.
    ends = np.where(np.isnan(ends), np.nan, ends + 0.0)
    total = (integers.view(np.uint64) * _ODD[:_INTEGERS]).sum(axis=0)
    total += (ends.view(np.uint64) * _ODD[_INTEGERS:]).sum(axis=0)
    return np.asarray(total >> np.uint64(SPARE), np.int64)


# -- reading -----------------------------------------------------------------------------------------------------------


class Checked:
    """A statement that also reads what seals need, where it does not read it anyway.

    plain: the statement without that. wanted: how many columns are wanted, the first ones.
    """

    def __init__(self, plain: Select[Any], of: tuple[Table, ...]) -> None:
        self.plain = plain
        self._of = of
        read = [getattr(column, "element", column) for column in plain.selected_columns]
        self.wanted = len(read)
        self._tests: list[_Test] = []
        for table in of:
            places = []
            for column in SEALS[table].read:
                at = next((index for index, other in enumerate(read) if other is column), len(read))
                if at == len(read):
                    read.append(column)
                places.append(at)
            self._tests.append(_Test(SEALS[table], places))
        self.statement = plain.add_columns(*read[self.wanted :])

    def where(self, *conditions: ColumnElement[bool]) -> Checked:
        """The same with more conditions."""
        return Checked(self.plain.where(*conditions), self._of)

    def check(self, rows: Sequence[Row]) -> tuple[list[Row], tuple[Table, Row] | None]:
        """The rows as they are wanted, and (table, what was read of it) of the first that has not its checksum."""
        for test in self._tests:
            if not test.all_hold(rows):
                return [], next(
                    (test.seal.table, test.pick(row)) for row in rows if not test.seal.holds(test.pick(row))
                )
        wanted = slice(self.wanted)
        return [row[wanted] for row in rows], None


class _Test:
    """A seal, and where in the rows of a statement its columns stand."""

    def __init__(self, seal: Seal, places: Sequence[int]) -> None:
        self.seal = seal
        self.pick: Callable[[Row], Row] = itemgetter(*places)
        self._own = itemgetter(*places[: len(seal.columns)])
        self._begin, self._close, self._end = (*places[-3:],) if seal.is_revisioned else (0, 0, places[-1])

    def all_hold(self, rows: Sequence[Row]) -> bool:
        """Whether all rows have their checksums: many at a time it takes half as long as one by one."""
        if self.seal.last is not None:
            return all(self.seal.holds(self.pick(row)) for row in rows)
        begin, close, end = self._begin, self._close, self._end
        # A bit that flips can change the type of a value.
        with suppress(TypeError, ValueError):
            digests = map(xxh3_64_intdigest, map(orjson.dumps, map(self._own, rows)))
            sums = [digest >> SPARE for digest in digests]
            if not self.seal.is_revisioned:
                return sums == [row[end] for row in rows]
            return sums == [row[end] - 2 * (row[begin] % PRIME) - row[close] % PRIME for row in rows]
        return False


def verify(statement: Select[Any], *of: Table) -> Checked:
    """The statement, its rows of these tables compared with their checksums (`statements`)."""
    return Checked(statement, of)
