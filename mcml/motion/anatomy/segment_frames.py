"""Frames of the pelvis and of bones of the legs, and the clinical angles between them.

Axes: x forward, y left, z up (along a bone, to its upper end), each as (n, 3) unit vectors in the world. Angles are
those of Grood and Suntay (1983) and of the recommendation of the ISB (Wu et al. 2002): about the proximal line from
right to left, the floating axis, and the distal long axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, divided, dot, length, unit

NEAR = 0.05
"""Sine of the angle between a bone and a line to its left below which that line tells no axis across the bone."""


@dataclass(frozen=True, eq=False)
class Frames:
    """The axes of one segment in n frames: x, y, z, (n, 3) unit vectors, NaN where unknown."""

    x: Array
    y: Array
    z: Array


def pelvis_frames(left_hip: Array, right_hip: Array, spine: Array) -> Frames:
    """Return the frames of the pelvis from positions (n, 3) of both hips, and of a point of the pelvis above them."""
    y = unit(left_hip - right_hip)
    up = spine - (left_hip + right_hip) / 2
    z = unit(up - dot(up, y)[:, None] * y)
    return Frames(cross(y, z), y, z)


def frames_between(left: Array, forward: Array) -> Frames:
    """Return the frames whose y is along one line (n, 3), and whose x is as near to another as possible."""
    y = unit(left)
    z = unit(cross(forward, y))
    return Frames(cross(y, z), y, z)


def bone_frames(bone: Array, left: Array) -> Frames:
    """Return the frames of a bone of a leg: z against the bone (n, 3), y as near to its left (n, 3) as possible."""
    z = -unit(bone)
    across = left - dot(left, z)[:, None] * z
    y = divided(across, length(across), NEAR * length(left))
    return Frames(cross(y, z), y, z)


def flexion_of(proximal: Frames, z: Array) -> Array:
    """(n,) degrees by which a distal long axis z (n, 3) is flexed forwards, as a thigh in the pelvis.

    It does not depend on how the distal bone is turned about itself.
    """
    degrees: Array = np.degrees(np.arctan2(-dot(proximal.x, z), dot(proximal.z, z)))
    return degrees


def lean_to_left_of(proximal: Frames, z: Array) -> Array:
    """(n,) degrees by which the upper end of a distal long axis z (n, 3) leans to the left, within a quarter turn."""
    degrees: Array = np.degrees(np.arcsin(np.clip(dot(proximal.y, z), -1.0, 1.0)))
    return degrees


def turn_to_left_of(proximal: Frames, distal: Frames) -> Array:
    """(n,) degrees by which a distal bone is turned to the left about its long axis."""
    degrees: Array = np.degrees(np.arctan2(dot(proximal.y, distal.x), dot(proximal.y, distal.y)))
    return degrees


def tilt_of(pelvis: Frames, up: Array) -> Array:
    """(n,) degrees by which a pelvis is tilted forwards about the line through its hips, from up (3,).

    It does not depend on where the body faces (Baker 2001, Gait & Posture 13:1-6).
    """
    degrees: Array = np.degrees(np.arctan2(-(pelvis.x @ up), pelvis.z @ up))
    return degrees
