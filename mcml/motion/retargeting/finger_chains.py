"""The joints of fingers from knuckle to tip, which rigs name and count differently."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from mcml.motion.skeleton import Skeleton

_METACARPAL: Final = re.compile(r"metacarp|in_?hand", re.IGNORECASE)
"""Names of bones of the palm, which the name of a finger may have been given to."""
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
        parent, below = skeleton.joints[first].parent, skeleton.children(first)
        if _METACARPAL.search(skeleton.joints[first].own_name) and below:
            palm, first = first, below[0]
        elif parent >= 0 and _METACARPAL.search(skeleton.joints[parent].own_name):
            palm = parent
    joints = [first]
    while len(joints) < _JOINTS and (below := skeleton.children(joints[-1])):
        joints.append(below[0])
    return palm, joints
