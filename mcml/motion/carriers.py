"""Joints that move a body through the world: the root, or the hips below a fixed root."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.motion.clip import ClipStream
from mcml.motion.skeleton import TRANSLATIONS, Array, Skeleton, once_a_skeleton

_HIPS = "Root"
"""MCML's name."""
_STILL = 1e-6
"""Of the largest distance from the origin: translations that differ by less do not move."""


@once_a_skeleton
def chain(skeleton: Skeleton, root: int) -> tuple[int, ...]:
    """The root, and below it joints that have all three positions, down to the first joint of the body that branches.

    Helpers may hang on joints above the hips, as targets of inverse kinematics do on the root in Unreal Engine.
    """
    found = [root]
    hips = skeleton.names.index(_HIPS) if _HIPS in skeleton.names else -1
    to_hips = []
    while hips >= 0 and hips != root:
        to_hips.append(hips)
        hips = skeleton.joints[hips].parent
    if hips == root and all(_is_placed(skeleton, joint) for joint in to_hips):
        found += reversed(to_hips)
    while True:
        children = skeleton.children(found[-1])
        if len(children) != 1 or not _is_placed(skeleton, children[0]):
            return tuple(found)
        found.append(children[0])


def _is_placed(skeleton: Skeleton, joint: int) -> bool:
    return set(TRANSLATIONS) <= set(skeleton.joints[joint].channels)


def carriers(skeleton: Skeleton, *translations: Array) -> tuple[int, ...]:
    """Of every root the joint that moves its body: the first of its chain that moves in any clip, else the root.

    translations: (n, J, 3) of each clip, in the hub form.
    """
    moves = np.zeros(len(skeleton), dtype=bool)
    for clip in translations:
        if clip.size:
            spread = np.ptp(clip, axis=0).max(axis=1)
            moves |= spread > _STILL * max(float(np.abs(clip).max()), 1e-30)
    return tuple(next((joint for joint in chain(skeleton, root) if moves[joint]), root) for root in skeleton.roots)


def first_moving(clip: ClipStream, joints: Sequence[int]) -> int | None:
    """Return the first of some joints whose position channels change over a clip, None if none does.

    Frames are read only as far as needed: to the end if the first one does not move.
    """
    low = np.full((len(joints), len(TRANSLATIONS)), np.inf)
    high = -low
    places = {joint: place for place, joint in enumerate(joints)}

    def moves(place: int) -> bool:
        known = np.isfinite(low[place])
        spread = (high[place] - low[place])[known].max(initial=0.0)
        size = np.abs(np.stack([low[place], high[place]]))[:, known].max(initial=0.0)
        return bool(spread > _STILL * max(float(size), 1e-30))

    for block in clip.blocks():
        for index, (joint, channel) in enumerate(block.columns):
            values = block.values[:, index]
            if joint in places and channel < len(TRANSLATIONS) and np.isfinite(values).any():
                place = places[joint]
                low[place, channel] = min(low[place, channel], float(np.nanmin(values)))
                high[place, channel] = max(high[place, channel], float(np.nanmax(values)))
        if moves(0):
            break
    return next((joint for joint, place in places.items() if moves(place)), None)
