"""Force plates of C3D files, from the group FORCE_PLATFORM. `mcml.laboratory.force_plates` computes their forces."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import BinaryIO, Final

import numpy as np

from mcml.formats.c3d.analog import Channels, read_channels
from mcml.formats.c3d.parameters import Statements
from mcml.formats.c3d.quantities import decode_text
from mcml.laboratory.force_plates import CHANNEL_COUNTS, Plate, plate_forces
from mcml.motion.floor_plates import MOST_PLATES, usable_plates
from mcml.motion.skeleton import Array
from mcml.motion.units import UNITS

_FORCES: Final = {"n": 1.0, "nt": 1.0, "newton": 1.0, "newtons": 1.0, "kn": 1000.0, "lb": 4.4482216152605}
_FORCES_ALONE: Final = {**_FORCES, "lbf": _FORCES["lb"], "lbs": _FORCES["lb"]}
_MOMENTS: Final = {
    **{force + length: newtons * UNITS[length] for force, newtons in _FORCES.items() for length in UNITS},
    **{length + force: newtons * UNITS[length] for force, newtons in _FORCES.items() for length in ("in", "ft")},
}
_QUANTITIES: Final = {1: "fffllm", 2: "fffmmm", 3: "ffffffff", 4: "fffmmm"}
"""The channels of each type: forces, moments and lengths."""

_MOST_BASELINE: Final = 10_000
"""Frames of a baseline that are read."""

_MOST_OFFSET: Final = 100.0
"""Newtons of a baseline; a larger one is a person on the plate."""

_NO_LETTERS: Final = re.compile(r"[\W\d_]+")


def read_plates(stream: BinaryIO) -> list[Plate]:
    """Read the force plates of a file; see `plates_of`. Raises as `read_channels`."""
    return plates_of(read_channels(stream))


def plates_of(channels: Channels, *, subtract_baseline: bool = False) -> list[Plate]:
    """Return the force plates of a file, in its order. A plate that cannot be used has reasons.

    subtract_baseline: whether the mean of the frames in FORCE_PLATFORM:ZERO is subtracted from each channel.
    """
    said = channels.said
    kinds = said.numbers("FORCE_PLATFORM:TYPE")
    count = _count_plates(said)
    types = [round(kind) if np.isfinite(kind) else 0 for kind in kinds] + [0] * count
    plates = [_plate(channels, index, types[index], count) for index in range(count)]
    return [plate if plate.problems else _add_baseline(channels, plate, asked=subtract_baseline) for plate in plates]


def _count_plates(said: Statements) -> int:
    used = said.number("FORCE_PLATFORM:USED")
    count = len(said.numbers("FORCE_PLATFORM:TYPE")) if used is None or not np.isfinite(used) else max(0, round(used))
    return min(MOST_PLATES, count)


def corners_of(said: Statements) -> Array:
    """Return (P, 4, 3) the corners of the plates that have any, in the unit of the file and the order of `Plate`."""
    corners = [_part(said, "CORNERS", index, 12) for index in range(_count_plates(said))]
    return usable_plates(np.array(corners, dtype=np.float64).reshape(-1, 4, 3))


def _plate(channels: Channels, index: int, kind: int, count: int) -> Plate:
    said = channels.said
    reasons: list[str] = []
    assumptions = list(channels.assumptions)
    unit, metres = _length(said, assumptions)
    corners = _part(said, "CORNERS", index, 12).reshape(4, 3) * metres
    origin = _part(said, "ORIGIN", index, 3) * metres
    if not kind:
        reasons.append("the file does not state its type")
    places: tuple[int, ...] = ()
    factors: tuple[float, ...] = ()
    if kind in CHANNEL_COUNTS:
        places = _places(channels, index, CHANNEL_COUNTS[kind], count, reasons)
        factors = _factors(channels, kind, places, unit, metres, assumptions)
    calibration = _part(said, "CAL_MATRIX", index, 36) if kind == 4 else None
    if calibration is not None:
        # By columns, as all parameters of several dimensions.
        calibration = None if np.isnan(calibration).any() else calibration.reshape(6, 6).T
    return Plate(
        kind, corners, origin, places, factors, calibration, tuple(reasons), tuple(assumptions),
        has_surface=channels.has_surfaces,
    )  # fmt: skip


def _add_baseline(channels: Channels, plate: Plate, *, asked: bool) -> Plate:
    """Return a usable plate with the baseline of the file, if it is asked for, and a note if the file has any.

    Source: The C3D File Format User Guide, "FORCE_PLATFORM:ZERO". Frames count from 1, the first of the file.
    """
    numbers = channels.said.numbers("FORCE_PLATFORM:ZERO", signed=True)[:2]
    if len(numbers) < 2 or not 1 <= numbers[0] <= numbers[1] <= channels.frames:
        return plate
    first, last = map(round, numbers)
    frames = f"frames {first} to {last}, its baseline by FORCE_PLATFORM:ZERO"
    if not asked:
        return replace(plate, assumptions=(*plate.assumptions, f"the mean of {frames}, is not subtracted"))
    means = channels.read(first - 1, min(last - first + 1, _MOST_BASELINE), plate.channels).mean(axis=0)
    force = float(np.linalg.norm(plate_forces(plate, means[None]).force))
    if not force <= _MOST_OFFSET:
        why = f"the mean of {frames}, is not subtracted: the plate has a load of {force:.0f} N then"
        return replace(plate, assumptions=(*plate.assumptions, why))
    why = f"the mean of {frames}, is subtracted: {force:.1f} N"
    return replace(plate, baseline=tuple(means.tolist()), assumptions=(*plate.assumptions, why))


def _part(said: Statements, name: str, index: int, size: int) -> Array:
    """The numbers of one plate in a parameter, NaN if there are too few."""
    numbers = said.numbers(f"FORCE_PLATFORM:{name}", signed=True)[index * size : (index + 1) * size]
    return np.array(numbers if len(numbers) == size else [np.nan] * size)


def _length(said: Statements, assumptions: list[str]) -> tuple[str, float]:
    """Return the unit of lengths and its metres."""
    texts = said.texts("POINT:UNITS")
    unit = decode_text(texts[0]).lower() if texts else ""
    if unit not in UNITS:
        what = f"has the unknown unit {unit!r}" if unit else "states no unit"
        assumptions.append(f"lengths are taken as mm: the file {what}")
        unit = "mm"
    return unit, UNITS[unit]


def _places(channels: Channels, index: int, needed: int, count: int, reasons: list[str]) -> tuple[int, ...]:
    """Return the places of the channels of a plate, from 0; () and a reason if any is absent."""
    parameter = channels.said.parameters.get("FORCE_PLATFORM:CHANNEL")
    numbers = parameter.numbers() if parameter is not None else []
    rows = parameter.dimensions[0] if parameter is not None and len(parameter.dimensions) > 1 else len(numbers) // count
    own = [round(number) for number in numbers[index * rows : (index + 1) * rows][:needed] if np.isfinite(number)]
    if len(own) < needed:
        reasons.append(f"the file names {len(own)} of its {needed} channels")
        return ()
    absent = [number for number in own if not 1 <= number <= len(channels)]
    if absent:
        listed = ", ".join(map(str, absent))
        reasons.append(f"its channels {listed} are not in the file, which has {len(channels)}")
        return ()
    return tuple(number - 1 for number in own)


def _factors(
    channels: Channels, kind: int, places: tuple[int, ...], unit: str, metres: float, assumptions: list[str]
) -> tuple[float, ...]:
    """Return newtons, newton metres and metres of the units of a plate's channels."""
    factors: list[float] = []
    for place, quantity in zip(places, _QUANTITIES[kind], strict=False):
        known, default, usual = {
            "f": (_FORCES_ALONE, 1.0, "N"),
            "m": (_MOMENTS, metres, f"N {unit}"),
            "l": (UNITS, metres, unit),
        }[quantity]
        written = channels.units[place]
        factor = known.get(_NO_LETTERS.sub("", written).lower())
        # Channels of type 4 are volts as a rule: the calibration gives newtons.
        if factor is None and not (kind == 4 and quantity == "f"):
            what = f"have the unit {written!r}" if written else "have no unit"
            part = {"f": "forces", "m": "moments", "l": "lengths"}[quantity]
            assumption = f"its {part} are taken as {usual}: the channels {what}"
            assumptions += [] if assumption in assumptions else [assumption]
        factors.append(default if factor is None else factor)
    return tuple(factors)
