"""Properties of a header that state a subject for the gait model: measures of the file, or stated by people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Final, Literal, TypeAlias

import numpy as np
import orjson

from mcml.formats.text.numbers import is_number
from mcml.laboratory.gait_model.measures import ANGLES, BODY_MEASURES, NAMES, Measures, has_known_lengths
from mcml.laboratory.gait_model.standing_trial import StandingTrial
from mcml.laboratory.gait_model.static_pass import FootOption
from mcml.laboratory.gait_model.virtual_markers import VIRTUAL, VirtualMarker
from mcml.motion.landmarks.sizes import PREFIX, to_metres, to_radians

Property: TypeAlias = tuple[str, str, str]
"""Name, value and unit."""

_FOOT: Final = "foot"
FOOT_OPTIONS: Final[dict[str, FootOption]] = {"flat": "foot flat", "as it stands": "as it stands"}
_MILLIMETRES: Final = 1000.0
_WANDS: Final = ("LThighRotation", "RThighRotation", "LShankRotation", "RShankRotation")
"""Angles of wands, with which the body of the clip places knees and ankles."""
_STANDING: Final = "standing trial"
"""The property that names the standing trial from which others come."""
_SAME: Final = 0.005
"""Relative difference of two measures that are told apart."""
_MASS: Final = "Bodymass"
_PLACES: Final = 3
"""Decimals of millimetres."""
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
            yield before + name, f"{value:.7g}", unit_of_measure(name)
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


def use_standing_trial(
    properties: Iterable[Property], trial: StandingTrial, title: str, of_file: Measures, subject: str = ""
) -> tuple[list[Property], list[str]]:
    """(properties of a walking trial with the measures of a standing one, notes).

    properties: of the walking trial; those of an earlier standing trial, and all offsets among them, are replaced.
    title: the name of the standing trial. of_file: measures in the walking trial's file. subject: its name, where the
    clip has several. Measures of the body that the walking trial states itself stay, and a note tells of a difference.
    """
    begin, kept = _begin_of(subject), list(properties)
    is_again = any(name == begin + _STANDING for name, _, _ in kept)
    stated = read_properties(kept, subject)[0]
    gone = {begin + _STANDING, *(begin + name for name in NAMES if name.endswith(ANGLES))}
    gone |= {begin + side + stem for side in "LR" for stem in VIRTUAL}
    used: dict[str, Property] = {}
    notes = []
    for measure in trial.measures:
        name = measure.name
        own = of_file.get(name) if is_again else stated.get(name, of_file.get(name))
        if measure.is_offset or own is None:
            used[name] = (begin + name, f"{measure.value:.9g}", unit_of_measure(name))
        elif not math.isclose(own, measure.value, rel_tol=_SAME):
            unit = unit_of_measure(name)
            notes.append(f"{name} stays {own:.4g} {unit}; the standing trial has {measure.value:.4g} {unit}")
    for name, marker in trial.virtual.items():
        places = {label: [round(number, _PLACES) for number in place] for label, place in marker.places.items()}
        used[name] = (begin + name, orjson.dumps(places).decode(), "mm")
    wands = [item for item in state_measures(of_file, subject) if item[0] in {begin + name for name in _WANDS}]
    gone |= {begin + name for name in used}
    items = [item for item in kept if item[0] not in gone]
    items += [item for item in wands if item[0].removeprefix(begin) not in used]
    return [*items, *used.values(), (begin + _STANDING, title, "")], notes


def read_virtual_markers(properties: Iterable[Property], subject: str = "") -> Iterator[tuple[str, VirtualMarker]]:
    """Yield (name with its side, virtual marker) of properties; others are passed over."""
    begin = _begin_of(subject)
    for name, value, _ in properties:
        if name.startswith(begin) and name.removeprefix(begin)[1:] in VIRTUAL:
            try:
                read = orjson.loads(value)
                places = {str(label): tuple(map(float, place)) for label, place in read.items()}
            except (ValueError, TypeError, AttributeError):
                continue
            if places and np.isfinite([*places.values()]).all() and {len(place) for place in places.values()} == {3}:
                yield name.removeprefix(begin), VirtualMarker(places)


def standing_trial_of(properties: Iterable[Property], subject: str = "") -> str:
    """The name of the standing trial that properties name, "" for none."""
    named = _begin_of(subject) + _STANDING
    return next((value for name, value, _ in properties if name == named), "")


def unit_of_measure(name: str) -> Literal["mm", "rad", "kg"]:
    """The unit in which properties state a measure."""
    return "rad" if name.endswith(ANGLES) else "kg" if name == _MASS else "mm"


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
            foot = FOOT_OPTIONS.get(value.strip().lower(), foot)
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
