"""Read the header and the parameters of a C3D file. See docs/formats/c3d.md.

The header is the first block of 512 bytes; the parameters begin at the block that its first byte names. No length is
trusted: an entry that would leave the section ends the read, and earlier entries are used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, Notice
from mcml.formats.format import note
from mcml.motion.skeleton import Array

BLOCK: Final = 512
INTEL, DEC, MIPS = 84, 85, 86
_MOST_BYTES: Final = 256 * BLOCK
"""Limit of a parameter section: a byte has its number of blocks."""

_SIZES: Final = {-1: 1, 1: 1, 2: 2, 4: 4}


@dataclass(frozen=True, slots=True)
class Machine:
    """How numbers are laid out. processor: 84 Intel, 85 DEC, 86 MIPS, as byte 4 of the parameter section has it."""

    processor: int

    @property
    def name(self) -> str:
        return {INTEL: "INTEL", DEC: "DEC", MIPS: "MIPS"}[self.processor]

    def words(self, data: bytes) -> NDArray[np.int64]:
        """16-bit words as numbers without sign."""
        return np.frombuffer(data, dtype=">u2" if self.processor == MIPS else "<u2").astype(np.int64)

    def integers(self, data: bytes) -> NDArray[np.int16]:
        """16-bit words as numbers with a sign."""
        return np.frombuffer(data, dtype=">i2" if self.processor == MIPS else "<i2")

    def floats(self, data: bytes) -> Array:
        """Return single precision numbers as doubles; NaN for values that DEC reserves."""
        if self.processor != DEC:
            # Damaged files have NaN of the kind that warns when it is converted.
            with np.errstate(invalid="ignore"):
                return np.frombuffer(data, dtype=">f4" if self.processor == MIPS else "<f4").astype(np.float64)
        # VAX F: the word of sign, exponent and high bits first; 0.1mmm × 2^(e - 128), and e = 0 is zero.
        pairs = np.frombuffer(data, dtype="<u2").reshape(-1, 2).astype(np.int64)
        sign, exponent = pairs[:, 0] >> 15, pairs[:, 0] >> 7 & 0xFF
        fraction = (pairs[:, 0] & 0x7F) << 16 | pairs[:, 1] | 1 << 23
        values = np.ldexp(fraction.astype(np.float64), (exponent - 128 - 24).astype(np.int32))
        values = np.where(exponent == 0, np.where(sign == 1, np.nan, 0.0), values)
        return np.where(sign == 1, -values, values)


@dataclass(frozen=True, slots=True)
class Parameter:
    """kind: -1 characters, 1 bytes, 2 words, 4 floats. dimensions: the first varies fastest; () is one value.

    spelling: group and name as the file writes them, such as "Processing:LLegLength".
    """

    kind: int
    dimensions: tuple[int, ...]
    data: bytes
    machine: Machine
    spelling: str = ""

    def numbers(self, *, signed: bool = False) -> list[float]:
        """All numbers, words without their sign (more than 32,767 frames are counted so); [] for characters.

        signed: words with their sign.
        """
        if self.kind == 4:
            return [float(value) for value in self.machine.floats(self.data)]
        if self.kind == 2:
            return [float(value) for value in (self.machine.integers if signed else self.machine.words)(self.data)]
        return [float(value) for value in self.data] if self.kind == 1 else []

    def to_intel(self) -> bytes:
        """Return its data as an Intel machine writes them."""
        if self.kind == 2:
            return self.machine.words(self.data).astype("<u2").tobytes()
        if self.kind == 4 and self.machine.processor != INTEL:
            return self.machine.floats(self.data).astype("<f4").tobytes()
        return self.data

    def texts(self) -> list[bytes]:
        """All texts, without the blanks and zeros that fill them up; [] for numbers."""
        if self.kind != -1:
            return []
        length = self.dimensions[0] if self.dimensions else 1
        count = math.prod(self.dimensions[1:])
        rows = (self.data[place * length : (place + 1) * length] for place in range(count))
        return [row.strip(b"\0 ").split(b"\0")[0].rstrip() for row in rows]


@dataclass(frozen=True)
class Statements:
    """The header and parameters of a file.

    header: its bytes. words: its 256 words without sign, the first of which is word 1 of the specification at index 0.
    section: (first byte, byte behind the last) of the parameter section, as stated.
    """

    machine: Machine
    header: bytes
    words: NDArray[np.int64]
    scale: float
    rate: float
    parameters: dict[str, Parameter]
    section: tuple[int, int]

    def number(self, name: str) -> float | None:
        """The first number of a parameter, such as "POINT:USED"; None if it is missing or not finite."""
        found = self.parameters.get(name)
        values = found.numbers() if found is not None else []
        return values[0] if values and math.isfinite(values[0]) else None

    def numbers(self, name: str, *, signed: bool = False) -> list[float]:
        """All numbers of a parameter and of its continuations, such as ANALOG:SCALE and ANALOG:SCALE2; [] for none."""
        numbers: list[float] = []
        part, number = self.parameters.get(name), 2
        while part is not None and (more := part.numbers(signed=signed)):
            numbers += more
            part, number = self.parameters.get(f"{name}{number}"), number + 1
        return numbers

    def long(self, name: str) -> int | None:
        """A whole number in two words, low and high, as TRIAL:ACTUAL_END_FIELD has it."""
        found = self.parameters.get(name)
        values = found.numbers() if found is not None and found.kind == 2 else []
        return int(values[0]) + (int(values[1]) << 16) if len(values) > 1 else None

    def texts(self, name: str) -> list[bytes]:
        found = self.parameters.get(name)
        return found.texts() if found is not None else []


def read_statements(stream: BinaryIO, notices: list[Notice]) -> Statements:
    """Read the statements of header and parameters. Raises FormatError if a file has none."""
    stream.seek(0)
    header = stream.read(BLOCK)
    if len(header) < BLOCK:
        raise FormatError(
            f"the file has {len(header)} bytes, the header of a C3D alone has {BLOCK}", remedy="Send the whole file."
        )
    start = (header[0] - 1) * BLOCK
    stream.seek(max(start, 0))
    section = stream.read(_MOST_BYTES)
    if start < BLOCK or len(section) < 4 or section[3] not in (INTEL, DEC, MIPS):
        raise FormatError(
            f"no parameters begin at block {header[0]}, where the header says they do",
            remedy="Send the C3D file itself, as the system wrote it.",
        )
    machine = Machine(section[3])
    words = machine.words(header)
    # Some files announce fewer blocks than they have: where the data begin behind them, the parameters end there.
    data = (int(words[8]) - 1) * BLOCK - start
    parameters = _walk(section[: data if data > 0 else section[2] * BLOCK], machine, notices)
    return Statements(
        machine,
        header,
        words,
        scale=float(machine.floats(header[12:16])[0]),
        rate=float(machine.floats(header[20:24])[0]),
        parameters=parameters,
        section=(start, start + section[2] * BLOCK),
    )


def _walk(section: bytes, machine: Machine, notices: list[Notice]) -> dict[str, Parameter]:
    """Read parameters by "GROUP:NAME" in capitals; the first of several with one name.

    A record: length of the name (negative: locked), number of the group (negative: this is one), name, distance to the
    next record; a parameter then has its kind, dimensions and data. Groups may come after their parameters.
    """
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Parameter]] = []
    place = 4
    while place + 2 <= len(section):
        length, group = abs(_signed(section[place])), _signed(section[place + 1])
        if length == 0 or group == 0:
            break
        after = place + 2 + length
        if after + 2 > len(section):
            note(notices, "warning", f"the parameters are damaged after the {len(found)}th: those before it count")
            break
        name = section[place + 2 : after].decode("latin-1").strip()
        distance = int(machine.words(section[after : after + 2])[0])
        if group < 0:
            groups.setdefault(-group, name)
        else:
            parameter = _parameter(section[after + 2 :], machine)
            if parameter is not None:
                found.append((group, name, parameter))
            else:
                note(notices, "warning", f"the parameter {name[:40]!r} is damaged: it was left out")
        if distance == 0:
            break
        place = after + distance
    result: dict[str, Parameter] = {}
    for group, name, parameter in found:
        spelling = f"{groups.get(group, '')}:{name}"
        result.setdefault(spelling.upper(), replace(parameter, spelling=spelling))
    return result


def _parameter(data: bytes, machine: Machine) -> Parameter | None:
    if len(data) < 2:
        return None
    kind, count = _signed(data[0]), data[1]
    dimensions = tuple(data[2 : 2 + count])
    if kind not in _SIZES or len(dimensions) < count or count > 7:
        return None
    size = _SIZES[kind] * math.prod(dimensions)
    content = data[2 + count : 2 + count + size]
    return Parameter(kind, dimensions, content, machine) if len(content) == size else None


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte
