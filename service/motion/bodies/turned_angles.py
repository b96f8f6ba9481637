"""Angles of the body that positions of joints do not tell: bones turned about themselves, heads, hands, fingers, toes.

They are turns from the reference pose of the calibration, the most upright one, so that they are small where a body
stands; what a wrist or a head is turned by in that pose they do not know.
"""

from __future__ import annotations

import numpy as np

from service.errors import VocabularyError
from service.motion.anatomical_angles import helical_angles
from service.motion.anatomical_axes import Stance, relative_turns, segments_of, stance_in
from service.motion.bodies.limb_angles import turn_named
from service.motion.hub import Rest
from service.motion.kinematics import rest_positions
from service.motion.rotations import IDENTITY, inverse, multiply
from service.motion.skeleton import Array, Skeleton
from service.motion.units import DEGREES, Reading


def reference_stance(
    skeleton: Skeleton, up: Array, pose: tuple[Array, Array] | None = None, reading: Reading = DEGREES
) -> Stance:
    """The reference pose of a calibration.

    up: (3,). pose: positions (J, 3) and rotations (J, 4) of the frame that it names, None for the rest pose. Raises
    ConversionError where nothing tells left from right in it.
    """
    if pose is None:
        turned = np.tile(IDENTITY, (len(skeleton), 1))
        pose = rest_positions(skeleton, reading)[: len(skeleton)], turned
    return stance_in(skeleton, *pose, up)


def turned_angle(name: str, skeleton: Skeleton, rest: Rest, stance: Stance, rotations: Array) -> Array:
    """(n,) degrees within half a turn, NaN where the skeleton has no such part.

    name: one of `NEEDS_ROTATIONS`, such as `left-wrist-flexion`. rotations: (n, J, 4) of the joints in the world, from
    rest (`Walker`). The pelvis turns first about the vertical, then tilts. Raises VocabularyError for another name.
    """
    asked = turn_named(name)
    if asked is None:
        raise VocabularyError(f"{name} is not the name of an angle that needs rotations")
    part, side, movement = asked
    for segment in segments_of(skeleton, rest, stance):
        if (segment.part.name, segment.side) == (part, side):
            turns = relative_turns(skeleton, rotations, stance, segment)
            if part == "pelvis":
                about = _about(turns, stance.up)
                turns = about if movement.endswith("-rotation") else multiply(inverse(about), turns)
            for found, opposite, radians in helical_angles(segment, stance, turns):
                if movement in (found, opposite):
                    degrees: Array = np.degrees(radians)
                    return degrees if movement == found else -degrees
    return np.full(len(rotations), np.nan)


def _about(turns: Array, axis: Array) -> Array:
    """(n, 4) that part of rotations (n, 4) that is about an axis (3,): the other part, before it, is across."""
    along = np.concatenate([(turns[:, :3] @ axis)[:, None] * axis, turns[:, 3:]], axis=1)
    lengths = np.linalg.norm(along, axis=1, keepdims=True)
    # Upside down there is no such part: none is as good as any.
    found: Array = np.where(lengths > 0, along / np.where(lengths > 0, lengths, 1.0), IDENTITY)
    return found
