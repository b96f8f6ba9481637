"""Motion without fast noise: a low-pass filter without lag, and a cut-off that the motion itself suggests."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import scipy

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Edited, in_columns, present, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import Flags, HubWriter, Known
from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading

_ORDER: Final = 2
"""Of each of the two passes: together the filter has order 4."""
_PASSES: Final = (2**0.5 - 1) ** 0.25
"""Of the cut-off of one pass: that of both passes of a Butterworth filter of order 2 (Robertson and Dowling 2003,
"Design and responses of Butterworth and critically damped digital filters")."""
_FEWEST: Final = 8
"""Known samples in a row that are filtered at least."""

_TRIED: Final = 60
"""Cut-offs of a residual analysis."""
_NOISY: Final = 0.5
"""Of the highest cut-off: from there on residuals are of noise alone."""


def low_pass(
    skeleton: Skeleton,
    block: FrameBlock,
    hertz: float,
    rate: float,
    strength: Array,
    joints: Sequence[int] | None = None,
    reading: Reading = DEGREES,
) -> Edited:
    """Frames of a clip after a Butterworth filter of order 4 that runs forwards and backwards, so that nothing lags.

    hertz: cut-off, at which half of the power is left. rate: frames a second. strength: (n,) of `frames.eased`: 0 keeps
    a frame bit by bit. joints: all by default. Rotations are filtered as unit quaternions on one half of their sphere.
    Missing samples stay missing; known samples between two gaps are filtered by themselves. Raises ConversionError for
    a cut-off that the rate does not allow.
    """
    sections = design(hertz, rate)
    columns = skeleton.columns()
    raw = in_columns(block, columns)
    hub = HubReader(skeleton, reading).read(block)
    chosen = range(len(skeleton)) if joints is None else joints
    has = present(raw, columns, len(skeleton))
    moved, turned, scales = hub.translations.copy(), hub.rotations.copy(), hub.scales.copy()
    for joint in chosen:
        for start, end in runs(has[:, joint]):
            part, share = slice(start, end), strength[start:end]
            moved[part, joint] += share[:, None] * (_filter(sections, moved[part, joint]) - moved[part, joint])
            scales[part, joint] += share * (_filter(sections, scales[part, joint]) - scales[part, joint])
            mean = _filter(sections, _on_one_half(turned[part, joint]))
            mean /= np.linalg.norm(mean, axis=1, keepdims=True)
            turned[part, joint] = slerp(turned[part, joint], mean, share)
    holds = np.ones((len(block), len(skeleton)), dtype=bool)
    holds[:, list(chosen)] = (strength == 0)[:, None]
    writer = HubWriter(skeleton, reading)
    values = writer.write(moved, turned, scales, Known(hub.values, holds))
    values[np.isnan(raw)] = np.nan
    rows = np.arange(len(block), dtype=np.intp)
    return Edited(remade(block, columns, values, rows, block.ids), writer.shortfall)


def design(hertz: float, rate: float) -> Array:
    """Second-order sections of one pass. Raises ConversionError for a cut-off that the rate does not allow."""
    if not 0 < hertz < rate / 2:
        raise ConversionError(
            f"a cut-off of {hertz:g} Hz is impossible at {rate:g} frames a second",
            remedy=f"Give one below {rate / 2:.4g} Hz, half of the frame rate.",
        )
    one_pass = np.arctan(np.tan(np.pi * hertz / rate) / _PASSES) * rate / np.pi
    sections: Array = scipy.signal.butter(_ORDER, one_pass, fs=rate, output="sos")
    return sections


def runs(known: Flags) -> Iterator[tuple[int, int]]:
    """First frame, and the one after the last, of known samples in a row that can be filtered."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2).tolist():
        if end - start >= _FEWEST:
            yield start, end


def _filter(sections: Array, samples: Array) -> Array:
    filtered: Array = scipy.signal.sosfiltfilt(
        sections, samples, axis=0, padlen=min(6 * (_ORDER + 1), len(samples) - 1)
    )
    return filtered


def _on_one_half(rotations: Array) -> Array:
    """The same rotations, each on the half of the sphere of the one before it."""
    flips = (rotations[1:] * rotations[:-1]).sum(axis=1) < 0
    signs = np.concatenate([[1.0], np.where(np.cumsum(flips) % 2, -1.0, 1.0)])
    turned: Array = rotations * signs[:, None]
    return turned


def suggest_cutoff(positions: Array, rate: float) -> float | None:
    """The cut-off in hertz at which filtering takes as much of the motion as it leaves of the noise, None if unknown.

    positions: (n, P, 3) of points, NaN where unknown; the longest run of each counts. Residual analysis: root mean
    squares of the parts that filters of rising cut-offs take out; a line through those of noise alone is extended to
    0 Hz, and the cut-off is where residuals reach its height there. Source: Winter 2009 ("Biomechanics and motor
    control of human movement", 4th edition, 3.4.4.3).
    """
    highest = rate / 2 * 0.95
    cutoffs = np.linspace(highest / _TRIED, highest, _TRIED)
    known = _longest_runs(positions)
    if not known:
        return None
    squares = np.zeros(_TRIED)
    for index, hertz in enumerate(cutoffs.tolist()):
        sections = design(hertz, rate)
        squares[index] = sum(float(((part - _filter(sections, part)) ** 2).sum()) for part in known)
    residuals = np.sqrt(squares / sum(part.size for part in known))
    tail = cutoffs >= _NOISY * highest
    slope, height = np.polyfit(cutoffs[tail], residuals[tail], 1)
    if not height > 0 or slope > 0:
        return None
    reached = np.flatnonzero(residuals <= height)
    if not len(reached) or reached[0] == 0:
        return None
    after = int(reached[0])
    low, high = residuals[after - 1], residuals[after]
    share = (low - height) / (low - high) if low > high else 0.0
    return float(cutoffs[after - 1] + share * (cutoffs[after] - cutoffs[after - 1]))


def _longest_runs(positions: Array) -> list[Array]:
    """The longest run of known samples of each point, (k, 3 points) of those with the same run; none of short ones."""
    same: dict[tuple[int, int], list[int]] = {}
    for point in range(positions.shape[1]):
        known = np.asarray(np.isfinite(positions[:, point]).all(axis=1))
        run = max(runs(known), key=lambda each: each[1] - each[0], default=None)
        if run is not None:
            same.setdefault(run, []).append(point)
    return [positions[start:end, points].reshape(end - start, -1) for (start, end), points in same.items()]
