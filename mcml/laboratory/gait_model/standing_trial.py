"""Measures that a standing trial of the Conventional Gait Model 1 gives to the walking trials of the same person.

Lengths that nobody took with a ruler come from medial markers: widths of knees and ankles are the distances between
lateral and medial marker without a marker's diameter, the length of a leg is that from the front spine of the pelvis to
the medial marker of the ankle. The offsets are those of `static_pass`. The markers of both trials must be in the same
places on the skin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

import numpy as np

from mcml.laboratory.gait_model.lower_body import Markers
from mcml.laboratory.gait_model.measures import ANGLES, NAMES, Measures
from mcml.laboratory.gait_model.static_pass import FootOption, has_device, mean_of
from mcml.laboratory.gait_model.subject import find_subject, has_pelvis, is_standing, list_lacks
from mcml.laboratory.gait_model.virtual_markers import VirtualMarker
from mcml.motion.skeleton import Array

Source: TypeAlias = Literal["stated", "markers", "alignment device", "medial knee marker", "medial ankle marker",
                            "heel and toe"]  # fmt: skip
"""How a measure is known. stated: by the file or by properties."""

STANDING_REMEDY: Final = (
    "Choose a trial in which the person stands still, with markers of pelvis, knees, ankles, heels and toes, and with "
    "measures of the legs or medial markers."
)
"""For trials that have no such measures."""

_WIDTHS: Final = {"KneeWidth": ("KNE", "KNM"), "AnkleWidth": ("ANK", "MED")}
_FOOT: Final = ("StaticPlantFlex", "StaticRotOff")


@dataclass(frozen=True)
class StandingMeasure:
    """name: of Plug-in Gait, with its side. value: millimetres, radians or kilograms."""

    name: str
    value: float
    source: Source

    @property
    def is_offset(self) -> bool:
        """Whether it tells how markers were placed, which the standing trial decides."""
        return self.name.endswith(ANGLES)


@dataclass(frozen=True)
class StandingTrial:
    """measures: in the order of `measures.NAMES`. virtual: markers of knees and ankles that others carry, by names such
    as "LKneeMedial". notes: assumptions. lacks: the reason if there is nothing of both, else ""."""

    measures: tuple[StandingMeasure, ...] = ()
    virtual: Mapping[str, VirtualMarker] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    lacks: str = ""


def measure_standing(
    measures: Measures,
    markers: Markers,
    up: Array,
    foot: FootOption | None,
    find_virtual: Callable[[], Mapping[str, VirtualMarker]] = dict,
) -> StandingTrial:
    """Measure a standing trial.

    measures: stated by the file or by properties. markers: (n, 3) millimetres. up: (3,) an axis of the laboratory.
    foot: as for `find_subject`. find_virtual: returns the virtual markers, if somebody stands.
    """
    if not has_pelvis(markers):
        return StandingTrial(lacks="the markers LASI, RASI and LPSI, RPSI or SACR are missing")
    if not is_standing(markers):
        return StandingTrial(lacks="ankles or pelvis move by more than 100 mm, so nobody stands still")
    taken = dict(_measure_lengths(measures, markers, find_subject(measures, markers, up).diameter))
    subject = find_subject(measures.with_values(taken), markers, up, foot)
    lacks = ", ".join(lack for side in "LR" for lack in list_lacks(side, markers, subject.measures))
    virtual = find_virtual()
    if not subject.is_static and not virtual:
        return StandingTrial(lacks=lacks)
    known = {name: StandingMeasure(name, value, "stated") for name, value in measures.values.items()}
    if measures.get("InterAsisDistance") is None:
        taken["InterAsisDistance"] = subject.width
    known |= {name: StandingMeasure(name, value, "markers") for name, value in taken.items()}
    known |= {name: StandingMeasure(name, value, _source_of(name, markers)) for name, value in subject.offsets.items()}
    notes = [note for note in (subject.diameter_note, subject.static_note) if note]
    notes += [f"offsets are not known of both sides, missing: {lacks}"] if lacks else []
    return StandingTrial(tuple(known[name] for name in NAMES if name in known), virtual, tuple(notes))


def _measure_lengths(measures: Measures, markers: Markers, diameter: float) -> Iterator[tuple[str, float]]:
    """(name, millimetres) of widths and legs that are not stated and that medial markers tell."""
    for side in "LR":
        for name, pair in _WIDTHS.items():
            lateral, medial = (markers.get(side + marker) for marker in pair)
            if measures.get(side + name) is None and lateral is not None and medial is not None:
                width = mean_of(np.linalg.norm(lateral - medial, axis=1)) - diameter
                if width > 0:
                    yield side + name, width
        spine, ankle = markers[f"{side}ASI"], markers.get(f"{side}MED")
        if measures.get(f"{side}LegLength") is None and ankle is not None:
            length = mean_of(np.linalg.norm(spine - ankle, axis=1))
            if np.isfinite(length):
                yield f"{side}LegLength", length


def _source_of(name: str, markers: Markers) -> Source:
    side, stem = name[0], name[1:]
    if stem in _FOOT:
        return "heel and toe"
    if stem != "ThighRotation":
        return "medial ankle marker"
    return "alignment device" if has_device(side, markers) else "medial knee marker"
