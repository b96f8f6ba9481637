"""Properties of a header that state a subject for the gait model: measures of the file, or stated by people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from mcml.formats.text.numbers import is_number
from mcml.laboratory.gait_model.measures import ANGLES, BODY_MEASURES, NAMES, Measures, has_known_lengths
from mcml.laboratory.gait_model.static_pass import FootOption
from mcml.motion.landmarks.sizes import PREFIX, to_metres, to_radians

_FOOT: Final = "foot"
_OPTIONS: Final[dict[str, FootOption]] = {"flat": "foot flat", "as it stands": "as it stands"}
_MILLIMETRES: Final = 1000.0
_WANDS: Final = ("LThighRotation", "RThighRotation", "LShankRotation", "RShankRotation")
"""Angles of wands, with which the body of the clip places knees and ankles."""
_MASS: Final = "Bodymass"
_DIGITS: Final = 1e-6


def state_measures(measures: Measures, subject: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield (name, value, unit) of properties for the measures of a body: "gait LKneeWidth", "104", "mm".

    subject: its name, where the file has several: "gait Anna LKneeWidth". Of angles only those of wands, which place
    knees and ankles (`landmarks.sizes`). Lengths whose unit is not sure are left out. Values have the 7 digits of
    single precision.
    """
    before = _begin_of(subject)
    names = BODY_MEASURES if has_known_lengths(measures) else [_MASS]
    for name in names:
        if (value := measures.get(name)) is not None:
            yield before + name, f"{value:.7g}", "kg" if name == _MASS else "mm"
    for name in _WANDS:
        if value := measures.of(name):
            yield before + name, f"{value:.7g}", "rad"


def leave_out_equal(stated: Mapping[str, float], measures: Measures) -> dict[str, float]:
    """Stated measures without those that a file has itself, up to the digits that `state_measures` writes."""
    return {
        name: value
        for name, value in stated.items()
        if not math.isclose(value, measures.of(name, math.nan), rel_tol=_DIGITS)
    }


def _begin_of(subject: str) -> str:
    """How names of the properties of a subject begin."""
    # Lists of documents take the text before the first colon as the name of a property.
    whose = "".join(letter if letter.isprintable() and letter != ":" else "_" for letter in subject)
    return f"{PREFIX}{whose} " if whose else PREFIX


def read_properties(
    properties: Iterable[tuple[str, str, str]], subject: str = ""
) -> tuple[dict[str, float], FootOption | None]:
    """(measures in millimetres, radians and kilograms, how a standing trial takes the foot) that properties state.

    properties: (name, value, unit). subject: its name, where the clip has several. Lengths without a unit are
    millimetres, angles without "rad" are degrees. Others than known measures and finite numbers are passed over.
    """
    measures: dict[str, float] = {}
    foot: FootOption | None = None
    known = {name.lower(): name for name in NAMES}
    begin = _begin_of(subject)
    for name, value, unit in properties:
        asked = name.removeprefix(begin).strip().lower()
        if not name.startswith(begin):
            continue
        if asked == _FOOT:
            foot = _OPTIONS.get(value.strip().lower(), foot)
        elif asked in known and is_number(value.strip()) and math.isfinite(float(value)):
            measures[known[asked]] = _to_own_unit(known[asked], float(value), unit.strip().lower())
    return measures, foot


def is_baseline_asked(properties: Iterable[tuple[str, str, str]]) -> bool:
    """Whether the property "gait baseline" says "subtract": the baseline of force plates that a file states."""
    return any(name == f"{PREFIX}baseline" and value.strip().lower() == "subtract" for name, value, _ in properties)


def _to_own_unit(name: str, value: float, unit: str) -> float:
    if name.endswith(ANGLES):
        return to_radians(value, unit)
    return value if name == _MASS else to_metres(value, unit) * _MILLIMETRES
