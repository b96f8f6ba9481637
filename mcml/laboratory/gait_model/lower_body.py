"""Pelvis and legs of the Conventional Gait Model 1, known as Plug-in Gait: frames, joint centres and angles.

Sources: Davis, Õunpuu, Tyburski and Gage 1991 ("A gait analysis data collection and reduction technique"); Kadaba,
Ramakrishnan and Wootten 1990 ("Measurement of lower extremity kinematics during level walking"). Points are (n, 3) in
millimetres, frames (n, 3, 3) as `segment_frames` has them, angles (n, 3) degrees in the signs of Plug-in Gait.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.laboratory.gait_model.measures import Measures
from mcml.laboratory.gait_model.segment_frames import (
    along_z,
    column,
    frame_of,
    joint_angles,
    turn_y,
    turn_z,
    wrap,
)
from mcml.motion.landmarks import construction
from mcml.motion.landmarks.construction import Sign, place_centre
from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, unit

Markers = Mapping[str, Array]
"""Points (n, 3) by the names of Plug-in Gait, such as "LASI"."""

SIGNS: Final[Mapping[str, Sign]] = {"L": 1, "R": -1}

_HIP_ANGLES: Final = 0.5, 0.314
"""Radians theta and beta of Davis et al. 1991, from radiographs of 25 hips."""


@dataclass(frozen=True, eq=False)
class Leg:
    """Centres (n, 3) and frames (n, 3, 3) of a leg.

    torsioned: the shank by the ankle's axis. shank: turned by the torsion of the tibia, so that its y is the knee's
    axis. foot: x forward, y left, z up.
    """

    hip: Array
    knee: Array
    ankle: Array
    thigh: Array
    torsioned: Array
    shank: Array
    foot: Array


def pelvis_frame(markers: Markers) -> tuple[Array, Array]:
    """(origin, frame) of the pelvis, see `construction.pelvis_frame`."""
    return construction.pelvis_frame(markers["LASI"], markers["RASI"], sacrum_of(markers))


def sacrum_of(markers: Markers) -> Array:
    """(n, 3) the middle of the back spines, or the marker between them."""
    if "LPSI" in markers and "RPSI" in markers:
        middle: Array = (markers["LPSI"] + markers["RPSI"]) / 2
        return middle
    return markers["SACR"]


def hip_in_pelvis(side: str, measures: Measures, width: float, diameter: float) -> Array:
    """(3,) millimetres of a hip centre in the pelvis, from its origin (Davis et al. 1991).

    width: between the front spines. diameter: of markers.
    """
    theta, beta = _HIP_ANGLES
    legs = [measures.values[f"{each}LegLength"] for each in "LR" if f"{each}LegLength" in measures.values]
    own = measures.get(f"{side}LegLength")
    depth = measures.get(f"{side}AsisTrocanterDistance")
    if depth is None:
        depth = 0.1288 * (own if own is not None else float(np.mean(legs))) - 48.56
    c, back = 0.115 * float(np.mean(legs)) - 15.3, depth + diameter / 2
    return np.array(
        [
            c * np.cos(theta) * np.sin(beta) - back * np.cos(beta),
            SIGNS[side] * (width / 2 - c * np.sin(theta)),
            -c * np.cos(theta) * np.cos(beta) - back * np.sin(beta),
        ]
    )


def place_in(origin: Array, frame: Array, point: Array) -> Array:
    """(n, 3) a point (3,) of a frame in the laboratory."""
    place: Array = origin + frame @ point
    return place


def knee_centre(side: str, hip: Array, markers: Markers, measures: Measures, diameter: float) -> Array:
    """(n, 3) the centre of a knee between hip, knee marker and the wand of the thigh."""
    radius = (measures.of(f"{side}KneeWidth", np.nan) + diameter) / 2
    turn = SIGNS[side] * measures.of(f"{side}ThighRotation")
    return place_centre(hip, markers[f"{side}KNE"], markers[f"{side}THI"], radius, turn)


def ankle_centre(side: str, knee: Array, markers: Markers, measures: Measures, diameter: float) -> Array:
    """(n, 3) the centre of an ankle between knee, ankle marker and the wand of the shank."""
    radius = (measures.of(f"{side}AnkleWidth", np.nan) + diameter) / 2
    turn = SIGNS[side] * measures.of(f"{side}ShankRotation")
    tilt = measures.of(f"{side}AnkleAbAdd")
    return place_centre(knee, markers[f"{side}ANK"], markers[f"{side}TIB"], radius, turn, tilt)


def thigh_frame(side: str, hip: Array, knee: Array, lateral: Array) -> Array:
    """Return the frame of a thigh, whose y is along the knee's axis. lateral: (n, 3) the marker of the knee."""
    return along_z(hip - knee, SIGNS[side] * (lateral - knee))


def shank_frames(side: str, knee: Array, ankle: Array, lateral: Array, torsion: float) -> tuple[Array, Array]:
    """(by the axis of the ankle, by that of the knee) frames of a shank. lateral: (n, 3) the marker of the ankle."""
    torsioned = along_z(knee - ankle, SIGNS[side] * (lateral - ankle))
    return torsioned, torsioned @ turn_z(SIGNS[side] * torsion)


def foot_frame(backward: Array, left: Array) -> Array:
    """Return the frame of a foot from its line to the back (n, 3) and the left axis (n, 3) of its shank."""
    back = unit(backward)
    up = unit(cross(left, back))
    return frame_of(-back, cross(back, up), up)


def offset_foot(side: str, foot: Array, flexion: float, rotation: float) -> Array:
    """Return a foot's frame after the offsets of the static trial, in radians."""
    offset: Array = foot @ turn_y(-flexion) @ turn_z(-SIGNS[side] * rotation)
    return offset


def leg_from_centres(side: str, hip: Array, knee: Array, ankle: Array, markers: Markers, measures: Measures) -> Leg:
    """Return a leg in a walking trial, with the offsets of the foot as far as the measures have them."""
    thigh = thigh_frame(side, hip, knee, markers[f"{side}KNE"])
    torsion = measures.of(f"{side}TibialTorsion")
    torsioned, shank = shank_frames(side, knee, ankle, markers[f"{side}ANK"], torsion)
    foot = foot_frame(ankle - markers[f"{side}TOE"], column(shank, 1))
    flexion, rotation = (measures.of(f"{side}{name}") for name in ("StaticPlantFlex", "StaticRotOff"))
    return Leg(hip, knee, ankle, thigh, torsioned, shank, offset_foot(side, foot, flexion, rotation))


def pelvis_angles(side: str, laboratory: Array, pelvis: Array) -> Array:
    """(n, 3) anterior tilt, this side up, this side forward."""
    alpha, beta, gamma = joint_angles(laboratory, pelvis).T
    k = SIGNS[side]
    return np.stack([alpha, k * beta, -k * gamma], axis=1)


def hip_angles(side: str, pelvis: Array, thigh: Array) -> Array:
    """(n, 3) flexion, adduction, internal rotation."""
    alpha, beta, gamma = joint_angles(pelvis, thigh).T
    k = SIGNS[side]
    return np.stack([-alpha, -k * beta, -k * gamma], axis=1)


def knee_angles(side: str, thigh: Array, shank: Array) -> Array:
    """(n, 3) flexion, varus, internal rotation."""
    alpha, beta, gamma = joint_angles(thigh, shank).T
    k = SIGNS[side]
    return np.stack([alpha, -k * beta, -k * gamma], axis=1)


def ankle_angles(side: str, torsioned: Array, foot: Array) -> Array:
    """(n, 3) dorsiflexion, inversion, internal rotation."""
    alpha, beta, gamma = joint_angles(torsioned, _upright(foot)).T
    k = SIGNS[side]
    return np.stack([wrap(-90.0 - alpha), -k * gamma, -k * beta], axis=1)


def foot_progress_angles(side: str, laboratory: Array, foot: Array) -> Array:
    """(n, 3) pitch, roll, toe-in of a foot in the laboratory."""
    alpha, beta, gamma = joint_angles(laboratory, _upright(foot)).T
    k = SIGNS[side]
    return np.stack([alpha, k * gamma, -k * beta], axis=1)


def _upright(foot: Array) -> Array:
    """The foot as its angles take it: x up, y left, z backwards, which is near to the axes of a shank."""
    return frame_of(column(foot, 2), column(foot, 1), -column(foot, 0))
