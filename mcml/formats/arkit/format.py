"""CSV of faces as Live Link Face writes it: weights of ARKit's blend shapes, angles of head and eyes.

Sources: Apple, ARFaceAnchor.BlendShapeLocation (names and range of the weights); Epic Games, Recording Face Animation
with Live Link Face (the app's CSV). docs/formats/arkit.md describes the reading.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.arkit.columns import FIRST, Columns, find_columns
from mcml.formats.arkit.timecodes import Timing, read_timecode, time_rows
from mcml.formats.format import FileKind, ReadOptions, SourceFile, note
from mcml.formats.scenes.make_clip import without_gaps
from mcml.formats.text.number_text import detect_style
from mcml.formats.text.numbers import is_number, parse_numbers
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart
from mcml.motion.lexemes import lexeme
from mcml.motion.skeleton import Array

_LONGEST_LINE: Final = 1 << 16
_FRAMES_AT_ONCE: Final = 256
_SAMPLE_ROWS: Final = 40
_DAMAGED: Final = "Send the whole file as the app wrote it."
_BOM: Final = "\ufeff"


class Arkit:
    """The format `arkit`; see `mcml.formats.format.Reader`."""

    name = "arkit"
    title = "ARKit and Live Link Face"
    label = "ARKit CSV"
    parts = (FileKind("csv", (".csv",), "Blend shapes of a face"),)
    media_type = "text/csv"
    states = frozenset({"frame_time", "blend_shapes"})

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        words = first_bytes[:200].decode("utf-8", "replace").lstrip(_BOM).lower().split(",")
        return "csv" if tuple(word.strip(' "') for word in words[:2]) == FIRST else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["csv"]
        with file.blamed():
            return _read(file, options)


@dataclass(frozen=True)
class _Row:
    line: int
    cells: list[str]


def _read(file: SourceFile, options: ReadOptions) -> ClipStream:
    rows = _rows(file)
    names = next(rows, _Row(1, [])).cells
    while names and not names[-1]:
        names.pop()
    columns = find_columns(names, options.limits)
    notices: list[Notice] = []
    timing, sample, start = _first_pass(rows, columns, options, notices)
    frames = int(timing.frames[-1]) + 1
    skeleton = columns.skeleton
    has_angles = any(joint.has_axes for joint in skeleton.joints)
    head = ClipHead(
        "arkit",
        skeleton,
        {"dataframe_rate": lexeme(timing.rate)} | ({"units_angle": "rad"} if has_angles else {}),
        number_style=detect_style(sample),
        sources=(SourcePart("csv", file.name.rsplit("/", 1)[-1]),),
        properties=(("timecode", start, ""),),
    )

    def blocks() -> Iterator[FrameBlock]:
        with file.blamed():
            yield from _blocks(file, columns, timing, frames)

    return ClipStream(head, blocks, frames, notices)


def _rows(file: SourceFile) -> Iterator[_Row]:
    """The lines that are not empty, as cells."""
    file.stream.seek(0)
    line = 0
    while text := file.stream.readline(_LONGEST_LINE + 1):
        line += 1
        if len(text) > _LONGEST_LINE:
            raise LimitError(
                f"the line is longer than {_LONGEST_LINE} bytes", at=Place(line=line), remedy="Check the file."
            )
        row = text.decode("utf-8", "replace").strip().lstrip(_BOM)
        if row:
            yield _Row(line, [cell.strip(' "') for cell in row.split(",")])


def _first_pass(
    rows: Iterator[_Row], columns: Columns, options: ReadOptions, notices: list[Notice]
) -> tuple[Timing, bytes, str]:
    """(timing, the numbers of some rows as text, the first timecode). Raises FormatError, LimitError."""
    seconds: list[int] = []
    counts: list[float] = []
    lines: list[int] = []
    sample: list[str] = []
    start = ""
    stated = str(columns.width - len(FIRST))
    for row in rows:
        if len(row.cells) != columns.width:
            raise FormatError(
                f"the row has {len(row.cells)} cells, the first line has {columns.width}",
                at=Place(line=row.line),
                remedy=_DAMAGED,
            )
        second, count = read_timecode(row.cells[0], row.line)
        start = start or row.cells[0]
        seconds.append(second)
        counts.append(count)
        lines.append(row.line)
        if row.cells[1] not in ("", stated):
            note(notices, "warning", f"BlendShapeCount says {row.cells[1][:20]!r}, the table has {stated} columns")
        if len(sample) < _SAMPLE_ROWS:
            sample.append(" ".join(cell for cell in row.cells[len(FIRST) :] if is_number(cell)))
        options.limits.check_size(len(lines), len(columns.cells))
    if not lines:
        raise FormatError("the table has no rows", remedy=_DAMAGED)
    timing = time_rows(seconds, counts, lines, options.rate)
    frames = int(timing.frames[-1]) + 1
    options.limits.check_size(frames, len(columns.cells))
    _tell(timing, frames, options, notices)
    return timing, " ".join(sample).encode(), start


def _tell(timing: Timing, frames: int, options: ReadOptions, notices: list[Notice]) -> None:
    if timing.is_guess:
        what = f"timecodes are taken to count {timing.base:g} frames a second: none of them counts 30 or more"
        note(notices, "guess", what)
    different = len(np.unique(timing.frames))
    if frames > different:
        note(notices, "note", f"{frames - different} frames have no row: no samples there")
    if len(timing.frames) > different:
        which = "that is wanted" if options.rate else "of the file"
        lost = len(timing.frames) - different
        note(notices, "warning", f"{lost} rows fall into the frame of the row before at the rate {which}: left out")


def _blocks(file: SourceFile, columns: Columns, timing: Timing, frames: int) -> Iterator[FrameBlock]:
    skeleton = columns.skeleton
    rows = _rows(file)
    next(rows)
    # The first row of a frame counts.
    chosen = np.concatenate([[True], np.diff(timing.frames) > 0])
    places = timing.frames.tolist()
    taken = 0
    for first in range(0, frames, _FRAMES_AT_ONCE):
        end = min(first + _FRAMES_AT_ONCE, frames)
        values = np.full((end - first, len(columns.cells)), np.nan)
        while taken < len(places) and places[taken] < end:
            row = next(rows)
            if chosen[taken]:
                values[places[taken] - first] = _numbers(row, columns)
            taken += 1
        yield without_gaps(values, skeleton.columns(), np.arange(first + 1, end + 1, dtype=np.int64))


def _numbers(row: _Row, columns: Columns) -> Array:
    """The numbers of a row, NaN where a cell is blank. Raises FormatError for other texts."""
    cells = [row.cells[index] for index in columns.cells]
    parsed = parse_numbers(" ".join(cells).encode()) if all(cells) else None
    if parsed is not None and len(parsed) == len(cells):
        return parsed
    bad = next((number for number, cell in enumerate(cells) if cell and not is_number(cell)), None)
    if bad is not None:
        joint, _ = columns.skeleton.columns()[bad]
        name = columns.skeleton.joints[joint].source_name
        raise FormatError(f"{cells[bad][:40]!r} of {name} is not a number", at=Place(line=row.line), remedy=_DAMAGED)
    return np.array([float(cell) if cell else np.nan for cell in cells])
