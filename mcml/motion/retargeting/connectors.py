"""Joints without a match between matched ones, such as TLS and TRS between a trunk and its shoulders.

Where they turn, the line between the joints of two sides, hips or shoulders, turns against the trunk. In the target
connectors are turned so that the line points as in the source; where only the source has connectors, or where the sides
hang from another joint in the source, the matched joint above is turned about its own bone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

import numpy as np

from mcml.motion.retargeting.posed_bodies import PosedBody
from mcml.motion.rotation_vectors import from_vector
from mcml.motion.sides import is_left, partners
from mcml.motion.skeleton import Array, Skeleton


@dataclass(frozen=True)
class SideLine:
    """The line from a right joint to a left one, both matched, below a matched joint of the target.

    connectors: the highest joints of the target between, one for each side or one for both; empty without any.
    """

    above: int
    left: int
    right: int
    connectors: tuple[int, ...]


def side_lines(
    source: Skeleton,
    target: Skeleton,
    pairs: Mapping[int, int],
    letters: Callable[[int], str],
    turning: Set[int],
) -> tuple[SideLine, ...]:
    """Lines that may turn against the joint above them.

    pairs: joint of the target -> joint of the source. letters: the axes about which a joint of the target can turn.
    turning: joints of the source that turn in their parents; others, such as those that only ASF needs, are no
    connectors.
    """
    other = partners(target)
    lines = []
    for left in sorted(pairs):
        right = int(other[left])
        if right == left or right not in pairs or not is_left(target, left, right):
            continue
        ways = [_unmatched_above(target, joint, pairs, letters) for joint in (left, right)]
        if ways[0][0] != ways[1][0] or ways[0][0] < 0:
            continue
        matched = set(pairs.values())
        sources = [_unmatched_above(source, pairs[joint], matched, turning.__contains__) for joint in (left, right)]
        connectors = tuple(dict.fromkeys(way[1][-1] for way in ways if way[1]))
        if not all(len(letters(joint)) == 3 for joint in connectors):
            connectors = ()
        elsewhere = any(above != pairs[ways[0][0]] for above, _ in sources)
        if connectors or ways[0][1] or sources[0][1] or sources[1][1] or elsewhere:
            lines.append(SideLine(ways[0][0], left, right, connectors))
    return tuple(lines)


def _unmatched_above(
    skeleton: Skeleton, joint: int, matched: Mapping[int, int] | Set[int], turns: Callable[[int], object]
) -> tuple[int, list[int]]:
    """The nearest matched joint above (-1: none), and the joints without a match on the way that turn, the highest
    last.
    """
    passed = []
    above = skeleton.joints[joint].parent
    while above >= 0 and above not in matched:
        passed += [above] if turns(above) else []
        above = skeleton.joints[above].parent
    return above, passed


def turn_about(axes: Array, lines: Array, goals: Array) -> Array:
    """(n, 4) turns about axes (n, 3) that bring lines (n, 3) as near as they can to goals (n, 3)."""
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    unit = axes / np.where(lengths > 0, lengths, 1.0)
    one, two = (vectors - (vectors * unit).sum(axis=1, keepdims=True) * unit for vectors in (lines, goals))
    sine, cosine = (np.cross(one, two) * unit).sum(axis=1), (one * two).sum(axis=1)
    angle = np.where(lengths[:, 0] > 0, np.arctan2(sine, cosine), 0.0)
    return from_vector(angle[:, None] * unit)


def without_hip_connectors(one: PosedBody, two: PosedBody, pairs: Mapping[int, int]) -> dict[int, int]:
    """Pairs without joints between pelvis and thigh (MCML's left_hip, right_hip) that differ in the two bodies.

    Such a joint is no joint of a person: it only carries the thigh to its place, from the middle of the pelvis in some
    rigs, from above the thigh in others. Its bone is not pointed where bones at rest differ by more than 15 degrees.
    """
    kept = dict(pairs)
    names = {two.skeleton.joints[joint].name: joint for joint in pairs}
    for side in ("left", "right"):
        hip, thigh = names.get(f"{side}_hip"), names.get(f"{side}_up_leg")
        if hip is None or thigh is None or "Root" not in names:
            continue
        ends = ((names["Root"], hip), (hip, thigh))
        bones = [
            (one.positions[pairs[end]] - one.positions[pairs[start]], two.positions[end] - two.positions[start])
            for start, end in ends
        ]
        if not all(_alike(first, second, one.short, two.short) for first, second in bones):
            del kept[hip]
    return kept


def _alike(first: Array, second: Array, short: float, other_short: float) -> bool:
    lengths = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    if lengths[0] <= short or lengths[1] <= other_short:
        return lengths[0] <= short and lengths[1] <= other_short
    return float(first @ second) >= _PARALLEL * lengths[0] * lengths[1]


_PARALLEL = float(np.cos(np.radians(15.0)))


def without_rigid(
    target: Skeleton, pairs: Mapping[int, int], letters: Callable[[int], str], turning: Set[int]
) -> dict[int, int]:
    """Pairs without joints below others that neither turn in the source nor can in the target, such as those that
    only ASF needs. letters, turning: as for `side_lines`.
    """
    return {
        joint: source
        for joint, source in pairs.items()
        if letters(joint) or source in turning or target.joints[joint].parent < 0
    }
