"""ASF and AMC: Acclaim's skeleton and motion, two files.

Source: M. Meredith and S. Maddock, "Motion Capture File Formats Explained" (University of Sheffield, CS-01-11, 2001);
this program's reading of it is in docs/formats/asf-amc.md.

An ASF alone is a clip without frames. AMC states no frame rate; it stays unknown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import BinaryIO

import numpy as np

from mcml.errors import FormatError, Notice, Place
from mcml.formats.asf_amc.skeleton import read_asf
from mcml.formats.asf_amc.writer import write_amc, write_asf
from mcml.formats.format import FileKind, Limits, ReadOptions, SourceFile, need_convention
from mcml.formats.text.frame_rows import FrameRows, RowLayout, note_comments
from mcml.formats.text.lines import BLANKS, Encoding, Lines, detect_encoding
from mcml.formats.text.number_text import detect_style
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart
from mcml.motion.skeleton import CHANNEL_INDEX, Convention, Skeleton

SAMPLE_BYTES = 1 << 16
_OPENING = re.compile(rb"[ \t]*([+-]?[0-9]+)[ \t]*")
_WRONG_ASF = "Is it the wrong ASF for this AMC?"
_THREE_VALUES = (
    "Programs write so with :FORCE-ALL-JOINTS-BE-3DOF. Repair it: `stated-dof` keeps the values of the ASF's dof, "
    "`three-dof` lets these bones turn about all three axes."
)


class AsfAmc:
    """The format `asf-amc`; see `mcml.formats.format.Format`."""

    name = "asf-amc"
    title = "Acclaim ASF/AMC"
    parts = (FileKind("asf", (".asf", ".ast"), "Skeleton"), FileKind("amc", (".amc",), "Motion"))
    convention = Convention.FIXED
    media_type = "text/plain"
    label = "ASF/AMC"
    bodies, markers = True, False
    needs = frozenset[str]()
    assumes = ""
    states = frozenset[str]()

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        """ASF by its sections, AMC by its flags; only comments or numbers: by the name."""
        lines = [line.strip().lower() for line in re.split(rb"[\r\n]+", first_bytes.removeprefix(b"\xef\xbb\xbf"))]
        for line in lines:
            if line.startswith((b":version", b":units", b":root", b":bonedata", b":hierarchy", b":documentation")):
                return "asf"
            if line.startswith((b":fully-specified", b":degrees", b":radians")):
                return "amc"
            if _OPENING.fullmatch(line):
                return "amc" if name.lower().endswith(".amc") else None
        stated = next((part.name for part in self.parts if name.lower().endswith(part.extensions)), None)
        first = next((line for line in lines if line), b"")
        return stated if first[:1] in (b"#", b":") else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        if "asf" not in files:
            name = files["amc"].name if "amc" in files else None
            raise FormatError("AMC needs its ASF skeleton", at=Place(file=name), remedy="Send the .asf file too.")
        notices: list[Notice] = []
        asf = files["asf"]
        with asf.blamed():
            encoding = detect_encoding(asf.stream, options.encoding)
            notices += encoding.notices
            skeleton_file = read_asf(asf.stream, encoding, options.limits, notices)
        part = SourcePart(
            part="asf",
            name=_base(asf.name),
            encoding=encoding.codec,
            keywords=tuple(skeleton_file.keywords),
            comments=tuple(skeleton_file.comments),
            sections=tuple(skeleton_file.sections),
        )
        head = ClipHead("asf-amc", skeleton_file.skeleton, skeleton_file.fields, sources=(part,))
        if "amc" not in files:
            return ClipStream(head, lambda: iter(()), 0, notices)
        notices.append(Notice("note", "AMC states no frame rate; CMU and HDM05 record at 120 frames a second"))
        return _read_amc(head, files["amc"], options, notices)

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_convention(clip.head.skeleton, self.convention, self.title)
        return write_asf(clip) if part == "asf" else write_amc(clip)


def _angles(head: ClipHead) -> str:
    """Return the unit of angles that is assumed for an AMC without its flag."""
    stated = head.fields.get("units_angle", "")
    unit = "radians" if stated.strip().lower().startswith("rad") else "degrees"
    return f"its angles count as {unit}, {'the unit of the ASF' if stated else 'since the ASF states no unit either'}"


def _base(name: str) -> str:
    return name.rsplit("/", 1)[-1]


def _read_amc(head: ClipHead, file: SourceFile, options: ReadOptions, notices: list[Notice]) -> ClipStream:
    stream = file.stream
    with file.blamed():
        encoding = detect_encoding(stream, options.encoding)
        notices += encoding.notices
        flags, comments, start = _read_amc_head(stream, encoding, options.limits)
    if not any(flag.lower() in (":degrees", ":radians") for flag in flags):
        notices.append(Notice("guess", f"the AMC says neither :DEGREES nor :RADIANS; {_angles(head)}"))
    stream.seek(start)
    sample = b" ".join(re.findall(rb"(?<=\s)[+-]?[.0-9][^\s]*", stream.read(SAMPLE_BYTES))[:-1])
    part = SourcePart(
        part="amc", name=_base(file.name), encoding=encoding.codec, flags=tuple(flags), comments=tuple(comments)
    )
    head = ClipHead(
        head.format,
        head.skeleton,
        head.fields,
        number_style=detect_style(sample),
        sources=(*head.sources, part),
    )
    full = any(flag.lower() == ":fully-specified" for flag in flags)
    rows = FrameRows(stream, start, _layout(head.skeleton, encoding), encoding.start)

    def blocks() -> Iterator[FrameBlock]:
        watch = _Watch(head.skeleton, full, notices)
        with file.blamed():
            for block in rows.blocks():
                options.limits.check_size(watch.frames + len(block), len(block.columns))
                watch.look(block)
                yield block
        watch.report()
        note_comments(rows, notices)

    return ClipStream(head, blocks, None, notices)


def _read_amc_head(stream: BinaryIO, encoding: Encoding, limits: Limits) -> tuple[list[str], list[str], int]:
    """(flags, comments, byte offset of the first frame)."""
    flags: list[str] = []
    comments: list[str] = []
    lines = Lines(stream, encoding)
    kept = 0
    while (line := lines.next()) is not None:
        text, sign, comment = line.text.partition("#")
        kept += len(line.text) + 64 if line.text else 0
        limits.check_text(kept, line.at())
        text = text.strip(BLANKS)
        if re.fullmatch(r"[+-]?[0-9]+", text, re.ASCII):
            return flags, comments, line.start
        if sign:
            comments.append((sign + comment).rstrip(BLANKS))
        if text.startswith(":"):
            flags.append(text)
        elif text:
            raise FormatError(f"expected a frame number, found {text[:40]!r}", at=line.at(1))
    raise FormatError("the AMC holds no frame", at=lines.here, remedy="The file was cut off; send it whole.")


def _layout(skeleton: Skeleton, encoding: Encoding) -> RowLayout:
    codec = "utf-8" if encoding.codec == "utf-8-sig" else encoding.codec
    joints = {joint.source_name.encode(codec, errors="replace"): index for index, joint in enumerate(skeleton.joints)}
    channels = {
        name: tuple(CHANNEL_INDEX[channel] for channel in skeleton.joints[index].channels)
        for name, index in joints.items()
    }
    return RowLayout(_OPENING, 1, joints, channels, True, "ASF", _WRONG_ASF, codec, _THREE_VALUES)


class _Watch:
    """Observes the frames while they are read: gaps in the numbers, missing bones."""

    def __init__(self, skeleton: Skeleton, full: bool, notices: list[Notice]) -> None:
        self.frames = 0
        self._last: int | None = None
        self._gap: tuple[int, int] | None = None
        self._absent = 0
        self._full = full
        self._moving = {index for index, joint in enumerate(skeleton.joints) if joint.channels}
        self._notices = notices

    def look(self, block: FrameBlock) -> None:
        ids = block.ids
        if not isinstance(ids, list):
            steps = np.diff(ids, prepend=ids[0] - 1 if self._last is None else self._last)
            odd = np.flatnonzero(steps != 1)
            if len(odd) and self._gap is None:
                self._gap = (int(ids[odd[0]] - steps[odd[0]]), int(ids[odd[0]]))
            self._last = int(ids[-1])
        lacking = np.array([bool(self._moving - {joint for joint, _ in shape}) for shape in block.shapes])
        shape_of = np.zeros(len(block), dtype=np.intp) if block.shape_of is None else block.shape_of
        self._absent += int(lacking[shape_of].sum())
        self.frames += len(block)

    def report(self) -> None:
        found = []
        if self._gap is not None:
            found.append(f"frame numbers do not rise by one: {self._gap[1]} follows {self._gap[0]}")
        if self._absent:
            states = ", though the file says :FULLY-SPECIFIED" if self._full else ""
            found.append(f"{self._absent} frames leave out bones that move{states}; such a bone keeps its last value")
        for what in found:
            notice = Notice("warning", what)
            if notice not in self._notices:
                self._notices.append(notice)
