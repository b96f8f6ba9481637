"""A new document from frames of others: header, skeleton and motion may each come from another one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mcml.errors import DocumentError
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.edits.composing import Piece, compose
from mcml.motion.edits.layering import lay_over
from mcml.motion.edits.mirroring import mirrored
from mcml.motion.edits.resampling import resampled
from mcml.motion.edits.splicing import Placement
from mcml.motion.frames import eased, joined, rows_of
from mcml.motion.guesses import stated_up
from mcml.motion.pictures.figures import axis_of
from mcml.motion.retargeting.move_character import with_body
from mcml_schemas.compose import Composed, ComposedSeam, ComposedSegment, ComposeRequest, Layer, Segment
from mcml_schemas.querying.queries import QueryRequest, RunItem
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.composing.fit_skeleton import JointMapping, fit
from mcml_service.actions.composing.keep_mapping import mapping_of
from mcml_service.actions.editing.motion_processing import Whole, read_whole
from mcml_service.actions.importing.store_clip import store_stream
from mcml_service.actions.reading.preview_motion import Window, preview_motion
from mcml_service.clips.read_clip import read_clip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries

MOST_FRAMES = 1_000_000
"""Of a composed document: it is made in memory."""


@dataclass(frozen=True)
class _Source:
    """Frames of one document at one revision. segment: which one of the request they belong to. first: from 0."""

    segment: int
    stored: StoredDocument
    whole: Whole
    frame_time: float
    first: int
    mapping: JointMapping | None

    def __len__(self) -> int:
        return len(self.whole.block)

    @property
    def name(self) -> str:
        """The same for frames that may follow one another."""
        return f"{self.stored.uuid} {self.stored.revision}"


def compose_frames(
    database: Database,
    queries: Queries,
    settings: Settings,
    request: ComposeRequest,
    author: str,
    window: Window | None = None,
) -> Composed:
    """Make the document, or in a preview only describe it.

    Raises DocumentError if skeletons do not fit or a frame time is unknown, NotFoundError for missing frames.
    """
    segments = list(_resolve_segments(queries, request.segments))
    with database.read() as tx:
        sources = [_source(tx, request.project, number, segment) for number, segment in segments]
        body = _body(tx, request, sources[0])
        fitting = _Fitting(tx, body, request.project)
        blocks = fitting.all(sources, segments)
    head = body.head
    frame_time = sources[0].frame_time if request.rate is None else 1 / request.rate
    speeds = [segment.speed for _, segment in segments]
    seconds = sum(
        len(block) * source.frame_time / speed for block, source, speed in zip(blocks, sources, speeds, strict=True)
    )
    if seconds / frame_time > MOST_FRAMES:
        raise DocumentError(f"The document would have more than {MOST_FRAMES:,} frames.", remedy="Compose it in parts.")
    pieces = [
        Piece(
            block,
            source.frame_time / segment.speed,
            _name(source, segment),
            source.first,
            _placement(segment, body.up),
        )
        for block, source, (_, segment) in zip(blocks, sources, segments, strict=True)
    ]
    made = compose(
        head.skeleton,
        pieces,
        frame_time,
        transition=round(request.seconds / frame_time) if request.transition is None else request.transition,
        transitions=[segment.transition for _, segment in segments],
        style=request.style,
        styles=[segment.style for _, segment in segments],
        lengthen=request.lengthen,
        align=request.align,
        match_phase=request.match_phase,
        lock_feet=request.lock_feet,
        up=body.up,
        reading=body.reading,
    )
    block = made.block if request.labels else replace(made.block, motion_names=None)
    uuid = None
    if not request.preview:
        stream = ClipStream(_set_frame_time(head, frame_time, sources), lambda: iter([block]), len(block))
        provenance = {
            "analysis": "compose",
            "sources": [
                {"document": s.stored.uuid, "revision": s.stored.revision, "first": s.first + 1, "frames": len(b)}
                for s, b in zip(sources, blocks, strict=True)
            ],
            "parameters": request.model_dump(mode="json", exclude_defaults=True),
        }
        uuid = store_stream(
            database, stream, settings, name=request.name, project=request.project, author=author, provenance=provenance
        )
    return Composed(
        document=uuid,
        frames=len(block),
        seconds_per_frame=frame_time,
        segments=[
            _segment(sources[piece], first, last, round(start * frame_time / pieces[piece].frame_time))
            for piece, first, last, start in made.spans
        ],
        seams=[
            ComposedSeam(
                segment=sources[seam.piece].segment,
                first=seam.first + 1,
                transition=seam.frames,
                degrees=float(np.degrees(seam.turn)),
                shift=seam.shift.tolist(),
                root_step=seam.root_step,
                angle_step=seam.angle_step,
                jerk=seam.jerk,
                slide=seam.slide,
                locked=list(seam.locked),
                left_out=seam.left_out,
            )
            for seam in made.seams
        ],
        notices=[
            *_tell_guessed_up(body),
            *fitting.notices,
            *(notice.what for notice in made.shortfall.notices(head.skeleton)),
        ],
        motion=None if window is None else preview_motion(head, [block], window, frame_time),
    )


def _name(source: _Source, segment: Segment) -> str:
    """Return the name of the clip in which pieces are consecutive; none for changed segments."""
    changed = segment.layers or segment.mirror or segment.transition is not None or segment.style is not None
    return "" if changed else source.name


def _tell_guessed_up(body: Whole) -> list[str]:
    if stated_up(body.head) is not None or body.up == "Y":
        return []
    return [f"no document states the up axis; {body.up} is taken, along which the body stands"]


def _placement(segment: Segment, up: str) -> Placement | None:
    place = segment.place
    return None if place is None else Placement(axis_of(up), np.radians(place.degrees), np.array(place.shift))


def _segment(source: _Source, first: int, last: int, start: int) -> ComposedSegment:
    return ComposedSegment(
        segment=source.segment,
        first=first + 1,
        last=last + 1,
        document=source.stored.uuid,
        revision=source.stored.revision,
        source_first=source.first + start + 1,
    )


def _resolve_segments(queries: Queries, segments: list[Segment]) -> Iterator[tuple[int, Segment]]:
    """Segments with their numbers from 1; those by XPath as the runs that it finds."""
    for number, segment in enumerate(segments, 1):
        if segment.xpath is None:
            yield number, segment
            continue
        count, cursor = 0, None
        while True:
            where: dict[str, Any] = {"document": [segment.document] if segment.document else [], "as": "runs"}
            asked = QueryRequest(q=segment.xpath, project=segment.project, limit=1000, cursor=cursor, **where)
            answer = queries.answer(asked)
            for item in answer.items or ():
                if isinstance(item, RunItem):
                    count += 1
                    run = {"first": item.first, "last": item.last, "revision": item.revision}
                    yield number, segment.model_copy(update={"xpath": None, "document": item.document, **run})
            cursor = answer.next_cursor
            if cursor is None:
                break
        if not count:
            raise DocumentError(f"Segment {number}: the expression finds no frames.", remedy="Try it with GET /xpath.")


def _source(tx: Transaction, project: str, number: int, segment: Segment) -> _Source:
    assert segment.document is not None
    current = tx.documents.get(segment.document)
    then = tx if segment.revision is None else tx.at_commit(tx.documents.commit_of(current.key, segment.revision))
    stored = then.documents.get(segment.document)
    seconds = seconds_of(stored)
    whole = read_whole(then, stored, segment.first, segment.last)
    return _Source(number, stored, whole, seconds, segment.first - 1, mapping_of(tx, project, segment.mapping))


def _body(tx: Transaction, request: ComposeRequest, first: _Source) -> Whole:
    """Header of one document, skeleton and frames of another."""
    body = first.whole
    if request.skeleton is not None:
        body = read_whole(tx, tx.documents.get(request.skeleton), 1, 1)
    head = first.whole.head
    if request.header is not None:
        head = read_clip(tx, tx.documents.get(request.header), first=1, last=1).clip.head
    return body if head is body.head else replace(body, head=with_body(head, body.head))


def _set_frame_time(head: ClipHead, frame_time: float, sources: list[_Source]) -> ClipHead:
    """Set the frame time of the result in the head: with the source's text, if it is the same."""
    first = sources[0]
    fields = {name: text for name, text in head.fields.items() if name not in ("num_frames", "filename")}
    if frame_time == first.frame_time:
        own = first.whole.head
        fields |= {"dataframe_rate": own.fields["dataframe_rate"]} if "dataframe_rate" in own.fields else {}
        return replace(head, fields=fields, frame_time=first.stored.frame_time, sources=())
    if "dataframe_rate" in fields:
        fields["dataframe_rate"] = f"{1 / frame_time:.15g}"
    return replace(head, fields=fields, frame_time=repr(frame_time), sources=())


class _Fitting:
    """Brings frames onto the skeleton of the result."""

    def __init__(self, tx: Transaction, body: Whole, project: str) -> None:
        self._tx, self._body, self._project = tx, body, project
        self.notices: list[str] = []

    def all(self, sources: list[_Source], segments: list[tuple[int, Segment]]) -> list[FrameBlock]:
        """The frames of every source, with its layers."""
        alike: dict[tuple[str, JointMapping | None], list[int]] = {}
        for index, source in enumerate(sources):
            alike.setdefault((source.name, source.mapping), []).append(index)
        blocks = [source.whole.block for source in sources]
        for indices in alike.values():
            # At once, so that pieces of one clip are brought to another body in one way.
            first = sources[indices[0]]
            whole = replace(first.whole, block=joined(blocks[index] for index in indices))
            fitted = self._fit_skeleton(first.stored, whole, first.mapping, first.frame_time)
            ends = np.cumsum([len(sources[index]) for index in indices])
            for index, end in zip(indices, ends.tolist(), strict=True):
                blocks[index] = rows_of(fitted, end - len(sources[index]), end)
        for index, (source, (_, segment)) in enumerate(zip(sources, segments, strict=True)):
            for layer in segment.layers:
                blocks[index] = self._layer(source, blocks[index], layer)
            if segment.mirror:
                body = self._body
                blocks[index] = mirrored(body.head.skeleton, blocks[index], up=body.up, reading=body.reading).block
        return blocks

    def _fit_skeleton(
        self, stored: StoredDocument, whole: Whole, mapping: JointMapping | None, frame_time: float
    ) -> FrameBlock:
        fitted = fit(whole, self._body, mapping, frame_time)
        notices = [f"{stored.name}: {notice}" for notice in fitted.notices]
        self.notices += [notice for notice in notices if notice not in self.notices]
        return fitted.block

    def _layer(self, source: _Source, block: FrameBlock, layer: Layer) -> FrameBlock:
        skeleton, reading = self._body.head.skeleton, self._body.reading
        unknown = [bone for bone in layer.bones if bone not in skeleton.names]
        if unknown:
            raise DocumentError(f"The skeleton has no bone {unknown[0]!r}.", remedy="Name bones by their MCML names.")
        stored = self._tx.documents.get(layer.document)
        seconds = seconds_of(stored)
        whole = read_whole(self._tx, stored, layer.first, layer.last)
        other = self._fit_skeleton(stored, whole, mapping_of(self._tx, self._project, layer.mapping), seconds)
        if seconds != source.frame_time:
            other = resampled(skeleton, other, seconds, source.frame_time, reading).block
        begin = layer.at - 1
        if begin >= len(block):
            raise DocumentError(
                f"A layer begins at frame {layer.at} of a segment of {len(block)} frames.",
                remedy="Frames of the segment count from 1.",
            )
        count = min(len(block) - begin, len(other))
        strength = np.zeros(len(block))
        strength[begin : begin + count] = layer.strength * eased(count, 0, count - 1, layer.ease)
        joints = [skeleton.names.index(bone) for bone in layer.bones]
        return lay_over(skeleton, block, other, joints, strength, reading, begin).block
