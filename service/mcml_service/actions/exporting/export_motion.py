"""Export: a stored document as files of any format that can hold it."""

from __future__ import annotations

import io
import math
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import orjson

from mcml.errors import ConversionError, Notice
from mcml.files.check_names import check_frame_time
from mcml.files.presets import Preset, choose_format, choose_shape, fit_shape
from mcml.files.reshape_clip import Reshaping, fit_height, need_stated_facts, reshape
from mcml.files.targets import check_character, convert_clip, find_target, part_without_frames
from mcml.files.wear_character import OWN
from mcml.formats import FORMATS, READERS, WRITERS
from mcml.formats.analog_files import analog_part, channels_reader
from mcml.formats.format import SourceFile, note
from mcml.language.elements import from_head, refresh_counts
from mcml.language.writer import write_document
from mcml.motion.clip import ClipStream, Original
from mcml.motion.conventions.convert import scale, turn_up
from mcml.motion.skeleton import CHANNELS
from mcml.motion.units import metres_per_unit
from mcml_service.actions.exporting.wear_character import At, wear_stored
from mcml_service.cells import safe_cell
from mcml_service.clips.bodies import read_bodies
from mcml_service.clips.read_clip import StoredClip, read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

ORIGINAL = "original"
"""The name of the form in which the uploaded files leave as they came."""
WITH_ORIGINAL = frozenset({"c3d", "opensim"})
"""Formats that take data from the uploaded file."""
WITH_REFERENCE = frozenset({"mot", "sto"})
"""Formats of angles, which start from the reference pose of the skeleton."""


@dataclass(frozen=True)
class ExportOptions:
    """format: a catalogue name, one part of a format ("asf", "amc"), "mcml", "csv" or "original".

    preset: the program that the file is for; it decides what the other options leave open, also the format None.
    names: table of joint names ("mcml", "bvh1", …) instead of the source's. unit, up: turn and scale to these; the
    document must state its own. fps, scale, height, in_place: at another frame rate, with all
    lengths multiplied or the body of a height in metres, without travel. guesses: False refuses
    where a format needs a unit or an up axis that the document does not state. frame_time: seconds of a frame, for a
    document that does not state them. original: False writes the file from the elements even where the kept bytes would
    do. raw: CSV has also texts that spreadsheets take for formulas as they are. character: a body with a skin instead
    of bones, in glTF and USD: "own" for this project's figure, or the id of a document with a character.
    """

    format: str | None
    first: int = 1
    last: int | None = None
    names: str | None = None
    unit: str | None = None
    up: str | None = None
    pretty: bool = False
    original: bool = True
    frame_time: str | float | None = None
    raw: bool = False
    fps: float | None = None
    scale: float | None = None
    height: float | None = None
    in_place: bool = False
    guesses: bool = True
    character: str | None = None
    preset: Preset | None = None

    @property
    def whole(self) -> bool:
        stated = self.names or self.unit or self.up or self.frame_time or self.preset or self.character
        return self.first == 1 and self.last is None and not stated and self.reshaping == Reshaping()

    @property
    def reshaping(self) -> Reshaping:
        """The changes that are asked for; the range is read from the store."""
        return Reshaping(in_place=self.in_place, fps=self.fps, scale=self.scale, height=self.height)


@dataclass
class Export:
    """One exported file.

    notices: losses of the format, complete once `content` was read to the end. size: bytes, of an uploaded file.
    """

    file_name: str
    media_type: str
    content: Iterator[bytes]
    notices: list[Notice] = field(default_factory=list)
    size: int | None = None


def export_document(
    tx: Transaction, stored: StoredDocument, options: ExportOptions, newest: Transaction | None = None
) -> Export:
    """The document as one file (several parts: a zip). Lives as long as the transaction.

    newest: to read a character with, where `tx` reads an older revision. Raises UnsupportedError for an unknown format,
    ConversionError where the format cannot hold the motion.
    """
    if options.preset is not None:
        skeleton = read_clip(tx, stored).clip.head.skeleton
        stated = choose_format(options.preset, options.format, character=options.character is not None)
        shape = choose_shape(options.preset, skeleton, stated)
        options = replace(options, format=shape.format, fps=options.fps or shape.fps)
    if options.format == ORIGINAL:
        return _export_original(tx, stored)
    name, part = find_target(options.format or "")
    if options.character is not None:
        check_character(name)
    part = part_without_frames(name) if stored.frames == 0 and part is None else part
    stem = file_stem(stored.name)
    if options.original and options.whole and stored.intact and stored.format == name and name in READERS:
        kept = _read_upload(tx, stored, part)
        # A format that is read in more forms than it is written in: glTF as text, say.
        if kept is not None and (name in FORMATS or kept.file_name.lower().endswith(_endings(name))):
            return kept
    source = _add_frame_time(read_clip(tx, stored, first=options.first, last=options.last), options.frame_time)
    if name in WITH_ORIGINAL and analog_part(source.clip.head) is not None:
        source = replace(source, clip=_add_original(tx, stored, source.clip))
    if options.character not in (None, OWN):
        readable = newest or tx
        character = readable.documents.get(options.character)
        source = wear_stored(At(tx, stored), source, At(readable, character))
    elif options.character == OWN:
        source = replace(source, clip=replace(source.clip, character=True))
    if options.reshaping != Reshaping():
        up = None
        if options.in_place and options.character in (None, OWN):
            up = read_bodies(tx, tx.columns.documents([stored.key]))[stored.key].calibration.up
        clip = reshape(source.clip, options.reshaping, up)
        if name in ("mcml", "csv"):
            clip = fit_height(clip, options.height, guesses=options.guesses)
        source = replace(source, clip=clip, document=refresh_counts(from_head(clip.head), clip.frames or 0))
    if name == "mcml":
        content = write_document(
            source.document, source.clip.frames or 0, source.clip.head.frame_time, source.clip.blocks(), source.names,
            pretty=options.pretty,
        )  # fmt: skip
        return Export(f"{stem}.mcml", "application/xml", content)
    if name == "csv":
        return Export(
            f"{stem}.csv",
            "text/csv; charset=utf-8",
            _csv(source, _columns(tx, source), str if options.raw else safe_cell),
        )
    clip = _convert(source, name, options)
    if name in WITH_REFERENCE:
        start = read_bodies(tx, tx.columns.documents([stored.key]))[stored.key].calibration.start
        clip = clip.with_head(replace(clip.head, reference=start))
    parts = [item.name for item in WRITERS[name].parts]
    if part is None:
        files = {f"{stem}{_extension(name, item)}": partial(WRITERS[name].write, clip, item) for item in parts}
        return Export(f"{stem}.zip", "application/zip", zip_files(files.items()), clip.notices)
    content = WRITERS[name].write(clip, part)
    return Export(f"{stem}{_extension(name, part)}", WRITERS[name].media_type, content, clip.notices)


def _endings(name: str) -> tuple[str, ...]:
    """The endings of the files of a format that is written."""
    return tuple(ending for part in WRITERS[name].parts for ending in part.extensions)


def _export_original(tx: Transaction, stored: StoredDocument) -> Export:
    """The files as they were uploaded, without later edits. ConversionError where none are kept."""
    kept = None if stored.format == "mcml" else _read_upload(tx, stored, None)
    if kept is None:
        raise ConversionError(
            "No uploaded file of this document is kept.", remedy="Export it in a format, such as mcml or bvh."
        )
    return kept


def skeleton_file(tx: Transaction, stored: StoredDocument) -> SourceFile:
    """The ASF of a stored document, as a file that an AMC can be read with."""
    export = export_document(tx, stored, ExportOptions("asf", last=0 if stored.frames == 0 else 1, first=1))
    kept = _read_upload(tx, stored, "asf") if stored.intact and stored.format == "asf-amc" else None
    chosen = kept or export
    return SourceFile(chosen.file_name, io.BytesIO(b"".join(chosen.content)))


def _read_upload(tx: Transaction, stored: StoredDocument, part: str | None) -> Export | None:
    """The bytes of the upload, None where they are not kept."""
    uploads = tx.uploads.of(stored.key)
    if part is not None:
        chosen = [upload for upload in uploads if upload.part.partition("#")[0] == part]
        content = tx.uploads.read(stored.key, chosen[0].part) if chosen else None
        if content is None:
            return None
        size = chosen[0].size
        return Export(chosen[0].file_name, READERS[stored.format].media_type, content, size=size)
    if len(uploads) < len(READERS[stored.format].parts):
        return None
    if len(uploads) == 1:
        return _read_upload(tx, stored, uploads[0].part.partition("#")[0])

    def opener(name: str) -> Callable[[], Iterator[bytes]]:
        return lambda: tx.uploads.read(stored.key, name) or iter(())

    files = {upload.file_name: opener(upload.part) for upload in uploads}
    return Export(f"{file_stem(stored.name)}.zip", "application/zip", zip_files(files.items()))


def _add_frame_time(source: StoredClip, frame_time: str | float | None) -> StoredClip:
    """The clip with a frame time, where it states none. Raises ConversionError where it states another."""
    if frame_time is None:
        return source
    frame_time = check_frame_time(frame_time)
    head = source.clip.head
    stated = head.seconds_per_frame()
    if stated is not None and not math.isclose(stated, float(frame_time), rel_tol=1e-6):
        raise ConversionError(
            f"The document states its frame time, {stated:g} seconds, and `frame_time` says {frame_time}.",
            remedy="Leave `frame_time` out, or change what the document states: mcml set ID --frame-time SECONDS.",
        )
    return replace(source, clip=source.clip.with_head(replace(head, frame_time=frame_time)))


def _add_original(tx: Transaction, stored: StoredDocument, clip: ClipStream) -> ClipStream:
    """The clip with the file of its document, whose analog channels and force plates the document does not have."""
    stream = tx.uploads.open(stored.key, analog_part(clip.head) or "")
    if stream is None:
        note(
            clip.notices, "warning", "the uploaded file is not kept: any analog channels and force plates are left out"
        )
        return clip
    return replace(clip, original=Original(channels_reader(clip.head, stream)))


def _convert(source: StoredClip, name: str, options: ExportOptions) -> ClipStream:
    clip = source.clip
    if options.unit:
        stated = metres_per_unit(_read_fact(clip, "calibration_unit", "length unit", "unit"))
        clip = scale(clip, stated / metres_per_unit(options.unit), unit=options.unit)
    if options.up:
        clip = turn_up(clip, _read_fact(clip, "global_axis_of_gravity", "up axis", "up").upper(), options.up.upper())
    if options.preset is not None:
        shape = choose_shape(options.preset, clip.head.skeleton, options.format)
        # The user's own unit and axis win.
        left = replace(shape, unit=None if options.unit else shape.unit, up=None if options.up else shape.up)
        clip = fit_shape(clip, left, options.preset, guesses=options.guesses)
    clip = fit_height(clip, options.height, guesses=options.guesses)
    if not options.guesses:
        need_stated_facts(clip.head, name)
    return convert_clip(clip, name, options.names)


def _read_fact(clip: ClipStream, field: str, what: str, parameter: str) -> str:
    """A fact of the header that a change of units or axes starts from. Raises ConversionError if it is not stated."""
    value = clip.head.fields.get(field)
    if not value:
        raise ConversionError(
            f"The document states no {what}, so it cannot be changed to another.",
            remedy=f"State it once: mcml set ID --{parameter}, or PATCH the document with `{parameter}`.",
        )
    return value


def _columns(tx: Transaction, source: StoredClip) -> list[tuple[int, int]]:
    """Return (joint, channel) of every channel in a frame: those of the skeleton, then those added by edits."""
    bones = tx.heads.bone_names(source.stored.key)
    joints = {name: joint for joint, name in enumerate(source.names)}
    columns = dict.fromkeys(source.clip.head.skeleton.columns())
    for shape in tx.tracks.shapes_in_use(source.stored.key):
        for bone, bits in shape:
            columns.update(
                {(joints[bones[bone]], channel): None for channel in range(len(CHANNELS)) if bits >> channel & 1}
            )
    return list(columns)


def _csv(source: StoredClip, columns: list[tuple[int, int]], shown: Callable[[str], str]) -> Iterator[bytes]:
    """Write frames as rows: position, id, time, then one column for each channel, named bone.channel; an empty cell is
    missing. shown: returns the text of a cell.
    """
    seconds = source.clip.head.seconds_per_frame()
    position = source.first
    if seconds is not None and not math.isfinite(seconds * (position + (source.clip.frames or 0))):
        seconds = None
    names = [_cell(shown(f"{source.names[joint]}.{CHANNELS[channel]}")) for joint, channel in columns]
    yield (",".join(["frame", "id", "time", *names]) + "\n").encode()
    for block in source.clip.blocks():
        place = {column: index for index, column in enumerate(block.columns)}
        values = np.full((len(block), len(columns)), np.nan)
        known = [index for index, column in enumerate(columns) if column in place]
        values[:, known] = block.values[:, [place[columns[index]] for index in known]]
        rows = orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY)[2:-2].split(b"],[")
        ids = [_cell(shown(str(item))).encode() for item in block.ids]
        for row, frame_id in zip(rows, ids, strict=True):
            time = b"" if seconds is None else repr((position - 1) * seconds).encode()
            yield b"%d,%s,%s,%s\n" % (position, frame_id, time, row.replace(b"null", b""))
            position += 1


def _cell(text: str) -> str:
    """A text as a field of CSV (RFC 4180)."""
    return '"' + text.replace('"', '""') + '"' if re.search(r'[",\r\n]', text) else text


def zip_files(
    files: Iterable[tuple[str, Callable[[], Iterator[bytes | memoryview]]]], *, compress: bool = False
) -> Iterator[bytes]:
    """A zip of the files, streamed: each starts when the previous one is done.

    Files are compressed only on request; answers are.

    Times are fixed so that equal content gives equal bytes.
    """
    buffer = Tail()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in files:
            info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
            with archive.open(info, "w", force_zip64=True) as member:
                for block in content():
                    member.write(block)
                    yield from buffer.take_blocks()
    yield from buffer.take_blocks()


class Tail(io.RawIOBase):
    """A write-only stream that returns the bytes written since the last call."""

    def __init__(self) -> None:
        self._blocks: list[bytes] = []
        self._told = 0

    def writable(self) -> bool:
        return True

    def write(self, data: bytes) -> int:  # type: ignore[override]
        self._blocks.append(bytes(data))
        self._told += len(data)
        return len(data)

    def tell(self) -> int:
        return self._told

    def take_blocks(self) -> Iterator[bytes]:
        blocks, self._blocks = self._blocks, []
        yield from blocks


def file_stem(name: str) -> str:
    """A document's name as a file name: without characters that file systems refuse."""
    return re.sub(r'[\x00-\x1f<>:"/\\|?*]', "_", name).strip(". ")[:120] or "motion"


def _extension(name: str, part: str) -> str:
    return next(item.extensions[0] for item in WRITERS[name].parts if item.name == part)
