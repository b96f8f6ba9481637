"""A mesh with a skin, which follows the joints of a skeleton."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.motion.rotations import inverse, multiply, rotate, to_matrix
from mcml.motion.skeleton import Array


@dataclass(frozen=True, eq=False)
class Character:
    """A body with a skin, in a pose of a skeleton: the pose that it is bound in.

    points, normals: (V, 3) in the clip's unit and axes. faces: (T, 3), counterclockwise from outside. joints: (V, 4),
    weights: (V, 4) of the joints that each vertex follows, with the sum 1. places: (J, 3), turns: (J, 4) from rest, of
    the joints in that pose. colours: (V, 3) red, green and blue of sRGB; None: it has none of its own.
    """

    points: Array
    normals: Array
    faces: NDArray[np.int64]
    joints: NDArray[np.int64]
    weights: Array
    places: Array
    turns: Array
    colours: NDArray[np.uint8] | None = None

    def scale(self, factor: float) -> Character:
        """The same with all lengths multiplied."""
        return replace(self, points=self.points * factor, places=self.places * factor)

    def turn(self, rotation: Array) -> Character:
        """The same turned about the origin, with its skeleton at rest. rotation: (4,)."""
        points, normals, places = (rotate(rotation, values) for values in (self.points, self.normals, self.places))
        turns = multiply(multiply(rotation, self.turns), inverse(rotation))
        return replace(self, points=points, normals=normals, places=places, turns=turns)

    def move(self, positions: Array, rotations: Array) -> Array:
        """(n, V, 3) the vertices in other poses, by linear blend skinning (Magnenat-Thalmann et al. 1988).

        positions: (n, J, 3), rotations: (n, J, 4) from rest, of the joints in the world.
        """
        turned = to_matrix(multiply(rotations, inverse(self.turns)))
        found = np.zeros((len(positions), len(self.points), 3))
        for slot in range(self.joints.shape[1]):
            joints = self.joints[:, slot]
            local = self.points - self.places[joints]
            moved = positions[:, joints] + np.einsum("nvij,vj->nvi", turned[:, joints], local)
            found += self.weights[:, slot, None] * moved
        return found
