"""The legs of a skeleton, by MCML's names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mcml.motion.skeleton import Array, Skeleton

Side = Literal["left", "right"]
SIDES: tuple[Side, ...] = ("left", "right")


@dataclass(frozen=True)
class Leg:
    """Joints of a leg. toe: the ankle where the skeleton has no toes."""

    side: Side
    hip: int
    knee: int
    ankle: int
    toe: int

    @property
    def joints(self) -> tuple[int, int, int, int]:
        """The leg as a limb (`mcml.motion.feet.limbs`): hip, knee, ankle, toe."""
        return self.hip, self.knee, self.ankle, self.toe

    def length(self, positions: Array) -> float:
        """From hip to ankle along the bones, the median over frames of positions (n, J, 3)."""
        bones = np.linalg.norm(np.diff(positions[:, [self.hip, self.knee, self.ankle]], axis=1), axis=2)
        return float(np.median(bones.sum(axis=1))) if len(bones) else 0.0


def legs_of(skeleton: Skeleton) -> tuple[Leg, ...]:
    """Legs with a hip, a knee below it and an ankle below that; other joints may lie between."""
    places = {joint.name: index for index, joint in enumerate(skeleton.joints)}
    legs = []
    for side in SIDES:
        hip, knee, ankle = (places.get(f"{side}_{part}") for part in ("up_leg", "low_leg", "foot"))
        if hip is None or knee is None or ankle is None:
            continue
        if is_below(skeleton, knee, hip) and is_below(skeleton, ankle, knee):
            toe = places.get(f"{side}_toes")
            below = toe is not None and is_below(skeleton, toe, ankle)
            legs.append(Leg(side, hip, knee, ankle, toe if toe is not None and below else ankle))
    return tuple(legs)


def is_below(skeleton: Skeleton, joint: int, other: int) -> bool:
    """Whether `other` is an ancestor of `joint`."""
    above = skeleton.joints[joint].parent
    while above >= 0 and above != other:
        above = skeleton.joints[above].parent
    return above == other >= 0
