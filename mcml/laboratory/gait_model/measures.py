"""Measures of a subject that the Conventional Gait Model takes, by the names of Plug-in Gait.

Lengths are millimetres, angles radians, the mass kilograms. Files of older programs have angles in degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

USUAL_DIAMETER: Final = 14.0
"""Millimetres of the markers of most laboratories."""

ANGLES: Final = (
    "ThighRotation",
    "ShankRotation",
    "TibiaRotation",
    "TibialTorsion",
    "AnkleAbAdd",
    "StaticPlantFlex",
    "StaticRotOff",
    "HeadOffset",
)
"""Ends of the names of angles."""

_POSITIVE: Final = ("LegLength", "AsisTrocanterDistance", "KneeWidth", "AnkleWidth", "ElbowWidth", "WristWidth",
                    "HandThickness", "InterAsisDistance", "MarkerDiameter", "Bodymass", "Height")  # fmt: skip
"""Measures that are absent where they are 0: programs write 0 for a measure that nobody took."""

_UNITS: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
_PLAUSIBLE: Final = {"LLegLength": (250.0, 1400.0), "RLegLength": (250.0, 1400.0), "Height": (400.0, 2500.0)}
"""Least and largest millimetres of people, which tell the unit of a file."""


@dataclass(frozen=True)
class Measures:
    """values: by name, such as "LKneeWidth" or "InterAsisDistance". were_degrees: whether angles were degrees. unit: of
    lengths in the file, "mm" as a rule."""

    values: Mapping[str, float] = field(default_factory=dict)
    were_degrees: bool = False
    unit: str = "mm"

    def get(self, name: str) -> float | None:
        """The value of a measure, None where it is absent."""
        return self.values.get(name)

    def of(self, name: str, default: float = 0.0) -> float:
        """The value of a measure, the default where it is absent."""
        return self.values.get(name, default)

    def with_values(self, more: Mapping[str, float]) -> Measures:
        """Return the same with further values in the place of its own."""
        return Measures({**self.values, **more}, self.were_degrees, self.unit)


def clean_measures(stated: Mapping[str, float]) -> Measures:
    """Return the measures of a file: finite ones, without zeros that mean "absent", and with angles in radians.

    If any angle is larger than pi, all of them are degrees. stated: by name, in any case of letters.
    """
    by_key = {_key(name): name for name in NAMES}
    values = {by_key[_key(name)]: value for name, value in stated.items() if _key(name) in by_key}
    values = {
        name: float(value)
        for name, value in values.items()
        if np.isfinite(value) and not (value <= 0 and _stem(name) in _POSITIVE)
    }
    angles = [name for name in values if _stem(name) in ANGLES]
    are_degrees = any(abs(values[name]) > np.pi for name in angles)
    if are_degrees:
        values |= {name: float(np.radians(values[name])) for name in angles}
    for side in "LR":
        # Both names are in use.
        if (turn := values.pop(f"{side}TibiaRotation", None)) is not None:
            values.setdefault(f"{side}ShankRotation", turn)
    unit, factor = _unit_of(values)
    values |= {name: factor * values[name] for name in values if _stem(name) in _LENGTHS}
    return Measures(values, are_degrees, unit)


def has_known_lengths(measures: Measures) -> bool:
    """Whether a leg or the height is that of people, so that the unit of the lengths is sure."""
    return any(least <= measures.of(name, np.nan) <= most for name, (least, most) in _PLAUSIBLE.items())


def _unit_of(values: Mapping[str, float]) -> tuple[str, float]:
    """(unit, its millimetres) in which a leg, else the height, is that of people; millimetres if neither tells."""
    for name, (least, most) in _PLAUSIBLE.items():
        for unit, factor in _UNITS.items():
            if name in values and least <= factor * values[name] <= most:
                return unit, factor
    return "mm", 1.0


_MIDDLE: Final = ("InterAsisDistance", "MarkerDiameter", "Bodymass", "HeadOffset", "Height")
_SIDED: Final = ("LegLength", "KneeWidth", "AnkleWidth", "AsisTrocanterDistance", "ShoulderOffset", "ElbowWidth",
                 "WristWidth", "HandThickness", *(name for name in ANGLES if name != "HeadOffset"))  # fmt: skip
_LENGTHS: Final = frozenset({*_MIDDLE, *_SIDED}) - {*ANGLES, "Bodymass"}
NAMES: Final = (*_MIDDLE, *(side + name for side in "LR" for name in _SIDED))
BODY_MEASURES: Final = tuple(name for name in NAMES if not name.endswith((*ANGLES, "MarkerDiameter")))
"""Measures of a person. The others describe how markers were placed."""


def _key(name: str) -> str:
    return name.strip().lower()


def _stem(name: str) -> str:
    return name if name in _MIDDLE else name[1:]
