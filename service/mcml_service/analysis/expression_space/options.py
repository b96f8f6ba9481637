"""Options of a space. `paper` and `robust` are two sets of values, not two programs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

from mcml_service.analysis.interface import AnalysisError

MARKER_MM = 2.3
"""The paper's threshold of 230 mm for each of its 100 markers: mm root mean square per pair of markers."""
FULL_FRAMES = 5000
"""Limit of frames for which all distances are stored; above, landmarks are used."""
FLOYD_FRAMES = 3000
FEWEST_MARKERS = 4
MOST_FRAMES = 100_000

TauRule: TypeAlias = Literal["published", "best", "unbroken"]


@dataclass(frozen=True)
class Options:
    """smooth_s: deviation of the Gaussian in time, s. gap_s: longest gap that is filled, s. tau_mm: threshold, mm;
    None: found by `tau_rule`. tau_count: thresholds tried. dimensions: kept of the map; cluster_dimensions: of these,
    those in which frames are grouped. first_level: candidates of the coarsest level. rho: radius of the paper's links,
    map units; None: half the median distance of candidates to the nearest. neighbours: old frames that an added one is
    joined to. landmarks: of large spaces.
    """

    method: Literal["robust", "paper"]
    smooth_s: float
    tau_rule: TauRule
    on_disconnected: Literal["bridge", "largest", "error"]
    cluster_dimensions: int
    grouping: Literal["fcm", "fps"]
    links: Literal["paper", "voronoi"]
    markers: tuple[str, ...] = ()
    normalise_scale: bool = False
    scale: Literal["auto", "full", "landmark"] = "auto"
    gap_s: float = 0.2
    tau_mm: float | None = None
    tau_count: int = 12
    dimensions: int = 10
    first_level: int = 11
    fuzziness: float = 2.0
    iterations: int = 100
    rho: float | None = None
    neighbours: int = 12
    landmarks: int = 300
    most_candidates: int = 2816
    seed: int = 0


_ROBUST = Options("robust", 1 / 30, "unbroken", "bridge", 10, "fcm", "voronoi")
_PAPER = Options("paper", 0.0, "published", "largest", 2, "fcm", "paper")


def options_of(method: Literal["robust", "paper"] = "robust", **stated: Any) -> Options:
    """Return the values of a method, overridden by the stated ones (not None)."""
    base = _ROBUST if method == "robust" else _PAPER
    return replace(base, **{name: value for name, value in stated.items() if value is not None})


def check_options(options: Options) -> None:
    """Raises AnalysisError `marker-sets-disjoint` for markers that cannot form a space, for any takes."""
    if 0 < len(set(options.markers)) < FEWEST_MARKERS:
        raise AnalysisError(
            "marker-sets-disjoint",
            f"{len(set(options.markers))} markers are wanted; a space needs {FEWEST_MARKERS}.",
            remedy="Name more, or none: then all that the takes have in common count.",
        )
