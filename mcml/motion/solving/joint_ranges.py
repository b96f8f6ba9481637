"""Ranges of joints, learnt from measured rotations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.rotation_vectors import from_vector, to_vector
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array

OUTER = (1.0, 99.0)
"""Percentiles of the measured rotations."""
WIDENING = np.radians(10.0)
HINGE = np.radians(1.0)
"""A joint that turns less than this about an axis does not turn about it at all."""


@dataclass(frozen=True)
class JointRanges:
    """A box of rotation vectors about own axes for each of J joints.

    reference: (J, 4) the rotations that the vectors are relative to. axes: (J, 3, 3), unit vectors in columns. low,
    high: (J, 3) radians about these axes.
    """

    reference: Array
    axes: Array
    low: Array
    high: Array

    def coordinates(self, rotations: Array) -> Array:
        """Return radians (..., J, 3) about the axes, of local rotations (..., J, 4)."""
        vectors = to_vector(multiply(inverse(self.reference), rotations))
        turns: Array = np.einsum("jca,...jc->...ja", self.axes, vectors)
        return turns

    def limit(self, rotations: Array, allowed: Array | None = None) -> Array:
        """Move local rotations (..., J, 4) to the nearest ones in the box, axis by axis.

        allowed: (..., J, 4) rotations that widen the box if they are outside, so that a measured pose always fits.
        """
        turns = self.coordinates(rotations)
        low, high = self.low, self.high
        if allowed is not None:
            own = self.coordinates(allowed)
            low, high = np.minimum(low, own), np.maximum(high, own)
        inside = (turns >= low) & (turns <= high)
        clipped = np.einsum("jca,...ja->...jc", self.axes, np.clip(turns, low, high))
        limited = multiply(self.reference, from_vector(clipped))
        # Rotations inside stay as they are, to the bit.
        kept: Array = np.where(inside.all(axis=-1, keepdims=True), rotations, limited)
        return kept

    def of(self, joints: slice | list[int]) -> JointRanges:
        """Return the ranges of some of the joints."""
        return JointRanges(self.reference[joints], self.axes[joints], self.low[joints], self.high[joints])


def learn_ranges(rotations: Array, reference: Array, widening: float = WIDENING) -> JointRanges:
    """Learn ranges from local rotations (n, J, 4): the 1st to the 99th percentile, widened on both sides.

    reference: (J, 4), such as the mean rotations. widening: radians. The axes are the principal ones of each joint's
    rotation vectors, so that a hinge has one axis of its own; directions with less than one degree are not widened.
    """
    vectors = to_vector(multiply(inverse(reference), rotations))
    centred = vectors - vectors.mean(axis=0)
    _, axes = np.linalg.eigh(np.einsum("njc,njd->jcd", centred, centred))
    turns = np.einsum("jca,njc->nja", axes, vectors)
    low, high = np.percentile(turns, OUTER, axis=0)
    wide = np.where(high - low > HINGE, widening, 0.0)
    return JointRanges(reference, axes, low - wide, high + wide)
