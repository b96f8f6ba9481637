"""Rows of many documents at once, as queries over whole repositories need them: one statement, not one a document."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from sqlalchemy import Select, select

from service.storage.encoding import unpack_shape
from service.storage.rows import to_elements
from service.storage.tables import (
    bone,
    frame_run,
    header,
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


class Columns:
    def __init__(self, tx: Transaction) -> None:
        self._tx = tx

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

    def bones_named(self, name: str, keys: Sequence[int]) -> dict[int, int]:
        """The number of the bone of this name in each of the documents that has one."""
        query = select(bone.c.document, bone.c.bone).where(bone.c.name == name, self._tx.valid(bone))
        return {row[0]: row[1] for row in self._rows(query, bone.c.document, keys)}

    def spans(self, keys: Sequence[int]) -> list[Any]:
        """Rows (document, first, last, name) in order of document and of the motion_names in a frame."""
        query = select(span.c.document, span.c.first, span.c.last, span.c.name)
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
        bones: Sequence[int],
        chunks: tuple[int, int] | None = None,
        above: tuple[int, float] | None = None,
        below: tuple[int, float] | None = None,
    ) -> Iterator[Any]:
        """Rows (document, chunk, bone, channels, codec, data) of the tracks of some bones.

        chunks: first and last chunk. above, below: (channel, bound): only tracks that hold a greater or equal (less or
        equal) sample, by their zone maps.
        """
        columns = track.c
        query = select(
            columns.document, columns.chunk, columns.bone, columns.channels, columns.codec, columns.data
        ).where(self._tx.valid(track), columns.bone.in_(bones))
        if chunks is not None:
            query = query.where(columns.chunk >= chunks[0], columns.chunk <= chunks[1])
        if above is not None:
            query = query.where(_zone("max", above[0]) >= above[1])
        if below is not None:
            query = query.where(_zone("min", below[0]) <= below[1])
        return self._rows(query, columns.document, keys)

    def _rows(self, query: Select[Any], column: Any, keys: Sequence[int]) -> Iterator[Any]:
        for start in range(0, len(keys), KEYS_AT_A_TIME):
            some = list(keys[start : start + KEYS_AT_A_TIME])
            narrowed = query.where(column == some[0] if len(some) == 1 else column.in_(some))
            yield from self._tx.connection.execute(narrowed)


def _zone(end: str, channel: int) -> Any:
    from service.motion.skeleton import CHANNELS

    return track.c[f"{end}_{CHANNELS[channel]}"]
