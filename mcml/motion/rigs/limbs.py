"""The joints of one arm or leg: the best path through the tree, given the possible meanings of words.

Slots rise from the trunk outwards, so a word is settled by its neighbours: `LeftShoulder` is a shoulder above
`LeftArm`, and an upper arm above `LeftElbow`. The path is found by dynamic programming over the joints, parents first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from mcml.motion.rigs.lengths import pieces_of, slots_by_length
from mcml.motion.rigs.readings import CORE, LIMBS, Reading
from mcml.motion.rigs.tree import Tree

MOST_CANDIDATES = 200
"""Joints that may be of one limb: of more, nothing is named."""
_CORE = 0.02
"""Value that a slot of the core adds to a path."""
_APART = 0.15
"""Relative to an arm: distance from which two joints called shoulder are shoulder and upper arm."""
_CERTAIN = 0.75
GAP, ELSEWHERE = 0.6, 0.65
"""Confidence of a joint that fills a gap, and of a joint with the right name elsewhere in the tree."""
_REPEATS = frozenset({"foot"})
"""Parts whose word may mean two slots of one chain."""


@dataclass
class Limb:
    """The recognised joints of one limb. joints: slot → (joint, confidence, evidence: "word", "tree" or "rest pose").

    told: sentences for the receipt.
    """

    side: str
    limb: str
    joints: dict[str, tuple[int, float, str]] = field(default_factory=dict)
    told: list[str] = field(default_factory=list)

    def core(self) -> int:
        """How many joints of the core it has."""
        return sum(slot in self.joints for slot in CORE[self.limb])

    def at(self, slot: str) -> int:
        """The joint of a slot, -1 for none."""
        return self.joints[slot][0] if slot in self.joints else -1


Path = tuple[tuple[int, str], ...]


def find_limb(tree: Tree, readings: Sequence[Reading], candidates: Sequence[int], side: str, limb: str) -> Limb:
    """The limb that some joints of one side make. candidates: joints that may be of it, parents first."""
    result = Limb(side, limb)
    if len(candidates) > MOST_CANDIDATES:
        result.told.append(f"{len(candidates)} joints may be of the {side} {limb}: not mapped")
        return result
    path = _likeliest(readings, candidates, limb) if tree.is_flat else best_path(tree, readings, candidates, limb)
    for joint, slot in path:
        result.joints[slot] = (joint, _confidence(readings[joint].value(slot)), "word")
    if not tree.is_flat:
        _settle_repeats(tree, readings, candidates, result)
        _settle_shoulders(tree, readings, candidates, result)
        _settle_elbow(tree, readings, result)
    if limb == "leg" and "up_leg" not in result.joints and "low_leg" in result.joints and "hip" in result.joints:
        result.joints["up_leg"] = result.joints.pop("hip")
    _take_elsewhere(tree, readings, candidates, result)
    return result


def _confidence(value: float) -> float:
    return 0.5 + 0.5 * min(value, 1.0)


def best_path(tree: Tree, readings: Sequence[Reading], candidates: Iterable[int], limb: str) -> Path:
    """The path from ancestor to descendant with slots in rising order and the greatest sum of values.

    Ties go to joints nearer to the trunk, then to the lower number in the name.
    """
    slots = LIMBS[limb]
    states: dict[int, dict[tuple[int, str], tuple[float, Path]]] = {}
    best: tuple[float, Path] = (0.0, ())
    nearest = _nearest_above(tree, candidates)
    for joint in candidates:
        above = states.get(nearest[joint], {})
        state = dict(above)
        reading = readings[joint]
        for place, slot in enumerate(slots):
            value = reading.value(slot)
            if not value:
                continue
            own = value + _CORE * (slot in CORE[limb]) - _tie(tree, reading, joint)
            before: tuple[float, Path] = (0.0, ())
            for (lower, part), entry in above.items():
                if lower < place and (part != reading.part or part in _REPEATS) and entry[0] > before[0] + 1e-12:
                    before = entry
            total = own + before[0], (*before[1], (joint, slot))
            if total[0] > state.get((place, reading.part), (0.0, ()))[0] + 1e-12:
                state[place, reading.part] = total
            if total[0] > best[0] + 1e-12:
                best = total
        states[joint] = state
    return best[1]


def _tie(tree: Tree, reading: Reading, joint: int) -> float:
    number = reading.numbers[0] if reading.numbers and reading.numbers[0] < 10 else 10
    return (1e-3 * tree.depth[joint] + 1e-5 * number) / (len(tree) + 1)


def _nearest_above(tree: Tree, candidates: Iterable[int]) -> dict[int, int]:
    """Of each candidate the next one above it, -1 for none."""
    some = set(candidates)
    found: list[int] = []
    nearest = {}
    for joint, parent in enumerate(tree.parents):
        above = -1 if parent < 0 else (parent if parent in some else found[parent])
        found.append(above)
        if joint in some:
            nearest[joint] = above
    return nearest


def _likeliest(readings: Sequence[Reading], candidates: Sequence[int], limb: str) -> Path:
    """Without a tree: each slot takes its likeliest word, certain words first."""
    claims = sorted(
        (
            (-readings[joint].value(slot), readings[joint].numbers[:1], joint, slot)
            for joint in candidates
            for slot in LIMBS[limb]
            if readings[joint].value(slot)
        ),
    )
    taken: dict[int, str] = {}
    for _, _, joint, slot in claims:
        if joint not in taken and slot not in taken.values():
            taken[joint] = slot
    return tuple(taken.items())


def _settle_repeats(tree: Tree, readings: Sequence[Reading], candidates: Sequence[int], limb: Limb) -> None:
    """One word for a whole limb, such as LArm LArm1 or leg_1 to leg_5: lengths decide, more specific words stay."""
    chain = _longest_chain(tree, [joint for joint in candidates if _is_plain(readings[joint], limb.limb)])
    if len(chain) < 2:
        return
    certain = {slot: joint for slot, joint in limb.joints.items() if readings[joint[0]].part != limb.limb}
    below = [joint for joint, _, _ in certain.values() if tree.is_above(chain[-1], joint)]
    above = [joint for joint, _, _ in certain.values() if tree.is_above(joint, chain[0])]
    if len(below) + len(above) < len(certain):
        return
    slots, pieces = LIMBS[limb.limb], pieces_of(tree, chain)
    if pieces and "foot" in certain:
        certain["toes"] = certain.pop("foot")
    places = {joint: slots.index(slot) for slot, (joint, _, _) in certain.items()}
    lowest = max((places[joint] for joint in above), default=-1)
    highest = min((places[joint] for joint in below), default=len(slots))
    between = slots[lowest + 1 : highest]
    missing = [slot for slot in CORE[limb.limb] if slot in between]
    if len(missing) < 2:
        return
    by_length = slots_by_length(tree, _with_next(tree, chain, below), limb.limb)
    found = {joint: slot for joint, slot in by_length.items() if joint in chain and slot in between}
    if pieces:
        found = dict(zip(pieces, CORE[limb.limb], strict=True))
    if "low_arm" not in found.values() and "low_leg" not in found.values():
        found = dict(zip(chain, missing, strict=False)) if len(chain) <= len(missing) else {}
    if not found:
        limb.told.append(
            f"{len(chain)} joints of the {limb.side} {limb.limb} have one word and no lengths to tell them apart: "
            "not mapped"
        )
    limb.joints = dict(certain)
    for joint, slot in found.items():
        limb.joints.setdefault(slot, (joint, 0.75, "rest pose" if tree.has_lengths else "tree"))


def _is_plain(reading: Reading, limb: str) -> bool:
    return reading.part == limb and not reading.half and reading.weight >= _CERTAIN


def _longest_chain(tree: Tree, joints: Sequence[int]) -> list[int]:
    """The longest row of joints that hang from one another."""
    nearest = _nearest_above(tree, joints)
    count: dict[int, int] = {}
    for joint in joints:
        count[joint] = 1 + count.get(nearest[joint], 0)
    last = max(joints, key=lambda joint: (count[joint], -joint), default=-1)
    chain = []
    while last >= 0:
        chain.append(last)
        last = nearest[last]
    return chain[::-1]


def _with_next(tree: Tree, chain: Sequence[int], below: Sequence[int]) -> list[int]:
    """Return a chain with the joints that continue it: known ones, or an only child."""
    last = min(below, key=lambda joint: tree.depth[joint], default=-1)
    if last >= 0:
        return [*chain, *(joint for joint in (last,))]
    only = tree.children[chain[-1]]
    return [*chain, *only] if len(only) == 1 else list(chain)


def _settle_shoulders(tree: Tree, readings: Sequence[Reading], candidates: Sequence[int], limb: Limb) -> None:
    """Rename two joints called shoulder to shoulder and upper arm if they are apart."""
    chain = _longest_chain(tree, [joint for joint in candidates if readings[joint].part == "shoulder"])
    taken = {limb.at("shoulder"), limb.at("up_arm")} - {-1}
    if len(chain) < 2 or not taken <= set(chain) or not tree.has_lengths:
        return
    end = limb.at("hand") if limb.at("hand") >= 0 else limb.at("low_arm")
    if end < 0 or not tree.is_above(chain[-1], end):
        return
    length = sum(
        tree.distance(upper, lower)
        for upper, lower in zip(
            *[[chain[-1], *tree.between(chain[-1], end), end][start:] for start in (0, 1)], strict=False
        )
    )
    if tree.distance(chain[0], chain[-1]) >= _APART * length:
        limb.joints["shoulder"] = (chain[0], 0.8, "word")
        limb.joints["up_arm"] = (chain[-1], 0.8, "word")


def _settle_elbow(tree: Tree, readings: Sequence[Reading], limb: Limb) -> None:
    """Shoulder, Arm, Wrist and no elbow: a limb has one, so they are the upper arm, the forearm and the hand."""
    shoulder, arm, hand = (limb.at(slot) for slot in ("shoulder", "up_arm", "hand"))
    if limb.limb != "arm" or "low_arm" in limb.joints or min(shoulder, arm, hand) < 0:
        return
    words = readings[shoulder].part, readings[arm].part
    if words == ("shoulder", "arm") and not tree.between(arm, hand):
        limb.joints["up_arm"] = (shoulder, 0.8, "tree")
        limb.joints["low_arm"] = (arm, 0.75, "tree")
        del limb.joints["shoulder"]


def _take_elsewhere(tree: Tree, readings: Sequence[Reading], candidates: Sequence[int], limb: Limb) -> None:
    """Take the one missing core joint from elsewhere in the tree, if exactly one joint has its name."""
    missing = [slot for slot in CORE[limb.limb] if slot not in limb.joints]
    if len(missing) != 1:
        return
    taken = {joint for joint, _, _ in limb.joints.values()}
    others = [j for j in candidates if j not in taken and readings[j].value(missing[0]) >= _CERTAIN]
    if len(others) == 1:
        limb.joints[missing[0]] = (others[0], ELSEWHERE, "word")
        limb.told.append(f"{tree.names[others[0]]} is called {limb.side}_{missing[0]} and hangs elsewhere in the tree")


def fill_gap(tree: Tree, limb: Limb, is_free: Callable[[int], bool]) -> None:
    """Name the only joint between two known ones of a limb where one core slot is missing between them."""
    slots = LIMBS[limb.limb]
    missing = [slot for slot in CORE[limb.limb] if slot not in limb.joints]
    if len(missing) != 1 or tree.is_flat:
        return
    place = slots.index(missing[0])
    above = [limb.at(slot) for slot in slots[:place] if slot in limb.joints]
    below = [limb.at(slot) for slot in slots[place + 1 :] if slot in limb.joints]
    if above and below:
        free = [joint for joint in tree.between(above[-1], below[0]) if is_free(joint)]
        if len(free) == 1:
            limb.joints[missing[0]] = (free[0], GAP, "tree")


def drop_unlike(tree: Tree, readings: Sequence[Reading], left: Limb, right: Limb) -> list[str]:
    """Drop joints whose names are each other's mirror and whose slots are not; sentences about them.

    Where lengths decided, names only count: one side may count upwards and the other downwards.
    """
    told = []
    keys: Mapping[tuple[str, ...], tuple[str, int]] = {
        readings[joint].key: (slot, joint) for slot, (joint, _, how) in right.joints.items() if how == "word"
    }
    for slot, (joint, _, how) in list(left.joints.items()):
        if how != "word":
            continue
        other, twin = keys.get(readings[joint].key, (slot, -1))
        if other != slot and left.joints.get(slot, (-1,))[0] == joint and right.joints.get(other, (-1,))[0] == twin:
            del left.joints[slot], right.joints[other]
            told.append(
                f"{tree.names[joint]} and {tree.names[twin]} stand at different places of their limbs: not mapped"
            )
    return told
