"""TRC: Motion Analysis' labelled points over time, as text. Facts and sources: formats.md 6.

Five head lines (file type, names of facts, facts, labels, axes), then a line for each frame: number, time, and x y z of
every marker between single tabs. An empty cell, or `nan`, is a sample that is missing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import BinaryIO, Final

from service.errors import FormatError, Notice
from service.formats.format import Limits, Part, ReadOptions, SourceFile, need_convention, note
from service.formats.lines import Line, Lines, detect_encoding, shown
from service.formats.number_text import detect_style
from service.formats.numbers import is_number, is_whole
from service.formats.trc_rows import Rows
from service.formats.trc_writer import write_trc
from service.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart
from service.motion.markers import marker_skeleton
from service.motion.skeleton import Convention

_FACTS: Final = ("DataRate", "NumFrames", "NumMarkers", "Units")
_SAMPLE_BYTES: Final = 1 << 16


class Trc:
    """The format `trc`; see `service.formats.format.Format`."""

    name = "trc"
    title = "Motion Analysis TRC"
    parts = (Part("trc", (".trc",), "Markers"),)
    convention = Convention.MARKER
    media_type = "text/plain"

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        return "trc" if first_bytes.removeprefix(b"\xef\xbb\xbf").lstrip()[:12].lower() == b"pathfiletype" else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["trc"]
        with file.blamed():
            return _read(file, options)

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_convention(clip.head.skeleton, self.convention, self.title)
        return write_trc(clip)


@dataclass(frozen=True)
class _Head:
    """file_type: cells of the first line. facts: names and texts of the second and third. labels: as written.

    data: byte offset of the first row. line: its number.
    """

    file_type: list[str]
    facts: dict[str, str]
    labels: list[str]
    data: int


def _read(file: SourceFile, options: ReadOptions) -> ClipStream:
    stream, limits = file.stream, options.limits
    encoding = detect_encoding(stream, options.encoding)
    notices = list(encoding.notices)
    head = _read_head(Lines(stream, encoding), notices)
    names = _labels(stream, head, limits, notices)
    skeleton = marker_skeleton(names)
    known = {name.lower(): text for name, text in head.facts.items()}
    frames = known.get("numframes", "")
    declared = int(frames) if is_whole(frames) and int(frames) >= 0 else None
    limits.check_size(declared or 0, 3 * len(names))
    rate = known.get("datarate", "")
    usable = is_number(rate) and float(rate) > 0
    if not usable:
        notices.append(Notice("warning", f"DataRate {shown(rate)} is no rate: how fast the frames follow is unknown"))
    fields = {"filetype": "PathFileType", "version": _cell(head.file_type, 1), "filename": _cell(head.file_type, 3)}
    fields |= {"dataframe_rate": rate} if usable else {}
    fields |= {"calibration_unit": known["units"]} if known.get("units") else {}
    rows = Rows(stream, head.data, skeleton, encoding.start, declared, float(rate) if usable else None, limits)
    sections = [("axes", _cell(head.file_type, 2))] if _cell(head.file_type, 2) else []
    known_facts = _FACTS if usable else _FACTS[1:]
    sections += [(name, text) for name, text in head.facts.items() if name not in known_facts]
    if rows.time is not None:
        sections.append(("Time", f"{rows.time.decimals} {rows.time.first!r}"))
    part = SourcePart(
        part="trc",
        name=file.name.rsplit("/", 1)[-1],
        encoding=encoding.codec,
        keywords=tuple(head.facts),
        sections=tuple(sections),
        missing="",
    )
    clip_head = ClipHead(
        "trc",
        skeleton,
        {name: text for name, text in fields.items() if text},
        number_style=_style(stream, head.data),
        sources=(part,),
    )

    def blocks() -> Iterator[FrameBlock]:
        with file.blamed():
            yield from rows.blocks(notices)

    return ClipStream(clip_head, blocks, None, notices)


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
    labels = _need(lines, "the labels of the markers")
    cells = _cells(labels)
    if not cells or not cells[0].lower().startswith("frame"):
        raise FormatError(f"expected Frame#, Time and labels, found {shown(labels.text[:40])}", at=labels.at())
    end = labels.end
    while (line := lines.peek()) is not None:
        words = line.text.split()
        if words and is_number(words[0]):
            break
        if words and not re.fullmatch(r"[XYZxyz][0-9]+", words[0]):
            what = f"expected the axes X1 Y1 Z1 … or a frame, found {shown(line.text[:40])}"
            raise FormatError(what, at=line.at())
        end = line.end
        lines.next()
    if "\t" not in labels.text:
        note(notices, "warning", "cells are separated by blanks: a missing sample cannot be seen", labels.at())
    facts = {key: value for key, value in zip(keys, values, strict=False) if key}
    return _Head(_cells(first), facts, cells[2:], end)


def _need(lines: Lines, what: str) -> Line:
    line = lines.next()
    if line is None:
        raise FormatError(f"the file ends before {what}", at=lines.here, remedy="The file was cut off; send it whole.")
    return line


def _cells(line: Line) -> list[str]:
    """Between tabs; between blanks where there is no tab."""
    return [cell.strip() for cell in line.text.split("\t")] if "\t" in line.text else line.text.split()


def _cell(cells: list[str], index: int) -> str:
    return cells[index] if index < len(cells) else ""


def _labels(stream: BinaryIO, head: _Head, limits: Limits, notices: list[Notice]) -> list[str]:
    """The label of every marker: the cells of the fourth line that are not empty, as many as the rows have points."""
    found = [cell for cell in head.labels if cell]
    said = next((text for name, text in head.facts.items() if name.lower() == "nummarkers"), "")
    wanted = int(said) if is_whole(said) and int(said) >= 0 else None
    limits.check_points(found)
    if wanted == len(found):
        return found
    stream.seek(head.data)
    row = re.split(rb"[\r\n]", stream.read(_SAMPLE_BYTES).lstrip(b"\r\n"))[0].rstrip(b"\t ")
    cells = len(row.split(b"\t") if b"\t" in row else row.split())
    points = -(-(cells - 2) // 3)
    if points == len(found) or wanted is None:
        note(notices, "warning", f"NumMarkers says {said or 'nothing'}, there are {len(found)} labels: these count")
        return found
    if points == wanted:
        note(notices, "warning", f"NumMarkers says {wanted}, {len(found)} labels follow: the rows have {points} points")
        limits.check_points([""] * wanted)
        return [*found[:wanted], *["unnamed"] * (wanted - len(found))]
    raise FormatError(
        f"NumMarkers says {wanted}, {len(found)} labels follow, the first row has {points} points",
        remedy="Write one label for each marker.",
    )


def _style(stream: BinaryIO, start: int) -> str:
    """How the coordinates are written; the first two cells of a row are not theirs."""
    stream.seek(start)
    rows = re.split(rb"[\r\n]+", stream.read(_SAMPLE_BYTES))[:-1]
    cells = [cell for row in rows for cell in row.split(b"\t")[2:] if cell.strip() and cell.strip().lower() != b"nan"]
    return detect_style(b" ".join(cells))
