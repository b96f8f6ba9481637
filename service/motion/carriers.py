"""Which joints carry a body through the world: the root, or the hips below a root that only stands there."""

from __future__ import annotations

import numpy as np

from service.motion.skeleton import TRANSLATIONS, Array, Skeleton

_STILL = 1e-6
"""Of the largest distance from the origin: translations that differ by less do not move."""


def chain(skeleton: Skeleton, root: int) -> list[int]:
    """The root, and below it only children that have all three positions, down to the first joint that branches."""
    found = [root]
    while True:
        children = skeleton.children(found[-1])
        if len(children) != 1 or not set(TRANSLATIONS) <= set(skeleton.joints[children[0]].channels):
            return found
        found.append(children[0])


def carriers(skeleton: Skeleton, *translations: Array) -> tuple[int, ...]:
    """Of every root the joint that moves its body: the first of its chain that moves in any clip, else the root.

    translations: (n, J, 3) of each clip, in the hub form.
    """
    moves = np.zeros(len(skeleton), dtype=bool)
    for clip in translations:
        if len(clip):
            spread = np.ptp(clip, axis=0).max(axis=1)
            moves |= spread > _STILL * max(float(np.abs(clip).max()), 1e-30)
    return tuple(next((joint for joint in chain(skeleton, root) if moves[joint]), root) for root in skeleton.roots)
