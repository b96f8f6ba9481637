"""Missing samples between known ones, filled: by splines, by markers of the same segment, or by a marker nearby.

Short gaps are bridged by a cubic spline. In a longer gap of a marker, three other markers that keep their distances to
it tell it as a rigid body does (rotation and shift by Kabsch 1976, "A solution for the best rotation to relate two sets
of vectors"); without three, the marker whose distance changes least tells its course between both ends. Samples before
the first and after the last known one stay missing: nothing is extrapolated.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from mcml.motion.clip import FrameBlock
from mcml.motion.frames import in_columns, present, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import Flags, HubWriter, Known
from mcml.motion.kinematics import RESIDUAL
from mcml.motion.rotation_vectors import from_vector, to_vector
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import CHANNEL_INDEX, TRANSLATIONS, Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading

Method: TypeAlias = Literal["spline", "segment", "nearby marker"]

_KNOTS: Final = 5
"""Known samples at either side of a gap that a spline goes through."""
_RIGID: Final = 0.05
"""Of the distance of two markers of one segment: its standard deviation at most."""
_NEARBY: Final = 0.3
"""The same of a marker whose course is taken."""
_FLAT: Final = 0.1
"""Of the longest side of three markers: the height of their triangle at least, so that they tell a rotation."""
_SHARED: Final = 10
"""Frames in which two markers are known together, at least, to compare their distance."""


@dataclass
class Filled:
    """block: the frames. counts: samples that were filled, by method. gaps: samples of gaps that stay."""

    block: FrameBlock
    counts: Counter[Method] = field(default_factory=Counter)
    left: int = 0


def fill_gaps(
    skeleton: Skeleton,
    block: FrameBlock,
    rows: slice,
    short: int,
    longest: int,
    joints: Sequence[int] | None = None,
    reading: Reading = DEGREES,
) -> Filled:
    """Fill gaps of joints and markers in some frames.

    block: frames of a clip, with those around that tell how it goes on. rows: the frames in which samples are filled.
    short: frames up to which a gap of a marker is bridged by a spline. longest: frames of a gap that is filled at most;
    gaps of joints are bridged by splines up to it. joints: all by default. Filled samples of markers have the residual
    0, which says in C3D that a sample was interpolated.
    """
    columns = skeleton.columns()
    values = in_columns(block, columns).copy()
    filled = Filled(block)
    chosen = range(len(skeleton)) if joints is None else joints
    markers = [joint for joint in chosen if skeleton.joints[joint].convention is Convention.MARKER]
    _fill_markers(skeleton, values, markers, rows, (short, longest), filled)
    bodies = [joint for joint in chosen if skeleton.joints[joint].has_axes]
    _fill_joints(skeleton, block, values, bodies, rows, longest, filled, reading)
    places = np.arange(len(block), dtype=np.intp)
    filled.block = remade(block, columns, values, places, block.ids)
    return filled


def _gaps(known: Flags, rows: slice) -> Iterator[tuple[int, int]]:
    """First frame, and the one after the last, of each gap with a known sample before and after it, that begins in the
    rows."""
    edges = np.flatnonzero(np.diff(known.astype(np.int8)))
    starts, ends = edges[~known[edges + 1]] + 1, edges[known[edges + 1]] + 1
    first, stop, _ = rows.indices(len(known))
    for start in starts.tolist():
        after = ends[ends > start]
        if len(after) and first <= start and int(after[0]) <= stop:
            yield start, int(after[0])


def _fill_markers(
    skeleton: Skeleton, values: Array, markers: Sequence[int], rows: slice, limits: tuple[int, int], filled: Filled
) -> None:
    place = {column: index for index, column in enumerate(skeleton.columns())}
    every = [joint for joint, each in enumerate(skeleton.joints) if each.convention is Convention.MARKER]
    if not markers:
        return
    axes = np.array([[place[joint, CHANNEL_INDEX[channel]] for channel in TRANSLATIONS] for joint in every])
    positions = values[:, axes].reshape(len(values), len(every), 3)
    known = np.asarray(np.isfinite(positions).all(axis=2))
    donors = _Donors(positions.copy(), known)
    short, longest = limits
    for joint in markers:
        own = every.index(joint)
        for start, end in _gaps(known[:, own], rows):
            course: tuple[Method, Array] | None = None
            if end - start <= min(short, longest):
                course = "spline", _bridge(positions[:, own], known[:, own], start, end)
            elif end - start <= longest:
                course = donors.find(own, start, end)
            if course is None:
                filled.left += end - start
                continue
            filled.counts[course[0]] += end - start
            values[start:end, axes[own]] = course[1]
            if (residual := place.get((joint, RESIDUAL))) is not None:
                values[start:end, residual] = 0.0


class _Donors:
    """Markers that tell where another one is. positions: (n, M, 3) as measured; known: (n, M)."""

    def __init__(self, positions: Array, known: Flags) -> None:
        self._positions, self._known = positions, known
        self._spreads: dict[int, tuple[Array, Array]] = {}

    def find(self, own: int, start: int, end: int) -> tuple[Method, Array] | None:
        """(method, (k, 3) positions) of a marker in a gap; None if no other marker tells."""
        spread, distance = self._spread(own)
        needed = slice(start - 1, end + 1)
        there = self._known[needed].all(axis=0) & np.isfinite(spread)
        order = [other for other in np.argsort(spread).tolist() if there[other]]
        rigid = [other for other in order if spread[other] <= _RIGID * distance[other]]
        base = self._triangle(rigid, start - 1)
        if base is not None:
            return "segment", self._by_segment(own, base, start, end)
        if order and spread[order[0]] <= _NEARBY * distance[order[0]]:
            return "nearby marker", self._by_marker(own, order[0], start, end)
        return None

    def _spread(self, own: int) -> tuple[Array, Array]:
        """(standard deviations, means) of the distances to every marker; NaN for itself and those rarely together."""
        if own not in self._spreads:
            away = np.linalg.norm(self._positions - self._positions[:, own : own + 1], axis=2)
            together = self._known & self._known[:, own : own + 1]
            often = together.sum(axis=0) >= _SHARED
            often[own] = False
            spread, mean = np.full(len(often), np.nan), np.full(len(often), np.nan)
            for other in np.flatnonzero(often).tolist():
                distances = away[together[:, other], other]
                spread[other], mean[other] = float(distances.std()), float(distances.mean())
            self._spreads[own] = spread, mean
        return self._spreads[own]

    def _triangle(self, rigid: Sequence[int], frame: int) -> list[int] | None:
        """The best three markers that are not on a line in a frame."""
        for third in range(2, len(rigid)):
            corners = self._positions[frame, [rigid[0], rigid[1], rigid[third]]]
            sides = corners - np.roll(corners, 1, axis=0)
            area = float(np.linalg.norm(np.cross(sides[0], sides[1])))
            longest = float(np.linalg.norm(sides, axis=1).max())
            if area > _FLAT * longest**2:
                return [rigid[0], rigid[1], rigid[third]]
        return None

    def _by_segment(self, own: int, base: Sequence[int], start: int, end: int) -> Array:
        """Carried with three markers from before the gap and from after it, and blended between both."""
        carried = []
        for known in (start - 1, end):
            reference = self._positions[known, base]
            middle = reference.mean(axis=0)
            places = self._positions[start:end, base]
            centres = places.mean(axis=1)
            turns = [Rotation.align_vectors(each, reference - middle)[0] for each in places - centres[:, None]]
            arm = self._positions[known, own] - middle
            carried.append(centres + np.stack([turn.apply(arm) for turn in turns]))
        share = (np.arange(1, end - start + 1) / (end - start + 1))[:, None]
        blended: Array = carried[0] * (1 - share) + carried[1] * share
        return blended

    def _by_marker(self, own: int, other: int, start: int, end: int) -> Array:
        """The course of another marker, added to the line between both ends."""
        share = (np.arange(1, end - start + 1) / (end - start + 1))[:, None]

        def line(marker: int) -> Array:
            first, last = self._positions[start - 1, marker], self._positions[end, marker]
            between: Array = first * (1 - share) + last * share
            return between

        course: Array = line(own) + self._positions[start:end, other] - line(other)
        return course


def _bridge(vectors: Array, known: Flags, start: int, end: int) -> Array:
    """(k, d) of a cubic spline through known samples (n, d) around a gap."""
    before = np.flatnonzero(known[:start])[-_KNOTS:]
    after = np.flatnonzero(known[end:])[:_KNOTS] + end
    knots = np.concatenate([before, after])
    frames = np.arange(start, end)
    if len(knots) < 4:
        return np.stack([np.interp(frames, knots, column) for column in vectors[knots].T], axis=1)
    bridged: Array = CubicSpline(knots, vectors[knots])(frames)
    return bridged


def _fill_joints(
    skeleton: Skeleton,
    block: FrameBlock,
    values: Array,
    joints: Sequence[int],
    rows: slice,
    longest: int,
    filled: Filled,
    reading: Reading,
) -> None:
    """Fill gaps of rotations and translations of joints that have all their channels before and after."""
    columns = skeleton.columns()
    there = present(values, columns, len(skeleton))
    gaps: Mapping[int, list[tuple[int, int]]] = {joint: list(_gaps(there[:, joint], rows)) for joint in joints}
    filled.left += sum(end - start for each in gaps.values() for start, end in each if end - start > longest)
    short = {joint: [gap for gap in each if gap[1] - gap[0] <= longest] for joint, each in gaps.items()}
    short = {joint: each for joint, each in short.items() if each}
    if not short:
        return
    hub = HubReader(skeleton, reading).read(block)
    moved, turned, scales = hub.translations.copy(), hub.rotations.copy(), hub.scales.copy()
    holds = np.ones((len(block), len(skeleton)), dtype=bool)
    for joint, each in short.items():
        for start, end in each:
            known = there[:, joint]
            moved[start:end, joint] = _bridge(hub.translations[:, joint], known, start, end)
            scales[start:end, joint] = _bridge(hub.scales[:, joint, None], known, start, end)[:, 0]
            turned[start:end, joint] = _turn(hub.rotations[:, joint], known, start, end)
            holds[start:end, joint] = False
            filled.counts["spline"] += end - start
    written = HubWriter(skeleton, reading).write(moved, turned, scales, Known(hub.values, holds))
    for index, (joint, _) in enumerate(columns):
        for start, end in short.get(joint, ()):
            values[start:end, index] = written[start:end, index]


def _turn(rotations: Array, known: NDArray[np.bool_], start: int, end: int) -> Array:
    """(k, 4) rotations in a gap: a spline of the rotation vectors from the last known rotation before it."""
    origin = rotations[start - 1 : start]
    vectors = to_vector(multiply(np.broadcast_to(inverse(origin), rotations.shape), rotations))
    turned: Array = multiply(
        np.broadcast_to(origin, (end - start, 4)), from_vector(_bridge(vectors, known, start, end))
    )
    return turned
