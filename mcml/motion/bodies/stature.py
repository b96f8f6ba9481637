"""How tall a body stands, by its bones: legs, trunk, neck and head in one line, in any pose and on any rig."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mcml.motion.bodies.calibration import Calibration
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import rest_positions
from mcml.motion.landmarks.centres import body_names
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import Reading

ANKLE = 0.039
"""Of the stature, the height of the ankle (Winter 2009, figure 4.1)."""
LEG = 0.530 - ANKLE
"""Of the stature, from the hip to the ankle (the same figure)."""
HEAD_JOINT = 0.92
"""Of the stature, the height of the joint of the skull: a little below the ears, which are at 0.925 (tragion height of
adults over their stature, Gordon et al. 2014, ANSUR II)."""
_SKULL = 0.04
"""Of the length up to the joint of the head: with no point further above it, the skull is not part of the skeleton."""
_LEAST, _MOST = 0.6, 1.6
"""Of the usual length of a trunk beside that of a leg: others are no trunk, such as bones in one place."""
_HEAD = "Head"
_HIPS = ("left_up_leg", "right_up_leg")


@dataclass(frozen=True)
class Stature:
    """height: in the clip's unit. kind: measured on the skeleton, or guessed by proportions. reason: as text."""

    height: float
    kind: Literal["measured", "guessed"]
    reason: str


def find_stature(skeleton: Skeleton, reading: Reading, calibration: Calibration) -> Stature | None:
    """Return the standing height of the body of a clip, None for a body without legs.

    It is the length of a leg and of the bones from the hips to the top of the head, without bends, and the height of
    the ankles by proportion. With markers, and without a named head, it is told by the leg alone.
    """
    leg = calibration.leg
    if not leg:
        return None
    trunk = _trunk(skeleton, reading)
    if trunk is not None:
        length, skull = trunk
        top = 1.0 if skull else HEAD_JOINT
        if _LEAST < length / leg * LEG / (top - ANKLE - LEG) < _MOST:
            reason = "bones of a leg, the trunk and the head in one line"
            if skull:
                return Stature((leg + length) / (top - ANKLE), "measured", reason)
            return Stature((leg + length) / (top - ANKLE), "guessed", f"{reason}, and a skull above its joint")
    return Stature(leg / LEG, "guessed", f"a leg is {LEG:g} of it (Winter 2009)")


def _trunk(skeleton: Skeleton, reading: Reading) -> tuple[float, bool] | None:
    """The length from between the hips to the top of the head, and whether the skull is part of it."""
    names = body_names(skeleton)[: len(skeleton)]
    if not {_HEAD, *_HIPS} <= set(names):
        return None
    rest = rest_positions(skeleton, reading)
    head, hips = names.index(_HEAD), [names.index(name) for name in _HIPS]
    below = set(_line_up(skeleton, hips[0])) & set(_line_up(skeleton, hips[1]))
    line = _line_up(skeleton, head)
    above = line[: next((at for at, joint in enumerate(line) if joint in below), len(line))]
    if not above:
        return None
    points = np.vstack([rest[hips].mean(axis=0), rest[above[::-1]]])
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    skull = _skull(skeleton, reading, rest, head, points[-1] - points[-2])
    return (length + skull, True) if skull > _SKULL * length else (length, False)


def _line_up(skeleton: Skeleton, joint: int) -> list[int]:
    """The joint, its parent, and so on up to the root."""
    line = [joint]
    while skeleton.joints[line[-1]].parent >= 0:
        line.append(skeleton.joints[line[-1]].parent)
    return line


def _skull(skeleton: Skeleton, reading: Reading, rest: Array, head: int, neck: Array) -> float:
    """How far points below the joint of the head are above it, along the neck. neck: (3,)."""
    inside = {head}
    for index, joint in enumerate(skeleton.joints):
        if joint.parent in inside:
            inside.add(index)
    ends = enumerate(rest_of(skeleton, reading).tips)
    points = [*inside, *(len(skeleton) + at for at, (joint, _) in ends if joint in inside)]
    size = float(np.linalg.norm(neck))
    return float(((rest[points] - rest[head]) @ neck).max() / size) if size > 0.0 else 0.0
