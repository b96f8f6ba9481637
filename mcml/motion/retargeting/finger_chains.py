"""The joints of fingers from knuckle to tip, which rigs name and count differently."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from mcml.motion.hub import rest_of
from mcml.motion.rigs.fingers import is_of_palm
from mcml.motion.skeleton import Skeleton, once_a_skeleton

_FINGERS: Final = ("one", "two", "three", "four", "five")
_JOINTS: Final = 3
"""Of a finger that bend; joints after them are tips."""


def is_finger(name: str) -> bool:
    """Whether a name of MCML's is that of one finger."""
    return name.partition("_finger_")[2] in _FINGERS


def pair_fingers(
    source: Skeleton, target: Skeleton, known: dict[str, int], wanted: dict[str, int]
) -> Iterator[tuple[int, int]]:
    """Yield pairs of joints of the same finger, of source and target: bones of the palm, then the joints from the
    knuckle on. known, wanted: the joints of both by MCML's names.
    """
    for name in (f"{side}_finger_{finger}" for side in ("left", "right") for finger in _FINGERS):
        if name in known and name in wanted:
            has_palm = not name.endswith("one")  # All three joints of a thumb bend, its metacarpal too.
            (palm, own), (other_palm, others) = (
                _chain(skeleton, place[name], has_palm) for skeleton, place in ((source, known), (target, wanted))
            )
            if palm >= 0 and other_palm >= 0:
                yield palm, other_palm
            yield from zip(own, others, strict=False)


def _chain(skeleton: Skeleton, first: int, has_palm: bool) -> tuple[int, list[int]]:
    """The bone of the palm, -1 without one, and the joints of the finger that has this joint."""
    palm = -1
    if has_palm:
        parent, below = skeleton.joints[first].parent, _next_joint(skeleton, first)
        if is_of_palm(skeleton.joints[first].own_name) and below is not None:
            palm, first = first, below
        elif parent >= 0 and is_of_palm(skeleton.joints[parent].own_name):
            palm = parent
    joints = [first]
    while len(joints) < _JOINTS and (below := _next_joint(skeleton, joints[-1])) is not None:
        joints.append(below)
    return palm, joints


def _next_joint(skeleton: Skeleton, joint: int) -> int | None:
    """The next joint of a chain, None at its end: the child with the longest chain below it, then the farthest, so that
    helpers do not count; in its place the last of several joints that stand there.
    """
    children = skeleton.children(joint)
    if not children:
        return None
    reach = _reach(skeleton)
    found = max(children, key=lambda child: reach[child])
    while len(below := skeleton.children(found)) == 1 and not reach[below[0]][1]:
        found = below[0]
    return found


@once_a_skeleton
def _reach(skeleton: Skeleton) -> list[tuple[int, float]]:
    """Of each joint the number of joints in the longest chain that begins with it, and its distance from its parent."""
    lengths = np.linalg.norm(rest_of(skeleton).offsets, axis=1).tolist()
    counts = [1] * len(skeleton)
    for index in reversed(range(len(skeleton))):
        parent = skeleton.joints[index].parent
        if parent >= 0:
            counts[parent] = max(counts[parent], 1 + counts[index])
    return list(zip(counts, lengths, strict=True))
