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
import scipy

from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Rows, in_columns, present, remade
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
_NEAREST: Final = 30
"""Markers, the nearest ones, that may tell where another one is."""
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
    following = np.searchsorted(ends, starts, side="right")
    for start, place in zip(starts.tolist(), following.tolist(), strict=True):
        if place < len(ends) and first <= start and ends[place] <= stop:
            yield start, int(ends[place])


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
        places = np.flatnonzero(known[:, own])
        for start, end in _gaps(known[:, own], rows):
            course: tuple[Method, Array] | None = None
            if end - start <= min(short, longest):
                knots = _find_knots(places, start)
                course = "spline", _bridge(positions[knots, own], knots, start, end)
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
        self._spreads: dict[tuple[int, int], tuple[float, float]] = {}

    def find(self, own: int, start: int, end: int) -> tuple[Method, Array] | None:
        """(method, (k, 3) positions) of a marker in a gap; None if no other marker tells."""
        there = np.asarray(self._known[start - 1 : end + 1].all(axis=0))
        there[own] = False
        away = np.linalg.norm(self._positions[start - 1] - self._positions[start - 1, own], axis=1)
        nearest = [other for other in np.argsort(away).tolist() if there[other]][:_NEAREST]
        spread, distance = {}, {}
        for other in nearest:
            spread[other], distance[other] = self._spread(own, other)
        order = sorted((other for other in nearest if np.isfinite(spread[other])), key=spread.__getitem__)
        rigid = [other for other in order if spread[other] <= _RIGID * distance[other]]
        base = self._triangle(rigid, start - 1)
        if base is not None:
            return "segment", self._by_segment(own, base, start, end)
        if order and spread[order[0]] <= _NEARBY * distance[order[0]]:
            return "nearby marker", self._by_marker(own, order[0], start, end)
        return None

    def _spread(self, own: int, other: int) -> tuple[float, float]:
        """(standard deviation, mean) of the distance of two markers; NaN where they are rarely known together."""
        pair = min(own, other), max(own, other)
        if pair not in self._spreads:
            together = self._known[:, own] & self._known[:, other]
            distances = np.linalg.norm(self._positions[together, own] - self._positions[together, other], axis=1)
            is_often = len(distances) >= _SHARED
            self._spreads[pair] = (float(distances.std()), float(distances.mean())) if is_often else (np.nan, np.nan)
        return self._spreads[pair]

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
            turns = [
                scipy.spatial.transform.Rotation.align_vectors(each, reference - middle)[0]
                for each in places - centres[:, None]
            ]
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


def _find_knots(places: Rows, start: int) -> Rows:
    """The known samples around a gap that a spline goes through. places: of all known samples."""
    middle = int(np.searchsorted(places, start))
    return places[max(0, middle - _KNOTS) : middle + _KNOTS]


def _bridge(vectors: Array, knots: Rows, start: int, end: int) -> Array:
    """(k, d) of a cubic spline in a gap. vectors: (m, d) at the knots (m,)."""
    frames = np.arange(start, end)
    if len(knots) < 4:
        return np.stack([np.interp(frames, knots, column) for column in vectors.T], axis=1)
    bridged: Array = scipy.interpolate.CubicSpline(knots, vectors)(frames)
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
        places = np.flatnonzero(there[:, joint])
        for start, end in each:
            knots = _find_knots(places, start)
            moved[start:end, joint] = _bridge(hub.translations[knots, joint], knots, start, end)
            scales[start:end, joint] = _bridge(hub.scales[knots, joint, None], knots, start, end)[:, 0]
            turned[start:end, joint] = _turn(hub.rotations[:, joint], knots, start, end)
            holds[start:end, joint] = False
            filled.counts["spline"] += end - start
    written = HubWriter(skeleton, reading).write(moved, turned, scales, Known(hub.values, holds))
    for index, (joint, _) in enumerate(columns):
        for start, end in short.get(joint, ()):
            values[start:end, index] = written[start:end, index]


def _turn(rotations: Array, knots: Rows, start: int, end: int) -> Array:
    """(k, 4) rotations in a gap: a spline of the rotation vectors from the last known rotation before it."""
    origin = rotations[start - 1 : start]
    vectors = to_vector(multiply(np.broadcast_to(inverse(origin), (len(knots), 4)), rotations[knots]))
    turned: Array = multiply(
        np.broadcast_to(origin, (end - start, 4)), from_vector(_bridge(vectors, knots, start, end))
    )
    return turned
