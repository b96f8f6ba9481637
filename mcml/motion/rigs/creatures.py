"""Detect bodies that are not a person, although their joints have a person's words: by names, additional limbs and
posture. Their joints get no names of MCML: a dog's front paw is not a hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcml.motion.rigs.limbs import Limb, best_path
from mcml.motion.rigs.postures import Posture, degrees, trunk_angle
from mcml.motion.rigs.readings import CORE, Reading
from mcml.motion.rigs.tree import Tree
from mcml.motion.rigs.vocabulary import HELPERS
from mcml.motion.rigs.words import Words
from mcml.motion.skeleton import Array

_FRONT, _HIND = ("fl", "fr"), ("rl", "rr", "bl", "br", "hl", "hr")
_LYING = 45.0, 135.0
"""Degrees between the trunk and the legs of a body on four legs."""
_FOREMOST = 0.45, 50.0
"""How long arms are at least that are legs, in parts of the legs, and the degrees from the direction of these."""
_APART = 0.3
"""Relative to the upper bone: least distance of a second limb from the first."""
_CERTAIN = 0.5


def creature_by_words(names: Sequence[str], words: Sequence[Words], readings: Sequence[Reading]) -> str:
    """Why names are no person's, "" where they do not tell."""
    front_feet, back_feet = "", ""
    odd: set[str] = set()
    for name, reading in zip(names, readings, strict=True):
        if "animal" in reading.parts and not reading.parts & HELPERS:
            return f"it has {name!r}"
        odd |= reading.words if "creature" in reading.parts else frozenset()
        if (
            reading.limb != "leg"
            or reading.part in ("hip", "pelvis", "hip_connector")
            or reading.helper
            or reading.half
        ):
            continue
        back = "back" in reading.words and reading.part in ("leg", "thigh", "foot")
        if ("hind" in reading.parts and reading.part != "foot") or "hind" in reading.words:
            return f"it has {name!r}"
        says_leg = "leg" in reading.parts or any("leg" in word for word in reading.words)
        if (back or "front" in reading.parts) and reading.part != "foot" and says_leg:
            return f"it has {name!r}"
        front_feet = front_feet or (name if "front" in reading.parts else "")
        back_feet = back_feet or (name if back or "hind" in reading.parts else "")
    if front_feet and back_feet:
        return f"it has {front_feet!r} and {back_feet!r}"
    weak = {text for text in odd if text in _ODD}
    if len(weak) > 1:
        return f"it has parts called {' and '.join(sorted(weak))}"
    limbs = {word.text for name, own in zip(readings, words, strict=True) if name.limb or name.trunk for word in own}
    if (set(_FRONT) <= limbs and sum(word in limbs for word in _HIND) >= 2) or {"lf", "lh", "rh"} <= limbs:
        return "its legs are in front and behind"
    before_leg = {own[place].text for own in words for place in range(len(own) - 1) if "leg" in own[place + 1].parts}
    return "its legs are in front and behind" if {"f", "b"} <= before_leg else ""


_ODD = frozenset({"antenna", "cannon", "claw", "mane", "muzzle", "pincer"})


def creature_by_limbs(
    tree: Tree,
    readings: Sequence[Reading],
    candidates: Mapping[tuple[str, str], Sequence[int]],
    limbs: Mapping[tuple[str, str], Limb],
) -> str:
    """Return the reason why a body with too many limbs is not a person; "" for other bodies."""
    further = [
        key
        for key, limb in limbs.items()
        if limb.core() >= 2 and _has_second(tree, readings, candidates.get(key, ()), limb)
    ]
    for kind in ("arm", "leg"):
        if sum(each == kind for _, each in further) == 2:
            return f"it has more than two {kind}s"
    return "it has more than four limbs" if {kind for _, kind in further} == {"arm", "leg"} else ""


def _has_second(tree: Tree, readings: Sequence[Reading], candidates: Sequence[int], limb: Limb) -> bool:
    """Tell whether a branch outside a limb has words for its slots, at a distance from it."""
    if not tree.has_lengths or tree.is_flat:
        return False
    slots = [slot for slot in CORE[limb.limb] if slot in limb.joints]
    first = [limb.at(slot) for slot in slots]
    others = [
        joint
        for joint in candidates
        if readings[joint].weight > _CERTAIN
        and not any(tree.is_above(joint, each) or tree.is_above(each, joint) for each in first)
    ]
    path = best_path(tree, readings, others, limb.limb)
    second = {slot: joint for joint, slot in path if slot in CORE[limb.limb]}
    shared = [slot for slot in slots if slot in second]
    if len(second) < 2 or not shared:
        return False
    if all(_bare(readings[limb.at(slot)]) < _bare(readings[second[slot]]) for slot in shared):
        return False
    upper = tree.distance(first[0], first[1])
    return upper > 0 and all(tree.distance(limb.at(slot), second[slot]) >= _APART * upper for slot in shared)


def _bare(reading: Reading) -> frozenset[str]:
    return frozenset(word for word in reading.words if not word.isdigit())


def creature_by_posture(
    posture: Posture, limbs: Mapping[tuple[str, str], Limb], poses: Sequence[Array], has_tail: bool
) -> str:
    """Return the reason why a body does not stand on two legs, from the first pose that decides; "" if none does.

    poses: (J, 3) of the rest pose, then of frames.
    """
    for places in poses:
        angle = trunk_angle(posture, places)
        if angle > _LYING[1]:
            return ""
        if not _LYING[0] <= angle <= _LYING[1]:
            continue
        legs = np.mean([places[end] - places[start] for start, end, _ in posture.legs], axis=0)
        arms = _arms(limbs, places)
        share, apart = _FOREMOST
        alike = (
            arms is not None and np.linalg.norm(arms) >= share * np.linalg.norm(legs) and degrees(arms, legs) <= apart
        )
        if has_tail or alike:
            return "its trunk lies over its legs"
    return ""


def _arms(limbs: Mapping[tuple[str, str], Limb], places: Array) -> Array | None:
    """The mean of both arms, (3,)."""
    ends = [
        limb_ends(limbs[side, "arm"], ("up_arm", "shoulder", "low_arm"), ("hand", "wrist", "low_arm"))
        for side in ("left", "right")
        if (side, "arm") in limbs
    ]
    if len(ends) < 2 or any(each is None for each in ends):
        return None
    mean: Array = np.mean([places[each[1]] - places[each[0]] for each in ends if each is not None], axis=0)
    return mean


def limb_ends(limb: Limb, starts: Sequence[str], ends: Sequence[str]) -> tuple[int, int] | None:
    """The first known joints of some slots and of some others, None where a limb has not two."""
    start = next((limb.at(slot) for slot in starts if slot in limb.joints), -1)
    end = next((limb.at(slot) for slot in ends if slot in limb.joints), -1)
    return None if min(start, end) < 0 or start == end else (start, end)
