"""Units of length and angle as motion files name them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.clip import ClipHead

UNITS: Final[Mapping[str, float]] = {
    "mm": 0.001,
    "cm": 0.01,
    "dm": 0.1,
    "m": 1.0,
    "in": 0.0254,
    "inch": 0.0254,
    "inches": 0.0254,
    "ft": 0.3048,
    "foot": 0.3048,
    "feet": 0.3048,
}
"""Metres of each unit of length."""


def metres_per_unit(name: str) -> float:
    """Return the metres of a unit; case is ignored. Raises ConversionError for an unknown one."""
    metres = UNITS.get(name.strip().lower())
    if metres is None:
        raise ConversionError(f"Unknown unit of length {name!r}.", remedy=f"Use one of: {', '.join(UNITS)}.")
    return metres


def metres_of(head: ClipHead) -> float | None:
    """Metres of the clip's unit of length, None if the file does not state it.

    ASF: local units are value / `length`; those of Vicon's files (CMU, HDM05: length 0.45) are inches, which the file
    itself does not state, so it is used only if the header states a calibration unit (docs/formats/asf-amc.md).
    """
    unit = head.fields.get("calibration_unit")
    return UNITS.get(unit.strip().lower()) if unit else None


@dataclass(frozen=True, slots=True)
class Reading:
    """The units of the numbers of a clip.

    rest_angle, motion_angle: radians of a unit of angle, in the skeleton and in the frames. bone_axis: 0, 1, 2, the
    local axis along which a bone of BASE extends.
    """

    rest_angle: float = np.pi / 180
    motion_angle: float = np.pi / 180
    bone_axis: int = 1


DEGREES: Final = Reading()


def reading_of(head: ClipHead) -> Reading:
    """Angle units and bone axis of a clip: of its header, and of the flag of an AMC (docs/formats/asf-amc.md)."""
    rest = _radians(head.fields.get("units_angle", "deg"))
    motion = rest
    for source in head.sources:
        for flag in source.flags:
            if flag.lower() in (":degrees", ":radians"):
                motion = _radians(flag[1:])
    axis = head.fields.get("bone_length_axis", "Y").strip().upper()
    return Reading(rest, motion, "XYZ".index(axis) if axis in ("X", "Y", "Z") else 1)


def _radians(name: str) -> float:
    return 1.0 if name.strip().lower().startswith("rad") else np.pi / 180
