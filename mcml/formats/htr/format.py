"""HTR and HTR2: Motion Analysis' hierarchical translation and rotation.

Source: M. Meredith and S. Maddock, "Motion Capture File Formats Explained" (University of Sheffield, CS-01-11, 2001);
this program's reading of it is in docs/formats/htr.md.

Version 1 lists all frames of a segment, then those of the next; version 2 (HTR2) lists frame by frame. A clip leaves
in the version it came in. GTR, the same layout with global data and no hierarchy, is refused.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from mcml.errors import FormatError, Notice
from mcml.formats.format import FileKind, ReadOptions, SourceFile, need_convention
from mcml.formats.htr.head import CHANNELS, HtrHead, read_head
from mcml.formats.htr.segments import Segments, index_segments, missing_lexeme, plain_ids
from mcml.formats.htr.writer import write_htr
from mcml.formats.text.frame_rows import FrameRows, RowLayout, note_comments
from mcml.formats.text.lines import Encoding, blocks_of, detect_encoding
from mcml.formats.text.number_text import detect_style
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, Shape, SourcePart, full_shape
from mcml.motion.skeleton import CHANNEL_INDEX, Convention, Skeleton

MISSING = 999999.0
"""A value at least this large, of either sign, marks a missing sample."""

_DEFAULT_LEXEME = "9999999"
_OPENING = re.compile(rb"[ \t]*Frame[ \t]+([0-9]+)[ \t]*:?[ \t]*", re.IGNORECASE)
_END = re.compile(rb"(?:^|(?<=[\r\n]))[ \t]*\[EndOfFile\]", re.IGNORECASE)
_NUMBERS = [CHANNEL_INDEX[channel] for channel in CHANNELS]


class Htr:
    """The format `htr`; see `mcml.formats.format.Format`."""

    name = "htr"
    title = "Motion Analysis HTR"
    parts = (FileKind("htr", (".htr", ".htr2"), "Skeleton and motion"),)
    convention = Convention.BASE
    media_type = "text/plain"
    label = "HTR"
    bodies, markers = True, False
    needs = frozenset[str]()
    assumes = ""
    states = frozenset({"unit", "up", "frame_time"})

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        for line in re.split(rb"[\r\n]+", first_bytes.removeprefix(b"\xef\xbb\xbf")):
            text = line.partition(b"#")[0].strip().lower()
            if text:
                return "htr" if text.startswith((b"[header]", b"[head]")) else None
        return "htr" if name.lower().endswith((".htr", ".htr2")) and first_bytes.lstrip()[:1] == b"#" else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["htr"]
        with file.blamed():
            return _read(file, options)

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_convention(clip.head.skeleton, self.convention, self.title)
        return write_htr(clip)


def _read(file: SourceFile, options: ReadOptions) -> ClipStream:
    stream = file.stream
    encoding = detect_encoding(stream, options.encoding)
    notices = list(encoding.notices)
    head = read_head(stream, encoding, options.limits, notices)
    columns = head.skeleton.columns()
    options.limits.check_size(head.frames, len(columns))
    comments = list(head.comments)
    if head.version == 1:
        index = index_segments(stream, head.data, encoding, options.limits)
        _check_index(head, set(index.spans))
        known = set(comments)
        comments += [comment for comment in index.comments if comment not in known]
        missing, has_end = index.missing, index.has_end
        if index.repeated:
            notices.append(
                Notice("warning", f"{index.repeated} segments occur again, as in concatenated clips: the first is read")
            )
        segments = Segments(stream, head.skeleton, index, head.frames, encoding.start)
        start = min((span[0] for span in index.spans.values()), default=head.data)
        source = _by_segment(segments, columns, notices)
    else:
        missing, has_end = _scan(file)
        start = head.data
        rows = FrameRows(stream, start, _layout(head.skeleton, encoding), encoding.start, _END)
        source = _by_frame(rows, head, notices)
    if not has_end:
        notices.append(Notice("warning", "no [EndOfFile]: the file may have been cut off"))
    stream.seek(start)
    sample = re.findall(rb"(?<=[\s])[+-]?[0-9]*\.[0-9]\S*", stream.read(1 << 16))[:-1]
    part = SourcePart(
        part="htr",
        name=file.name.rsplit("/", 1)[-1],
        encoding=encoding.codec,
        keywords=tuple(head.keywords),
        comments=tuple(comments),
        sections=tuple(head.unknown),
        missing=missing,
    )
    clip_head = ClipHead(
        "htr", head.skeleton, head.fields, number_style=detect_style(b" ".join(sample)), sources=(part,)
    )

    def blocks() -> Iterator[FrameBlock]:
        gaps = 0
        with file.blamed():
            for block in source():
                cleaned = _without_missing(block)
                gaps += cleaned is not block
                yield cleaned
        if gaps:
            notice = Notice("warning", f"values of {missing or _DEFAULT_LEXEME} say that a sample is missing")
            if notice not in notices:
                notices.append(notice)

    return ClipStream(clip_head, blocks, head.frames, notices)


def _check_index(head: HtrHead, found: set[str]) -> None:
    """Raises FormatError where the segments with motion are not those of the hierarchy."""
    for joint in head.skeleton.joints:
        if joint.source_name not in found:
            raise FormatError(
                f"segment {joint.source_name!r} has no motion: NumSegments says {len(head.skeleton)}, "
                f"{len(found)} follow",
                remedy="The file was cut off; send it whole.",
            )
    names = {joint.source_name for joint in head.skeleton.joints}
    for name in sorted(found - names):
        raise FormatError(f"section [{name[:60]}] is no segment of the hierarchy")


def _by_segment(
    segments: Segments, columns: tuple[tuple[int, int], ...], notices: list[Notice]
) -> Callable[[], Iterator[FrameBlock]]:
    shapes = (full_shape(columns),)

    def blocks() -> Iterator[FrameBlock]:
        for values, ids in segments.blocks(notices):
            yield FrameBlock(values, columns, shapes, plain_ids(ids))

    return blocks


def _by_frame(rows: FrameRows, head: HtrHead, notices: list[Notice]) -> Callable[[], Iterator[FrameBlock]]:
    def blocks() -> Iterator[FrameBlock]:
        done = 0
        for block in rows.blocks():
            for place, shape in enumerate(block.shapes):
                if len(shape) != len(head.skeleton):
                    first = 0 if block.shape_of is None else int(np.flatnonzero(block.shape_of == place)[0])
                    raise FormatError(
                        f"frame {block.ids[first]} has {len(shape)} rows, NumSegments says {len(head.skeleton)}",
                        remedy="Write a row for every segment.",
                    )
            done += len(block)
            if done > head.frames:
                break
            yield block
        if done != head.frames:
            found = f"more than {head.frames}" if done > head.frames else str(done)
            raise FormatError(
                f"the file has {found} frames, NumFrames says {head.frames}", remedy="The file may have been cut off."
            )
        note_comments(rows, notices)

    return blocks


def _scan(file: SourceFile) -> tuple[str, bool]:
    """(lexeme of missing values, whether the file has its end) of a frame-major file, in one pass."""
    missing, has_end, tail = "", False, b""
    for block in blocks_of(file.stream, 0, 1 << 20):
        text = tail + block
        missing = missing or missing_lexeme(text)
        has_end = has_end or (b"[" in text and _END.search(text) is not None)
        tail = text[-64:]
    return missing, has_end


def _layout(skeleton: Skeleton, encoding: Encoding) -> RowLayout:
    codec = "utf-8" if encoding.codec == "utf-8-sig" else encoding.codec
    joints = {joint.source_name.encode(codec, errors="replace"): index for index, joint in enumerate(skeleton.joints)}
    channels = dict.fromkeys(joints, tuple(_NUMBERS))
    return RowLayout(_OPENING, 2, joints, channels, False, "hierarchy", "Name every segment there.", codec)


def _without_missing(block: FrameBlock) -> FrameBlock:
    """The block with NaN and shapes for samples that the file marks as missing; the same block if there are none."""
    missing = np.abs(block.values) >= MISSING
    if not missing.any():
        return block
    values = np.where(missing, np.nan, block.values)
    patterns, pattern_of = np.unique(missing, axis=0, return_inverse=True)
    old_of = np.zeros(len(block), dtype=np.intp) if block.shape_of is None else block.shape_of
    place = {column: index for index, column in enumerate(block.columns)}
    shapes: dict[Shape, int] = {}
    known: dict[tuple[int, int], int] = {}
    shape_of = np.empty(len(block), dtype=np.intp)
    for frame, pair in enumerate(zip(old_of.tolist(), pattern_of.reshape(-1).tolist(), strict=True)):
        if pair not in known:
            gone = patterns[pair[1]]
            shape = tuple(
                (joint, sum(1 << c for c in range(8) if bits >> c & 1 and not gone[place[joint, c]]))
                for joint, bits in block.shapes[pair[0]]
            )
            known[pair] = shapes.setdefault(shape, len(shapes))
        shape_of[frame] = known[pair]
    return FrameBlock(values, block.columns, tuple(shapes), block.ids, shape_of, block.motion_names)
