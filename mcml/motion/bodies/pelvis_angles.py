"""Clinical angles from positions of joints, for rigs with any axes: hips in the pelvis, pelvis, ankles.

A hip is measured in the frame of the pelvis, as in gait analysis and by the ISB (Wu et al. 2002), not from the trunk: a
body that bends forward in its back flexes no hip. Flexion and adduction are those of the direction of the thigh, which
are the Cardan angles of the whole joint, however the thigh is turned about itself. Constants of a standing body
(`reference.standing_zeros`) are subtracted where the skeleton has a pose that tells them; without, the values are in
the frame of the joints. A pelvis of markers has the frame of its spines, as the ISB and Plug-in Gait define it.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.anatomy.segment_frames import Frames, flexion_of, frames_between, lean_to_left_of, tilt_of
from mcml.motion.bodies.bone_axes import FORWARD, line_of
from mcml.motion.bodies.bone_axes import PELVIS as PELVIS_BONE
from mcml.motion.bodies.reference import PELVIS, SPINE, dorsiflexion_of, frames_of_pelvis, pelvis_points
from mcml.motion.bodies.stretch import HIPS, Stretch
from mcml.motion.skeleton import Array
from mcml.motion.vectors import unit

PELVIS_NEEDS = (*HIPS, "|".join((*SPINE, "Root")), "|".join(("Root", *SPINE)))
"""Hips, and the lowest joint of the spine or the root, and both where a body has both."""
PELVIS_BONES = (PELVIS_BONE, f"{PELVIS_BONE}{FORWARD}")
"""Lines of the pelvis in a body of markers: to the left, and forwards."""
PELVIS_LINES = tuple(map(line_of, PELVIS_BONES))


def frames_of(stretch: Stretch) -> Frames:
    """The frames of the pelvis: by its markers, or by its joints with their lean left in."""
    if (kept := stretch.kept.get("pelvis")) is None and set(PELVIS_LINES) <= stretch.places.keys():
        kept = stretch.kept["pelvis"] = frames_between(*(stretch.at(line) for line in PELVIS_LINES))
    if kept is None:
        points = [stretch.at(name) for name in pelvis_points(tuple(stretch.places))]
        kept = stretch.kept["pelvis"] = frames_of_pelvis(stretch.at(HIPS[0]), stretch.at(HIPS[1]), points)
    frames: Frames = kept
    return frames


def measure_hip_flexion(stretch: Stretch, side: str) -> Array:
    """(n,) degrees, 0 for a thigh upright in the pelvis."""
    degrees = flexion_of(frames_of(stretch), _thigh(stretch, side)) - _zero(stretch, PELVIS)
    return _within_half_a_turn(degrees)


def measure_hip_adduction(stretch: Stretch, side: str) -> Array:
    """(n,) degrees, positive towards the other leg; a pelvis that drops to the other side adducts."""
    degrees = lean_to_left_of(frames_of(stretch), _thigh(stretch, side))
    return -degrees if side == "right" else degrees


def measure_pelvis_tilt(stretch: Stretch, side: str) -> Array:
    """(n,) degrees forwards about the line through the hips."""
    return _within_half_a_turn(tilt_of(frames_of(stretch), stretch.up) - _zero(stretch, PELVIS))


def measure_pelvis_obliquity(stretch: Stretch, side: str) -> Array:
    """(n,) degrees by which the line through the hips, or through the front spines of markers, rises to the left."""
    left = stretch.at(PELVIS_LINES[0]) if PELVIS_LINES[0] in stretch.places else stretch.between(HIPS[1], HIPS[0])
    degrees: Array = np.degrees(np.arcsin(np.clip(unit(left) @ stretch.up, -1.0, 1.0)))
    return degrees


def measure_ankle(stretch: Stretch, side: str) -> Array:
    """(n,) degrees of dorsiflexion from the standing body, or of the line from heel to toe where markers tell it."""
    knee, ankle, toes = (stretch.at(f"{side}_{joint}") for joint in ("low_leg", "foot", "toes"))
    if (line := line_of(f"{side}_foot{FORWARD}")) in stretch.places:
        return dorsiflexion_of(knee, ankle, ankle + stretch.at(line))
    return dorsiflexion_of(knee, ankle, toes) - _zero(stretch, f"{side}_foot")


def _thigh(stretch: Stretch, side: str) -> Array:
    return unit(stretch.between(f"{side}_low_leg", f"{side}_up_leg"))


def _zero(stretch: Stretch, name: str) -> float:
    return stretch.calibration.zeros.get(name, 0.0)


def _within_half_a_turn(degrees: Array) -> Array:
    return np.where(degrees > 180.0, degrees - 360.0, np.where(degrees <= -180.0, degrees + 360.0, degrees))
