"""Slots of a limb by the lengths of its bones, where words do not tell them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from mcml.motion.rigs.tree import Tree
from mcml.motion.skeleton import Array

_SHORT = 0.02
"""Of the whole chain: a joint nearer to the one before it is passed over."""
_MIDLINE = {"arm": 0.35, "leg": 0.05}
"""Of a limb's length: a first joint nearer to its twin is the shoulder or hip joint."""
_ALIKE = 0.55, 1.8
"""Limits of the ratio of the upper to the lower bone."""
_HALF = 0.5
"""Of the chain, that the upper and the lower bone make together at least."""
_PIECES = 1.3
"""How many times as long as another a piece of a cut limb may be."""


def slots_by_length(tree: Tree, chain: Sequence[int], limb: str, twin: int = -1) -> dict[int, str]:
    """Slots of the joints of a chain from the trunk outwards: the two long bones in a row are the upper and the lower.

    twin: the first joint of the other side. Nothing where no two bones can be a limb's.
    """
    if not tree.has_lengths or len(chain) < 2:
        return {}
    kept, places = [chain[0]], [tree.places[chain[0]]]
    ends = tree.tips_of(chain[-1])
    whole = _length([*(tree.places[joint] for joint in chain), *ends[:1]])
    if not whole > 0:
        return {}
    for joint in chain[1:]:
        if np.linalg.norm(tree.places[joint] - places[-1]) >= _SHORT * whole:
            kept.append(joint)
            places.append(tree.places[joint])
    if ends:
        places.append(ends[0])
    found: dict[int, str] = {}
    if twin >= 0 and len(kept) > 2 and tree.distance(chain[0], twin) < _MIDLINE[limb] * whole:
        found[kept[0]] = "shoulder" if limb == "arm" else "hip"
        kept, places = kept[1:], places[1:]
    bones = [float(np.linalg.norm(after - before)) for before, after in itertools.pairwise(places)]
    if len(bones) < 2:
        return {}
    sums = [first + second for first, second in itertools.pairwise(bones)]
    at = max(range(len(sums)), key=lambda place: (round(sums[place] / max(sums), 6), -place))
    upper, lower = bones[at], bones[at + 1]
    if not lower or not _ALIKE[0] <= upper / lower <= _ALIKE[1] or sums[at] < _HALF * sum(bones) or at > 1:
        return {}
    if at and kept[0] not in found and not found:
        found[kept[0]] = "shoulder" if limb == "arm" else "hip"
    found |= dict(zip(kept[at:], _names(limb), strict=False))
    return found


def _names(limb: str) -> tuple[str, ...]:
    return ("up_arm", "low_arm", "hand") if limb == "arm" else ("up_leg", "low_leg", "foot", "toes")


def pieces_of(tree: Tree, chain: Sequence[int]) -> list[int]:
    """First, middle and last joint of a limb that is cut into equal pieces; nothing for another chain."""
    if len(chain) < 5 or len(chain) % 2 == 0 or not tree.has_lengths:
        return []
    bones = [tree.distance(upper, lower) for upper, lower in itertools.pairwise(chain)]
    middle = len(chain) // 2
    for half in (bones[:middle], bones[middle:]):
        if not min(half) > 0 or max(half) > _PIECES * min(half):
            return []
    return [chain[0], chain[middle], chain[-1]]


def _length(places: Sequence[Array]) -> float:
    return float(sum(np.linalg.norm(after - before) for before, after in itertools.pairwise(places)))
