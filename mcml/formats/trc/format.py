"""TRC: Motion Analysis' labelled points over time, as text.

Source: OpenSim documentation, Marker (.trc) Files; this program's reading of it is in docs/formats/trc.md.

Five head lines (file type, names of facts, facts, labels, axes), then a line for each frame: number, time, and x y z of
every marker between single tabs. An empty cell, or `nan`, is a sample that is missing. A table of forces may stand
beside it (`mcml.formats.trc.forces`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.format import FileKind, ReadOptions, SourceFile, need_convention, note
from mcml.formats.text.lines import Line, Lines, detect_encoding, shown
from mcml.formats.text.number_text import detect_style
from mcml.formats.text.numbers import is_number, is_whole
from mcml.formats.text.separators import tabbed
from mcml.formats.trc.columns import find_columns
from mcml.formats.trc.force_table import FramesOfTrial
from mcml.formats.trc.forces import PART as FORCES
from mcml.formats.trc.forces import describe_forces
from mcml.formats.trc.rows import Rows
from mcml.formats.trc.times import Times, decide_rate, first_time
from mcml.formats.trc.writer import write_trc
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart
from mcml.motion.markers import marker_skeleton
from mcml.motion.skeleton import Convention

_FACTS: Final = ("DataRate", "NumFrames", "NumMarkers", "Units")
_SAMPLE_BYTES: Final = 1 << 16


class Trc:
    """The format `trc`; see `mcml.formats.format.Format`."""

    name = "trc"
    title = "Motion Analysis TRC"
    parts = (FileKind("trc", (".trc",), "Markers"),)
    convention = Convention.MARKER
    media_type = "text/plain"
    label = "TRC"
    bodies, markers = False, True
    needs = frozenset({"frame_time", "unit"})
    assumes = ""
    states = frozenset({"unit", "frame_time"})

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        return "trc" if first_bytes.removeprefix(b"\xef\xbb\xbf").lstrip()[:12].lower() == b"pathfiletype" else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["trc"]
        with file.blamed():
            return _read(file, options, files.get(FORCES))

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_convention(clip.head.skeleton, self.convention, self.title)
        return write_trc(clip)


@dataclass(frozen=True)
class _Head:
    """file_type: cells of the first line. facts: names and texts of the second and third. labels: as written.

    axes: how many the fifth line names. data: byte offset of the first row.
    """

    file_type: list[str]
    facts: dict[str, str]
    labels: list[str]
    axes: int
    data: int


def _read(file: SourceFile, options: ReadOptions, forces: SourceFile | None) -> ClipStream:
    stream, limits = tabbed(file.stream), options.limits
    encoding = detect_encoding(stream, options.encoding)
    notices = list(encoding.notices)
    if stream is not file.stream:
        note(notices, "note", "cells are separated by commas or semicolons; they are read as if by tabs")
    head = _read_head(Lines(stream, encoding), notices)
    names, columns = find_columns(head.labels, head.facts, head.axes, _first_row(stream, head.data), limits, notices)
    skeleton = marker_skeleton(names)
    known = {name.lower(): text for name, text in head.facts.items()}
    frames = known.get("numframes", "")
    declared = int(frames) if is_whole(frames) and int(frames) >= 0 else None
    limits.check_size(declared or 0, 3 * len(names))
    rows = Rows(stream, head.data, skeleton, columns, encoding.start, declared, limits)
    times = rows.times()
    stated = known.get("datarate", "")
    rate = decide_rate(times, stated, is_number(stated) and float(stated) > 0, notices)
    fields = {"filetype": "PathFileType", "version": _cell(head.file_type, 1), "filename": _cell(head.file_type, 3)}
    fields |= {"dataframe_rate": rate} if rate else {}
    fields |= {"calibration_unit": known["units"]} if known.get("units") else {}
    sections = [("axes", _cell(head.file_type, 2))] if _cell(head.file_type, 2) else []
    known_facts = _FACTS if rate else _FACTS[1:]
    sections += [(name, text) for name, text in head.facts.items() if name not in known_facts]
    if len(times.seconds) and np.isfinite(times.seconds[0]):
        start = first_time(times, float(rate) if rate else None)
        sections.append(("Time", f"{times.decimals} {start!r}{_number(_first_row(stream, head.data))}"))
    part = SourcePart(
        part="trc",
        name=file.name.rsplit("/", 1)[-1],
        encoding=encoding.codec,
        keywords=tuple(head.facts),
        sections=tuple(sections),
        missing="",
    )
    beside = () if forces is None else _describe(forces, rows, times, rate, fields, notices)
    clip_head = ClipHead(
        "trc",
        skeleton,
        {name: text for name, text in fields.items() if text},
        number_style=_style(stream, head.data),
        sources=(part, *beside),
    )

    def blocks() -> Iterator[FrameBlock]:
        with file.blamed():
            yield from rows.blocks(notices)

    return ClipStream(clip_head, blocks, None, notices)


def _describe(
    file: SourceFile, rows: Rows, times: Times, rate: str | None, fields: Mapping[str, str], notices: list[Notice]
) -> tuple[SourcePart, ...]:
    """The table of forces as a part of the document; () with a warning where it cannot be used."""
    try:
        ids = np.concatenate([np.empty(0, np.int64), *(np.asarray(block.ids) for block in rows.blocks([]))])
        if rate is None or not len(ids) or not np.isfinite(times.seconds[0]):
            raise FormatError("the times of the frames are unknown")
        if not (np.diff(ids) == 1).all():
            raise FormatError("the numbers of the frames do not follow one another")
        unit = fields.get("calibration_unit", "")
        frames = FramesOfTrial(int(ids[0]), first_time(times, float(rate)), float(rate), len(ids), unit)
        return (describe_forces(file.stream, file.name.rsplit("/", 1)[-1], frames, notices),)
    except (FormatError, LimitError) as error:
        note(notices, "warning", f"forces of {file.name} are left out: {error}")
        return ()


def _read_head(lines: Lines, notices: list[Notice]) -> _Head:
    first = _need(lines, "the first line, PathFileType")
    if not first.text.lstrip("\ufeff \t").lower().startswith("pathfiletype"):
        raise FormatError(f"not a TRC file: expected PathFileType, found {shown(first.text[:40])}", at=first.at())
    names, texts = _need(lines, "the names of the facts, DataRate …"), _need(lines, "the facts")
    keys, values = _cells(names), _cells(texts)
    if "datarate" not in [key.lower() for key in keys]:
        raise FormatError("the second line does not name DataRate", at=names.at(), remedy="Check the head of the file.")
    if len(values) < len([key for key in keys if key]):
        raise FormatError(
            f"the head names {len([key for key in keys if key])} facts, {len(values)} follow", at=texts.at()
        )
    filled = [value for value in values if value]
    if len(values) > len(keys) and len(filled) == len([key for key in keys if key]):
        # Some programs write two tabs between values.
        keys, values = [key for key in keys if key], filled
    labels = _need(lines, "the labels of the markers")
    cells = _cells(labels)
    if not cells or not cells[0].lower().startswith("frame"):
        raise FormatError(f"expected Frame#, Time and labels, found {shown(labels.text[:40])}", at=labels.at())
    end, axes = labels.end, 0
    while (line := lines.peek()) is not None:
        words = line.text.split()
        if words and is_number(words[0]):
            break
        if words and not re.fullmatch(r"[XYZxyz][0-9]+", words[0]):
            what = f"expected the axes X1 Y1 Z1 … or a frame, found {shown(line.text[:40])}"
            raise FormatError(what, at=line.at())
        end, axes = line.end, axes + len(words)
        lines.next()
    if "\t" not in labels.text:
        note(notices, "warning", "cells are separated by blanks: a missing sample cannot be seen", labels.at())
    facts = {key: value for key, value in zip(keys, values, strict=False) if key}
    return _Head(_cells(first), facts, cells[2:], axes, end)


def _need(lines: Lines, what: str) -> Line:
    line = lines.next()
    if line is None:
        raise FormatError(f"the file ends before {what}", at=lines.here, remedy="The file was cut off; send it whole.")
    return line


def _cells(line: Line) -> list[str]:
    """Split a line at tabs, or at blanks without a tab."""
    return [cell.strip() for cell in line.text.split("\t")] if "\t" in line.text else line.text.split()


def _cell(cells: list[str], index: int) -> str:
    return cells[index] if index < len(cells) else ""


def _first_row(stream: BinaryIO, start: int) -> list[bytes]:
    """The cells of the first row, without the tabs behind the last one."""
    stream.seek(start)
    row = re.split(rb"[\r\n]", stream.read(_SAMPLE_BYTES).lstrip(b"\r\n"))[0].rstrip(b"\t ")
    return row.split(b"\t") if b"\t" in row else row.split()


def _number(row: list[bytes]) -> str:
    """The number of the first frame behind a blank; nothing where it has none."""
    text = row[0].strip().decode("latin-1") if row else ""
    return f" {int(text)}" if is_whole(text) else ""


def _style(stream: BinaryIO, start: int) -> str:
    """How the coordinates are written; the first two cells of a row are not theirs."""
    stream.seek(start)
    rows = re.split(rb"[\r\n]+", stream.read(_SAMPLE_BYTES))[:-1]
    cells = [cell for row in rows for cell in row.split(b"\t")[2:] if cell.strip() and cell.strip().lower() != b"nan"]
    return detect_style(b" ".join(cells))
