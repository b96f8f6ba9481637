"""The graph of the bars of some clips: bars numbered through, their clouds, edges and the part worth keeping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.figure import Figure, cloud_points
from mcml_service.analysis.dance.motion_beats import whole
from mcml_service.analysis.dance.motion_graph import (
    REACH,
    Edges,
    Indices,
    Pairs,
    Told,
    cloud_frames,
    cloud_weights,
    connect,
    largest_component,
    least_threshold,
    nearest_jumps,
)
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.interface import AnalysisError
from mcml_service.analysis.pieces import Spread

CloudAt = Literal["entry", "first beat"]
MOST_BARS = 2000
FAR = 0.15
"""Body sizes: a jump further than this slides visibly."""


@dataclass(frozen=True)
class AllBars:
    """Bars of all clips, clip by clip. owners: (B,) clips. numbers: (B,) from 0 in their clip. frames: (B, 4) beats.

    entries, leaves: (B,). These are instants: frames, or between them. seconds: (B,) of a beat. natural: (B,) the bar
    that follows in the clip, or -1.
    """

    owners: Indices
    numbers: Indices
    frames: Array
    entries: Array
    leaves: Array
    seconds: Array
    natural: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.owners)


@dataclass(frozen=True)
class BarGraph:
    """edges: all. kept: (B,) whether a bar is in the largest strongly connected component. size: the body's.

    ends, starts: (B, K, 3) clouds, weights (K,), kept for errors that must look for another threshold. jumps: the
    nearest ones, also beyond the threshold.
    """

    bars: AllBars
    edges: Edges
    threshold: float
    kept: NDArray[np.bool_]
    size: float
    ends: Array
    starts: Array
    weights: Array
    jumps: Pairs


def all_bars(clips: Sequence[Clip]) -> AllBars:
    """The bars of clips. Raises AnalysisError `no-beats`, `no-bars`, `too-many-bars`."""
    if not any(len(clip.detected) for clip in clips):
        counts = {
            name: int(sum((clip.candidates.verdicts == verdict).sum() for clip in clips))
            for name, verdict in (("F1", 2), ("F2", 3), ("F3", 4))
        }
        failed = ", ".join(f"{count} by {name}" for name, count in counts.items())
        raise AnalysisError(
            "no-beats",
            f"No clip has a motion beat; candidates refused: {failed}.",
            remedy="Use clips that slow down on beats, or allow shallower ones by k2 and k3.",
            failures=counts,
        )
    count = sum(len(clip.bars.bars) for clip in clips)
    if not count:
        raise AnalysisError(
            "no-bars",
            "No clip has a bar: four beats, evenly a period apart.",
            remedy="Try beats=tracked, state the tempo of the music as source_bpm, or raise interval_tolerance.",
        )
    if count > MOST_BARS:
        raise AnalysisError(
            "too-many-bars",
            f"The clips have {count} bars; a graph may have {MOST_BARS}.",
            remedy="Choose fewer clips.",
            most=MOST_BARS,
        )
    owners = np.concatenate([np.full(len(clip.bars.bars), index) for index, clip in enumerate(clips)]).astype(np.intp)
    numbers = np.concatenate([np.arange(len(clip.bars.bars)) for clip in clips])
    frames = np.concatenate([clip.bars.bars for clip in clips])
    entries = np.concatenate([clip.bars.entries for clip in clips])
    leaves = np.concatenate([clip.bars.leaves for clip in clips])
    rates = np.array([clip.fps for clip in clips])[owners]
    natural = np.full(count, -1, dtype=np.intp)
    last = {(int(owner), float(beat)): bar for bar, (owner, beat) in enumerate(zip(owners, frames[:, 3], strict=True))}
    for bar in range(count):
        before = last.get((int(owners[bar]), float(entries[bar])))
        if before is not None and before != bar:
            natural[before] = bar
    return AllBars(
        owners, numbers, frames, entries, leaves, (frames[:, 3] - frames[:, 0]) / (3 * rates), natural
    )  # fmt: skip


def bar_graph(
    clips: Sequence[Clip],
    threshold: float | None = None,
    coverage: float = 0.8,
    allow_repeat: bool = False,
    cloud_at: CloudAt = "entry",
    told: Told = lambda share: None,
    spread: Spread | None = None,
) -> BarGraph:
    """Edges between the bars of clips on one skeleton, and the component that is kept."""
    bars = all_bars(clips)
    figures = find_shared_points(clips)
    points = figures[0].points
    middles = bars.entries if cloud_at == "entry" else bars.frames[:, 0]
    ends, starts = _clouds(clips, figures, bars, bars.frames[:, 3]), _clouds(clips, figures, bars, middles)
    weights, size = cloud_weights(points), clips[0].figure.size or 1.0
    edges, level, jumps = connect(
        ends, starts, weights, size, bars.natural, threshold, coverage, allow_repeat, told, spread
    )
    kept = largest_component(len(bars), edges.first, edges.second)
    return BarGraph(bars, edges, level, kept, size, ends, starts, weights, jumps)


def find_shared_points(clips: Sequence[Clip]) -> list[Figure]:
    """The figures of clips with the same points: the first one's joints, tips of joints that have as many in all."""
    tips = [[joint for joint, _ in clip.figure.tips] for clip in clips]
    shared = {joint for joint in tips[0] if all(found.count(joint) == tips[0].count(joint) for found in tips)}
    used = clips[0].figure.used
    return [
        replace(clip.figure, used=used, tips=tuple(tip for tip in clip.figure.tips if tip[0] in shared))
        for clip in clips
    ]


def _clouds(clips: Sequence[Clip], figures: Sequence[Figure], bars: AllBars, middles: Array) -> Array:
    """(B, 7 P, 3) points about a frame of each bar, lengths in the clips' unit."""
    points = figures[0].points
    points_of_bars = np.empty((len(bars), (2 * REACH + 1) * points, 3))
    for owner, (clip, figure) in enumerate(zip(clips, figures, strict=True)):
        own = np.flatnonzero(bars.owners == owner)
        if not len(own):
            continue
        motion = clip.motion
        middle = whole(middles[own]).tolist()
        frames = np.concatenate([cloud_frames(frame, clip.fps, len(motion)) for frame in middle])
        clouds = cloud_points(figure, motion.translations[frames], motion.rotations[frames])
        points_of_bars[own] = clouds.reshape(len(own), -1, 3)
    return points_of_bars


def keep_only(graph: BarGraph, wanted: NDArray[np.bool_]) -> BarGraph:
    """The graph with the largest component among wanted bars (B,) kept."""
    inside = graph.edges.among(wanted)
    chosen = np.flatnonzero(wanted)
    place = np.full(len(wanted), -1, dtype=np.intp)
    place[chosen] = np.arange(len(chosen))
    kept = np.zeros(len(wanted), dtype=bool)
    if len(chosen):
        kept[chosen[largest_component(len(chosen), place[inside.first], place[inside.second])]] = True
    return replace(graph, kept=kept)


def threshold_for_two(graph: BarGraph) -> float | None:
    """The least threshold with which two bars lead to each other, natural pairs counted in; None if none does."""
    count = len(graph.bars)
    none = np.full(count, -1, dtype=np.intp)
    pairs = nearest_jumps(graph.ends, graph.starts, graph.weights, graph.size, none, False, count * count)
    natural = graph.bars.natural[pairs.first] == pairs.second
    return least_threshold(count, replace(pairs, distances=np.where(natural, 0.0, pairs.distances)), 2)
