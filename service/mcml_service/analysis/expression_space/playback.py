"""A path as a moving face: markers at constant speed along the walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.errors import SizeError
from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.navigation import Walk
from mcml_service.analysis.interface import AnalysisError

MOST_SAMPLES = 36_000
SMOOTHING = 2.0


@dataclass(frozen=True)
class Samples:
    """first, second: (S,) frames before and after a sample.

    alpha: (S,) its relative position, 0 at first. position: (S,) mm along the path. speed: mm/s.
    """

    first: NDArray[np.int32]
    second: NDArray[np.int32]
    alpha: Array
    position: Array
    speed: float


def sample(
    walk: Walk, speed: float, fps: float = 60.0, *, duration: float | None = None, loop: bool = False
) -> Samples:
    """Samples at constant speed, the first and last of them the end keys exactly.

    speed: mm/s; a whole number of steps needs a slightly different one, which the answer has. duration: seconds of one
    way, in place of the speed. loop: the way back is appended, without the last key twice.
    Raises AnalysisError `zero-length`, `no-speed`; SizeError above 36,000 samples.
    """
    if walk.length <= 1e-9:
        raise AnalysisError("zero-length", "The path stays at one face.", remedy="Choose keys that differ.")
    if duration is None and speed <= 0:
        raise AnalysisError("no-speed", "No speed of capture is known.", remedy="State duration_s or speed_mm_s.")
    steps = max(1.0, np.round((walk.length / speed if duration is None else duration) * fps))
    if steps * (2 if loop else 1) + 1 > MOST_SAMPLES:
        raise SizeError(
            f"The playback has more than {MOST_SAMPLES} samples.",
            remedy="Play it faster, in fewer frames a second, or refine it less.",
            code="too-many-samples",
        )
    position = walk.length * np.arange(int(steps) + 1) / steps
    # Frames that are equal take no time: an edge is entered behind them.
    edge = np.clip(np.searchsorted(walk.position, position, side="right") - 1, 0, len(walk.frames) - 2)
    hop = np.diff(walk.position)[edge]
    alpha = np.clip((position - walk.position[edge]) / np.where(hop > 0, hop, 1.0), 0.0, 1.0)
    edge[-1], alpha[-1] = len(walk.frames) - 2, 1.0
    edge[0], alpha[0] = 0, 0.0
    first, second = walk.frames[edge], walk.frames[edge + 1]
    if loop:
        back = slice(-2, None, -1)
        first, second, alpha, position = (
            np.concatenate([values, values[back]]) for values in (first, second, alpha, position)
        )
    return Samples(first, second, alpha, position, walk.length * fps / steps)


def markers_of(samples: Samples, positions: Array, *, smooth: bool = False) -> Array:
    """Return (S, M, 3) markers in mm, NaN where missing in both frames; if one frame has a marker, its position there.

    positions: (n, M, 3) of all frames, aligned to the neutral one. smooth: Gaussian over 2 samples, ends unchanged.
    """
    a, b = positions[samples.first].astype(float), positions[samples.second].astype(float)
    a, b = np.where(np.isnan(a), b, a), np.where(np.isnan(b), a, b)
    alpha = samples.alpha[:, None, None]
    mixed = (1 - alpha) * a + alpha * b
    return _smooth(mixed) if smooth else mixed


def _smooth(markers: Array) -> Array:
    """Odd about its ends, so that these stay; around missing samples as if they were not there."""
    count = len(markers)
    margin = min(count - 1, int(4 * SMOOTHING + 0.5))
    if margin < 1:
        return markers
    wide = np.concatenate(
        [2 * markers[:1] - markers[margin:0:-1], markers, 2 * markers[-1:] - markers[-2 : -margin - 2 : -1]]
    )
    here = ~np.isnan(wide)
    weight = scipy.ndimage.gaussian_filter1d(here.astype(float), SMOOTHING, axis=0)
    mean = scipy.ndimage.gaussian_filter1d(np.where(here, wide, 0.0), SMOOTHING, axis=0) / np.maximum(weight, 1e-300)
    smooth: Array = np.where(np.isnan(markers), np.nan, mean[margin : margin + count])
    smooth[0], smooth[-1] = markers[0], markers[-1]
    return smooth
