"""A space of expressions, built stage by stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.errors import SizeError
from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import (
    FrameGraph,
    closest_bridges,
    hub_graph,
    threshold_graph,
)
from mcml_service.analysis.expression_space.geodesics import all_pairs
from mcml_service.analysis.expression_space.landmark_scale import Basis, basis_of, landmark_geodesics
from mcml_service.analysis.expression_space.levels import Level, farthest_order, level_sizes, make_levels
from mcml_service.analysis.expression_space.links import Links, edge_links, half_nearest, paper_links, voronoi_links
from mcml_service.analysis.expression_space.neighbours import nearest
from mcml_service.analysis.expression_space.options import FLOYD_FRAMES, FULL_FRAMES, MARKER_MM, MOST_FRAMES, Options
from mcml_service.analysis.expression_space.planar_map import (
    Agreement,
    Scaling,
    agreement,
    agreement_between,
    classical_scaling,
    neighbourhoods,
)
from mcml_service.analysis.expression_space.states import SAME, distances, state_vectors, step_lengths
from mcml_service.analysis.expression_space.takes import Frames, frames_of, part_of, smooth_takes
from mcml_service.analysis.expression_space.threshold import STEPS, Chosen, choose
from mcml_service.analysis.expression_space.trials import Trials, Tried
from mcml_service.analysis.interface import AnalysisError, Motion, Progress, silent

SAMPLE = 2000
SPEED_SMOOTHING = 1 / 30
POOR = 0.9
HUBS = 1000
SHOWN_DIMENSIONS = (2, 3, 5, 10)


@dataclass(frozen=True)
class Reduced:
    """The data of a large space that replace all distances.

    states: (n, d). landmarks: (l,) frames. geodesics: (l, n).
    """

    basis: Basis
    states: Array
    landmarks: NDArray[np.int32]
    geodesics: NDArray[np.float32]


@dataclass(frozen=True)
class Space:
    """coordinates: (n, p) mm on the map.

    scaling: of all frames, or of the landmarks. geodesics: (n, n) in single precision, None with landmarks. tau: mm.
    connecting: mm, the smallest threshold that joins all frames (or all hubs and their frames, with landmarks).
    neighbourhoods: trustworthiness and continuity of the plane. speed: mm of path per second in which faces were
    captured, three quarters of the frames slower.
    """

    options: Options
    frames: Frames
    graph: FrameGraph
    tau: float
    connecting: float
    tried: tuple[Tried, ...]
    components: tuple[int, ...]
    coordinates: Array
    scaling: Scaling
    agreements: tuple[Agreement, ...]
    neighbourhoods: tuple[float, float]
    levels: tuple[Level, ...]
    links: tuple[Links, ...]
    radii: tuple[float, ...]
    geodesics: NDArray[np.float32] | None
    reduced: Reduced | None
    speed: float
    warnings: tuple[tuple[str, str], ...]


def build(motions: Sequence[Motion], options: Options, progress: Progress = silent) -> Space:
    """The space of takes. Raises AnalysisError as documented, SizeError above 100,000 frames."""
    total = sum(len(motion) for motion in motions)
    if total > MOST_FRAMES:
        raise SizeError(
            f"The takes have {total} frames.",
            remedy=f"Give at most {MOST_FRAMES}, or take every second frame.",
            code="too-many-frames",
        )
    progress("states", 0.0)
    frames = frames_of(motions, options)
    count = len(frames.take)
    if options.method == "paper" and count > FLOYD_FRAMES:
        raise AnalysisError(
            "too-many-frames-for-floyd",
            f"The paper's algorithm takes at most {FLOYD_FRAMES} frames; these are {count}.",
            remedy='Use method="robust", or fewer takes.',
        )
    large = options.scale == "landmark" or (options.scale == "auto" and count > FULL_FRAMES)
    return _with_landmarks(frames, options, progress) if large else _with_all(frames, options, progress)


def _with_all(frames: Frames, options: Options, progress: Progress) -> Space:
    states = state_vectors(frames.positions)
    progress("distances", 0.08)
    apart = distances(states)
    del states
    trials = Trials(apart)
    _require_variation(trials.longest)
    tried, tau, warnings = _threshold(trials, len(frames.markers), options, progress, (0.2, 0.45))
    edges, lengths = trials.tree
    connecting = float(lengths.max())
    progress("graph", 0.45)
    graph = threshold_graph(apart, tau)
    cut = (lengths > tau) & np.isfinite(lengths)
    graph, kept, sizes, more = _connect(graph, edges[cut], lengths[cut], frames, options, connecting)
    warnings += more
    if not kept.all():
        frames, graph, apart = part_of(frames, kept), graph.keep(kept), apart[np.ix_(kept, kept)]
    progress("geodesics", 0.5)
    paths = all_pairs(graph.matrix)
    progress("map", 0.75)
    scaling = classical_scaling(paths, options.dimensions)
    sample = trials.spread if kept.all() else Trials(apart).spread
    near = neighbourhoods(apart[np.ix_(sample, sample)], scaling.coordinates[sample, :2])
    shown = [size for size in SHOWN_DIMENSIONS if size <= options.dimensions]
    agreements = tuple(agreement(paths, scaling.coordinates[:, :size]) for size in shown)
    # Noise of single frames is no speed: where frames were not smoothed, they are for this.
    after = np.diagonal(apart, 1) if options.smooth_s > 0 else step_lengths(smooth_takes(frames, SPEED_SMOOTHING))
    speed = _speed(frames, lambda first: after[first])
    kept_paths = paths.astype(np.float32)
    del apart, paths
    return _with_levels(
        frames, options, progress, graph, tau, connecting, tried, sizes, scaling.coordinates, scaling,
        agreements, near, kept_paths, None, speed, warnings,
    )  # fmt: skip


def _with_landmarks(frames: Frames, options: Options, progress: Progress) -> Space:
    basis = basis_of(frames.positions, options.seed)
    states = np.empty((len(frames.take), len(basis.components)))
    step = 10_000
    for start in range(0, len(states), step):
        progress("states", 0.05 + 0.35 * start / len(states))
        states[start : start + step] = basis.reduce(frames.positions[start : start + step])
    _require_variation(float(np.ptp(states, axis=0).max()))
    progress("tau", 0.4)
    hubs = farthest_order(states, min(HUBS, len(states)))
    radius = float(nearest(states[hubs], states)[0].max())
    trials = Trials(scipy.spatial.distance.cdist(states[hubs], states[hubs]), max(2.0 * radius, SAME))
    tried, tau, warnings = _threshold(trials, len(frames.markers), options, progress, (0.4, 0.43))
    progress("graph", 0.43)
    graph = hub_graph(states, hubs, tau, frames.take, frames.frame)
    pairs, lengths = closest_bridges(states, graph.components())
    graph, kept, sizes, more = _connect(graph, pairs, lengths, frames, options, trials.low)
    warnings += more
    if not kept.all():
        frames, graph, states = part_of(frames, kept), graph.keep(kept), states[kept]
    progress("geodesics", 0.45)
    landmarks = farthest_order(states, min(options.landmarks, len(states)))
    geodesics = landmark_geodesics(graph, landmarks)
    progress("map", 0.7)
    scaling = classical_scaling(geodesics[:, landmarks].astype(float), options.dimensions)
    coordinates = np.empty((len(states), options.dimensions))
    for start in range(0, len(states), step):
        coordinates[start : start + step] = scaling.place(geodesics[:, start : start + step].T.astype(float) ** 2)
    sample = np.unique(np.linspace(0, len(states) - 1, min(SAMPLE, len(states))).astype(np.intp))
    agreements = tuple(
        agreement_between(geodesics[:, sample].astype(float), scaling.coordinates[:, :size], coordinates[sample, :size])
        for size in SHOWN_DIMENSIONS
        if size <= options.dimensions
    )
    speed = _speed(frames, lambda first: np.linalg.norm(states[first + 1] - states[first], axis=1))
    near = neighbourhoods(
        scipy.spatial.distance.cdist(states[landmarks], states[landmarks]), coordinates[landmarks, :2]
    )
    return _with_levels(
        frames, options, progress, graph, tau, trials.low, tried, sizes, coordinates, scaling, agreements, near, None,
        Reduced(basis, states, landmarks, geodesics), speed, warnings,
    )  # fmt: skip


def _with_levels(
    frames: Frames,
    options: Options,
    progress: Progress,
    graph: FrameGraph,
    tau: float,
    connecting: float,
    tried: tuple[Tried, ...],
    components: tuple[int, ...],
    coordinates: Array,
    scaling: Scaling,
    agreements: tuple[Agreement, ...],
    neighbourhoods: tuple[float, float],
    geodesics: NDArray[np.float32] | None,
    reduced: Reduced | None,
    speed: float,
    warnings: list[tuple[str, str]],
) -> Space:
    count = len(coordinates)
    sizes = level_sizes(count, min(options.first_level, count))
    if reduced is not None:
        options = replace(options, grouping="fps")
        sizes = [size for size in sizes if size <= options.most_candidates] or sizes[:1]
    plane = coordinates[:, :2]
    levels: list[Level] = []
    links: list[Links] = []
    radii: list[float] = []
    for level in make_levels(coordinates[:, : options.cluster_dimensions], options, sizes):
        done = sum(sizes[: len(levels) + 1]) / sum(sizes)
        progress("levels", 0.78 + 0.2 * done)
        levels.append(level)
        radii.append(half_nearest(plane[level.candidates]) if options.rho is None else options.rho)
        progress("links", 0.78 + 0.21 * done)
        if len(level.candidates) == count:
            links.append(edge_links(graph))
        elif options.links == "paper":
            links.append(paper_links(graph, level.candidates, plane, radii[-1]))
        else:
            links.append(voronoi_links(graph, level.candidates))
        if links[-1].components > 1:
            text = f"The links of level {len(links) - 1} fall into {links[-1].components} parts."
            warnings.append(("links-disconnected", text))
    if scaling.negative > 0.2:
        text = f"{100 * scaling.negative:.0f} % of the map's spectrum are negative: it cannot keep the distances."
        warnings.append(("poor-embedding", text))
    if min(neighbourhoods) < POOR:
        trustworthiness, continuity = neighbourhoods
        text = (
            f"The plane keeps what is near badly (trustworthiness {trustworthiness:.2f}, continuity {continuity:.2f}): "
            "levels, links and paths use more dimensions."
        )
        warnings.append(("poor-map", text))
    missing = int((scaling.eigenvalues <= 0).sum())
    if missing:
        warnings.append(("fewer-dimensions", f"{missing} of the map's dimensions are empty."))
    return Space(
        options=options,
        frames=frames,
        graph=graph,
        tau=tau,
        connecting=connecting,
        tried=tried,
        components=components,
        coordinates=coordinates,
        scaling=scaling,
        agreements=agreements,
        neighbourhoods=neighbourhoods,
        levels=tuple(levels),
        links=tuple(links),
        radii=tuple(radii),
        geodesics=geodesics,
        reduced=reduced,
        speed=speed,
        warnings=(*frames.warnings, *warnings),
    )


def _threshold(
    trials: Trials, markers: int, options: Options, progress: Progress, span: tuple[float, float]
) -> tuple[tuple[Tried, ...], float, list[tuple[str, str]]]:
    """The curve of thresholds, the one that is taken, warnings. span: shares of the work where this begins and ends."""
    published, stated = MARKER_MM * markers, options.tau_mm
    searched = stated is None and options.tau_rule == "unbroken"
    count = max(options.tau_count, STEPS) if searched else options.tau_count
    tried = []
    steps = trials.steps(count, published, *([] if stated is None else [stated]))
    for number, tau in enumerate(steps):
        progress("tau", span[0] + (span[1] - span[0]) * number / len(steps))
        tried.append(trials.try_threshold(tau))
    chosen = Chosen(stated) if stated is not None else choose(trials, tried, options.tau_rule, markers)
    return tuple(tried), chosen.tau, list(chosen.warnings)


def _require_variation(longest: float) -> None:
    if not longest >= SAME:
        raise AnalysisError("no-variation", "All frames show the same face.", remedy="Give takes in which it moves.")


def _connect(
    graph: FrameGraph,
    pairs: NDArray[np.intp],
    lengths: Array,
    frames: Frames,
    options: Options,
    connecting: float,
) -> tuple[FrameGraph, NDArray[np.bool_], tuple[int, ...], list[tuple[str, str]]]:
    """Connect the graph as the options require (2.4); return it, the remaining frames, the sizes of its parts
    before, and warnings.
    """
    sizes = np.bincount(graph.components())
    before = tuple(sorted((int(size) for size in sizes), reverse=True))
    whole = np.ones(graph.frames, dtype=bool)
    if len(sizes) == 1:
        return graph, whole, before, []
    if options.on_disconnected == "error":
        raise AnalysisError(
            "disconnected",
            f"At this threshold the frames fall into {len(sizes)} parts.",
            remedy='Use a larger threshold, or on_disconnected="bridge".',
            components=list(before[:100]),
            connecting_tau_mm=connecting if np.isfinite(connecting) else None,
        )
    warnings = []
    if options.on_disconnected == "bridge":
        graph = graph.add_bridges(pairs, lengths)
        warnings.append(
            (
                "bridged",
                f"{len(sizes)} parts of the graph were joined by {len(pairs)} bridges, {max(lengths):.0f} mm at most.",
            )
        )
    labels = graph.components()
    sizes = np.bincount(labels)
    if len(sizes) > 1:
        whole = labels == sizes.argmax()
        lost = sorted(set(frames.take.tolist()) - set(frames.take[whole].tolist()))
        names = ", ".join(frames.takes[take].name for take in lost[:10])
        text = f"{int((~whole).sum())} frames outside the largest part of the graph were left out"
        warnings.append(("frames-left-out", text + (f", with them all of: {names}." if lost else ".")))
    if int(whole.sum()) < 3:
        raise AnalysisError(
            "disconnected", "No two frames are near enough to be joined.", remedy="Use a larger threshold.",
            components=list(before[:100]), connecting_tau_mm=connecting,
        )  # fmt: skip
    return graph, whole, before, warnings


def _speed(frames: Frames, apart: Callable[[NDArray[np.intp]], Array]) -> float:
    """Three quarters of the captured steps are slower, mm/s. apart: first frames of steps -> lengths, mm."""
    first = np.flatnonzero((np.diff(frames.take) == 0) & (np.diff(frames.frame) == 1))
    if not len(first):
        return 0.0
    rates = np.array([take.fps for take in frames.takes])[frames.take[first]]
    speeds = apart(first) * rates
    speeds = speeds[np.isfinite(speeds)]
    return float(np.percentile(speeds, 75)) if len(speeds) else 0.0
