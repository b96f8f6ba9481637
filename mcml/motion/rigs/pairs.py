"""Limbs of joints without telling names: pairs of like chains, the lower of which are legs and the upper arms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcml.motion.rigs.tree import Tree

_JOINTS = 3
"""In a chain, at least."""
_ALIKE, _SLACK = 0.12, 0.02
"""By how much of itself, and of the whole chain, a bone may be longer than its twin."""
_APART = 0.1
"""Relative to their length: distance between the chains of a pair at some joint."""
_HEAD = 0.28
"""Of the trunk below the arms: a head is longer, a neck shorter."""
_MOST_CHILDREN = 40
"""Of a joint: of more no pairs are sought."""


@dataclass(frozen=True)
class Pair:
    """Two chains that hang from one joint. above: that joint. first, second: joints from the trunk outwards."""

    above: int
    first: tuple[int, ...]
    second: tuple[int, ...]


def find_pairs(tree: Tree, out: Sequence[bool]) -> list[Pair]:
    """Find all pairs of a rig, except those within a limb. out: excluded joints."""
    if not tree.has_lengths:
        return []
    best, counts = _longest(tree, out)
    pairs: list[Pair] = []
    open_joints = [index for index, parent in enumerate(tree.parents) if parent < 0]
    while open_joints:
        joint = open_joints.pop()
        some = [child for child in tree.children[joint] if not out[child]]
        paired: set[int] = set()
        if len(some) <= _MOST_CHILDREN:
            for place, first in enumerate(some):
                for second in some[place + 1 :]:
                    if counts[first] != counts[second] or counts[first] < _JOINTS:
                        continue
                    pair = Pair(joint, _follow(best, first), _follow(best, second))
                    if _are_alike(tree, joint, pair.first, pair.second):
                        pairs.append(pair)
                        paired |= {first, second}
        open_joints += [child for child in tree.children[joint] if child not in paired]
    return pairs


def _longest(tree: Tree, out: Sequence[bool]) -> tuple[list[int], list[int]]:
    """Return for each joint the child on its longest path, -1 at its end, and the number of joints on it."""
    count, length, best = [1] * len(tree), [0.0] * len(tree), [-1] * len(tree)
    bones = np.zeros(len(tree))
    for index, parent in enumerate(tree.parents):
        if parent >= 0:
            bones[index] = tree.distance(index, parent)
    for index in range(len(tree) - 1, -1, -1):
        parent = tree.parents[index]
        if parent < 0 or out[index]:
            continue
        whole = (count[index] + 1, length[index] + float(bones[index]))
        if best[parent] < 0 or (whole[0], round(whole[1], 9)) > (count[parent], round(length[parent], 9)):
            best[parent] = index
            count[parent], length[parent] = whole
    return best, count


def _follow(best: Sequence[int], start: int) -> tuple[int, ...]:
    path = [start]
    while best[path[-1]] >= 0:
        path.append(best[path[-1]])
    return tuple(path)


def _are_alike(tree: Tree, above: int, first: Sequence[int], second: Sequence[int]) -> bool:
    places = tree.places[list(first)], tree.places[list(second)]
    bones = [np.linalg.norm(np.diff(np.vstack([tree.places[above], each]), axis=0), axis=1) for each in places]
    length = float(max(bones[0].sum(), bones[1].sum()))
    if not length > 0 or np.linalg.norm(places[0] - places[1], axis=1).max() < _APART * length:
        return False
    return bool((np.abs(bones[0] - bones[1]) <= _ALIKE * np.maximum(bones[0], bones[1]) + _SLACK * length).all())


def arms_and_legs(tree: Tree, pairs: Sequence[Pair], head_way: Sequence[int]) -> dict[str, Pair]:
    """Return {"arm": a pair, "leg": a pair} of exactly two pairs; empty if they are not those of a person.

    head_way: joints of the longest other chain below the upper pair's joint.
    """
    if len(pairs) != 2:
        return {}
    one, two = pairs
    if one.above == two.above:
        if not head_way:
            return {}
        head = tree.places[head_way[-1]]
        far = [float(np.linalg.norm(tree.places[[p.first[-1], p.second[-1]]].mean(axis=0) - head)) for p in pairs]
        legs, arms = (one, two) if far[0] > far[1] else (two, one)
        return {"arm": arms, "leg": legs}
    if tree.is_above(one.above, two.above):
        return {"arm": two, "leg": one}
    if tree.is_above(two.above, one.above):
        return {"arm": one, "leg": two}
    return {}


def way_to_head(tree: Tree, above: int, pairs: Sequence[Pair], out: Sequence[bool]) -> list[int]:
    """The longest chain from a joint that is of no pair, from there outwards."""
    paired = {joint for pair in pairs for joint in (pair.first[0], pair.second[0])}
    best, _ = _longest(tree, out)
    ways = [_follow(best, child) for child in tree.children[above] if child not in paired and not out[child]]
    ways = [
        way
        for way in ways
        if not paired & set(way) and not any(tree.is_above(way[0], pair.above) for pair in pairs if pair.above != above)
    ]
    best_way: tuple[int, ...] = max(ways, key=lambda way: (len(way), _length(tree, above, way)), default=())
    return list(best_way)


def _length(tree: Tree, above: int, way: Sequence[int]) -> float:
    places = tree.places[[above, *way]]
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def head_by_length(tree: Tree, way: Sequence[int], trunk: float) -> int:
    """The joint of a chain above the arms that starts its longest bone, -1 for none.

    trunk: how long the trunk is below the arms. Where the chain's last joint has no tip and no bone before it is as
    long as a head, that joint is the head: its bone is not written.
    """
    best, longest = -1, 0.0
    for place, joint in enumerate(way):
        ends = [tree.places[way[place + 1]]] if place + 1 < len(way) else tree.tips_of(joint)[:1]
        for end in ends:
            length = float(np.linalg.norm(end - tree.places[joint]))
            if length > longest * (1 + 1e-9):
                best, longest = joint, length
    tips = [float(np.linalg.norm(tip - tree.places[way[-1]])) for tip in tree.tips_of(way[-1])] if way else []
    if way and not any(tips) and longest < _HEAD * trunk:
        return way[-1]
    return best if best >= 0 else (way[0] if way else -1)
