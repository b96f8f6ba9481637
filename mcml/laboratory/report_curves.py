"""The curves of a gait report: joint angles of both sides, with moments and powers where a file has them.

Names and signs are those of Plug-in Gait's quantities (Davis et al. 1991; Vicon, "Plug-in Gait Reference Guide").
Bodies without them show angles of their joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from mcml.laboratory.gait_events import SIDES, Side


@dataclass(frozen=True)
class ReportCurve:
    """quantities: of the left and of the right side, as requests write them. positive, negative: directions."""

    title: str
    quantities: Mapping[Side, str]
    positive: str = ""
    negative: str = ""


_OF_MODEL: Final = (
    ("Pelvic tilt", "PelvisAngles", "x", "anterior", "posterior"),
    ("Pelvic obliquity", "PelvisAngles", "y", "up", "down"),
    ("Pelvic rotation", "PelvisAngles", "z", "internal", "external"),
    ("Hip flexion", "HipAngles", "x", "flexion", "extension"),
    ("Hip adduction", "HipAngles", "y", "adduction", "abduction"),
    ("Hip rotation", "HipAngles", "z", "internal", "external"),
    ("Knee flexion", "KneeAngles", "x", "flexion", "extension"),
    ("Knee varus", "KneeAngles", "y", "varus", "valgus"),
    ("Knee rotation", "KneeAngles", "z", "internal", "external"),
    ("Ankle dorsiflexion", "AnkleAngles", "x", "dorsiflexion", "plantarflexion"),
    ("Ankle rotation", "AnkleAngles", "z", "internal", "external"),
    ("Foot progression", "FootProgressAngles", "z", "internal", "external"),
    ("Hip moment", "HipMoment", "x", "extensor", "flexor"),
    ("Knee moment", "KneeMoment", "x", "extensor", "flexor"),
    ("Ankle moment", "AnkleMoment", "x", "plantarflexor", "dorsiflexor"),
    ("Hip power", "HipPower", "z", "generated", "absorbed"),
    ("Knee power", "KneePower", "z", "generated", "absorbed"),
    ("Ankle power", "AnklePower", "z", "generated", "absorbed"),
)
"""(title, label without the side, axis, positive, negative)."""

_OF_SKELETON: Final = (
    ("Pelvic tilt", "pelvis-tilt", "anterior", "posterior"),
    ("Hip flexion", "hip-flexion", "flexion", "extension"),
    ("Hip adduction", "hip-adduction", "adduction", "abduction"),
    ("Hip rotation", "hip-internal-rotation", "internal", "external"),
    ("Knee flexion", "knee-flexion", "flexion", "extension"),
    ("Knee varus", "knee-varus", "varus", "valgus"),
    ("Knee rotation", "knee-internal-rotation", "internal", "external"),
    ("Ankle dorsiflexion", "ankle-dorsiflexion", "dorsiflexion", "plantarflexion"),
)
"""(title, angle without the side, positive, negative)."""


def choose_curves(labels: Iterable[str], angles: Iterable[str]) -> tuple[ReportCurve, ...]:
    """Choose the curves that a document can have, in the order of a report.

    labels: of the quantities of its file or of a computed model. angles: names of angles of bodies, for documents
    without such quantities; none for markers alone.
    """
    by_end = {label.rpartition(":")[2]: label for label in reversed(list(labels))}
    own = tuple(
        ReportCurve(title, {side: f"quantity:{by_end[side[0].upper() + stem]},{axis}" for side in SIDES}, *words)
        for title, stem, axis, *words in _OF_MODEL
        if all(side[0].upper() + stem in by_end for side in SIDES)
    )
    if own:
        return own
    known = set(angles)
    curves = []
    for title, name, *words in _OF_SKELETON:
        names = {side: name if name in known else f"{side}-{name}" for side in SIDES}
        if known.issuperset(names.values()):
            curves.append(ReportCurve(title, {side: f"angle:{name}" for side, name in names.items()}, *words))
    return tuple(curves)
