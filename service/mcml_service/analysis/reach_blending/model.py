"""A fitted model: all that it takes to make a motion for any attributes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.solving.joint_ranges import JointRanges
from mcml_service.analysis.interface import AnalysisError
from mcml_service.analysis.reach_blending.attribute_space import AttributeSpace
from mcml_service.analysis.reach_blending.blend import Blend, invert, kernel, terms
from mcml_service.analysis.reach_blending.durations import from_time_values
from mcml_service.analysis.reach_blending.motion_spaces import MotionSpace
from mcml_service.analysis.reach_blending.time_normalisation import Knots


@dataclass(frozen=True)
class Source:
    """A clip that the model was fitted to."""

    document: str
    revision: int
    name: str
    subject: str


@dataclass(frozen=True)
class Reaching:
    """The arm of a model, for targets.

    chain: joints from the root to the hand. shoulder, elbow: places in the chain. hinge: (3,) axis of the elbow in the
    upper arm, None if it never bends. ranges: of the chain's joints, learnt
    from the examples. hold: the share of the time after t2 during which the hand stays, middle of the examples.
    """

    chain: tuple[int, ...]
    shoulder: int
    elbow: int
    hinge: Array | None
    ranges: JointRanges
    hold: float


@dataclass(frozen=True)
class Model:
    """N clips, n examples (clips of equal attributes may be one), A attributes, d coordinates, K components.

    skeleton: joints, channels, names. offsets: (N, J, 3) and tips (N, T, 3): each clip's body. metres: of the unit of
    length, None if unknown. names, units: (A,) of the attributes. attributes: (N, A). example_of: (N,) each clip's
    example. gaps: by attribute, intervals without examples. neighbour: mean distance to the nearest example.
    mean: (D,). basis: (K, D). coefficients: of x (q, d) the K coefficients. times: of x the three times, as logarithms
    of durations where log_times is set; frames at base_fps. cardinal: (n, n + m), see `Inverse`. reaching: None of
    models fitted by earlier releases, and where the hand has no arm of two bones. contacts: (n, legs, 2, F0) when feet
    of the examples stand, see `learn_contacts`.
    """

    skeleton: Skeleton
    offsets: Array
    tips: Array
    metres: float | None
    up: str | None
    sources: tuple[Source, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    attributes: Array
    attribute_space: AttributeSpace
    example_of: NDArray[np.intp]
    gaps: tuple[tuple[tuple[float, float], ...], ...]
    neighbour: float
    motion_space: MotionSpace
    mean: Array
    basis: Array
    coefficients: Blend
    times: Blend
    cardinal: Array
    knots: Knots
    base_fps: float
    log_times: bool
    legacy_time_map: bool
    reaching: Reaching | None = None
    contacts: Array | None = None

    @property
    def centres(self) -> Array:
        """(n, d) coordinates of the examples."""
        return self.coefficients.centres

    def weights(self, x: Array) -> Array:
        """(n,) how much each example counts at x (d,); they sum to 1 and may be negative."""
        row = np.concatenate([kernel(x[None], self.centres, self.coefficients.s), self.polynomial(x)], axis=1)
        weights: Array = self.cardinal @ row[0]
        return weights

    def polynomial(self, x: Array) -> Array:
        return terms(x[None], self.coefficients.degree)

    def samples(self, x: Array) -> tuple[Array, Array]:
        """Root (F0, 3) and unit rotations (F0, J, 4) of the normalised motion at x (d,)."""
        vector = self.mean + self.coefficients(x[None]) @ self.basis
        root, rotations = self.motion_space.motions(vector)
        return root[0], rotations[0]

    def phase_times(self, x: Array) -> Array:
        """(3,) t1, t2, end at x (d,), in frames at base_fps. Raises AnalysisError `time-order`."""
        times: Array = from_time_values(self.times(x[None]), self.log_times)[0]
        if not 0 < times[0] < times[1] < times[2]:
            raise AnalysisError(
                "time-order",
                "The extrapolated phase times are not in order: "
                + ", ".join(f"{time / self.base_fps:.2f} s" for time in times),
                remedy="Ask for attributes nearer to the examples, or fit with the robust method.",
            )
        return times


def cardinal_of(blend: Blend) -> Array:
    """The matrix behind the weights of a blend's examples."""
    return invert(blend.centres, blend.s, blend.lam, blend.degree).cardinal
