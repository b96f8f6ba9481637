"""Rows of many documents at once, as queries over whole repositories need them: one statement, not one a document."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sqlalchemy import Select, and_, func, select

from service.motion.skeleton import CHANNELS
from service.storage.encoding import unpack_shape
from service.storage.rows import to_elements
from service.storage.tables import (
    CURRENT,
    bone,
    content,
    document,
    frame_run,
    header,
    revision,
    shape,
    shape_run,
    skeleton_element,
    span,
    timeline,
    track,
)

if TYPE_CHECKING:
    from service.mcml.elements import Element
    from service.motion.clip import Shape
    from service.storage.database import Transaction

KEYS_AT_A_TIME = 10_000
"""In one statement; SQLite takes 32,766 parameters, PostgreSQL 65,535."""


@dataclass(frozen=True, slots=True)
class Listed:
    """A document at one revision: what a query needs to know of every one it is asked of."""

    key: int
    uuid: str
    name: str
    version: str
    skeleton: int
    frames: int
    frame_time: str | None
    revision: int


ROWS_AT_A_TIME = 4096


class Columns:
    def __init__(self, tx: Transaction) -> None:
        self._tx = tx

    def documents(self, keys: Sequence[int] | None = None, project_key: int | None = None) -> list[Listed]:
        """The documents (all, if no keys are given) by name, then key."""
        at = self._tx.at
        newest = (
            select(func.max(revision.c.number))
            .where(revision.c.document == document.c.id, revision.c.commit <= at)
            .scalar_subquery()
        )
        source: Any = document
        held: Any = document
        if at < CURRENT - 1:
            # The past, which only the revision of that time knows.
            held = revision.alias()
            source = document.join(held, and_(held.c.document == document.c.id, held.c.number == newest))
        about = (document.c.id, document.c.uuid, held.c.name, content.c.version, content.c.skeleton)
        query = (
            select(*about, content.c.frames, content.c.frame_time, newest)
            .select_from(source)
            .join(content, and_(content.c.document == document.c.id, self._tx.valid(content)))
            .where(self._tx.documents.visible(), document.c.deleted_commit > at)
        )
        if project_key is not None:
            query = query.where(held.c.project == project_key)
        found: Iterable[Any] = self._tx.connection.execute(query) if keys is None else ()
        if keys is not None:
            found = self._rows(query, document.c.id, keys)
        listed = [Listed(*row) for row in found]
        return sorted(listed, key=lambda one: (one.name, one.key))

    def timelines(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, first, slot, count) in order of document and position."""
        query = select(timeline.c.document, timeline.c.first, timeline.c.slot, timeline.c.count)
        query = query.where(self._tx.valid(timeline)).order_by(timeline.c.document, timeline.c.first)
        return list(self._rows(query, timeline.c.document, keys))

    def shape_runs(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, slot, count, shape) in order of document and slot."""
        query = select(shape_run.c.document, shape_run.c.slot, shape_run.c.count, shape_run.c.shape)
        query = query.where(self._tx.valid(shape_run)).order_by(shape_run.c.document, shape_run.c.slot)
        return list(self._rows(query, shape_run.c.document, keys))

    def shapes(self, keys: Sequence[int]) -> dict[tuple[int, int], Shape]:
        """Every shape by (document, number)."""
        query = select(shape.c.document, shape.c.shape, shape.c.bones)
        return {(row[0], row[1]): unpack_shape(row[2]) for row in self._rows(query, shape.c.document, keys)}

    def bone_names(self, keys: Sequence[int]) -> dict[tuple[int, int], str]:
        """The name of each bone by (document, number)."""
        query = select(bone.c.document, bone.c.bone, bone.c.name).where(self._tx.valid(bone))
        return {(row[0], row[1]): row[2] for row in self._rows(query, bone.c.document, keys)}

    def used_bone_names(self, keys: Sequence[int]) -> list[str]:
        """The names of all bones of the documents."""
        query = select(bone.c.name).where(self._tx.valid(bone)).distinct()
        return sorted({row[0] for row in self._rows(query, bone.c.document, keys)})

    def used_motion_names(self, keys: Sequence[int]) -> list[str]:
        """The names of all spans of the documents."""
        query = select(span.c.name).where(self._tx.valid(span)).distinct()
        return sorted({row[0] for row in self._rows(query, span.c.document, keys)})

    def bones_named(self, name: str, keys: Sequence[int]) -> dict[int, int]:
        """The number of the bone of this name in each of the documents that has one."""
        query = select(bone.c.document, bone.c.bone).where(bone.c.name == name, self._tx.valid(bone))
        return {row[0]: row[1] for row in self._rows(query, bone.c.document, keys)}

    def spans(self, keys: Sequence[int], frames: tuple[int, int] | None = None) -> list[Any]:
        """Rows (document, first, last, name) in order of document and of the motion_names in a frame.

        frames: only spans that touch these, first to last.
        """
        query = select(span.c.document, span.c.first, span.c.last, span.c.name)
        if frames is not None:
            query = query.where(span.c.first <= frames[1], span.c.last >= frames[0])
        query = query.where(self._tx.valid(span)).order_by(span.c.document, span.c.rank, span.c.id)
        return list(self._rows(query, span.c.document, keys))

    def frame_runs(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, first, count, first_id, step, texts) in order of document and position."""
        run = frame_run.c
        query = select(run.document, run.first, run.count, run.first_id, run.step, run.texts)
        query = query.where(self._tx.valid(frame_run)).order_by(run.document, run.first)
        return list(self._rows(query, run.document, keys))

    def headers(self, keys: Sequence[int]) -> dict[int, Element]:
        """The `header` element of each document."""
        query = select(header.c.document, header.c.level, header.c.tag, header.c.attributes, header.c.text)
        query = query.where(self._tx.valid(header)).order_by(header.c.document, header.c.pre)
        rows: dict[int, list[Any]] = {}
        for row in self._rows(query, header.c.document, keys):
            rows.setdefault(row.document, []).append(row)
        return {key: to_elements(found)[0] for key, found in rows.items()}

    def skeletons(self, keys: Sequence[int]) -> dict[int, list[Element]]:
        """The `root` element, where there is one, and the `skeleton` element of each skeleton."""
        element = skeleton_element.c
        query = select(element.skeleton, element.level, element.tag, element.attributes, element.text)
        rows: dict[int, list[Any]] = {}
        for row in self._rows(query.order_by(element.skeleton, element.pre), element.skeleton, keys):
            rows.setdefault(row.skeleton, []).append(row)
        return {key: to_elements(found) for key, found in rows.items()}

    def tracks(
        self,
        keys: Sequence[int],
        bones: Sequence[int] | None,
        chunks: tuple[int, int] | None = None,
        bounds: Sequence[tuple[str, int, float]] = (),
    ) -> Iterator[Any]:
        """Rows (document, chunk, bone, from_commit, channels) of the tracks of some bones or all.

        chunks: first and last. bounds: ("min" | "max", channel, bound): by their zone maps, only tracks whose least
        sample is not above the bound, or greatest not below it.
        """
        query = select(track.c.document, track.c.chunk, track.c.bone, track.c.from_commit, track.c.channels)
        return self._rows(self._of_bones(_within(query, bounds), bones, chunks), track.c.document, keys)

    def tracks_named(
        self,
        name: str,
        keys: Sequence[int] | None,
        chunks: tuple[int, int] | None = None,
        bounds: Sequence[tuple[str, int, float]] = (),
    ) -> Iterator[Any]:
        """As `tracks`, of the bones of a name, whatever their numbers. keys: None for all documents there are."""
        query: Select[Any] = (
            select(track.c.document, track.c.chunk, track.c.bone, track.c.from_commit, track.c.channels)
            .select_from(bone)
            .join(track, and_(track.c.document == bone.c.document, track.c.bone == bone.c.bone))
            .where(bone.c.name == name, self._tx.valid(bone))
        )
        query = self._of_bones(_within(query, bounds), None, chunks)
        return (
            iter(self._tx.connection.execute(query).all()) if keys is None else self._rows(query, bone.c.document, keys)
        )

    def track_data(self, keys: Sequence[int], bones: Sequence[int], chunks: tuple[int, int]) -> Iterator[Any]:
        """Rows (document, chunk, bone, from_commit, channels, codec, data)."""
        query = select(
            track.c.document,
            track.c.chunk,
            track.c.bone,
            track.c.from_commit,
            track.c.channels,
            track.c.codec,
            track.c.data,
        )
        return self._rows(self._of_bones(query, bones, chunks), track.c.document, keys)

    def _of_bones(self, query: Select[Any], bones: Sequence[int] | None, chunks: tuple[int, int] | None) -> Select[Any]:
        query = query.where(self._tx.valid(track))
        if bones is not None:
            query = query.where(track.c.bone == bones[0] if len(bones) == 1 else track.c.bone.in_(bones))
        if chunks is not None:
            query = query.where(track.c.chunk >= chunks[0], track.c.chunk <= chunks[1])
        return query

    def _rows(self, query: Select[Any], column: Any, keys: Sequence[int]) -> Iterator[Any]:
        for start in range(0, len(keys), KEYS_AT_A_TIME):
            some = list(keys[start : start + KEYS_AT_A_TIME])
            narrowed = query.where(column == some[0] if len(some) == 1 else column.in_(some))
            for part in self._tx.connection.execute(narrowed).partitions(ROWS_AT_A_TIME):
                yield from part


def _within(query: Select[Any], bounds: Sequence[tuple[str, int, float]]) -> Select[Any]:
    for end, channel, bound in bounds:
        zone = track.c[f"{end}_{CHANNELS[channel]}"]
        query = query.where(zone >= bound if end == "max" else zone <= bound)
    return query
