"""Spikes: samples far from all around them, found by the Hampel identifier and bridged by splines."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from mcml.motion.clip import FrameBlock
from mcml.motion.edits.gap_filling import fill_gaps
from mcml.motion.frames import in_columns, present, remade
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import Flags
from mcml.motion.rotation_vectors import to_vector
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import CHANNEL_INDEX, ROTATIONS, TRANSLATIONS, Array, Skeleton
from mcml.motion.units import DEGREES, Reading

_GAUSSIAN: Final = 1.4826
"""Standard deviation of normal noise, in median absolute deviations."""
_SMALL: Final = 0.005
"""Of the size of the body: a sample that is nearer to the median is no spike, however still the others are."""
_SMALL_ANGLE: Final = np.radians(2.0)
"""The same of a rotation, radians."""
_FEWEST: Final = 3
"""Known samples of a window, at least."""
_PAIRS: Final = 3
"""Of neighbours that tell a sample, at least."""
_MOVES: Final = frozenset(CHANNEL_INDEX[channel] for channel in TRANSLATIONS)
_TURNS: Final = frozenset(CHANNEL_INDEX[channel] for channel in ROTATIONS)


@dataclass
class Despiked:
    """block: the frames. counts: samples that were replaced, by joint. frames: of them, from 0, in order. left: spikes
    that stay, since no known sample is before or after them.
    """

    block: FrameBlock
    counts: Counter[int] = field(default_factory=Counter)
    frames: tuple[int, ...] = ()
    left: int = 0


def despike(
    skeleton: Skeleton,
    block: FrameBlock,
    rows: slice,
    deviations: float = 6.0,
    window: int = 7,
    joints: Sequence[int] | None = None,
    reading: Reading = DEGREES,
) -> Despiked:
    """Replace spikes of joints and markers in some frames by splines over the samples around them.

    Each sample is compared with the median of the means of samples at the same distance before and after it, so that a
    fast straight course is no spike and hides none. A place is a spike where one coordinate of that difference is more
    than `deviations` scaled median absolute deviations from its median over a window of so many frames (Hampel 1974,
    "The influence curve and its role in robust estimation"), and over half a hundredth of the body's size; a rotation
    likewise, as rotation vector, and over 2 degrees. block: frames of a clip, with those around. rows: the frames in
    which spikes are replaced. joints: all by default. Other samples keep their bits; missing ones stay missing.
    """
    columns = skeleton.columns()
    raw = in_columns(block, columns)
    known = present(raw, columns, len(skeleton))
    hub = HubReader(skeleton, reading).read(block)
    small = _SMALL * _size(skeleton, hub.translations, hub.rotations, known)
    inside = np.zeros(len(block), dtype=bool)
    inside[rows] = True
    spikes = np.zeros(raw.shape, dtype=bool)
    for joint in range(len(skeleton)) if joints is None else joints:
        own = [(index, channel) for index, (each, channel) in enumerate(columns) if each == joint]
        moves = [index for index, channel in own if channel in _MOVES]
        turns = [index for index, channel in own if channel in _TURNS]
        if moves:
            places = np.where(known[:, joint, None], hub.translations[:, joint], np.nan)
            off = places - from_neighbours(places, window)
            spikes[:, moves] = (inside & find_spikes(off, deviations, window, small))[:, None]
        if turns:
            off = _turns_from_neighbours(hub.rotations[:, joint], known[:, joint], window)
            spikes[:, turns] = (inside & find_spikes(off, deviations, window, _SMALL_ANGLE))[:, None]
    return _bridge(skeleton, block, raw, spikes, reading)


def find_spikes(residuals: Array, deviations: float, window: int, small: float = 0.0) -> Flags:
    """(n,) the Hampel identifier: whether a residual is far from the median of its window, in any column.

    residuals: (n, d), NaN where missing. window: frames, odd; at the ends and beside gaps it has fewer samples, at
    least three. small: residuals up to this are of no spike.
    """
    around = _windows(residuals, window)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        middle = np.nanmedian(around, axis=2)
        spread = _GAUSSIAN * np.nanmedian(np.abs(around - middle[..., None]), axis=2)
    far = (np.abs(residuals - middle) > deviations * spread) & (np.abs(residuals) > small)
    enough = np.isfinite(around).sum(axis=2) >= _FEWEST
    flags: Flags = (far & enough).any(axis=1)
    return flags


def from_neighbours(values: Array, window: int) -> Array:
    """(n, d) the median of the means of samples at the same distance before and after each, within half a window.

    values: (n, d), NaN where missing. A straight course is its own; NaN where fewer than three such pairs are known, as
    at the ends.
    """
    around = _windows(values, window)
    half = window // 2
    means = (around[..., :half] + around[..., :half:-1]) / 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        predicted: Array = np.nanmedian(means, axis=2)
    predicted[np.isfinite(means).sum(axis=2) < min(_PAIRS, half)] = np.nan
    return predicted


def _windows(values: Array, window: int) -> Array:
    """(n, d, window) of values (n, d), NaN beyond the ends."""
    half = window // 2
    padded = np.pad(values, ((half, half), (0, 0)), constant_values=np.nan)
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)


def _turns_from_neighbours(rotations: Array, known: Flags, window: int) -> Array:
    """(n, 3) rotation vectors from the rotation that the neighbours tell to each rotation (n, 4); NaN where missing."""
    signs = np.where((rotations[1:] * rotations[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    even = rotations * np.concatenate([[1.0], np.cumprod(signs)])[:, None]
    even[~known] = np.nan
    told = from_neighbours(even, window)
    length = np.linalg.norm(told, axis=1)
    lacking = ~(length > 0.5) | ~known
    told = np.where(lacking[:, None], rotations, told / np.where(lacking, 1.0, length)[:, None])
    vectors: Array = to_vector(multiply(inverse(told), rotations))
    vectors[lacking] = np.nan
    return vectors


def _size(skeleton: Skeleton, translations: Array, rotations: Array, known: Flags) -> float:
    """Four times the median distance of joints from their middle: about a person's height, also with points far off."""
    places = np.where(known[..., None], walked(skeleton, translations, rotations)[0], np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        middle = np.nanmedian(places, axis=1, keepdims=True)
        size = 4.0 * float(np.nanmedian(np.linalg.norm(places - middle, axis=2))) if places.size else 0.0
    return size if np.isfinite(size) else 0.0


def _bridge(skeleton: Skeleton, block: FrameBlock, raw: Array, spikes: Flags, reading: Reading) -> Despiked:
    columns = skeleton.columns()
    joints = sorted({columns[index][0] for index in np.flatnonzero(spikes.any(axis=0))})
    if not joints:
        return Despiked(block)
    of_joint = np.array([joint for joint, _ in columns])
    gone = raw.copy()
    for joint in joints:
        own = of_joint == joint
        gone[np.ix_(spikes[:, own].any(axis=1), own)] = np.nan
    places = np.arange(len(block), dtype=np.intp)
    emptied = remade(block, columns, gone, places, block.ids)
    everything = len(block)
    filled = fill_gaps(skeleton, emptied, slice(0, everything), everything, everything, joints, reading)
    made = in_columns(filled.block, columns)
    replaced = spikes & np.isfinite(made) & np.isfinite(raw)
    counts = Counter({joint: int(replaced[:, of_joint == joint].any(axis=1).sum()) for joint in joints})
    left = sum(int((spikes & ~replaced)[:, of_joint == joint].any(axis=1).sum()) for joint in joints)
    values = np.where(replaced, made, raw)
    frames = tuple(np.flatnonzero(replaced.any(axis=1)).tolist())
    return Despiked(remade(block, columns, values, places, block.ids), +counts, frames, left)
