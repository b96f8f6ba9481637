"""Sizes of a person that place the centres of joints beside their markers, from properties of a clip.

Properties are named as the Conventional Gait Model names its measures: "gait LKneeWidth" in millimetres, "gait
RThighRotation" in degrees, or in the unit that they state; of several people "gait Anna LKneeWidth".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from mcml.motion.clip import ClipHead
from mcml.motion.units import UNITS

PREFIX: Final = "gait "
"""Beginning of the names of properties that state measures."""
USUAL_DIAMETER: Final = 0.014
"""Metres of the markers of most laboratories."""

_SIDES: Final = {"l": "left", "r": "right"}
_WIDTHS: Final = {"kneewidth": "low_leg", "anklewidth": "foot", "elbowwidth": "low_arm"}
_TURNS: Final = {"thighrotation": "low_leg", "shankrotation": "foot", "tibiarotation": "foot"}
_DIAMETER: Final = "markerdiameter"
_WIDEST: Final = 0.4
"""Metres of a joint at most: a larger number is no width."""


@dataclass(frozen=True)
class Sizes:
    """Sizes of the people in a clip.

    metres: of a unit of positions, None where it is unknown. widths: metres of joints, by the names of their centres.
    turns: radians from the marker to the wand about the bone, as `construction.place_centre` takes them, by the names
    of centres. diameter: metres of markers.
    """

    metres: float | None = None
    widths: Mapping[str, float] = field(default_factory=dict)
    turns: Mapping[str, float] = field(default_factory=dict)
    diameter: float = USUAL_DIAMETER

    def radius(self, name: str) -> float | None:
        """Distance of a lateral marker from the centre of its joint, in the unit of positions; None if unknown."""
        if self.metres is None or name not in self.widths:
            return None
        return (self.widths[name] + self.diameter) / 2 / self.metres


def sizes_of(head: ClipHead, metres: float | None) -> Sizes:
    """Read the sizes that the properties of a clip state; other properties are passed over.

    metres: of a unit of its positions, None if it is unknown.
    """
    widths: dict[str, float] = {}
    turns: dict[str, float] = {}
    diameter = USUAL_DIAMETER
    for name, text, unit in head.properties:
        person, _, measure = name.removeprefix(PREFIX).strip().rpartition(" ")
        measure = measure.lower()
        side, stem = _SIDES.get(measure[:1], ""), measure[1:]
        before = f"{person}:" if person else ""
        value = _number(text)
        if not name.startswith(PREFIX) or value is None:
            continue
        if measure == _DIAMETER and 0 < (length := to_metres(value, unit)) < _WIDEST:
            diameter = length
        elif side and stem in _WIDTHS and 0 < (length := to_metres(value, unit)) < _WIDEST:
            widths[f"{before}{side}_{_WIDTHS[stem]}"] = length
        elif side and stem in _TURNS:
            turn = to_radians(value, unit)
            turns[f"{before}{side}_{_TURNS[stem]}"] = turn if side == "left" else -turn
    return Sizes(metres, widths, turns, diameter)


def to_metres(value: float, unit: str) -> float:
    """Metres of a length in a property; without a known unit it is millimetres."""
    return value * UNITS.get(unit.strip().lower(), 0.001)


def to_radians(value: float, unit: str) -> float:
    """Radians of an angle in a property; without the unit "rad" it is degrees."""
    return value if unit.strip().lower().startswith("rad") else math.radians(value)


def _number(text: str) -> float | None:
    try:
        value = float(text.strip())
    except ValueError:
        return None
    return value if math.isfinite(value) else None
