"""Clinical angles of legs that take the line to the left of thighs and shanks (`bone_axes`), beside positions.

Grood and Suntay's angles (1983): of the thigh in the pelvis, and of the shank in the thigh. Long axes are the lines
between centres of joints. A knee bent backwards has negative flexion. Without a line to the left, a knee has only the
angle between its bones, which is never negative, and turns are unknown.
"""

from __future__ import annotations

from mcml.motion.anatomy.segment_frames import Frames, bone_frames, flexion_of, lean_to_left_of, turn_to_left_of
from mcml.motion.bodies.bone_axes import BONES, line_of
from mcml.motion.bodies.pelvis_angles import frames_of
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, unit


def measure_knee_flexion(stretch: Stretch, side: str) -> Array:
    """(n,) degrees, negative for a knee bent backwards; of a body without lines to the left, never negative."""
    shank = stretch.between(f"{side}_low_leg", f"{side}_foot")
    if line_of(f"{side}_up_leg") not in stretch.places:
        return angle_between(stretch.between(f"{side}_up_leg", f"{side}_low_leg"), shank)
    # A knee flexes its lower end backwards, a hip forwards.
    return -flexion_of(_frames(stretch, f"{side}_up_leg"), -unit(shank))


def measure_knee_varus(stretch: Stretch, side: str) -> Array:
    """(n,) degrees by which the ankle leans to the middle of the body, in the thigh."""
    shank = stretch.between(f"{side}_low_leg", f"{side}_foot")
    degrees = lean_to_left_of(_frames(stretch, f"{side}_up_leg"), -unit(shank))
    return -degrees if side == "right" else degrees


def measure_knee_rotation(stretch: Stretch, side: str) -> Array:
    """(n,) degrees by which the front of the shank is turned to the middle of the body, in the thigh."""
    return _inwards(turn_to_left_of(_frames(stretch, f"{side}_up_leg"), _frames(stretch, f"{side}_low_leg")), side)


def measure_hip_rotation(stretch: Stretch, side: str) -> Array:
    """(n,) degrees by which the front of the thigh is turned to the middle of the body, in the pelvis."""
    return _inwards(turn_to_left_of(frames_of(stretch), _frames(stretch, f"{side}_up_leg")), side)


def _frames(stretch: Stretch, bone: str) -> Frames:
    return bone_frames(stretch.between(bone, BONES[bone][0]), stretch.at(line_of(bone)))


def _inwards(turned_left: Array, side: str) -> Array:
    return turned_left if side == "right" else -turned_left
