"""Survey a clip for features that a target may not support: translations of joints, scales, missing samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.clip import ClipStream
from mcml.motion.hub import HubReader, Rest
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import Reading

STILL = 1e-9
"""Of the size of the skeleton: translations that differ by less are constant."""


@dataclass(frozen=True)
class Survey:
    """rest: the pose at rest. low, high: (J, 3) extremes of each joint's translation in the hub form; the rest offset
    for joints that have no such channel. scaled: whether any bone is scaled. root_still: whether no root turns.
    """

    rest: Rest
    low: Array
    high: Array
    scaled: bool
    root_still: bool

    def moving(self) -> Array:
        """(J,) whether a joint's translation changes over the clip."""
        size = max(float(np.abs(self.rest.offsets).max(initial=0.0)), float(np.abs(self.rest.bones).max(initial=0.0)))
        spread = (self.high - self.low).max(axis=1, initial=0.0)
        moving: Array = spread > STILL * (size or 1.0)
        return moving

    def middles(self) -> Array:
        """(J, 3) the translation that is never further from the true one than half its spread."""
        same = self.low == self.high
        return np.where(same, self.low, (self.low + self.high) / 2)

    def displacement(self, joint: int) -> float:
        """The most by which a joint leaves its middle."""
        return float(np.linalg.norm(self.high[joint] - self.low[joint]) / 2)


def survey(clip: ClipStream, reading: Reading) -> Survey:
    """Survey the frames in one pass, which is skipped if the skeleton alone is enough."""
    skeleton = clip.head.skeleton
    hub = HubReader(skeleton, reading)
    low, high = hub.rest.offsets.copy(), hub.rest.offsets.copy()
    if not _needs_frames(skeleton):
        return Survey(hub.rest, low, high, False, False)
    scaled, root_still, first = False, True, True
    for block in clip.blocks():
        if not len(block):
            continue
        frames = hub.read(block)
        lows, highs = frames.translations.min(axis=0), frames.translations.max(axis=0)
        low = lows if first else np.minimum(low, lows)
        high = highs if first else np.maximum(high, highs)
        first = False
        scaled = scaled or bool((frames.scales != 1.0).any())
        roots = list(skeleton.roots)
        root_still = root_still and bool((np.abs(frames.rotations[:, roots, :3]) < 1e-12).all())
    return Survey(hub.rest, low, high, scaled, root_still)


def _needs_frames(skeleton: Skeleton) -> bool:
    """Whether joints other than roots have channels that move or scale them, or samples may be missing."""
    return any(
        channel == "SF" or (channel[0] == "T" and joint.parent >= 0)
        for joint in skeleton.joints
        for channel in joint.channels
    ) or any(joint.convention is Convention.MARKER for joint in skeleton.joints)
