"""Bodies whose joint angles are known: markers of Plug-in Gait from segment frames, one side after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mcml.laboratory.gait_model.measures import Measures
from mcml.motion.skeleton import Array

DIAMETER = 14.0
LENGTHS: Mapping[str, float] = {
    "InterAsisDistance": 240.0,
    "MarkerDiameter": DIAMETER,
    "Bodymass": 60.0,
    "LLegLength": 880.0,
    "RLegLength": 880.0,
    "LKneeWidth": 100.0,
    "RKneeWidth": 104.0,
    "LAnkleWidth": 66.0,
    "RAnkleWidth": 70.0,
    "LAsisTrocanterDistance": 70.0,
    "RAsisTrocanterDistance": 70.0,
}


@dataclass(frozen=True)
class LegPose:
    """Degrees of flexion, adduction, internal rotation of the hip, and flexion, varus, internal rotation of the knee;
    the direction of the toe from the ankle in the shank's axes. turns: radians of the measures."""

    hip: Sequence[float] = (20.0, 3.0, 5.0)
    knee: Sequence[float] = (15.0, 2.0, -4.0)
    toe: Sequence[float] = (1.0, 0.0, -0.3)
    turns: Mapping[str, float] = field(default_factory=dict)


def turn(axis: str, degrees: float) -> Array:
    """(3, 3) the rotation about an axis of a frame."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]),
    }[axis]


def make_body(
    poses: Mapping[str, LegPose], pelvis: Array | None = None, at: Sequence[float] = (0.0, 0.0, 950.0)
) -> tuple[dict[str, Array], Measures, dict[str, Array]]:
    """(markers (1, 3), measures, centres (3,)) of a body in one frame. pelvis: (3, 3) its axes in the laboratory."""
    axes = np.eye(3) if pelvis is None else pelvis
    origin = np.array(at, dtype=float)
    values = dict(LENGTHS)
    markers = {"LASI": origin + axes @ [0, 120.0, 0], "RASI": origin + axes @ [0, -120.0, 0]}
    markers |= {"LPSI": origin + axes @ [-180.0, 45.0, 0], "RPSI": origin + axes @ [-180.0, -45.0, 0]}
    centres: dict[str, Array] = {}
    for side, k in (("L", 1), ("R", -1)):
        pose = poses[side]
        values |= {side + name: value for name, value in pose.turns.items()}
        c, d = 0.115 * 880.0 - 15.3, 70.0 + DIAMETER / 2
        hip = origin + axes @ [
            c * np.cos(0.5) * np.sin(0.314) - d * np.cos(0.314),
            k * (120.0 - c * np.sin(0.5)),
            -c * np.cos(0.5) * np.cos(0.314) - d * np.sin(0.314),
        ]
        flexion, adduction, inner = pose.hip
        thigh = axes @ turn("y", -flexion) @ turn("x", -k * adduction) @ turn("z", -k * inner)
        knee = hip - 400.0 * thigh[:, 2]
        wide = (values[f"{side}KneeWidth"] + DIAMETER) / 2
        lateral = knee + k * wide * thigh[:, 1]
        rotation = np.degrees(pose.turns.get("ThighRotation", 0.0))
        wand = knee + 150.0 * thigh[:, 2] + k * 120.0 * (thigh @ turn("z", k * rotation))[:, 1]
        flexion, varus, inner = pose.knee
        shank = thigh @ turn("y", flexion) @ turn("x", -k * varus) @ turn("z", -k * inner)
        torsion = np.degrees(pose.turns.get("TibialTorsion", 0.0))
        torsioned = shank @ turn("z", -k * torsion)
        ankle = knee - 390.0 * shank[:, 2]
        wide = (values[f"{side}AnkleWidth"] + DIAMETER) / 2
        tilt = pose.turns.get("AnkleAbAdd", 0.0)
        malleolus = ankle + wide * (k * np.cos(tilt) * torsioned[:, 1] - np.sin(tilt) * torsioned[:, 2])
        rotation = np.degrees(pose.turns.get("ShankRotation", 0.0))
        low_wand = ankle + 150.0 * torsioned[:, 2] + k * 90.0 * (torsioned @ turn("z", k * rotation))[:, 1]
        toe = ankle + 150.0 * shank @ (np.array(pose.toe) / np.linalg.norm(pose.toe))
        markers |= {f"{side}THI": wand, f"{side}KNE": lateral, f"{side}TIB": low_wand, f"{side}ANK": malleolus}
        markers |= {f"{side}TOE": toe, f"{side}HEE": ankle - 50.0 * shank[:, 0] - 40.0 * shank[:, 2]}
        centres |= {f"{side}HJC": hip, f"{side}KJC": knee, f"{side}AJC": ankle}
    return {name: np.asarray(place)[None] for name, place in markers.items()}, Measures(values), centres


def mirror(markers: Mapping[str, Array]) -> dict[str, Array]:
    """The body in a mirror across its left and right: y is negative, and names change sides."""
    other = {"L": "R", "R": "L"}
    return {other[name[0]] + name[1:]: place * [1.0, -1.0, 1.0] for name, place in markers.items()}
