"""Angles of the body that depend on rotations of joints, not only positions: bones rotated about themselves, heads,
hands, fingers, toes. They are relative to the reference pose of the skeleton (`reference`), so they are small in a
standing body. The rotation of a wrist or a head in that pose itself is unknown.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import VocabularyError
from mcml.motion.anatomy.angles import turned_angles
from mcml.motion.anatomy.axes import Segment, Stance, relative_turns, segments_of
from mcml.motion.bodies.limb_angles import turn_named
from mcml.motion.hub import Rest
from mcml.motion.rotations import IDENTITY, inverse, multiply, rotate
from mcml.motion.skeleton import Array, Skeleton

OBLIQUE: Final = 0.7
"""Cosine between the one axis of an elbow and the forearm from which on the elbow is no hinge, but twists."""


def turned_angle(
    name: str,
    skeleton: Skeleton,
    rest: Rest,
    stance: Stance,
    rotations: Array,
    unseen: NDArray[np.bool_] | None = None,
) -> Array:
    """(n,) degrees within half a turn, NaN where unknown: where the skeleton has no such part, or it never turns it, as
    rigs of positions alone, or a sample is missing.

    name: one of `NEEDS_ROTATIONS`, such as `left-wrist-flexion`. rotations: (n, J, 4) of the joints in the world, from
    rest (`Walker`). unseen: (n, J) where a sample that a joint hangs on is missing. The pelvis turns first about the
    vertical, then tilts. Raises VocabularyError for another name.
    """
    asked = turn_named(name)
    if asked is None:
        raise VocabularyError(f"{name} is not the name of an angle that needs rotations")
    part, side, movement = asked
    for segment in segments_of(skeleton, rest, stance):
        if (segment.part.name, segment.side) == (part, side) and _is_turned(skeleton, segment):
            segment = _from_ulna(skeleton, rest, stance, segment)
            turns = relative_turns(skeleton, rotations, stance, segment)
            if part == "pelvis" and not movement.endswith("-rotation"):
                turns = multiply(inverse(_about(turns, stance.up)), turns)
            for found, opposite, radians in turned_angles(segment, stance, turns):
                if movement in (found, opposite):
                    degrees: Array = np.degrees(radians if movement == found else -radians)
                    return degrees if unseen is None else np.where(unseen[:, segment.joint], np.nan, degrees)
    return np.full(len(rotations), np.nan)


def _from_ulna(skeleton: Skeleton, rest: Rest, stance: Stance, segment: Segment) -> Segment:
    """A forearm that twists at a joint below an elbow of one axis is measured from the ulna between them.

    The axis of an elbow is oblique to the forearm, so that from the upper arm its bends would show as twists.
    """
    names = [joint.name for joint in skeleton.joints]
    elbow = f"{segment.side}_low_arm"
    if segment.part.name != "forearm" or elbow not in names or names.index(elbow) == segment.joint:
        return segment
    ulna = names.index(elbow)
    turning = [channel[1:].lower() for channel in skeleton.joints[ulna].channels if channel[0] == "R"]
    if len(turning) != 1 or not any(channel[0] == "R" for channel in skeleton.joints[segment.joint].channels):
        return segment
    axis = rotate(rest.orientations[ulna], np.eye(3)["xyz".index(turning[0])])
    bone = rotate(inverse(stance.turned[segment.joint]), segment.bone)
    return replace(segment, above=ulna) if abs(float(axis @ bone)) < OBLIQUE else segment


def _is_turned(skeleton: Skeleton, segment: Segment) -> bool:
    """Tell whether a joint between a part and its parent segment has rotations; without, its rotation is unknown."""
    joint = segment.joint
    while joint >= 0 and joint != segment.above:
        if any(channel[0] == "R" for channel in skeleton.joints[joint].channels):
            return True
        joint = skeleton.joints[joint].parent
    return False


def _about(turns: Array, axis: Array) -> Array:
    """(n, 4) that part of rotations (n, 4) that is about an axis (3,): the other part, before it, is across."""
    along = np.concatenate([(turns[:, :3] @ axis)[:, None] * axis, turns[:, 3:]], axis=1)
    lengths = np.linalg.norm(along, axis=1, keepdims=True)
    # Upside down there is no such part, so any choice is equal.
    found: Array = np.where(lengths > 0, along / np.where(lengths > 0, lengths, 1.0), IDENTITY)
    return found
