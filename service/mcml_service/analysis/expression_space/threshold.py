"""How near two expressions have to be for a step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcml_service.analysis.expression_space.options import MARKER_MM, TauRule
from mcml_service.analysis.expression_space.trials import Trials, Tried

STEPS = 24
"""Thresholds that the rule `unbroken` chooses among."""
BROKEN = 0.005
MARGIN = 1.3
FARTHER = 1.5
JUMP = 0.10
SPARSE = 0.25


@dataclass(frozen=True)
class Chosen:
    """A threshold, mm, and warnings: (code, sentence)."""

    tau: float
    warnings: tuple[tuple[str, str], ...] = ()


def choose(trials: Trials, tried: Sequence[Tried], rule: TauRule, markers: int) -> Chosen:
    """The threshold of a rule.

    published: 2.3 mm for each marker. best: largest r (the paper's search; on a chain of frames r is 1, so it has
    little meaning). unbroken: with a margin, the smallest at which near frames are near on the graph.
    """
    published = MARKER_MM * markers
    if rule == "published":
        return Chosen(published)
    if rule == "unbroken":
        return _unbroken(trials, [trial for trial in tried if trial.tau >= trials.low])
    usable = [trial for trial in tried if np.isfinite(trial.r)]
    if not usable:
        text = "No threshold tried has a correlation that is defined: 2.3 mm for each marker is taken."
        return Chosen(published, (("tau-undefined", text),))
    best = max(trial.r for trial in usable)
    return Chosen(next(trial.tau for trial in usable if trial.r == best))


def _unbroken(trials: Trials, tried: Sequence[Tried]) -> Chosen:
    """The first threshold at which at most 0.005 of the near pairs are broken, times 1.3 where that opens no short cut.

    tried: by rising tau, up to the longest distance, at which nothing is broken.
    """
    first = next((trial.tau for trial in tried if trial.broken <= BROKEN), trials.longest)
    wide = max(first, min(MARGIN * first, trials.longest))
    cut = trials.jump(first, wide) > JUMP
    tau = first if cut else wide
    warnings = []
    if first > SPARSE * trials.far:
        text = (
            f"Near faces are near on the graph only from {first:.3g} mm on, {100 * first / trials.far:.0f} % of the "
            "distance of far ones: the space is sparse, and its map nearly that of straight distances."
        )
        warnings.append(("sparse-space", text))
    if cut or trials.jump(tau, FARTHER * tau) > JUMP:
        text = (
            f"A threshold a little above {tau:.3g} mm opens short cuts: {100 * JUMP:.0f} % of the ways or more become "
            "shorter by a third. Look at the map at several thresholds (tau_mm)."
        )
        warnings.append(("near-gap", text))
    return Chosen(tau, tuple(warnings))
