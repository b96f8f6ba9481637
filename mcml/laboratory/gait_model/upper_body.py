"""Head, trunk and arms of the Conventional Gait Model 1, known as Plug-in Gait: frames, centres and angles.

Points are (n, 3) in millimetres, frames (n, 3, 3), angles (n, 3) degrees in the signs of Plug-in Gait. Angles of the
shoulder are turns about x, then y, then z, not the sequence of the ISB (Wu et al. 2005).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.laboratory.gait_model.lower_body import SIGNS, Markers
from mcml.laboratory.gait_model.measures import Measures
from mcml.laboratory.gait_model.segment_frames import (
    column,
    frame_of,
    joint_angles,
    transpose,
    turn_y,
    wrap,
)
from mcml.motion.landmarks.construction import place_centre
from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, unit

TRUNK = ("CLAV", "C7", "STRN", "T10")
HEAD = ("LFHD", "RFHD", "LBHD", "RBHD")
ARM = ("SHO", "ELB", "WRA", "WRB")
"""Markers of a side."""


@dataclass(frozen=True, eq=False)
class Arm:
    """Centres (n, 3) and frames (n, 3, 3) of an arm."""

    shoulder: Array
    elbow: Array
    wrist: Array
    humerus: Array
    radius: Array


def thorax_frame(markers: Markers, diameter: float) -> tuple[Array, Array]:
    """(origin, frame) of the thorax: z down its middle turned up, x from the back to the front."""
    front, back = markers["CLAV"] + markers["STRN"], markers["C7"] + markers["T10"]
    z = unit(markers["CLAV"] + markers["C7"] - markers["STRN"] - markers["T10"])
    y = unit(cross(z, front - back))
    x = cross(y, z)
    return markers["CLAV"] - diameter / 2 * x, frame_of(x, y, z)


def head_frame(markers: Markers, offset: float) -> Array:
    """Return the frame of the head. offset: radians by which a level head's markers are tilted (HeadOffset)."""
    left_front, right_front, left_back, right_back = (markers[name] for name in HEAD)
    x = unit(left_front + right_front - left_back - right_back)
    z = unit(cross(x, left_front + left_back - right_front - right_back))
    turned: Array = frame_of(x, cross(z, x), z) @ turn_y(offset)
    return turned


def arm_of(side: str, thorax: tuple[Array, Array], markers: Markers, measures: Measures, diameter: float) -> Arm:
    """Return an arm. thorax: (origin, frame)."""
    k, half = SIGNS[side], diameter / 2
    origin, trunk = thorax
    acromion, elbow_marker, thumb, little = (markers[f"{side}{name}"] for name in ARM)
    middle = (thumb + little) / 2
    wand = acromion + k * cross(column(trunk, 0), acromion - origin)
    shoulder = place_centre(origin, acromion, wand, measures.of(f"{side}ShoulderOffset", np.nan) + half)
    wand = elbow_marker + k * cross(shoulder - elbow_marker, middle - elbow_marker)
    elbow = place_centre(shoulder, elbow_marker, wand, measures.of(f"{side}ElbowWidth", np.nan) / 2 + half)
    depth = measures.of(f"{side}WristWidth", np.nan) / 2 + half
    wrist = middle - k * depth * unit(cross(elbow - middle, thumb - little))
    z = unit(shoulder - elbow)
    y = unit(cross(z, wrist - elbow))
    x = unit(cross(y, elbow - wrist))
    humerus, radius = frame_of(cross(y, z), y, z), frame_of(x, y, cross(x, y))
    return Arm(shoulder, elbow, wrist, humerus, radius)


def hand_frame(side: str, wrist: Array, markers: Markers, measures: Measures, diameter: float) -> Array:
    """Return the frame of a hand from its wrist, the markers of the wrist and FIN."""
    thumb, little = markers[f"{side}WRA"], markers[f"{side}WRB"]
    middle = (thumb + little) / 2
    radius = (measures.of(f"{side}HandThickness", np.nan) + diameter) / 2
    z = unit(wrist - place_centre(wrist, markers[f"{side}FIN"], middle, radius))
    x = unit(cross(SIGNS[side] * (middle - thumb), z))
    return frame_of(x, cross(z, x), z)


def thorax_angles(side: str, laboratory: Array, thorax: Array) -> Array:
    """(n, 3) backward tilt, tilt to this side, rotation of the thorax in the laboratory."""
    alpha, beta, gamma = joint_angles(laboratory, thorax).T
    k = SIGNS[side]
    return np.stack([alpha, k * beta, -k * gamma], axis=1)


def trunk_angles(side: str, proximal: Array, distal: Array) -> Array:
    """(n, 3) of the head (laboratory, head), the neck (head, thorax) or the spine (thorax, pelvis)."""
    alpha, beta, gamma = joint_angles(proximal, distal).T
    k = SIGNS[side]
    return np.stack([-alpha, k * beta, -k * gamma], axis=1)


def shoulder_angles(side: str, thorax: Array, humerus: Array) -> Array:
    """(n, 3) flexion, abduction, rotation."""
    turn, k = transpose(thorax) @ humerus, SIGNS[side]
    flexion = -np.arcsin(np.clip(turn[:, 0, 2], -1.0, 1.0))
    abduction = k * np.arctan2(-turn[:, 1, 2], turn[:, 2, 2])
    rotation = -k * np.arctan2(-turn[:, 0, 1], turn[:, 0, 0])
    angles: Array = np.degrees(np.stack([flexion, abduction, rotation], axis=1))
    return angles


def elbow_angles(humerus: Array, radius: Array) -> Array:
    """(n, 3) flexion; the model has no other turns of an elbow, which are 0."""
    flexion = -joint_angles(humerus, radius)[:, 0]
    none = np.where(np.isfinite(flexion), 0.0, np.nan)
    return np.stack([flexion, none, none], axis=1)


def wrist_angles(side: str, radius: Array, hand: Array) -> Array:
    """(n, 3) flexion, deviation, rotation."""
    alpha, beta, gamma = joint_angles(radius, hand).T
    k = SIGNS[side]
    return np.stack([-alpha, k * beta, wrap(180.0 - k * gamma)], axis=1)
