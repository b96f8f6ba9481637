"""Planted feet: detect contacts, measure sliding, and bend legs so that feet do not slide.

A contact begins when the foot is low and slow, and ends when it is no longer low or no longer slow; the limits for the
end are wider than those for the start (hysteresis), so that contacts do not flicker. Planted feet are locked by bending
the knee and rotating the hip (two-bone inverse kinematics); the correction fades out before and after.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mcml.motion.hub import walked
from mcml.motion.hub_writer import Flags, HubWriter
from mcml.motion.rotation_vectors import from_vector, shortest_arcs
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array, Skeleton
from mcml.numerics.runs import find_true

_LOW, _NOT_LOW = 0.06, 0.12
"""Heights above the lowest the foot gets, in lengths of a leg."""
_SLOW, _NOT_SLOW = 0.35, 0.7
"""Speeds in lengths of a leg a second."""
_SHORTEST = 0.05
"""Shortest contact in seconds."""
_FADE = 0.15
"""Seconds over which a correction fades out."""
_ROUNDS = 4
"""Of bending a leg whose joints cannot turn freely."""
_STRETCHED = 0.9995
"""Of its whole length: no leg is made straighter."""


@dataclass(frozen=True)
class Feet:
    """A leg of the target.

    hip, knee, ankle, toe: joints (toe is the ankle without toes). source: the joint of the source whose contacts count.
    """

    hip: int
    knee: int
    ankle: int
    toe: int
    source: int


@dataclass(frozen=True)
class FootReport:
    """joint: the planted joint of the target.

    contacts: (first frame, last frame) from 0. before, after: distance that it slides over the ground during contacts,
    in the target's unit, over all frames.
    """

    joint: int
    contacts: tuple[tuple[int, int], ...]
    before: float
    after: float


def feet_of(source: Skeleton, target: Skeleton, pairs: Mapping[int, int]) -> tuple[Feet, ...]:
    """The legs that both skeletons have, by MCML's names. pairs: joint of the target -> joint of the source."""
    places = {joint.name: index for index, joint in enumerate(target.joints) if index in pairs}
    found = []
    for side in ("left", "right"):
        leg = [places.get(f"{side}_{part}") for part in ("up_leg", "low_leg", "foot")]
        hip, knee, ankle = leg
        if hip is None or knee is None or ankle is None:
            continue
        direct = target.joints[ankle].parent == knee and target.joints[knee].parent == hip
        toe = places.get(f"{side}_toes", ankle)
        if direct:
            found.append(Feet(hip, knee, ankle, toe, pairs[toe]))
    return tuple(found)


def contacts(places: Array, frame_time: float, leg: float, up: Array) -> tuple[tuple[int, int], ...]:
    """Return (first, last) of the frames, from 0, in which a foot is planted.

    places: (n, 3) in the world. frame_time: seconds. leg: its length, in the same unit. up: (3,) unit vector. The floor
    is the height under which the foot is in a twentieth of the frames.
    """
    if len(places) < 2 or not leg:
        return ()
    heights = places @ up
    heights = (heights - np.percentile(heights, 5)) / leg
    speeds = np.linalg.norm(np.gradient(places, axis=0), axis=1) / (frame_time * leg)
    return tuple((first, end - 1) for first, end in standing(heights, speeds, frame_time))


def standing(heights: Array, speeds: Array, frame_time: float) -> list[tuple[int, int]]:
    """Return (first, end) of the frames, from 0, in which something is planted; the end is the index after the last.

    heights: (n,) above the ground in leg lengths. speeds: (n,) in leg lengths a second. NaN where unknown: no contact
    there. frame_time: seconds.
    """
    stands = hysteresis((heights < _LOW) & (speeds < _SLOW), (heights < _NOT_LOW) & (speeds < _NOT_SLOW))
    shortest = max(2, int(np.ceil(_SHORTEST / frame_time)))
    return [(first, end) for first, end in find_true(stands).tolist() if end - first >= shortest]


def hysteresis(begins: Flags, stays: Flags) -> Flags:
    """(n,) true from where `begins` is until `stays` is no longer, both ways from each beginning.

    >>> hysteresis(np.array([0, 0, 1, 0, 0, 0]) > 0, np.array([0, 1, 1, 1, 0, 1]) > 0).astype(int).tolist()
    [0, 1, 1, 1, 0, 0]
    """
    stands = np.zeros(len(begins), dtype=bool)
    for first, end in find_true(stays | begins):
        stands[first:end] = begins[first:end].any()
    return stands


def sliding(places: Array, stands: Sequence[tuple[int, int]], up: Array) -> float:
    """Return the distance that a foot at positions (n, 3) moves over the ground during contacts."""
    total = 0.0
    for first, last in stands:
        steps = np.diff(places[first : last + 1], axis=0)
        total += float(np.linalg.norm(steps - np.outer(steps @ up, up), axis=1).sum())
    return total


def clean_feet(
    skeleton: Skeleton,
    feet: Sequence[Feet],
    positions: Array,
    translations: Array,
    rotations: Array,
    frame_time: float,
    leg: float,
    up: Array,
    writer: HubWriter,
    clean: bool,
) -> tuple[Array, tuple[FootReport, ...]]:
    """Lock planted feet; return rotations (n, J, 4) and a report.

    positions: (n, Js, 3) of the source, which decide the contacts; leg: the length of its legs. translations,
    rotations: of
    the target, hub form. writer: knows the channels of its joints. clean: if false, nothing is changed, only reported.
    """
    reports = []
    for foot in feet:
        stands = contacts(positions[:, foot.source], frame_time, leg, up)
        before = walked(skeleton, translations, rotations)[0][:, foot.toe]
        if clean and stands:
            goals = _held(before, stands, max(1, round(_FADE / frame_time)), up)
            rotations = _reach(skeleton, foot, translations, rotations, goals, writer)
        after = walked(skeleton, translations, rotations)[0][:, foot.toe] if clean else before
        reports.append(FootReport(foot.toe, stands, sliding(before, stands, up), sliding(after, stands, up)))
    return rotations, tuple(reports)


def _held(places: Array, stands: Sequence[tuple[int, int]], fade: int, up: Array) -> Array:
    """Return the target positions of a foot (n, 3): during a contact its mean position."""
    moves = np.zeros_like(places)
    for first, last in stands:
        spot = places[first : last + 1].mean(axis=0)
        moves[first : last + 1] = spot - places[first : last + 1]
        moves[first : last + 1] -= np.outer(moves[first : last + 1] @ up, up)
    edges = [(-1, -1), *stands, (len(places), len(places))]
    for (_, end), (start, _) in pairwise(edges):
        for place in range(end + 1, start):
            ahead, behind = start - place, place - end
            move = np.zeros(3)
            if end >= 0:
                move += _level(behind / min(fade, start - end)) * moves[end]
            if start < len(places):
                move += _level(ahead / min(fade, start - end)) * moves[start]
            moves[place] = move
    return places + moves


def _level(part: float) -> float:
    part = min(max(part, 0.0), 1.0)
    return 1 - part * part * (3 - 2 * part)


def _reach(
    skeleton: Skeleton, foot: Feet, translations: Array, rotations: Array, goals: Array, writer: HubWriter
) -> Array:
    """Rotations with the toe at its goal as nearly as the leg can."""
    places, world = walked(skeleton, translations, rotations)
    faces = world[:, foot.ankle]
    targets = places[:, foot.ankle] + goals - places[:, foot.toe]
    rotations = rotations.copy()
    for _ in range(_ROUNDS):
        hip, knee = two_bones(places[:, foot.hip], places[:, foot.knee], places[:, foot.ankle], targets)
        parents = [skeleton.joints[joint].parent for joint in (foot.hip, foot.knee, foot.ankle)]
        above = world[:, parents[0]] if parents[0] >= 0 else np.tile([0.0, 0.0, 0.0, 1.0], (len(world), 1))
        for joint, wanted in (
            (foot.hip, multiply(hip, world[:, foot.hip])),
            (foot.knee, multiply(hip, multiply(knee, world[:, foot.knee]))),
            (foot.ankle, faces),
        ):
            rotations[:, joint] = writer.nearest(joint, multiply(inverse(above), wanted))
            above = multiply(above, rotations[:, joint])
        places, world = walked(skeleton, translations, rotations)
        missed = goals - places[:, foot.toe]
        if float(np.abs(missed).max()) < 1e-9 * max(1.0, float(np.abs(goals).max())):
            break
        targets = places[:, foot.ankle] + missed
    return rotations


def two_bones(hip: Array, knee: Array, ankle: Array, goal: Array) -> tuple[Array, Array]:
    """Return rotations in the world (n, 4) of the upper bone, and before it of the lower one, that move the ankle to
    the goal.

    hip, knee, ankle, goal: (n, 3). The knee bends in the plane in which it is bent; a goal out of reach is approached
    along the line to it. With a, b the lengths and d the distance of the goal, the cosine of the angle at the knee is
    (a^2 + b^2 - d^2) / 2 a b.
    """
    upper, lower, line = knee - hip, ankle - knee, goal - hip
    a, b = np.linalg.norm(upper, axis=1), np.linalg.norm(lower, axis=1)
    distance = np.clip(np.linalg.norm(line, axis=1), np.abs(a - b) + 1e-9, _STRETCHED * (a + b))
    old = np.arctan2(np.linalg.norm(np.cross(upper, lower), axis=1), (upper * lower).sum(axis=1))
    reached = np.linalg.norm(ankle - hip, axis=1)
    # If the leg already reaches that far, nothing is bent, even if it is straight.
    stays = np.abs(np.linalg.norm(line, axis=1) - reached) < 1e-12 * (a + b)
    cosine = np.clip((distance**2 - a**2 - b**2) / np.where(a * b > 0, 2 * a * b, 1.0), -1.0, 1.0)
    bend = np.where(stays, 0.0, np.arccos(cosine) - old)
    axis = _bend_axis(upper, lower)
    at_knee = from_vector(axis * bend[:, None])
    arrived = upper + rotate(at_knee, lower)
    return shortest_arcs(arrived, line), at_knee


def _bend_axis(upper: Array, lower: Array) -> Array:
    """Unit axes (n, 3) about which knees are bent; a straight knee bends as it did when it last was bent."""
    across = np.cross(upper, lower)
    lengths = np.linalg.norm(across, axis=1)
    size = np.linalg.norm(upper, axis=1) * np.linalg.norm(lower, axis=1)
    bent = lengths > 1e-4 * size
    if not bent.any():
        first = np.cross(upper, np.eye(3)[np.argmin(np.abs(upper), axis=1)])
        unit: Array = first / np.linalg.norm(first, axis=1, keepdims=True)
        return unit
    rows = np.where(bent, np.arange(len(bent)), -1)
    rows = np.maximum.accumulate(rows)
    rows = np.where(rows < 0, int(np.argmax(bent)), rows)
    axis = across[rows] / lengths[rows, None]
    # Across the bone as it now is.
    along = upper / np.linalg.norm(upper, axis=1, keepdims=True)
    axis = np.where(bent[:, None], axis, axis - (axis * along).sum(axis=1, keepdims=True) * along)
    found: Array = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    return found
