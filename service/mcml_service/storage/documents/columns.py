"""Rows of many documents at once, as queries over whole repositories need them: one statement, not one a document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import orjson
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, and_, bindparam, func, select

from mcml_service.storage.core.schema import CHANNEL_ENDS, CURRENT
from mcml_service.storage.core.seals import PRIME, damage, track_checksums, unsound
from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import (
    bone,
    commit,
    content,
    document,
    frame_run,
    header,
    revision,
    shape,
    shape_run,
    skeleton,
    skeleton_element,
    span,
    timeline,
    track,
)
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import there, valid
from mcml_service.storage.documents.damage import describe_track_damage
from mcml_service.storage.documents.document_statements import select_listed
from mcml_service.storage.documents.encoding import unpack_shape
from mcml_service.storage.documents.rows import to_elements, to_skeleton

if TYPE_CHECKING:
    from mcml.language.elements import Element
    from mcml.motion.clip import Shape

TRACKS_AT_A_TIME = 2000
CHUNKS_AT_A_TIME = 50
KEYS_AT_A_TIME = 10_000
"""In one statement."""


class Listed(NamedTuple):
    """A document at one revision: the data that a query needs for every document in its scope."""

    key: int
    uuid: str
    name: str
    version: str
    skeleton: int
    frames: int
    frame_time: str | None
    revision: int
    project: int


# Made once: to make a statement takes longer than to run a short one.
_TIMELINES = Prepared(
    select(timeline.c.document, timeline.c.first, timeline.c.slot, timeline.c.count)
    .where(OneOf(timeline.c.document, "keys"), valid(timeline))
    .order_by(timeline.c.document, timeline.c.first),
    timeline,
)
_SHAPE_RUNS = Prepared(
    select(shape_run.c.document, shape_run.c.slot, shape_run.c.count, shape_run.c.shape)
    .where(OneOf(shape_run.c.document, "keys"), valid(shape_run))
    .order_by(shape_run.c.document, shape_run.c.slot),
    shape_run,
)
_SHAPES = Prepared(select(shape.c.document, shape.c.shape, shape.c.bones).where(OneOf(shape.c.document, "keys")), shape)
_BONE_NAMES = Prepared(
    select(bone.c.document, bone.c.bone, bone.c.name).where(OneOf(bone.c.document, "keys"), valid(bone)), bone
)
_SPANS = Prepared(
    select(span.c.document, span.c.first, span.c.last, span.c.name)
    .where(OneOf(span.c.document, "keys"), valid(span))
    .order_by(span.c.document, span.c.rank, span.c.id),
    span,
)
_FRAME_RUNS = Prepared(
    select(
        frame_run.c.document,
        frame_run.c.first,
        frame_run.c.count,
        frame_run.c.first_id,
        frame_run.c.step,
        frame_run.c.texts,
    )
    .where(OneOf(frame_run.c.document, "keys"), valid(frame_run))
    .order_by(frame_run.c.document, frame_run.c.first),
    frame_run,
)
_TRACK_KEY = (track.c.document, track.c.chunk, track.c.bone, track.c.from_commit)
_IN_CHUNKS = and_(track.c.chunk >= bindparam("low"), track.c.chunk <= bindparam("high"))
_OF_BONES = OneOf(track.c.bone, "bones")
_TRACKS = Prepared(
    select(*_TRACK_KEY, track.c.channels).where(OneOf(track.c.document, "keys"), valid(track), _IN_CHUNKS)
)
_TRACKS_OF_BONES = _TRACKS.where(_OF_BONES)
_ZONES = Prepared(
    select(
        *_TRACK_KEY,
        track.c.channels,
        track.c.has_missing,
        track.c.count,
        *(track.c[end] for end in CHANNEL_ENDS),
        track.c.codec,
        track.c.data_checksum,
        track.c.to_commit,
        track.c.checksum,
    ).where(OneOf(track.c.document, "keys"), valid(track))
)
_ZONES_OF_BONES = _ZONES.where(_OF_BONES)
_HEADERS = Prepared(
    select(header.c.document, header.c.level, header.c.tag, header.c.attributes, header.c.text)
    .where(OneOf(header.c.document, "keys"), valid(header))
    .order_by(header.c.document, header.c.pre),
    header,
)
_SKELETONS = Prepared(
    select(
        skeleton_element.c.skeleton,
        skeleton_element.c.level,
        skeleton_element.c.tag,
        skeleton_element.c.attributes,
        skeleton_element.c.text,
        skeleton.c.hash,
    )
    .join(skeleton, skeleton.c.id == skeleton_element.c.skeleton)
    .where(OneOf(skeleton_element.c.skeleton, "keys"))
    .order_by(skeleton_element.c.skeleton, skeleton_element.c.pre)
)


_NAMED: dict[str, ColumnElement[bool]] = {
    table.name: and_(table.c.document == document.c.id, valid(table), there()) for table in (bone, span)
}
_NAMES = {table.name: Prepared(select(table.c.name).where(_NAMED[table.name]).distinct()) for table in (bone, span)}
_COUNTS = {
    table.name: Prepared(
        select(table.c.name, func.count(table.c.document.distinct())).where(_NAMED[table.name]).group_by(table.c.name)
    )
    for table in (bone, span)
}
_HOLDERS = {
    table.name: Prepared(select(document.c.id).where(_NAMED[table.name], table.c.name == bindparam("name")).limit(1))
    for table in (bone, span)
}
_OF_KEYS = OneOf(document.c.id, "keys")
_NAMES_OF_KEYS = {kind: query.where(_OF_KEYS) for kind, query in _NAMES.items()}
_COUNTS_OF_KEYS = {kind: query.where(_OF_KEYS) for kind, query in _COUNTS.items()}
_HOLDERS_OF_KEYS = {kind: query.where(_OF_KEYS) for kind, query in _HOLDERS.items()}
_ZONE_WIDTH = 7 + len(CHANNEL_ENDS)
_DOCUMENTS = {past: Prepared(select_listed(past=past), document, content) for past in (False, True)}
_COMMIT = Prepared(select(commit.c.time, commit.c.author).where(commit.c.number == bindparam("number")))
_CHANGED = Prepared(select(revision.c.document).where(revision.c.commit > bindparam("number")))
_DOCUMENTS_OF_KEYS = {past: query.where(OneOf(document.c.id, "keys")) for past, query in _DOCUMENTS.items()}


class Columns:
    """Every method takes the keys of the documents (or skeletons) it reads."""

    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def documents(self, keys: Sequence[int] | None = None) -> list[Listed]:
        """The documents (all, if no keys are given) by name, then key."""
        past = self._tx.at < CURRENT - 1
        rows: Iterable[Any]
        if keys is None:
            rows = self._tx.fetch_all(_DOCUMENTS[past], {"at": self._tx.at})
        else:
            rows = self._rows(_DOCUMENTS_OF_KEYS[past], keys)
        listed = list(map(Listed._make, rows))
        return sorted(listed, key=lambda one: (one.name, one.key))

    def changed_since(self, number: int) -> list[int]:
        """Return the documents with revisions after a commit."""
        # Not DISTINCT, for which SQLite would read all revisions in the order of documents.
        return sorted(set(self._tx.fetch_column(_CHANGED, {"number": number})))

    def commit_facts(self, number: int) -> str:
        """Return the data that distinguish a commit from the one with the same number in another store, "" if there
        is none.
        """
        row = self._tx.fetch_one(_COMMIT, {"number": number})
        return "" if row is None else " ".join(map(str, row))

    def timelines(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, first, slot, count) in order of document and position."""
        return list(self._rows(_TIMELINES, keys))

    def shape_runs(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, slot, count, shape) in order of document and slot."""
        return list(self._rows(_SHAPE_RUNS, keys))

    def shapes(self, keys: Sequence[int]) -> dict[tuple[int, int], Shape]:
        """Every shape by (document, number)."""
        return {(row[0], row[1]): unpack_shape(row[2]) for row in self._rows(_SHAPES, keys)}

    def bone_names(self, keys: Sequence[int]) -> dict[tuple[int, int], str]:
        """The name of each bone by (document, number)."""
        return {(row[0], row[1]): row[2] for row in self._rows(_BONE_NAMES, keys)}

    def used_names(self, kind: Literal["bone", "span"], keys: Sequence[int] | None) -> list[str]:
        """The different names of bones, or motion names of spans, in the documents (in all, if no keys are given)."""
        if keys is None:
            return sorted(self._tx.fetch_column(_NAMES[kind], {"at": self._tx.at}))
        return sorted({row[0] for row in self._rows(_NAMES_OF_KEYS[kind], keys)})

    def used_counts(self, kind: Literal["bone", "span"], keys: Sequence[int] | None) -> dict[str, int]:
        """The different names, by code point, with how many documents have each (of all, if no keys are given)."""
        counts: Counter[str] = Counter()
        if keys is None:
            counts.update(dict(self._tx.fetch_all(_COUNTS[kind], {"at": self._tx.at})))
        else:
            for name, count in self._rows(_COUNTS_OF_KEYS[kind], keys):
                counts[name] += count
        return dict(sorted(counts.items()))

    def is_used(self, kind: Literal["bone", "span"], name: str, keys: Sequence[int] | None) -> bool:
        """Whether a bone has the name, or a frame the motion name, in one of the documents."""
        if keys is None:
            return bool(self._tx.fetch_all(_HOLDERS[kind], {"at": self._tx.at, "name": name}))
        return any(True for _ in self._rows(_HOLDERS_OF_KEYS[kind], keys, name=name))

    def spans(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, first, last, name) in order of document and of the motion_names in a frame."""
        return list(self._rows(_SPANS, keys))

    def frame_runs(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, first, count, first_id, step, texts) in order of document and position."""
        return list(self._rows(_FRAME_RUNS, keys))

    def headers(self, keys: Sequence[int]) -> dict[int, Element]:
        """The `header` element of each document."""
        rows: dict[int, list[Any]] = {}
        for document_key, *row in self._rows(_HEADERS, keys):
            rows.setdefault(document_key, []).append(row)
        return {key: to_elements(elements)[0] for key, elements in rows.items()}

    def skeletons(self, keys: Sequence[int]) -> dict[int, list[Element]]:
        """Return the `root` element, if there is one, and the `skeleton` element of each skeleton."""
        rows: dict[int, list[Any]] = {}
        hashes: dict[int, str] = {}
        for skeleton_key, *row, hashed in self._rows(_SKELETONS, keys):
            rows.setdefault(skeleton_key, []).append(row)
            hashes[skeleton_key] = hashed
        return {key: to_skeleton(elements, hashes[key]) for key, elements in rows.items()}

    def tracks(self, keys: Sequence[int], chunks: tuple[int, int], bones: Sequence[int] | None = None) -> Iterator[Any]:
        """Rows (document, chunk, bone, from_commit, channels) of the tracks of some bones or all, of chunks first to
        last."""
        query = _TRACKS if bones is None else _TRACKS_OF_BONES
        values = {} if bones is None else {"bones": list(bones)}
        return self._rows(query, keys, low=chunks[0], high=chunks[1], **values)

    def zones(self, keys: Sequence[int], bones: Sequence[int] | None = None) -> NDArray[np.float64]:
        """Of the tracks of some bones or all: (n, 7 + 2 * channels), each (document, chunk, bone, from_commit,
        channels, has_missing, count, and for each channel least and greatest sample, NaN where it has none)."""
        narrowed = {} if bones is None else {"bones": list(bones)}
        rows = list(self._rows(_ZONES if bones is None else _ZONES_OF_BONES, keys, **narrowed))
        try:
            values, wrong = _zones(rows)
        except (TypeError, ValueError, OverflowError):
            # A bit that flipped changed the type of a value.
            raise damage("A document", "the zone map of a track") from None
        for index in np.flatnonzero(wrong)[:1].tolist():
            raise describe_track_damage(self._tx, *rows[index][:3])
        return values

    def track_data(self, keys: Sequence[tuple[int, int, int, int]]) -> Iterator[Any]:
        """Rows (document, chunk, bone, from_commit, codec, data, checksum of the data) of the tracks that are named by
        their first four."""
        for start in range(0, len(keys), TRACKS_AT_A_TIME):
            values = {"keys": orjson.dumps(keys[start : start + TRACKS_AT_A_TIME]).decode()}
            rows = self._tx.fetch_all(self._tx.dialect.tracks_by_key, values)
            if (wrong := unsound(rows, codec=4)) is not None:
                raise describe_track_damage(self._tx, *wrong[:3])
            yield from rows

    def tracks_over(self, chunks: Sequence[tuple[int, int]]) -> Iterator[Any]:
        """Rows (document, chunk, bone, channels, count, codec, data, checksum of the data) of all tracks over some
        chunks (document, chunk), those of a chunk by bone."""
        for start in range(0, len(chunks), CHUNKS_AT_A_TIME):
            keys = orjson.dumps(chunks[start : start + CHUNKS_AT_A_TIME]).decode()
            rows = self._tx.fetch_all(self._tx.dialect.tracks_over_chunks, {"keys": keys, "at": self._tx.at})
            if (wrong := unsound(rows, codec=5)) is not None:
                raise describe_track_damage(self._tx, *wrong[:3])
            yield from sorted(rows, key=itemgetter(0, 1, 2))

    def _rows(self, query: Prepared, keys: Sequence[int], **given: Any) -> Iterator[Any]:
        given["at"] = self._tx.at
        for start in range(0, len(keys), KEYS_AT_A_TIME):
            given["keys"] = list(keys[start : start + KEYS_AT_A_TIME])
            yield from self._tx.fetch_all(query, given)


def _zones(rows: Sequence[Any]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Zone maps as an array, and which of them have not their checksum."""
    values = np.array(rows, np.float64).reshape(-1, _ZONE_WIDTH + 4)
    # Doubles represent all of these exactly, except the last commit, which means none.
    values[:, -2][values[:, -2] >= CURRENT] = CURRENT % PRIME
    document_key, chunk, number, begin, bits, gaps, count = values[:, :7].T.astype(np.int64)
    codec, data, end, checksum = values[:, _ZONE_WIDTH:].T.astype(np.int64)
    facts = np.stack([document_key, chunk, number, count, bits, gaps, codec, data])
    zones = values[:, :_ZONE_WIDTH]
    return zones, track_checksums(facts, zones[:, 7:].T) + 2 * (begin % PRIME) + end % PRIME != checksum
