"""Read a clip, check it and convert it to rows: the part of an import that needs no store."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

from mcml.errors import DocumentError, Notice
from mcml.files.check_names import check_frame_time
from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.files.open_clip import OpenClip, offering, open_clip
from mcml.files.shared_skeleton import SharedSkeleton
from mcml.formats.text.number_text import decimals_of
from mcml.language import motion_names
from mcml.language.elements import Element
from mcml.motion.clip import ClipHead, ClipStream, Shape
from mcml_service.actions.reading.make_thumbnail import Thumbnail, poses_of, thumbnail_of
from mcml_service.settings import Settings
from mcml_service.storage.documents.encoding import ClipEncoder, TrackRow
from mcml_service.storage.documents.rows import SkeletonRows, skeleton_rows

Progress: TypeAlias = Callable[[str, int, int | None], None]
"""Called with a file name, frames done, and frames in all if known; may raise to stop the import."""


@dataclass(frozen=True)
class EncodedClip:
    """A clip that was read, without the rows of its tracks; plain data, possibly from another process.

    intact: whether the uploaded file still equals the document. facts: the receipt. thumbnail: None if there is nothing
    to draw, or if the clip is so large that it is drawn on request.
    """

    header: Element
    version: str
    skeleton: SkeletonRows
    bones: list[str]
    frames: int
    frame_time: str | None
    intact: bool
    shapes: dict[Shape, int]
    shape_rows: list[dict[str, Any]]
    frame_runs: list[dict[str, Any]]
    spans: list[dict[str, Any]]
    facts: dict[str, Any]
    thumbnail: Thumbnail | None


def encode_clip(
    clip: Clip,
    options: ImportOptions,
    settings: Settings,
    encoder: ClipEncoder,
    keep: Callable[[Iterator[list[TrackRow]]], None],
    progress: Progress | None = None,
    made: OpenClip | None = None,
) -> EncodedClip:
    """Read, check and encode a clip. Raises what readers raise.

    keep: is given the track rows that are done while the clip is read; the others wait in the encoder. made: the clip
    that the files hold, where they were written here.
    """
    with offering(clip):
        opened = open_clip(clip, options, settings.file_limits) if made is None else made
        stream = opened.stream
        encoder.decimals = decimals_of(stream.head.number_style)
        poses = poses_of(stream.head)
        for block in stream.blocks():
            poses.add(block)
            keep(encoder.add(block))
            if progress is not None:
                progress(clip.name, encoder.frames, stream.frames)
    encoder.close()
    head = replace(stream.head, frame_time=_frame_time(stream, options))
    opened.check(encoder.shapes)
    _make_names_canonical(encoder, stream, options)
    _add_labels(encoder, options)
    forest = opened.document.children[1:]
    return EncodedClip(
        header=opened.document.children[0],
        version=opened.document.attributes.get("version", ""),
        skeleton=skeleton_rows(forest) if opened.shared is None else _make_rows_once(opened.shared),
        bones=list(head.skeleton.names),
        frames=encoder.frames,
        frame_time=head.frame_time,
        intact=_is_intact(head, options) and not opened.repaired,
        shapes=encoder.shapes,
        shape_rows=encoder.shape_rows,
        frame_runs=encoder.ids.rows,
        spans=encoder.spans.rows,
        facts=opened.receipt(head, encoder.frames),
        thumbnail=thumbnail_of(poses, head),
    )


_ROWS: WeakKeyDictionary[SharedSkeleton, SkeletonRows] = WeakKeyDictionary()


def _make_rows_once(shared: SharedSkeleton) -> SkeletonRows:
    """The rows of a skeleton, made once for the clips that share it."""
    if shared not in _ROWS:
        _ROWS[shared] = skeleton_rows(shared.elements)
    return _ROWS[shared]


def _frame_time(stream: ClipStream, options: ImportOptions) -> str | None:
    if options.frame_time is None:
        return stream.head.frame_time
    return check_frame_time(options.frame_time)


def _is_intact(head: ClipHead, options: ImportOptions) -> bool:
    # A stated frame time changes what BVH holds; AMC and HTR files have no place for it.
    return head.frame_time is None or options.frame_time is None or head.format != "bvh"


def _make_names_canonical(encoder: ClipEncoder, stream: ClipStream, options: ImportOptions) -> None:
    """Motion names that the document itself has are stored as labels are: canonically, and none impossible."""
    for row in encoder.spans.rows:
        source_name = row["name"]
        row["name"] = motion_names.canonical(source_name, strict=options.strict_names)
        if row["name"] != source_name:
            notice = Notice("note", f"motion name {source_name!r} is stored as {row['name']!r}")
            if notice not in stream.notices:
                stream.notices.append(notice)


def _add_labels(encoder: ClipEncoder, options: ImportOptions) -> None:
    for label in options.labels:
        name = motion_names.canonical(label.name, strict=options.strict_names)
        first = 1 if label.first is None else label.first
        last = encoder.frames if label.last is None else label.last
        if not 1 <= first <= last <= encoder.frames:
            raise DocumentError(
                f"The label {label.name!r} is on frames {first} to {last}, the clip has {encoder.frames}.",
                remedy="Give positions from 1 to the number of frames.",
            )
        overlapping = [row["rank"] for row in encoder.spans.rows if row["first"] <= last and row["last"] >= first]
        rank = max(overlapping, default=-1) + 1
        encoder.spans.rows.append({"name": name, "rank": rank, "first": first, "last": last})
