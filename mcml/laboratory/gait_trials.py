"""Trials whose strides count together: means and standard deviations of parameters and of cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mcml.laboratory.gait_cycles import Cycles, MeanCycle, mean_cycle
from mcml.laboratory.gait_events import Side
from mcml.laboratory.gait_parameters import Stride, Summary, summarise
from mcml.laboratory.measure_gait import Gait
from mcml.motion.skeleton import Array


@dataclass(frozen=True, eq=False)
class Trial:
    """gait: None where it could not be measured. cycles: of each quantity and side. warnings: of the gait, and of
    quantities that it lacks."""

    document: str
    name: str
    gait: Gait | None
    cycles: Mapping[tuple[str, Side], Cycles]
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Group:
    """Trials whose strides count alike. units: of the quantities."""

    trials: tuple[Trial, ...]
    units: Mapping[str, str]

    @property
    def strides(self) -> list[Stride]:
        """Of all trials."""
        return [stride for trial in self.trials if trial.gait is not None for stride in trial.gait.strides]

    def summary(self, side: Side, name: str) -> Summary:
        """Summarise a parameter of a side over all strides that are not rejected."""
        return summarise(self.strides, side, name)

    def cycles(self, quantity: str, side: Side) -> tuple[Array, int]:
        """((strides, 101) curves, number of strides with a gap)."""
        found = [trial.cycles[quantity, side] for trial in self.trials if (quantity, side) in trial.cycles]
        return np.concatenate([np.empty((0, 101)), *(each.curves for each in found)]), sum(each.gaps for each in found)

    def mean(self, quantity: str, side: Side) -> MeanCycle:
        """The mean cycle of a side."""
        return mean_cycle(self.cycles(quantity, side)[0])
