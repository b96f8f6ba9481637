"""Which examples a blend goes through or near, with which width and ridge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.interface import AnalysisError
from mcml_service.analysis.reach_blending.attribute_space import attribute_space
from mcml_service.analysis.reach_blending.blend import (
    RIDGES,
    SINGULAR,
    SUSPECT,
    WIDTHS,
    Choice,
    Groups,
    choose,
    groups_of,
    invert,
    leavable,
    nearest_distances,
    terms,
)
from mcml_service.analysis.reach_blending.durations import from_time_values
from mcml_service.analysis.reach_blending.options import Options


@dataclass(frozen=True)
class Selected:
    """n examples and the parameters of their blends.

    groups: the clips of each example. centres: (n, d). coefficients: (n, K). time_values: (n, 3). subjects: groups of
    examples of one person, which can be left out; None if people are unknown. alone: the same of each example.
    neighbour: mean distance of different examples to the nearest. condition: of the saddle matrix. choice, time_choice:
    the tried values, None if there were none.
    """

    groups: list[list[int]]
    centres: Array
    coefficients: Array
    time_values: Array
    s: float
    lam: float
    time_s: float
    time_lam: float
    condition: float
    time_condition: float
    subjects: Groups | None
    alone: Groups
    neighbour: float
    choice: Choice | None
    time_choice: Choice | None
    warnings: tuple[tuple[str, str], ...]


def examples_needed(attributes: Array, options: Options, reasons: Sequence[str]) -> None:
    """Raises AnalysisError `too-few-examples` or `degenerate-attributes` where attributes (N, A) carry no model."""
    why = f" {len(reasons)} clips were left out, the first because: {reasons[0]}" if reasons else ""
    if len(attributes) < 2:
        raise AnalysisError(
            "too-few-examples",
            f"{len(attributes)} clips can be used; two are the least.{why}",
            remedy="Add clips, or mend those that were left out.",
        )
    space = attribute_space(attributes, options.scaling)
    x = space.coordinates(attributes)
    dimensions = x.shape[1]
    if not dimensions:
        raise AnalysisError(
            "degenerate-attributes", "All clips have the same attributes.", remedy="Add clips with other attributes."
        )
    distinct = len(np.unique(np.round(x / np.abs(x).max(), 9), axis=0))
    needed = terms(x[:1], options.degree).shape[1]
    if distinct < needed:
        raise AnalysisError(
            "too-few-examples",
            f"{distinct} clips with different attributes are too few for {dimensions} attributes; {needed} are the "
            f"least.{why}",
            remedy="Add clips, or use fewer attributes, or degree 0.",
        )
    # Whitening excludes such directions automatically; without the linear terms they do no harm.
    if options.degree and options.scaling != "whiten" and attribute_space(attributes, "whiten").dropped:
        raise AnalysisError(
            "degenerate-attributes",
            "The clips' attributes are collinear: one of them depends linearly on the others.",
            remedy="Leave an attribute out, or use the robust method.",
        )


def select(
    x: Array,
    groups: list[list[int]],
    coefficients: Array,
    time_values: Array,
    labels: Sequence[str] | None,
    options: Options,
    hand: Callable[[Array], float],
) -> Selected:
    """Select examples of clips at x (N, d) with coefficients (N, K) and time values (N, 3), and the parameters with the
    best prediction. groups: clips of equal attributes. labels: people, (N,). hand: error of the hand at the contact,
    of predicted coefficients (N, K) with NaN. Raises AnalysisError `too-few-examples`, `singular`.
    """
    merged = options.duplicates == "mean" or (
        options.duplicates is None and (options.interpolate or options.lam == 0.0)
    )
    if not merged:
        groups = [[row] for row in range(len(x))]
    centres = np.stack([x[rows].mean(axis=0) for rows in groups])
    values = np.stack([coefficients[rows].mean(axis=0) for rows in groups])
    durations = np.stack([time_values[rows].mean(axis=0) for rows in groups])
    alone = leavable(centres, options.degree, _alone(centres))
    subjects = None
    if labels is not None:
        # An example of several people's clips represents all of them.
        names = ["+".join(sorted({labels[row] for row in rows})) for rows in groups]
        subjects = leavable(centres, options.degree, groups_of(names)) or None
    neighbours = nearest_distances(np.unique(np.round(centres, 9), axis=0))
    widths, ridges = _candidates(neighbours, options)
    choice = time_choice = None
    if len(widths) * len(ridges) > 1:
        left = subjects or alone
        if not left:
            raise AnalysisError(
                "too-few-examples",
                "The clips are too few to leave one out and predict it, which sets the blend's parameters.",
                remedy="Add clips, or state s and lam.",
            )
        example_of = examples_of(groups)
        choice, time_choice = choose(
            centres,
            (values, durations),
            (
                _distance_to(values) if options.choose_by == "coefficients" else lambda new: hand(new[example_of]),
                _frames_to(durations, options.log_times),
            ),
            widths,
            ridges,
            options.degree,
            left,
        )
        if choice is None or time_choice is None:
            raise AnalysisError(
                "singular", "Every width leaves the equations singular.", remedy="Set lam above 0, or add clips."
            )
        s, lam, time_s, time_lam = choice.s, choice.lam, time_choice.s, time_choice.lam
    else:
        s = time_s = widths[0]
        lam = time_lam = ridges[0]
    condition = invert(centres, s, lam, options.degree).condition
    time_condition = invert(centres, time_s, time_lam, options.degree).condition
    worst = max(condition, time_condition)
    if worst > SINGULAR:
        raise AnalysisError(
            "singular",
            f"The equations are singular (condition {worst:.1e}).",
            remedy="Set lam above 0, decrease s, or exclude clips with nearly equal attributes.",
        )
    warnings = (("ill-conditioned", f"The equations are ill-conditioned ({worst:.1e})."),) if worst > SUSPECT else ()
    return Selected(
        groups=groups,
        centres=centres,
        coefficients=values,
        time_values=durations,
        s=s,
        lam=lam,
        time_s=time_s,
        time_lam=time_lam,
        condition=condition,
        time_condition=time_condition,
        subjects=subjects,
        alone=alone,
        neighbour=float(neighbours.mean()),
        choice=choice,
        time_choice=time_choice,
        warnings=warnings,
    )


def examples_of(groups: Sequence[Sequence[int]]) -> NDArray[np.intp]:
    """Return the example of each clip, (N,). groups: the clips of each example."""
    example_of = np.empty(sum(map(len, groups)), dtype=np.intp)
    for example, rows in enumerate(groups):
        example_of[list(rows)] = example
    return example_of


def _alone(centres: Array) -> Groups:
    return [np.array([row], dtype=np.intp) for row in range(len(centres))]


def _candidates(neighbours: Array, options: Options) -> tuple[list[float], list[float]]:
    """Widths and ridges to try: those stated, else the paper's rule or the grid."""
    if options.s is not None:
        widths = [options.s]
    elif options.method == "paper":
        widths = [2.0 * float(neighbours.min())]
    else:
        widths = [factor * float(neighbours.mean()) for factor in WIDTHS]
    if options.interpolate:
        return widths, [0.0]
    return widths, list(RIDGES) if options.lam is None else [options.lam]


def _distance_to(values: Array) -> Callable[[Array], float]:
    """Root mean square distance of predictions (n, K) from the examples' own coefficients."""

    def error(predicted: Array) -> float:
        return float(np.sqrt(np.nanmean(np.sum((predicted - values) ** 2, axis=1))))

    return error


def _frames_to(values: Array, log_times: bool) -> Callable[[Array], float]:
    """Root mean square difference, in base frames, of predicted times from the examples' own."""
    own = from_time_values(values, log_times)

    def error(predicted: Array) -> float:
        return float(np.sqrt(np.nanmean((from_time_values(predicted, log_times) - own) ** 2)))

    return error
