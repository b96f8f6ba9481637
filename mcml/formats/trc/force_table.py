"""Tables of forces beside a TRC, OpenSim's MOT and STO: their columns, and their samples at the times of frames.

Source: OpenSim documentation, "Preparing Your Data" and "Storage (.mot) Files": a head that ends with `endheader`, a
row of names, then rows of numbers; forces in newtons, points in metres and torques in newton metres about the point,
all in the axes of the markers. This program's reading of it is in docs/formats/trc.md.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, LimitError
from mcml.formats.text.lines import blocks_of
from mcml.formats.text.numbers import is_number, parse_numbers
from mcml.motion.skeleton import Array
from mcml.motion.units import UNITS

ENDINGS: Final = (".mot", ".sto")
HEAD_BYTES: Final = 1 << 16
"""Bytes in which the head of a table must end, with the row of names."""

FRAMES: Final = "frames"
"""The section that says which frames have samples: number and time of the first, rate, count, unit of length."""

_BLOCK: Final = 1 << 20
_MOST_BYTES: Final = 1 << 29
_MOST_VALUES: Final = 50_000_000

_SAME_INSTANT: Final = 0.05
"""Of the time between samples."""
_EVEN: Final = 0.01
"""Of the time between samples, by which their times may differ from an even rate, besides the rounding of the text."""
_ROUNDING: Final = 1.01
"""Of the last digit of the times."""

_NAMES: Final = re.compile(rb"(?is)\bendheader[ \t]*\r?\n\s*([^\r\n]+)")
_COLUMN: Final = re.compile(r"(?i)(.*?)([xyz])")
_KINDS: Final = (
    ("torque", re.compile(r"(?i).*(?:torque|moment).*|.*_[mt]_?|m\d+_?")),
    ("force", re.compile(r"(?i).*force.*_?v|.*_v|f\d+_?")),
    ("point", re.compile(r"(?i).*force.*_?p|.*_p|.*cop.*|p\d+_?")),
)
_FILLERS: Final = re.compile(
    r"(?i)ground|force|torque|moment|cop|(?<![a-z0-9])[vpmt](?![a-z0-9])|^[fpm](?=\d)|[^a-z0-9]+|(?<=\d)[vpmt]$"
)
"""Parts in which the names of a force, of its point and of its torque differ."""


@dataclass(frozen=True)
class Wrench:
    """Columns of the force on one plate or foot, of its point and of its torque, by x, y and z; () for none."""

    label: str
    force: tuple[int, ...]
    point: tuple[int, ...]
    torque: tuple[int, ...]


@dataclass(frozen=True)
class FramesOfTrial:
    """The frames of a TRC, one after another.

    first: number of the first one. start: its time. rate: frames a second. unit: of lengths, "" where unknown.
    """

    first: int
    start: float
    rate: float
    count: int
    unit: str

    @property
    def length(self) -> str:
        """The unit, mm where it is unknown, as in C3D."""
        return self.unit if self.unit.lower() in UNITS else "mm"

    @property
    def metres(self) -> float:
        """Of the unit."""
        return UNITS[self.length.lower()]

    @classmethod
    def of(cls, text: str) -> FramesOfTrial:
        """Read the text of a section. Raises FormatError for another one."""
        words = [*text.split(" ", 4), ""]
        try:
            frames = cls(int(words[0]), float(words[1]), float(words[2]), int(words[3]), words[4])
        except (ValueError, IndexError):
            raise FormatError(f"{text[:60]!r} does not say which frames have forces") from None
        if not (np.isfinite([frames.start, frames.rate]).all() and frames.rate > 0 and frames.count > 0):
            raise FormatError(f"{text[:60]!r} does not say which frames have forces")
        return frames

    def section(self) -> tuple[str, str]:
        return FRAMES, f"{self.first} {self.start!r} {self.rate!r} {self.count} {self.unit}".rstrip()


@dataclass(frozen=True, eq=False)
class ForceTable:
    """names: of columns, the first is time. values: (rows, columns). wrenches: among the columns."""

    names: tuple[str, ...]
    values: Array
    wrenches: tuple[Wrench, ...]

    @property
    def others(self) -> list[int]:
        """Columns of nothing of that."""
        taken = {
            place for wrench in self.wrenches for part in (wrench.force, wrench.point, wrench.torque) for place in part
        }
        return [place for place in range(1, len(self.names)) if place not in taken]


@dataclass(frozen=True, eq=False)
class Instants:
    """The times at which frames have samples. samples: of a frame. rows: (n,) of the table, None where times differ."""

    samples: int
    times: Array
    rows: NDArray[np.intp] | None

    def read(self, seconds: Array, columns: Array) -> Array:
        """(n, k) of columns (rows, k) at these times: a row itself, or between two; NaN before and after the table."""
        if self.rows is None:
            columns_at = [np.interp(self.times, seconds, column, left=np.nan, right=np.nan) for column in columns.T]
            return np.stack(columns_at, axis=1)
        inside = (self.rows >= 0) & (self.rows < len(columns))
        read = np.full((len(self.rows), columns.shape[1]), np.nan)
        read[inside] = columns[self.rows[inside]]
        return read


def has_forces(first_bytes: bytes) -> bool:
    """Whether a table that begins so has forces of the ground."""
    return bool(_find_wrenches(_names(first_bytes)))


def read_table(stream: BinaryIO) -> ForceTable:
    """Read a whole table. Raises FormatError for one without forces, LimitError for one that is too large."""
    pieces, size = [], 0
    for piece in blocks_of(stream, 0, _BLOCK):
        pieces.append(piece)
        size += len(piece)
        if size > _MOST_BYTES:
            raise LimitError(f"the table has more than {_MOST_BYTES >> 20} MiB", remedy="Cut it into trials.")
    text = b"".join(pieces)
    names, head = _names(text), _NAMES.search(text[:HEAD_BYTES])
    if head is None or not names or names[0].lower() != "time":
        raise FormatError("the table has no row of names that begins with time", remedy="Send the table as it was.")
    wrenches = tuple(_find_wrenches(names))
    if not wrenches:
        raise FormatError("the table has no forces with points or torques", remedy="Send the forces of the trial.")
    return ForceTable(tuple(names), _numbers(text[head.end() :], len(names)), wrenches)


def _numbers(body: bytes, columns: int) -> Array:
    values = parse_numbers(body)
    if values is None:
        cells = body.decode("latin-1").split()
        bad = next((cell for cell in cells if not (is_number(cell) or cell.lower() == "nan")), None)
        if bad is not None:
            raise FormatError(f"{bad[:40]!r} is no number", remedy="Send the table as it was.")
        values = np.array([float(cell) for cell in cells])
    if len(values) > _MOST_VALUES:
        raise LimitError(f"the table has {len(values)} numbers, the limit is {_MOST_VALUES}", remedy="Cut it.")
    if not len(values) or len(values) % columns:
        what = f"the rows have {len(values)} numbers, which are no whole rows of {columns} columns"
        raise FormatError(what, remedy="Send the whole table.")
    return values.reshape(-1, columns)


def _names(first_bytes: bytes) -> list[str]:
    """The names of the columns; [] without any."""
    found = _NAMES.search(first_bytes[:HEAD_BYTES])
    return [] if found is None else found[1].decode("utf-8", "replace").split()


def _find_wrenches(names: Sequence[str]) -> list[Wrench]:
    """Forces in three columns, with the points and torques whose names differ in their kind alone."""
    stems: dict[str, dict[str, int]] = {}
    for place, name in enumerate(names):
        parts = _COLUMN.fullmatch(name)
        if parts is not None:
            stems.setdefault(parts[1], {}).setdefault(parts[2].lower(), place)
    groups: dict[str, dict[str, tuple[int, ...]]] = {}
    for stem, axes in stems.items():
        kind = next((kind for kind, pattern in _KINDS if pattern.fullmatch(stem)), None)
        if kind is not None and len(axes) == 3:
            group = groups.setdefault(_FILLERS.sub("", stem).lower(), {})
            group.setdefault(kind, (axes["x"], axes["y"], axes["z"]))
    return [
        Wrench(names[group["force"][0]][:-1], group["force"], group.get("point", ()), group.get("torque", ()))
        for group in groups.values()
        if "force" in group and ("point" in group or "torque" in group)
    ]


def align(seconds: Array, frames: FramesOfTrial) -> Instants:
    """Return the times at which frames have samples, as many in each as a table with rows at `seconds` has.

    Raises FormatError for times that do not rise evenly, or are of other times than the frames; LimitError for too
    many samples.
    """
    steps = np.diff(seconds)
    if len(seconds) < 2 or not np.isfinite(seconds).all() or not (steps > 0).all():
        raise FormatError("the times of the forces do not rise", remedy="Send the rows in the order of their times.")
    step = float(seconds[-1] - seconds[0]) / len(steps)
    rounding = _ROUNDING * 10.0 ** -_decimals(seconds)
    if np.abs(steps - step).max() > _EVEN * step + rounding:
        raise FormatError("the times of the forces are not even", remedy="Resample the forces to an even rate.")
    samples = max(1, round(1 / (step * frames.rate)))
    if samples * frames.count > _MOST_VALUES:
        raise LimitError("the table has too many samples a frame", remedy="Check its times.")
    times = frames.start + np.arange(samples * frames.count) / (samples * frames.rate)
    rows = np.rint((times - seconds[0]) / step).astype(np.intp)
    inside = (rows >= 0) & (rows < len(seconds))
    if not inside.any():
        what = f"forces are from {seconds[0]:g} s to {seconds[-1]:g} s, frames from {times[0]:g} s to {times[-1]:g} s"
        raise FormatError(what, remedy="Send the forces of this trial.")
    away = np.abs(times[inside] - seconds[rows[inside]]).max()
    return Instants(samples, times, rows if away <= _SAME_INSTANT * step + rounding else None)


def _decimals(seconds: Array) -> int:
    """How many decimals times have, at most 9."""
    return next((digits for digits in range(9) if np.abs(seconds - np.round(seconds, digits)).max() < 1e-10), 9)
