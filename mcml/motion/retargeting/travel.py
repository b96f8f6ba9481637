"""Where a retargeted body is: its hips at the source's place, times a scale, and joints that move in their parents."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mcml.motion.carriers import carriers, chain
from mcml.motion.feet.legs import is_below
from mcml.motion.hub import in_every_frame, walked
from mcml.motion.retargeting.posed_bodies import PosedBody
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import TRANSLATIONS, Array


@dataclass(frozen=True)
class Travel:
    """one: the source's body, two: the target's. pairs: joint of the target -> joint of the source."""

    one: PosedBody
    two: PosedBody
    pairs: Mapping[int, int]

    def moves_along(self, joint: int) -> bool:
        """Whether a joint moves in its parent as its source does: it can, and their parents are matched."""
        parent = self.two.skeleton.joints[joint].parent
        above = self.one.skeleton.joints[self.pairs[joint]].parent
        can = set(TRANSLATIONS) <= set(self.two.skeleton.joints[joint].channels)
        return can and parent >= 0 and above >= 0 and self.pairs.get(parent) == above

    def translations(
        self, moved: Array, positions: Array, turned: Array, rotations: Array, scale: float, scales: Array
    ) -> Array:
        """(n, J, 3) of the target. moved: the source's in the hub form; rotations: the target's, local.

        scales: (3,) factors of places along X, Y and Z. scale: of moves of joints in their parents.
        """
        skeleton = self.two.skeleton
        translations = in_every_frame(self.two.rest.offsets, len(moved))
        world = walked(skeleton, translations, rotations)[1]
        for joint, source in self.pairs.items():
            parent, above = skeleton.joints[joint].parent, self.one.skeleton.joints[source].parent
            if not self.moves_along(joint):
                continue
            delta = scale * (moved[:, source] - self.one.rest.offsets[source])
            translations[:, joint] += rotate(multiply(inverse(world[:, parent]), turned[:, above]), delta)
        for root in skeleton.roots:
            self._carry(root, moved, positions, rotations, scales, translations)
        return translations

    def _carry(
        self, root: int, moved: Array, positions: Array, rotations: Array, scales: Array, translations: Array
    ) -> None:
        """Places a body under its root."""
        skeleton = self.two.skeleton
        path = chain(skeleton, root)
        moving = carriers(self.one.skeleton, moved)
        matched = [joint for joint in path if joint in self.pairs]
        bearer = next((joint for joint in matched if self.pairs[joint] in moving), matched[0] if matched else None)
        if bearer is None:
            return
        for joint in path[: path.index(bearer)]:
            if joint in self.pairs:
                translations[:, joint] = scales * moved[:, self.pairs[joint]]
        goal = scales * positions[:, self.pairs[bearer]]
        places, world = walked(skeleton, translations, rotations)
        hips = self._hips(bearer)
        if hips is not None:
            left, right = hips
            middle = (positions[:, self.pairs[left]] + positions[:, self.pairs[right]]) / 2
            goal = scales * middle + places[:, bearer] - (places[:, left] + places[:, right]) / 2
        parent = skeleton.joints[bearer].parent
        if parent < 0:
            translations[:, bearer] = goal
        else:
            translations[:, bearer] = rotate(inverse(world[:, parent]), goal - places[:, parent])

    def _hips(self, bearer: int) -> tuple[int, int] | None:
        skeleton = self.two.skeleton
        places = {joint.name: index for index, joint in enumerate(skeleton.joints) if index in self.pairs}
        left, right = places.get("left_up_leg"), places.get("right_up_leg")
        if (
            left is None
            or right is None
            or not (is_below(skeleton, left, bearer) and is_below(skeleton, right, bearer))
        ):
            return None
        return left, right
