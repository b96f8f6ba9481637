"""The standing trial of the Conventional Gait Model 1: its angles, and the offsets that walking trials take from it.

The sole of the foot is taken as level in standing: the line from heel to toe is the foot's x, and its angle to the line
from ankle to toe is the offset. The knee's axis comes from an alignment device (KAX, KD1, KD2) or a medial marker (KNM)
where there is one, that of the ankle from a medial marker (MED). Source: Davis et al. 1991; the program is known as
Plug-in Gait.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from mcml.laboratory.gait_model.lower_body import (
    SIGNS,
    Leg,
    Markers,
    ankle_centre,
    foot_frame,
    knee_centre,
    shank_frames,
    thigh_frame,
)
from mcml.laboratory.gait_model.measures import Measures
from mcml.laboratory.gait_model.segment_frames import column, transpose
from mcml.motion.landmarks.construction import angle_about, place_centre
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, dot, unit

FootOption: TypeAlias = Literal["as it stands", "foot flat"]
"""Whether the heel marker is first set to the height of the toe marker."""

DEVICE: Final = ("KAX", "KD1", "KD2")
"""Markers of the knee alignment device, without the side."""

MEDIAL: Final = ("KNM", "MED")
"""Medial markers of knee and ankle, without the side."""


@dataclass(frozen=True, eq=False)
class StaticLeg:
    """leg: of a standing trial. offsets: radians by the names of Plug-in Gait with a side, such as "LStaticPlantFlex";
    NaN where they are unknown."""

    leg: Leg
    offsets: Mapping[str, float]


def has_device(side: str, markers: Markers) -> bool:
    """Whether a side wears the knee alignment device."""
    return all(f"{side}{name}" in markers for name in DEVICE)


def has_knee_axis(side: str, markers: Markers) -> bool:
    """Whether the device or a medial marker tells the axis of a knee."""
    return has_device(side, markers) or {f"{side}KNE", f"{side}KNM"} <= markers.keys()


def find_knee(side: str, markers: Markers) -> Array:
    """(n, 3) where the knee's marker would be that the alignment device stands for.

    The device's three markers are at equal distances along axes from the marker's place.
    """
    axis, upper, lower = (markers[f"{side}{name}"] for name in DEVICE)
    sides = [np.linalg.norm(a - b, axis=1) for a, b in ((axis, upper), (upper, lower), (lower, axis))]
    edge = np.mean(sides, axis=0) / np.sqrt(2.0)
    normal = unit(np.cross(upper - axis, lower - axis))
    knee: Array = (axis + upper + lower) / 3 - SIGNS[side] * (edge / np.sqrt(3.0))[:, None] * normal
    return knee


def stand(
    side: str,
    hip: Array,
    markers: Markers,
    measures: Measures,
    diameter: float,
    up: Array,
    option: FootOption,
    known: tuple[Array | None, Array | None] = (None, None),
) -> StaticLeg:
    """Return a leg in a standing trial, and its offsets.

    markers: with HEE. Where they have an alignment device or medial markers, rotations of thigh and shank and torsion
    of the tibia come from these. up: (3,) of the laboratory. known: centres (n, 3) of knee and ankle that are not to be
    constructed.
    """
    k = SIGNS[side]
    offsets: dict[str, float] = {}
    lateral = find_knee(side, markers) if has_device(side, markers) else markers[f"{side}KNE"]
    if has_knee_axis(side, markers):
        knee = _knee_on_axis(side, hip, lateral, markers, (measures.of(f"{side}KneeWidth", np.nan) + diameter) / 2)
        if known[0] is not None and not has_device(side, markers):
            knee = known[0]
        if f"{side}THI" in markers:
            turn = angle_about(hip - knee, lateral - knee, markers[f"{side}THI"] - knee)
            offsets[f"{side}ThighRotation"] = mean_of(k * turn)
    else:
        knee = knee_centre(side, hip, markers, measures, diameter) if known[0] is None else known[0]
    malleolus = markers[f"{side}ANK"]
    if f"{side}MED" in markers:
        radius = (measures.of(f"{side}AnkleWidth", np.nan) + diameter) / 2
        ankle = malleolus + radius * unit(markers[f"{side}MED"] - malleolus)
        up_shank = knee - ankle
        if f"{side}TIB" in markers:
            turn = angle_about(up_shank, malleolus - ankle, markers[f"{side}TIB"] - ankle)
            offsets[f"{side}ShankRotation"] = mean_of(k * turn)
        torsion = angle_about(up_shank, k * (malleolus - ankle), k * (lateral - knee))
        offsets[f"{side}TibialTorsion"] = mean_of(k * torsion)
        offsets[f"{side}AnkleAbAdd"] = np.radians(mean_of(angle_between(up_shank, malleolus - ankle)) - 90.0)
    else:
        ankle = ankle_centre(side, knee, markers, measures, diameter) if known[1] is None else known[1]
    thigh = thigh_frame(side, hip, knee, lateral)
    torsioned, shank = shank_frames(side, knee, ankle, malleolus, 0.0)
    heel, toe = markers[f"{side}HEE"], markers[f"{side}TOE"]
    if option == "foot flat":
        heel = heel + dot(toe - heel, np.broadcast_to(up, heel.shape))[:, None] * up
    left = column(torsioned, 1)
    sole = (transpose(foot_frame(ankle - toe, left)) @ unit(toe - heel)[:, :, None])[:, :, 0]
    offsets[f"{side}StaticPlantFlex"] = mean_of(np.arctan2(sole[:, 2], sole[:, 0]))
    offsets[f"{side}StaticRotOff"] = mean_of(np.arcsin(np.clip(-k * sole[:, 1], -1.0, 1.0)))
    foot = foot_frame(heel - toe, left)
    return StaticLeg(Leg(hip, knee, ankle, thigh, torsioned, shank, foot), offsets)


def _knee_on_axis(side: str, hip: Array, lateral: Array, markers: Markers, radius: float) -> Array:
    """(n, 3) the centre of a knee on the axis of the device, or between hip, lateral and medial marker."""
    if has_device(side, markers):
        return place_centre(hip, lateral, markers[f"{side}KAX"], radius)
    beyond = 2 * lateral - markers[f"{side}KNM"]
    return place_centre(hip, lateral, beyond, radius)


def mean_of(values: Array) -> float:
    """The mean of values that are known, NaN for none."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")
