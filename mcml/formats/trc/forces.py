"""Forces of the ground beside a TRC, as analog channels and force plates (`mcml.formats.trc.force_table`).

The table states no plates: one stands in for each force with a point, with its surface where the point was.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np

from mcml.errors import FormatError, Notice
from mcml.formats.c3d.analog import Channels
from mcml.formats.c3d.layout import Layout
from mcml.formats.c3d.parameters import INTEL, Machine, Parameter, Statements
from mcml.formats.c3d.records import LONGEST_TEXT, MOST_TEXTS
from mcml.formats.format import note
from mcml.formats.trc.force_table import FRAMES, ForceTable, FramesOfTrial, Wrench, align, read_table
from mcml.laboratory.force_plates import LEAST_FORCE
from mcml.motion.clip import ClipHead, SourcePart
from mcml.motion.floor_plates import section_of_plates
from mcml.motion.skeleton import Array, unique_names

PART: Final = "forces"
"""The part of a TRC clip that is its table of forces."""

_MARGIN: Final = 0.1
"""Metres around the centres of pressure that count as surface: half a foot is beside them."""
_LOADED: Final = 0.05
"""Share of the largest load from which a centre of pressure is steady enough to tell where the surface is."""
_UPRIGHT: Final = 0.8
"""Share of the sum of all forces that is along the vertical: gravity outweighs the rest."""
_FARTHEST: Final = 100.0
"""Metres from the origin: points beyond are in another unit."""

_NO_CORNERS: Final = f"its surface is where its centres of pressure are and {_MARGIN:g} m around"
_CHANNELS: Final = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
_MACHINE: Final = Machine(INTEL)
_NO_FILE: Final = io.BytesIO()


@dataclass(frozen=True, eq=False)
class _Plate:
    """A plate of type 2 with the origin 0 that stands in for a wrench.

    corners: (4, 3) in the unit of the TRC, in single precision. samples: (n, 6) newtons, and newtons times that unit
    about its centre, in its own axes: z is the vertical of the laboratory, x and y are the axes that follow.
    """

    wrench: Wrench
    corners: Array
    samples: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class TableChannels(Channels):
    """Analog channels that are in memory. table: (frames × samples, channels)."""

    table: Array

    @property
    def block(self) -> int:
        return max(1, self.frames)

    def read_raw(self, first: int = 0, count: int | None = None, channels: Sequence[int] | None = None) -> Array:
        places = self._places(channels)
        count = max(0, min(self.frames if count is None else count, self.frames - first))
        return self.table[first * self.samples : (first + count) * self.samples, places]


def describe_forces(stream: BinaryIO, name: str, frames: FramesOfTrial, notices: list[Notice]) -> SourcePart:
    """Return the part of a document that is a table of forces, with notices about assumptions.

    Raises FormatError for a table that cannot be used, LimitError for one that is too large.
    """
    table = read_table(stream)
    instants = align(table.values[:, 0], frames)
    plates = _stand_in(table, frames)
    for number, plate in enumerate(plates, 1):
        note(notices, "guess", f"force plate {number} is {plate.wrench.label}: {_NO_CORNERS}")
    loaded = [plate.wrench.label for plate in plates]
    for wrench in table.wrenches:
        if wrench.label not in loaded:
            note(notices, "note", f"{wrench.label} never reaches {LEAST_FORCE:g} N, and is left out")
    if instants.rows is None:
        what = f"frames have {instants.samples} samples of forces each, between the rows of {name}"
        note(notices, "note", f"{what}, which are at other times")
    outside = (instants.times < table.values[0, 0]) | (instants.times > table.values[-1, 0])
    if instants.rows is not None:
        outside = (instants.rows < 0) | (instants.rows >= len(table.values))
    unknown = int(outside.reshape(frames.count, -1).any(axis=1).sum())
    if unknown:
        note(
            notices,
            "warning",
            f"forces are unknown in {unknown} of {frames.count} frames: {name} does not reach so far",
        )
    corners = section_of_plates(np.stack([plate.corners for plate in plates]))
    return SourcePart(PART, name, sections=(frames.section(), corners))


def read_forces(head: ClipHead, stream: BinaryIO) -> Channels:
    """Return the analog channels and force plates of the table of forces of a clip. Raises as `describe_forces`."""
    part = next(source for source in head.sources if source.part == PART)
    frames = FramesOfTrial.of(dict(part.sections).get(FRAMES, ""))
    table = read_table(stream)
    seconds, instants = table.values[:, 0], align(table.values[:, 0], frames)
    plates = _stand_in(table, frames)
    others = table.others[: MOST_TEXTS - len(_CHANNELS) * len(plates)]
    columns = np.concatenate([*(plate.samples for plate in plates), table.values[:, others]], axis=1)
    numbers = range(1, len(plates) + 1)
    labels = unique_names(
        [f"{name}{number}" for number in numbers for name in _CHANNELS] + [table.names[k] for k in others]
    )
    # Programs that read C3D take moments in newtons times the unit of lengths.
    units = [*["N", "N", "N", *[f"N{frames.length}"] * 3] * len(plates), *[""] * len(others)]
    return TableChannels(
        _NO_FILE,
        _statements(frames, labels, units, np.stack([plate.corners for plate in plates])),
        Layout(0, frames.count, 0, 0, real=True),
        tuple(labels),
        ("",) * len(labels),
        tuple(units),
        frames.rate * instants.samples,
        instants.samples,
        frames.first,
        np.ones(len(labels)),
        np.zeros(len(labels)),
        unsigned=False,
        notices=(),
        assumptions=(_NO_CORNERS,),
        has_surfaces=False,
        table=instants.read(seconds, columns),
    )


def _stand_in(table: ForceTable, frames: FramesOfTrial) -> list[_Plate]:
    """The plates of a table. Raises FormatError where none is loaded, or numbers are no forces in metres."""
    axis = _find_vertical(table)
    plates = [_make_plate(table.values, wrench, axis, frames.metres) for wrench in table.wrenches]
    loaded = [plate for plate in plates if plate is not None]
    if not loaded:
        raise FormatError(f"no force reaches {LEAST_FORCE:g} N", remedy="Send the forces of the trial.")
    return loaded


def _find_vertical(table: ForceTable) -> int:
    """The axis along which the ground carries the weight."""
    sums = np.abs(np.nansum([table.values[:, wrench.force] for wrench in table.wrenches], axis=(0, 1)))
    if not sums.max() > _UPRIGHT * np.linalg.norm(sums):
        raise FormatError("no axis of the forces is vertical", remedy="Give forces in axes of which one is vertical.")
    return int(sums.argmax())


def _make_plate(values: Array, wrench: Wrench, axis: int, metres: float) -> _Plate | None:
    """The plate that stands in for a wrench, with a sample for each row; None for one that is never loaded.

    metres: of the unit of the TRC.
    """
    force, nothing = values[:, wrench.force], np.zeros((len(values), 3))
    point = values[:, wrench.point] if wrench.point else nothing
    torque = values[:, wrench.torque] if wrench.torque else nothing
    upward = force[:, axis]
    loaded = np.abs(upward) >= LEAST_FORCE
    # Programs write 0 for the point of no force, and some NaN.
    pointless = ~loaded & ~(np.isfinite(point) & np.isfinite(torque)).all(axis=1)
    point, torque = (np.where(pointless[:, None], 0.0, part) for part in (point, torque))
    farthest = float(np.abs(point[loaded]).max(initial=0.0))
    if farthest > _FARTHEST:
        raise FormatError(
            f"points of {wrench.label} are up to {farthest:g} from the origin, metres are expected",
            remedy="Write points in metres, as OpenSim reads them.",
        )
    x, y = (axis + 1) % 3, (axis + 2) % 3
    centre = np.zeros(3)
    heights = point[loaded, axis][np.isfinite(point[loaded, axis])]
    centre[axis] = float(np.median(heights)) if len(heights) else 0.0
    moment = np.cross(point - centre, force) + torque
    steady = loaded & (np.abs(upward) >= _LOADED * np.abs(upward[loaded]).max(initial=0.0))
    places = np.stack([-moment[steady, y], moment[steady, x]], axis=1) / upward[steady, None]
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places):
        return None
    low, high = places.min(axis=0) - _MARGIN, places.max(axis=0) + _MARGIN
    corners = np.tile(centre, (4, 1))
    corners[:, x], corners[:, y] = [high[0], low[0], low[0], high[0]], [high[1], high[1], low[1], low[1]]
    # Moments are about the centre of the corners as a parameter of C3D holds them.
    kept = (corners / metres).astype(np.float32).astype(np.float64)
    moment -= np.cross(kept.mean(axis=0) * metres - centre, force)
    order = [x, y, axis]
    return _Plate(wrench, kept, np.concatenate([force[:, order], moment[:, order] / metres], axis=1))


def _statements(frames: FramesOfTrial, labels: Sequence[str], units: Sequence[str], corners: Array) -> Statements:
    """The statements of a C3D file with these channels and plates (P, 4, 3)."""
    count, channels = len(corners), len(labels)
    parameters = {
        "POINT:RATE": _floats("POINT:RATE", [frames.rate], ()),
        "POINT:UNITS": _texts("POINT:UNITS", [frames.length]),
        "ANALOG:LABELS": _texts("ANALOG:LABELS", labels),
        "ANALOG:UNITS": _texts("ANALOG:UNITS", units),
        "ANALOG:SCALE": _floats("ANALOG:SCALE", [1.0] * channels, (channels,)),
        "ANALOG:GEN_SCALE": _floats("ANALOG:GEN_SCALE", [1.0], ()),
        "ANALOG:OFFSET": _words("ANALOG:OFFSET", [0] * channels, (channels,)),
        "FORCE_PLATFORM:USED": _words("FORCE_PLATFORM:USED", [count], ()),
        "FORCE_PLATFORM:TYPE": _words("FORCE_PLATFORM:TYPE", [2] * count, (count,)),
        "FORCE_PLATFORM:CORNERS": _floats("FORCE_PLATFORM:CORNERS", corners.ravel().tolist(), (3, 4, count)),
        "FORCE_PLATFORM:ORIGIN": _floats("FORCE_PLATFORM:ORIGIN", [0.0] * (3 * count), (3, count)),
        "FORCE_PLATFORM:CHANNEL": _words("FORCE_PLATFORM:CHANNEL", range(1, 6 * count + 1), (6, count)),
        "FORCE_PLATFORM:ZERO": _words("FORCE_PLATFORM:ZERO", [0, 0], (2,)),
    }
    return Statements(_MACHINE, b"", np.zeros(256, np.int64), -1.0, frames.rate, parameters, (0, 0))


def _floats(spelling: str, numbers: Sequence[float], dimensions: tuple[int, ...]) -> Parameter:
    return Parameter(4, dimensions, np.array(numbers, "<f4").tobytes(), _MACHINE, spelling)


def _words(spelling: str, numbers: Sequence[int], dimensions: tuple[int, ...]) -> Parameter:
    return Parameter(2, dimensions, np.array(numbers, "<i2").tobytes(), _MACHINE, spelling)


def _texts(spelling: str, texts: Sequence[str]) -> Parameter:
    plain = [text.encode()[:LONGEST_TEXT] for text in texts]
    longest = max(1, *map(len, plain))
    return Parameter(-1, (longest, len(plain)), b"".join(text.ljust(longest) for text in plain), _MACHINE, spelling)
