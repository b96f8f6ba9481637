"""Properties of a header that state a subject for the gait model: measures that the file lacks, or has wrong."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from mcml.formats.text.numbers import is_number
from mcml.laboratory.gait_model.measures import ANGLES, NAMES
from mcml.laboratory.gait_model.static_pass import FootOption
from mcml.motion.units import UNITS

PREFIX: Final = "gait "
"""Properties that begin so state measures by the names of Plug-in Gait: "gait LKneeWidth"."""

_FOOT: Final = "foot"
_OPTIONS: Final[dict[str, FootOption]] = {"flat": "foot flat", "as it stands": "as it stands"}
_MILLIMETRES: Final = 1000.0


def read_properties(properties: Iterable[tuple[str, str, str]]) -> tuple[dict[str, float], FootOption | None]:
    """(measures in millimetres, radians and kilograms, how a standing trial takes the foot) that properties state.

    properties: (name, value, unit). Lengths without a unit are millimetres, angles without "rad" are degrees. Others
    than known measures and finite numbers are passed over.
    """
    measures: dict[str, float] = {}
    foot: FootOption | None = None
    known = {name.lower(): name for name in NAMES}
    for name, value, unit in properties:
        asked = name.removeprefix(PREFIX).strip().lower()
        if not name.startswith(PREFIX):
            continue
        if asked == _FOOT:
            foot = _OPTIONS.get(value.strip().lower(), foot)
        elif asked in known and is_number(value.strip()) and math.isfinite(float(value)):
            measures[known[asked]] = _to_own_unit(known[asked], float(value), unit.strip().lower())
    return measures, foot


def _to_own_unit(name: str, value: float, unit: str) -> float:
    if name.endswith(ANGLES):
        return value if unit.startswith("rad") else float(np.radians(value))
    return value if name == "Bodymass" else value * UNITS.get(unit, 1 / _MILLIMETRES) * _MILLIMETRES
