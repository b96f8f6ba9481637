"""How well a dance keeps to its grid, and how smooth its transitions are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.hub import walked
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.assembly import Transition
from mcml_service.analysis.dance.figure import Figure
from mcml_service.analysis.dance.motion_beats import locate, mean_speed, minima, refine

SIGMA = 0.05
"""Seconds; AIST++ uses 3 frames at 60 a second."""
NEAR = 0.07
MARGIN = 0.1
"""Seconds at each end of a transition that contain its two beats."""
LOW = 0.02


@dataclass(frozen=True)
class Watched:
    """A motion as the metrics see it. speed: (F,) smoothed. raw: (F,) unsmoothed. beats: seconds.

    foot_speed: mean horizontal speed (F,) of low feet, sizes a second, NaN where no foot is low.
    turning: (F - 1,) greatest joint rotation, radians a second. moving: (F - 1,) the mean point, sizes a second.
    """

    fps: float
    speed: Array
    raw: Array
    beats: Array
    foot_speed: Array
    turning: Array
    moving: Array


def watch(
    figure: Figure,
    translations: Array,
    rotations: Array,
    fps: float,
    located: bool = True,
    k2: float = 2 / 15,
    k3: float = 1.0,
    smooth: float = 0.04,
) -> Watched:
    """Return the data of a motion for the metrics: translations (F, J, 3), rotations (F, J, 4), Y up."""
    positions, _ = walked(figure.skeleton, translations, rotations)
    used = np.ascontiguousarray(positions[:, figure.used].transpose(1, 2, 0))
    speed, raw = mean_speed(used, fps, smooth), mean_speed(used, fps, 0.0)
    accepted = refine(speed, fps, k2, k3).beats
    beats = locate(speed, accepted, fps) if located else accepted.astype(float)
    middle = used.mean(axis=0)
    size = figure.size or 1.0
    return Watched(
        fps,
        speed,
        raw,
        beats / fps,
        foot_speed(positions[:, figure.feet], fps, size),
        rotation_speed(rotations[:, figure.used], fps),
        np.linalg.norm(np.diff(middle, axis=1), axis=0) * fps / size,
    )


def rotation_speed(rotations: Array, fps: float) -> Array:
    """(F - 1,) the greatest angle of any joint from one frame to the next, radians a second. rotations: (F, J, 4)."""
    products = np.sum(rotations[1:] * rotations[:-1], axis=-1)
    halves = np.abs(products)
    chords = np.linalg.norm(rotations[1:] - np.where(products < 0, -1.0, 1.0)[..., None] * rotations[:-1], axis=-1)
    # The arc cosine is blind to small angles, the chord to large ones.
    angles = np.where(halves > 0.9, 4 * np.arcsin(np.clip(chords / 2, 0, 1)), 2 * np.arccos(np.clip(halves, 0, 1)))
    greatest: Array = angles.max(axis=1, initial=0.0) * fps
    return greatest


def foot_speed(feet: Array, fps: float, size: float) -> Array:
    """(F,) mean horizontal speed, sizes a second, of feet near the ground; NaN without any. feet: (F, N, 3).

    Near: lower than 0.02 size above the 2 % quantile of that joint's own height.
    """
    if not feet.shape[1] or len(feet) < 2:
        return np.full(len(feet), np.nan)
    low = feet[..., 1] < np.quantile(feet[..., 1], 0.02, axis=0) + LOW * size
    velocity = np.gradient(feet[..., [0, 2]], axis=0) * fps / size
    speed = np.linalg.norm(velocity, axis=-1)
    count = low.sum(axis=1)
    mean: Array = np.where(count > 0, (speed * low).sum(axis=1) / np.maximum(count, 1), np.nan)
    return mean


def beat_alignment(beats: Array, grid: Array, sigma: float = SIGMA) -> float:
    """Mean over `beats` of exp(-d^2 / (2 sigma^2)), d to the nearest of `grid`; 0 where either is empty. Seconds.

    AIST++ (Li et al., ICCV 2021), eq. 8.
    """
    if not len(beats) or not len(grid):
        return 0.0
    return float(np.exp(-(nearest(beats, grid) ** 2) / (2 * sigma**2)).mean())


def nearest(times: Array, others: Array) -> Array:
    """(n,) distance of each time to the nearest of others (sorted, not empty)."""
    place = np.clip(np.searchsorted(others, times), 1, max(1, len(others) - 1))
    after, before = others[np.minimum(place, len(others) - 1)], others[place - 1]
    distances: Array = np.minimum(np.abs(times - after), np.abs(times - before))
    return distances


def inside(time: Array, transitions: Sequence[Transition]) -> NDArray[np.bool_]:
    """Return (F,) whether a time is in a transition."""
    within = np.zeros(len(time), dtype=bool)
    for transition in transitions:
        within |= (time > transition.start) & (time < transition.end)
    return within


def of_transition(watched: Watched, transition: Transition) -> dict[str, float | int | None]:
    """Variance and peak of the speed over its mean in the whole dance, motion beats inside, foot skate."""
    time = np.arange(len(watched.raw)) / watched.fps
    window = (time > transition.start) & (time < transition.end)
    mean = float(watched.raw.mean())
    relative = watched.raw[window] / mean if mean > 0 else watched.raw[window]
    low, high = transition.start + MARGIN, transition.end - MARGIN
    return {
        "speed_variance": float(relative.var()) if len(relative) else 0.0,
        "speed_peak": float(relative.max(initial=0.0)),
        "beats_inside": int(((watched.beats > low) & (watched.beats < high)).sum()),
        "foot_skate": mean_or_none(watched.foot_speed[window]),
    }


def mean_or_none(values: Array) -> float | None:
    """Return the mean of values that are not NaN; None if all are."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None


def grid_metrics(watched: Watched, grid: Array) -> dict[str, float]:
    """Measure the match of dance and grid.

    grid: motion beats, seconds; its two ends, where no minimum can be, are left out.
    """
    inner = grid[1:-1]
    lows = minima(watched.speed) / watched.fps
    hits = {"grid_hits_frame": 1.0 / watched.fps, "grid_hits_70ms": NEAR}
    figures = {
        "beat_align_music": beat_alignment(inner, watched.beats),
        "beat_align_motion": beat_alignment(watched.beats, grid),
    }
    for name, width in hits.items():
        near = nearest(inner, lows) <= width + 1e-9 if len(lows) and len(inner) else np.zeros(len(inner))
        figures[name] = float(near.mean()) if len(inner) else 0.0
    return figures


def greatest(values: Array) -> float:
    """The greatest of an array, 0 of an empty one."""
    return float(values.max(initial=0.0))


def clip_extremes(figure: Figure, translations: Array, rotations: Array, fps: float) -> tuple[float, float]:
    """Greatest joint rotation speed (radians a second) and body speed (sizes a second) of a source."""
    turning = greatest(rotation_speed(rotations[:, figure.used], fps))
    positions, _ = walked(figure.skeleton, translations, rotations)
    middle = positions[:, figure.used].mean(axis=1)
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    return turning, greatest(steps) * fps / (figure.size or 1.0)
