"""Attributes as coordinates in which distances mean something."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mcml.motion.skeleton import Array
from mcml_service.analysis.reach_blending.principal_components import signs_of

Scaling = Literal["rotate", "zscore", "whiten"]

SMALLEST = 1e-6
"""Relative to the largest component: below this, attributes are on a plane."""


@dataclass(frozen=True)
class AttributeSpace:
    """x = (a - mean) matrix. mean, scale: (A,), the scale 0 where an attribute is constant. matrix: (A, d).

    dropped: how many directions the examples do not span, constant attributes not counted.
    """

    mean: Array
    scale: Array
    matrix: Array
    dropped: int = 0

    def coordinates(self, attributes: Array) -> Array:
        """(n, d) of attributes (n, A)."""
        mapped: Array = (attributes - self.mean) @ self.matrix
        return mapped

    def attributes(self, coordinates: Array) -> Array:
        """Return (n, A): the attributes in the span of the examples with these coordinates (n, d)."""
        # In deviations the kept axes are orthogonal, so that the pseudoinverse stays in their plane.
        back: Array = self.mean + coordinates @ np.linalg.pinv(self.scale[:, None] * self.matrix) * self.scale
        return back

    def off_plane(self, attributes: Array) -> Array:
        """Return (n,) the distance of attributes from the span of the examples, in deviations of the examples."""
        varied = self.scale > 0
        missed = (attributes - self.attributes(self.coordinates(attributes)))[:, varied] / self.scale[varied]
        distance: Array = np.linalg.norm(missed, axis=1)
        return distance


def attribute_space(attributes: Array, scaling: Scaling) -> AttributeSpace:
    """The space of the examples' attributes (n, A).

    rotate: principal axes, as the paper has it; distances stay those of the raw numbers, so the attribute with the
    largest spread decides and a change of unit changes the model. zscore: each over its deviation. whiten: zscore,
    principal axes, each over its deviation; axes below 1e-6 of the first are dropped.
    """
    mean = attributes.mean(axis=0)
    spread = attributes.std(axis=0)
    spread = np.where(np.ptp(attributes, axis=0) <= 1e-9 * np.maximum(np.abs(mean), 1.0), 0.0, spread)
    varied = np.flatnonzero(spread > 0)
    matrix = np.zeros((len(mean), len(varied)))
    if not len(varied):
        return AttributeSpace(mean, spread, matrix)
    centred = attributes[:, varied] - mean[varied]
    if scaling == "zscore":
        matrix[varied, np.arange(len(varied))] = 1.0 / spread[varied]
        return AttributeSpace(mean, spread, matrix)
    scale = spread[varied] if scaling == "whiten" else np.ones(len(varied))
    values, axes = np.linalg.eigh(np.atleast_2d((centred / scale).T @ (centred / scale) / len(centred)))
    values, axes = values[::-1], axes[:, ::-1]
    axes = axes * signs_of(axes.T)
    if scaling == "rotate":
        matrix[varied] = axes
        return AttributeSpace(mean, spread, matrix)
    kept = values > SMALLEST * values[0]
    matrix = np.zeros((len(mean), int(kept.sum())))
    matrix[varied] = (axes / scale[:, None])[:, kept] / np.sqrt(values[kept])
    return AttributeSpace(mean, spread, matrix, int((~kept).sum()))


def gaps(values: Array, share: float = 0.15) -> list[tuple[float, float]]:
    """Intervals between neighbouring values (n,) of an attribute that are wider than a share of its whole range."""
    ordered = np.unique(values)
    width = share * (ordered[-1] - ordered[0])
    wide = np.flatnonzero(np.diff(ordered) > width) if width > 0 else np.empty(0, dtype=np.intp)
    return [(float(ordered[index]), float(ordered[index + 1])) for index in wide]


def duplicates(coordinates: Array, tolerance: float = 1e-9) -> list[list[int]]:
    """Return groups of rows (n, d) within a tolerance of their first, in order; single rows are left out."""
    groups: dict[int, list[int]] = {}
    order = np.lexsort(coordinates.T[::-1]) if coordinates.shape[1] else np.arange(len(coordinates))
    taken = np.zeros(len(coordinates), dtype=bool)
    for place, index in enumerate(order):
        if taken[index]:
            continue
        for other in order[place + 1 :]:
            if coordinates.shape[1] and coordinates[other, 0] - coordinates[index, 0] > tolerance:
                break
            if not taken[other] and np.all(np.abs(coordinates[other] - coordinates[index]) <= tolerance):
                groups.setdefault(int(index), [int(index)]).append(int(other))
                taken[other] = True
    return sorted(sorted(group) for group in groups.values())


def same_place(groups: Sequence[Sequence[int]], count: int) -> list[list[int]]:
    """All rows in groups: those given, and each other row alone; in the order of their first rows."""
    grouped = {row for group in groups for row in group}
    alone = [[row] for row in range(count) if row not in grouped]
    return sorted([*(list(group) for group in groups), *alone])
