"""Bodies whose rest pose does not show them: the motion tells their lengths, and its first frame a pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mcml.motion.feet.legs import legs_of
from mcml.motion.hub import HubBlock, Rest
from mcml.motion.retargeting.posed_bodies import PosedBody
from mcml.motion.skeleton import Array, Skeleton

_NOTHING = 0.01
"""Length of a bone at rest, in parts of that in the motion, under which it says nothing."""
_LOOKED_AT = 100
"""Frames of a motion, from which lengths are taken."""
_FOLDED = 0.5
"""Cosine of the angle between legs and trunk, from which a rest pose does not show a body: 60 degrees."""


@dataclass(frozen=True)
class Known:
    """A body: its rest, a pose (J, 4) of local rotations if one is given, and frames of it if there are any."""

    skeleton: Skeleton
    rest: Rest
    pose: Array | None
    motion: HubBlock | None

    def pose_body(self, pose: Array | None) -> PosedBody:
        """The body in a pose, by default its rest pose, with lengths of its motion where most have none at rest."""
        return PosedBody.of(self.skeleton, replace(self.rest, offsets=self._offsets), pose)

    @property
    def has_no_lengths(self) -> bool:
        """Whether most bones have a length in the motion alone."""
        return self._offsets is not self.rest.offsets

    @cached_property
    def _offsets(self) -> Array:
        if self.motion is None or not len(self.motion.translations):
            return self.rest.offsets
        below = [index for index, joint in enumerate(self.skeleton.joints) if joint.parent >= 0]
        count = len(self.motion.translations)
        rows = np.unique(np.linspace(0, count - 1, min(count, _LOOKED_AT)).astype(np.intp))
        offsets = np.median(self.motion.translations[rows], axis=0)
        moving, resting = (np.linalg.norm(each[below], axis=1) for each in (offsets, self.rest.offsets))
        has_length = moving > 0
        if 2 * int((resting[has_length] < _NOTHING * moving[has_length]).sum()) <= int(has_length.sum()):
            return self.rest.offsets
        whole = self.rest.offsets.copy()
        whole[below] = offsets[below]
        return whole

    def in_first_frame(self) -> PosedBody | None:
        """The body in the first frame; None without frames."""
        if self.motion is None or not len(self.motion.rotations):
            return None
        return self.pose_body(self.motion.rotations[0])


def comparable_bodies(source: Known, target: Known) -> tuple[PosedBody, PosedBody]:
    """Both bodies in poses to compare: those given, else the rest poses.

    The first frame is compared where bones have no length at rest, or where one body is folded at rest, with the legs
    beside the trunk, and the other is not.
    """
    folded = [known.pose is None and _is_folded(known.pose_body(None)) for known in (source, target)]
    bodies = []
    for known, is_folded in zip((source, target), folded, strict=True):
        body = known.pose_body(known.pose)
        if known.pose is None and (known.has_no_lengths or (is_folded and not all(folded))):
            body = known.in_first_frame() or body
        bodies.append(body)
    return bodies[0], bodies[1]


def _is_folded(body: PosedBody) -> bool:
    """Whether the legs lead along the trunk, as no pose of a standing body does."""
    legs = legs_of(body.skeleton)
    places = {joint.name: index for index, joint in enumerate(body.skeleton.joints)}
    top = places.get("Head", places.get("neck1"))
    if len(legs) < 2 or top is None:
        return False
    hips = body.positions[[leg.hip for leg in legs]].mean(axis=0)
    down = body.positions[[leg.ankle for leg in legs]].mean(axis=0) - hips
    upward = body.positions[top] - hips
    size = float(np.linalg.norm(down) * np.linalg.norm(upward))
    return bool(size > 0 and down @ upward >= _FOLDED * size)
