"""How clips begin: with a pose before the motion, such as a T-pose, and often some frames from it into the motion."""

from __future__ import annotations

import numpy as np

from mcml.motion.bodies.origins import Origin
from mcml.motion.frames import Rows
from mcml.motion.skeleton import Array, Skeleton

_LEAP, _LEAPS = 0.3, 5.0
"""Leg lengths that a joint moves from a first frame that is no part of the motion to the next one, and how many times
as much as in any of the steps that follow."""
_FOLLOWING = 10
_BLENDED = 12
"""Frames at most from a pose before the motion into the motion."""
_FASTEST = 15.0
"""Leg lengths a second: farther than hands and feet go, the fastest pitchers' apart."""
_STRAIGHT = 0.9
"""Parts of its bones' lengths that a straight arm reaches, and the cosine to the line through the shoulders."""
_LAST, _USUAL = 3, 1.5
"""Size of the steps at the end of a blend, relative to the usual size of the following steps."""
LOOKED_AT = _BLENDED + _LAST + _FOLLOWING + 1
"""Frames at the start."""


def frames_before_motion(
    skeleton: Skeleton, positions: Array, frames: Rows, leg: float | None, seconds: float | None
) -> tuple[int, Origin]:
    """Return the number of frames at the start with a pose before the motion, or with the blend from it into the
    motion. The evidence is steps away from the first frame that are many times as large as the following ones. Of
    several such steps only impossible ones count, or those away from a pose with both arms held out.
    """
    count = min(len(frames), LOOKED_AT)
    if leg is None or count < 3 or not (frames[:count] == np.arange(count)).all():
        return 0, Origin("measured")
    looked = positions[:count]
    steps = np.linalg.norm(np.diff(looked, axis=0), axis=2)
    farthest = np.fmax.reduce(steps, axis=1, initial=0.0)
    fast = seconds is not None and float(farthest.max()) / seconds > _FASTEST * leg
    blends = fast or _arms_held_out(skeleton, looked[0])
    for blended in range(1, min(_BLENDED, len(farthest) - 1) + 1):
        following = float(farthest[blended : blended + _FOLLOWING].max())
        away = float(np.fmax.reduce(np.linalg.norm(looked[blended] - looked[0], axis=1), initial=0.0))
        if away > _LEAP * leg and float(farthest[:blended].max()) > _LEAPS * following and (blended == 1 or blends):
            if blended > 1:
                blended = _end_of(farthest, blended)
            far = f"{away / leg:.2g} leg lengths away from"
            if blended == 1:
                why = f"the first frame is {far} the second one: a pose before the motion"
            else:
                why = f"the first {blended} frames lead from a pose {far} the motion into it"
            return blended, Origin("guessed", why)
    return 0, Origin("measured")


def _end_of(farthest: Array, blended: int) -> int:
    """Where the last small steps of a blend end. farthest: (n,) of each step. blended: the frames that are known."""
    while blended < min(_BLENDED, len(farthest) - _LAST):
        usual = float(np.median(farthest[blended + _LAST : blended + _LAST + _FOLLOWING]))
        if not float(farthest[blended : blended + _LAST].max()) > _USUAL * usual:
            break
        blended += 1
    return blended


def _arms_held_out(skeleton: Skeleton, pose: Array) -> bool:
    """Whether both arms are straight, and point away from the other side. pose: (J, 3)."""
    at = {name: index for index, name in enumerate(skeleton.names)}
    arms = [[f"{side}_{part}" for part in ("up_arm", "low_arm", "hand")] for side in ("left", "right")]
    if not all(name in at for arm in arms for name in arm):
        return False
    left, right = (pose[[at[name] for name in arm]] for arm in arms)
    for arm, other in ((left, right), (right, left)):
        reach, across = arm[2] - arm[0], arm[0] - other[0]
        bones = np.linalg.norm(np.diff(arm, axis=0), axis=1).sum()
        far = float(np.linalg.norm(reach) * np.linalg.norm(across))
        # Also where a joint is not seen, for nothing is below NaN.
        if not (np.linalg.norm(reach) > _STRAIGHT * bones and reach @ across > _STRAIGHT * far):
            return False
    return True
