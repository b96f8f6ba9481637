"""Feet of pieces that are composed: where they stand, and how they are held over transitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.motion.edits.splicing import Placement, Poses
from mcml.motion.feet.contacts import contact_flags, standing_height
from mcml.motion.feet.legs import Leg, Side, legs_of
from mcml.motion.feet.limbs import limb_hinge
from mcml.motion.feet.locking import move_feet
from mcml.motion.feet.seams import Stance, pivot_shift, seam_moves, slide_of
from mcml.motion.hub import walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array, Skeleton


@dataclass(frozen=True)
class SeamFeet:
    """legs: of the skeleton. size: their length. floors: (2,) heights of toes and ankles that stand, in all pieces.

    hinges: axes of their knees in the thighs.
    """

    skeleton: Skeleton
    legs: tuple[Leg, ...]
    size: float
    floors: Array
    hinges: tuple[Array | None, ...]
    frame_time: float
    up: Array

    @staticmethod
    def of(skeleton: Skeleton, pieces: Sequence[Poses], frame_time: float, up: Array) -> SeamFeet | None:
        """The feet of pieces on one skeleton; None where it has no legs. up: (3,) unit vector."""
        legs = legs_of(skeleton)
        if not legs:
            return None
        walks = [walked(skeleton, piece.translations, piece.rotations) for piece in pieces]
        places, world = (np.concatenate([walk[place] for walk in walks]) for place in (0, 1))
        size = float(np.mean([leg.length(places) for leg in legs]))
        points = _points(places, legs)
        floors = [min(standing_height(points[:, leg, place], up) for leg in range(len(legs))) for place in (0, 1)]
        hinges = tuple(limb_hinge(places, world, leg.joints) for leg in legs)
        return SeamFeet(skeleton, legs, size, np.array(floors), hinges, frame_time, up) if 0 < size < np.inf else None

    def stance(self, poses: Poses) -> Stance:
        """Where the feet are in frames, and which parts of them stand."""
        places = _points(walked(self.skeleton, poses.translations, poses.rotations)[0], self.legs)
        stands = np.zeros(places.shape[:3], dtype=bool)
        for leg in range(len(self.legs)):
            for point in (0, 1):
                stands[:, leg, point] = contact_flags(
                    places[:, leg, point], self.frame_time, self.size, self.up, float(self.floors[point])
                )
        return Stance(places, stands)

    def keep_foot(self, placement: Placement, before: Stance, after: Stance) -> Placement:
        """A placement in which a foot that stands on both sides stays in place. before: placed; after: not yet."""
        assert placement.shift is not None
        turned = rotate(placement.turn(), after.places[0])
        shift = pivot_shift(before, after, turned, placement.shift, self.up, self.size)
        return replace(placement, shift=shift)

    def lock(self, between: Poses, before: Stance, after: Stance, writer: HubWriter) -> tuple[Poses, tuple[Side, ...]]:
        """A transition with standing feet held, and the sides of these."""
        walk = walked(self.skeleton, between.translations, between.rotations)[0]
        hips, reach = walk[:, [leg.hip for leg in self.legs]], np.array([leg.length(walk) for leg in self.legs])
        moves = seam_moves(_points(walk, self.legs), before, after, self.up, self.size, hips, reach)
        translations, rotations, _ = move_feet(
            self.skeleton,
            self.legs,
            moves,
            between.translations,
            between.rotations,
            self.frame_time,
            self.up,
            writer,
            fixed_ends=True,
            hinges=self.hinges,
        )
        held = tuple(
            leg.side
            for index, leg in enumerate(self.legs)
            if before.stands[:, index].any() or after.stands[:, index].any()
        )
        return Poses(translations, rotations, between.scales), held

    def slide(self, poses: Poses) -> float:
        """Mean speed of the foot that moves least, in leg lengths a second."""
        places = _points(walked(self.skeleton, poses.translations, poses.rotations)[0], self.legs)
        return slide_of(places, self.up, self.frame_time, self.size)


def _points(places: Array, legs: Sequence[Leg]) -> Array:
    """(n, L, 2, 3) toes and ankles of positions (n, J, 3)."""
    return places[:, [[leg.toe, leg.ankle] for leg in legs]]
