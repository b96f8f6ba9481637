"""A new document from frames of others: header, skeleton and motion may each come from another one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from schemas.compose import Composed, ComposedSeam, ComposedSegment, ComposeRequest, Layer, Segment
from schemas.queries import QueryRequest, RunItem
from service.actions.read_clip import read_clip
from service.actions.reshape_motion import Whole, read_whole
from service.actions.store_clip import store_stream
from service.errors import DocumentError
from service.motion.clip import ClipHead, ClipStream, FrameBlock
from service.motion.composing import Piece, compose, layered
from service.motion.frames import eased
from service.motion.skeleton import Skeleton
from service.settings import Settings
from service.storage.database import Database, Transaction
from service.storage.documents import StoredDocument
from service.xpath.run import Queries

MOST_FRAMES = 1_000_000
"""Of a composed document: it is made in memory."""


@dataclass(frozen=True)
class _Source:
    """Frames of one document at one revision. segment: which one of the request they belong to."""

    segment: int
    stored: StoredDocument
    whole: Whole
    frame_time: float
    first: int

    @property
    def name(self) -> str:
        """The same for frames that may follow one another."""
        return f"{self.stored.uuid} {self.stored.revision}"


def compose_frames(
    database: Database, queries: Queries, settings: Settings, request: ComposeRequest, author: str
) -> Composed:
    """Make the document, or in a preview only say what it would be.

    Raises DocumentError where skeletons differ or a frame time is not known, NotFoundError for frames not there.
    """
    segments = list(_resolved(queries, request.segments))
    with database.read() as tx:
        sources = [_source(tx, number, segment) for number, segment in segments]
        head = _head(tx, request, sources[0])
        skeleton = head.skeleton
        blocks = [_on(tx, skeleton, source, segment) for source, (_, segment) in zip(sources, segments, strict=True)]
    frame_time = sources[0].frame_time if request.rate is None else 1 / request.rate
    seconds = sum(len(block) * source.frame_time for block, source in zip(blocks, sources, strict=True))
    if seconds / frame_time > MOST_FRAMES:
        raise DocumentError(f"The document would have more than {MOST_FRAMES:,} frames.", remedy="Compose it in parts.")
    pieces = [
        Piece(block, source.frame_time, "" if segment.layers else source.name, source.first)
        for block, source, (_, segment) in zip(blocks, sources, segments, strict=True)
    ]
    made = compose(
        skeleton,
        pieces,
        frame_time,
        transition=request.transition,
        style=request.style,
        lengthen=request.lengthen,
        align=request.align,
        up=sources[0].whole.up,
        reading=sources[0].whole.reading,
    )
    block = made.block if request.labels else replace(made.block, motion_names=None)
    uuid = None
    if not request.preview:
        stream = ClipStream(_timed(head, frame_time, sources), lambda: iter([block]), len(block))
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
        segments=[_segment(sources[piece], first, last) for piece, first, last in made.spans],
        seams=[
            ComposedSeam(
                segment=sources[seam.piece].segment,
                first=seam.first + 1,
                transition=seam.frames,
                degrees=float(np.degrees(seam.turn)),
                shift=seam.shift.tolist(),
                root_step=seam.root_step,
                angle_step=seam.angle_step,
            )
            for seam in made.seams
        ],
        notices=[notice.what for notice in made.shortfall.notices(skeleton)],
    )


def _segment(source: _Source, first: int, last: int) -> ComposedSegment:
    return ComposedSegment(
        segment=source.segment,
        first=first + 1,
        last=last + 1,
        document=source.stored.uuid,
        revision=source.stored.revision,
        source_first=source.first + 1,
    )


def _resolved(queries: Queries, segments: list[Segment]) -> Iterator[tuple[int, Segment]]:
    """Segments with their numbers from 1; those by XPath as the runs that it finds."""
    for number, segment in enumerate(segments, 1):
        if segment.xpath is None:
            yield number, segment
            continue
        found, cursor = 0, None
        while True:
            where: dict[str, Any] = {"document": [segment.document] if segment.document else [], "as": "runs"}
            asked = QueryRequest(q=segment.xpath, project=segment.project, limit=1000, cursor=cursor, **where)
            answer = queries.answer(asked)
            for item in answer.items or ():
                if isinstance(item, RunItem):
                    found += 1
                    run = {"first": item.first, "last": item.last, "revision": item.revision}
                    yield number, Segment(document=item.document, layers=segment.layers, **run)
            cursor = answer.next_cursor
            if cursor is None:
                break
        if not found:
            raise DocumentError(f"Segment {number}: the expression finds no frames.", remedy="Try it with GET /xpath.")


def _source(tx: Transaction, number: int, segment: Segment) -> _Source:
    assert segment.document is not None
    current = tx.documents.get(segment.document)
    then = tx if segment.revision is None else tx.at_commit(tx.documents.commit_of(current.key, segment.revision))
    stored = then.documents.get(segment.document)
    seconds = stored.seconds_per_frame
    if seconds is None:
        raise DocumentError(f"{stored.name} has no frame time.", remedy="State it: PATCH the document with frame_time.")
    whole = read_whole(then, stored, segment.first, segment.last)
    return _Source(number, stored, whole, seconds, segment.first - 1)


def _head(tx: Transaction, request: ComposeRequest, first: _Source) -> ClipHead:
    """Header of one document, skeleton of another."""
    head = first.whole.head
    if request.header is not None:
        other = _head_of(tx, request.header)
        head = replace(other, skeleton=head.skeleton)
    if request.skeleton is not None:
        head = replace(head, skeleton=_head_of(tx, request.skeleton).skeleton)
    return head


def _head_of(tx: Transaction, uuid: str) -> ClipHead:
    return read_clip(tx, tx.documents.get(uuid), first=1, last=1).clip.head


def _timed(head: ClipHead, frame_time: float, sources: list[_Source]) -> ClipHead:
    """The head at the frame time of the result: as it is written in the source, if it is still the same."""
    first = sources[0]
    fields = {name: text for name, text in head.fields.items() if name not in ("num_frames", "filename")}
    if frame_time == first.frame_time:
        own = first.whole.head
        fields |= {"dataframe_rate": own.fields["dataframe_rate"]} if "dataframe_rate" in own.fields else {}
        return replace(head, fields=fields, frame_time=first.stored.frame_time, sources=())
    if "dataframe_rate" in fields:
        fields["dataframe_rate"] = f"{1 / frame_time:.15g}"
    return replace(head, fields=fields, frame_time=repr(frame_time), sources=())


def _on(tx: Transaction, skeleton: Skeleton, source: _Source, segment: Segment) -> FrameBlock:
    """A segment's frames on the skeleton of the result, with its layers."""
    block = on_skeleton(skeleton, source.whole.head.skeleton, source.whole.block, source.stored.name)
    for layer in segment.layers:
        block = _layered(tx, skeleton, source, block, layer)
    return block


def _layered(tx: Transaction, skeleton: Skeleton, source: _Source, block: FrameBlock, layer: Layer) -> FrameBlock:
    stored = tx.documents.get(layer.document)
    over = read_whole(tx, stored, layer.first, layer.last)
    if stored.seconds_per_frame != source.frame_time:
        raise DocumentError(
            f"{stored.name} has another frame rate than {source.stored.name}.", remedy="Resample one of them first."
        )
    unknown = [bone for bone in layer.bones if bone not in skeleton.names]
    if unknown:
        raise DocumentError(f"The skeleton has no bone {unknown[0]!r}.", remedy="Name bones by their MCML names.")
    joints = [skeleton.names.index(bone) for bone in layer.bones]
    count = min(len(block), len(over.block))
    strength = np.zeros(len(block))
    strength[:count] = layer.strength * eased(count, 0, count - 1, layer.ease)
    other = on_skeleton(skeleton, over.head.skeleton, over.block, stored.name)
    return layered(skeleton, block, other, joints, strength, source.whole.reading).block


def on_skeleton(target: Skeleton, own: Skeleton, block: FrameBlock, name: str) -> FrameBlock:
    """Frames with joints as another skeleton numbers them. DocumentError unless both are the same body."""
    if own == target:
        return block
    place = {joint.name: index for index, joint in enumerate(target.joints)}
    for joint in own.joints:
        other = target.joints[place[joint.name]] if joint.name in place else None
        parents = (_parent(own, joint.parent), None if other is None else _parent(target, other.parent))
        same = other is not None and parents[0] == parents[1] and replace(joint, parent=0) == replace(other, parent=0)
        if not same or len(own) != len(target):
            raise DocumentError(
                f"{name}: {joint.name!r} is not the same bone as in the skeleton of the result.",
                remedy="Retarget it onto that skeleton first: POST /documents/{id}/retarget.",
            )
    number = [place[joint.name] for joint in own.joints]
    return replace(
        block,
        columns=tuple((number[joint], channel) for joint, channel in block.columns),
        shapes=tuple(tuple((number[joint], bits) for joint, bits in shape) for shape in block.shapes),
    )


def _parent(skeleton: Skeleton, index: int) -> str:
    return skeleton.joints[index].name if index >= 0 else ""
