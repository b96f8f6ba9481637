"""Points of C3D that are not positions: angles, forces, moments, powers, and other types named by parameters.

Models such as Plug-in Gait write their results into the same table as markers, and name them in POINT:ANGLES and
similar parameters. This module converts each to a section of the head, and back to points of a file. See
docs/formats/c3d.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import Notice
from mcml.formats.c3d.parameters import Statements
from mcml.formats.format import note
from mcml.formats.text.numbers import is_whole, parse_numbers
from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Array

TYPES: Final = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
"""Groups of points that are no places, whether or not POINT:TYPE_GROUPS names them."""

PLACES: Final = frozenset({"LABELS", "MARKERS", "MODELED_MARKERS", "VIRTUAL_MARKERS"})
"""Groups of points that are places, as markers are."""

MOST_TEXT: Final = 8 << 20
"""Characters of all quantities of a file that a document takes: its head is read as a whole."""

_LENGTHS: Final = frozenset({"mm", "cm", "m", "in", "inch", "ft", "dm"})
_PREFIX: Final = "POINT:"
_MISSING: Final = "-"
_CONTROL: Final = re.compile(r"[\x00-\x1f\x7f]+")


@dataclass(frozen=True)
class Quantity:
    """A typed point of a file. group: such as "ANGLES". unit: "" if the file does not state it.

    label: as the file writes it. first: number of the first frame. rate: as text, "?" for unknown.
    samples: (n, 4) x, y, z and residual, which is -1 for a missing sample.
    """

    group: str
    label: str
    unit: str
    first: int = 1
    rate: str = "?"
    samples: Array | None = None

    def has_rate(self, rate: str) -> bool:
        """Whether frames at this rate (`rate_of`) may be its own; a rate that nobody knows is no reason against it."""
        return "?" in (self.rate, rate or "?") or self.rate == rate

    def section(self) -> tuple[str, str]:
        """(name, text) of the section that keeps it: a line of facts, then a line for each frame."""
        samples = np.zeros((0, 4)) if self.samples is None else self.samples
        lines = [f"{self.first} {self.rate} {self.unit}".rstrip()]
        for x, y, z, residual in samples.astype(np.float32).tolist():
            row = f"{_short(x)} {_short(y)} {_short(z)}"
            lines.append(_MISSING if residual < 0 else f"{row} {_short(residual)}" if residual else row)
        return f"{_PREFIX}{self.group} {self.label}", "\n".join(lines)


def _short(value: float) -> str:
    """The fewest digits that are the same number in single precision."""
    return str(np.float32(value)).removesuffix(".0")


def quantities_of(said: Statements, labels: Sequence[str]) -> dict[int, Quantity]:
    """The points that are quantities, by their place among the points. labels: of all points, as read."""
    places: dict[str, int] = {}
    for index, label in enumerate(labels):
        places.setdefault(label, index)
        # Groups may leave out the subject that labels begin with.
        places.setdefault(label.rpartition(":")[2], index)
    found: dict[int, Quantity] = {}
    for group, unit in _groups(said):
        for text in texts_of(said, f"{_PREFIX}{group}"):
            label = decode_text(text)
            place = places[label] if label in places else places.get(label.rpartition(":")[2])
            if label and place is not None and place not in found:
                found[place] = Quantity(group, labels[place], unit)
    return found


def _groups(said: Statements) -> list[tuple[str, str]]:
    """(group, unit) of groups whose points are no places."""
    pairs = [decode_text(text).upper() for text in said.texts(f"{_PREFIX}TYPE_GROUPS")]
    stems = dict(zip(pairs[::2], pairs[1::2], strict=False))
    found = []
    for group in dict.fromkeys((*TYPES, *stems)):
        texts = said.texts(f"{_PREFIX}{stems.get(group) or group.removesuffix('S')}_UNITS")
        unit = decode_text(texts[0]) if texts else "deg" if group == "ANGLES" else ""
        # Groups of a maker's own are quantities where their unit is one.
        if group in TYPES or (group and group not in PLACES and unit and unit.lower() not in _LENGTHS):
            found.append((group, unit))
    return found


def texts_of(said: Statements, name: str) -> list[bytes]:
    """Return the texts of a parameter and of its continuations: LABELS, LABELS2 …"""
    texts, number = said.texts(name), 2
    while more := said.texts(f"{name}{number}"):
        texts, number = texts + more, number + 1
    return texts


def decode_text(text: bytes) -> str:
    """The text of a parameter without blanks around it: UTF-8, otherwise Windows-1252."""
    try:
        return text.decode("utf-8").strip()
    except UnicodeDecodeError:
        return text.decode("cp1252", errors="replace").strip()


def plain_text(text: bytes) -> str:
    """The text of a parameter without control characters, which would end a line of a section or one of its parts."""
    return _CONTROL.sub(" ", decode_text(text)).strip()


def sections_of(quantities: Iterable[Quantity], notices: list[Notice]) -> list[tuple[str, str]]:
    """Return the sections for quantities, with a notice. No sections if they are longer than MOST_TEXT."""
    quantities = list(quantities)
    if not quantities:
        return []
    counts: dict[str, int] = {}
    for quantity in quantities:
        counts[quantity.group] = counts.get(quantity.group, 0) + 1
    named = ", ".join(f"{count} {group}" for group, count in counts.items())
    sections = [quantity.section() for quantity in quantities]
    if sum(len(text) for _, text in sections) > MOST_TEXT:
        what = f"{named} are quantities, not markers, and too long for a document; the kept file has them"
        note(notices, "warning", what)
        return []
    what = f"{named} are quantities, not markers: kept in sections of the head, and written to C3D again"
    note(notices, "note", what)
    return sections


def kept_quantities(sections: Iterable[tuple[str, str]]) -> list[Quantity]:
    """The quantities that sections keep; sections that keep none are passed over."""
    found = []
    for name, text in sections:
        head, _, label = name.partition(" ")
        lines = text.split("\n")
        facts = lines[0].split(None, 2)
        if not head.startswith(_PREFIX) or not label or len(facts) < 2 or not is_whole(facts[0]):
            continue
        table = _parse_samples(lines[1:])
        if table is not None:
            unit = facts[2] if len(facts) > 2 else ""
            found.append(Quantity(head.removeprefix(_PREFIX), label, unit, int(facts[0]), facts[1], table))
    return found


def _parse_samples(lines: Sequence[str]) -> Array | None:
    """(n, 4) of lines with three or four numbers, or none; None if a line is another."""
    words: list[str] = []
    for line in lines:
        row = line.split()
        if row == [_MISSING]:
            row = ["0", "0", "0", "-1"]
        if len(row) == 3:
            row.append("0")
        if len(row) != 4:
            return None
        words += row
    numbers = parse_numbers(" ".join(words).encode())
    return None if numbers is None else numbers.astype(np.float32).astype(np.float64).reshape(-1, 4)


def samples_at(quantity: Quantity, ids: NDArray[np.int64] | Sequence[int] | Sequence[str]) -> Array:
    """(n, 4) of the frames with these numbers; missing where it has none."""
    samples = np.zeros((0, 4)) if quantity.samples is None else quantity.samples
    chosen = np.tile([0.0, 0.0, 0.0, -1.0], (len(ids), 1))
    numbers = np.asarray(ids)
    if numbers.dtype.kind == "i":
        places = numbers - quantity.first
        inside = (places >= 0) & (places < len(samples))
        chosen[inside] = samples[places[inside]]
    return chosen


def rate_of(head: ClipHead) -> str:
    """Frames a second of a clip's file, as sections write them; "" where unknown. A frame time stated later tells how
    long these frames last, not that they are others.
    """
    rate = float(head.fields.get("dataframe_rate") or head.rate_text() or 0.0)
    return str(np.float32(rate)).removesuffix(".0") if rate > 0 else ""


def units_of(quantities: Iterable[Quantity]) -> Mapping[str, str]:
    """The unit of each group, the first that one of its quantities states."""
    units: dict[str, str] = {}
    for quantity in quantities:
        units[quantity.group] = units.get(quantity.group) or quantity.unit
    return units
