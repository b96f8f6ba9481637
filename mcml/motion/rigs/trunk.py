"""Root, trunk, necks and head: by words on the way from the joint above both thighs to the head."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from mcml.motion.rigs.limbs import Limb
from mcml.motion.rigs.readings import Reading
from mcml.motion.rigs.tree import Tree

Claim = tuple[int, float, str]
"""A joint, how sure it is, and by what: "word", "tree" or "rest pose"."""
TRUNK = ("waist", "torso2", "torso3", "torso4", "torso5", "torso6", "torso7")
_MOST = 60
"""Joints of a trunk among which spare ones are sought."""
_CERTAIN = 0.5
"""Of a joint's weight: twist bones and their like are no part of the trunk."""


@dataclass
class Trunk:
    """names: MCML's name → its claim. carrier: the joint that both arms hang from, -1 for none."""

    names: dict[str, Claim] = field(default_factory=dict)
    carrier: int = -1

    def at(self, name: str) -> int:
        """The joint of a name, -1 for none."""
        return self.names[name][0] if name in self.names else -1


def find_trunk(
    tree: Tree,
    readings: Sequence[Reading],
    limbs: Mapping[tuple[str, str], Limb],
    is_out: Callable[[int], bool],
    is_in_limb: Callable[[int], bool],
) -> Trunk:
    """The trunk of a body whose limbs are known. is_out: whether a joint is a helper; is_in_limb: or of a limb."""
    trunk = Trunk()
    tops = {limb: _tops(limbs, limb) for limb in ("arm", "leg")}
    trunk.carrier = _above(tree, tops["arm"])

    def is_free(joint: int) -> bool:
        return not is_out(joint) and not is_in_limb(joint)

    head = _head(tree, readings, trunk.carrier, is_free)
    if head >= 0:
        trunk.names["Head"] = (head, 0.98 if readings[head].trunk == "head" else 0.8, "word")
    else:
        _claim_spine_above(tree, readings, trunk, is_free)
    thighs = _above(tree, tops["leg"])
    root, sure, how = _root(tree, readings, trunk, thighs, is_free)
    if root >= 0 and root != trunk.at("Head"):
        trunk.names["Root"] = (root, sure, how)
    if tree.is_flat:
        _claim_flat(readings, trunk, is_free)
    else:
        _claim_way(tree, readings, trunk, is_free)
    return trunk


def _tops(limbs: Mapping[tuple[str, str], Limb], kind: str) -> list[int]:
    """The topmost joint of each limb of a kind."""
    found = [limb for (_, each), limb in limbs.items() if each == kind and limb.joints]
    order = ("shoulder", "up_arm", "low_arm", "hip", "up_leg", "low_leg")
    return [next((limb.at(slot) for slot in order if slot in limb.joints), -1) for limb in found if limb.core()]


def _above(tree: Tree, tops: Sequence[int]) -> int:
    """The lowest joint that all of some hang from, -1 for none."""
    some = [joint for joint in tops if joint >= 0]
    common = tree.common(some)
    return tree.parents[common] if common in some and common >= 0 else common


def _head(tree: Tree, readings: Sequence[Reading], carrier: int, is_free: Callable[[int], bool]) -> int:
    free = [joint for joint in range(len(tree)) if is_free(joint)]
    spine_goes_on = carrier >= 0 and any(
        readings[joint].trunk == "spine" and joint != carrier and tree.is_above(carrier, joint) for joint in free
    )
    heads = [
        joint
        for joint in free
        if readings[joint].trunk == "head"
        and not readings[joint].end
        and readings[joint].side not in ("left", "right")
        and not (spine_goes_on and not tree.is_above(carrier, joint))
    ]
    if heads:
        return min(
            heads,
            key=lambda joint: (
                -round(readings[joint].weight, 6),
                tree.depth[joint],
                min(readings[joint].numbers[:1], default=0),
                joint,
            ),
        )
    necks = [joint for joint in free if readings[joint].trunk == "neck"]
    both = [joint for joint in necks if "head" in readings[joint].words and len(necks) > 1]
    if both:
        return max(both, key=lambda joint: tree.depth[joint])
    under, has_neck = [False] * len(tree), set(necks)
    for joint, parent in enumerate(tree.parents):
        under[joint] = parent >= 0 and (parent in has_neck or under[parent])
        if under[joint] and "face" in readings[joint].words:
            return joint
    noses = [joint for joint in free if readings[joint].trunk == "nose" and not readings[joint].end]
    return min(noses, key=lambda joint: tree.depth[joint], default=-1)


def _claim_spine_above(tree: Tree, readings: Sequence[Reading], trunk: Trunk, is_free: Callable[[int], bool]) -> None:
    """Claim the head for a spine with a single word that continues above the arms."""
    if trunk.carrier < 0 or any(reading.trunk == "neck" for reading in readings):
        return
    chain: list[int] = []
    for joint in range(len(tree)):
        fits = readings[joint].trunk == "spine" and is_free(joint) and joint != trunk.carrier
        if (
            fits
            and tree.is_above(trunk.carrier, joint)
            and tree.depth[joint] == tree.depth[trunk.carrier] + len(chain) + 1
        ):
            chain.append(joint)
    if not chain:
        return
    trunk.names["Head"] = (chain[-1], 0.8, "tree")
    if len(chain) > 1:
        trunk.names["neck1"] = (chain[-2], 0.8, "tree")
    if len(chain) > 2:
        trunk.names["neck2"] = (chain[0], 0.8, "tree")


def _root(tree: Tree, readings: Sequence[Reading], trunk: Trunk, thighs: int, is_free: Callable[[int], bool]) -> Claim:
    pelvises = [
        joint
        for joint in range(len(tree))
        if readings[joint].trunk == "pelvis" and is_free(joint) and readings[joint].weight > _CERTAIN
    ]
    pelvises.sort(key=lambda joint: (-round(readings[joint].weight, 6), tree.depth[joint], joint))
    if tree.is_flat and pelvises:
        return pelvises[0], 0.98, "word"
    if thighs < 0:
        carried = [joint for joint in pelvises if trunk.carrier < 0 or tree.is_above(joint, trunk.carrier)]
        return (carried[0], 0.9, "word") if carried else (-1, 0.0, "")
    upper = trunk.at("Head") if "Head" in trunk.names else trunk.carrier
    root = tree.common([joint for joint in (thighs, upper) if joint >= 0])
    if root < 0:
        root = thighs
    if readings[root].trunk in ("spine", "chest", "waist", ""):
        above = next((joint for joint in tree.way_up(root) if joint in pelvises), -1)
        if above >= 0:
            return above, 0.95, "word"
    if readings[root].trunk in ("root", "waist", "") and readings[thighs].trunk == "pelvis":
        return thighs, 0.95, "word"
    word = readings[root].trunk
    return root, {"pelvis": 0.98, "root": 0.95}.get(word, 0.85), "word" if word in ("pelvis", "root") else "tree"


def _claim_way(tree: Tree, readings: Sequence[Reading], trunk: Trunk, is_free: Callable[[int], bool]) -> None:
    """Necks and the trunk, on the way from the root to the head."""
    root, head = trunk.at("Root"), trunk.at("Head")
    necks = [joint for joint in range(len(tree)) if readings[joint].trunk == "neck" and is_free(joint)]
    top = head if head >= 0 else max(necks, key=lambda joint: tree.depth[joint], default=trunk.carrier)
    if top < 0:
        return
    above_root = set(tree.way_up(root)) if root >= 0 else set()
    way = [joint for joint in tree.way_up(top)[::-1] if joint not in above_root and joint != head]
    on_way = [joint for joint in way if joint in necks]
    on_way = [joint for joint in on_way if readings[joint].weight >= _CERTAIN] or on_way
    taken = {joint for joint, _, _ in trunk.names.values()}
    if on_way and "neck1" not in trunk.names:
        trunk.names["neck1"] = (on_way[-1], 0.95, "word")
        if len(on_way) > 1:
            trunk.names["neck2"] = (on_way[0], 0.95, "word")
    lowest = on_way[0] if on_way else -1
    below = [joint for joint in way if joint not in taken and (lowest < 0 or not tree.is_above(lowest, joint))]
    if lowest < 0 and trunk.carrier >= 0:
        below = [joint for joint in below if tree.is_above(joint, trunk.carrier)]
    _claim_trunk(_trunk_joints(readings, below, trunk.carrier, is_free), readings, trunk)


def _trunk_joints(
    readings: Sequence[Reading], way: Sequence[int], carrier: int, is_free: Callable[[int], bool]
) -> list[int]:
    words = {joint: readings[joint].trunk for joint in way if is_free(joint) and readings[joint].weight >= _CERTAIN}
    named = [joint for joint, word in words.items() if word in ("chest", "spine", "waist")]
    if not any(words[joint] in ("spine", "waist") for joint in named):
        named += [joint for joint, word in words.items() if word == "pelvis"][:1]
    if carrier in way:
        named.append(carrier)
    chosen = set(named)
    for joint in named if len(named) <= _MOST else ():
        plain = [each for each in chosen if each != joint and readings[each].weight > readings[joint].weight]
        if joint != carrier and any(_bare(readings[each]) < _bare(readings[joint]) for each in plain):
            chosen.discard(joint)
    return [joint for joint in way if joint in chosen]


def _bare(reading: Reading) -> frozenset[str]:
    """The words of a name without its numbers."""
    return frozenset(word for word in reading.words if not word.isdigit())


def _claim_trunk(joints: Sequence[int], readings: Sequence[Reading], trunk: Trunk) -> None:
    def claim(joint: int) -> Claim:
        return (joint, 0.9, "word") if readings[joint].trunk else (joint, 0.8, "tree")

    if len(joints) == 1:
        only = joints[0]
        is_chest = readings[only].trunk == "chest" or only == trunk.carrier
        trunk.names["torso7" if is_chest else "waist"] = claim(only)
    elif joints:
        for name, joint in zip(TRUNK[:-1], joints[:-1], strict=False):
            trunk.names[name] = claim(joint)
        trunk.names[TRUNK[-1]] = claim(joints[-1])


def _claim_flat(readings: Sequence[Reading], trunk: Trunk, is_free: Callable[[int], bool]) -> None:
    """The trunk where joints hang from one root: by words and numbers alone."""
    free = [joint for joint in range(len(readings)) if is_free(joint) and readings[joint].weight >= _CERTAIN]
    taken = {joint for joint, _, _ in trunk.names.values()}
    necks = [joint for joint in free if readings[joint].trunk == "neck" and joint not in taken]
    necks.sort(key=lambda joint: (readings[joint].numbers[:1], joint))
    if necks:
        trunk.names["neck1"] = (necks[-1], 0.9, "word")
        if len(necks) > 1:
            trunk.names["neck2"] = (necks[0], 0.9, "word")
    rank = {"waist": 0, "spine": 1, "chest": 2}
    joints = [joint for joint in free if readings[joint].trunk in rank and joint not in taken]
    joints.sort(key=lambda joint: (rank[readings[joint].trunk], readings[joint].numbers[:1], joint))
    _claim_trunk(joints, readings, trunk)
