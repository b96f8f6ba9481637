"""Fingers: the joint of each one that is nearest to its hand, by words or by numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mcml.motion.rigs.limbs import Limb
from mcml.motion.rigs.readings import FINGERS, Reading
from mcml.motion.rigs.tree import Tree

_NAMES = ("fingers", "finger_one", "finger_two", "finger_three", "finger_four", "finger_five")
_EVERY = frozenset(FINGERS)
_PALM = re.compile(r"metacarp|in_?hand", re.IGNORECASE)


def is_of_palm(name: str) -> bool:
    """Tell whether a joint has the name of a bone of the palm, which the name of a finger may have been given to."""
    return _PALM.search(name) is not None


def find_fingers(
    tree: Tree, readings: Sequence[Reading], sides: Sequence[str], out: Sequence[bool], arm: Limb
) -> dict[str, tuple[int, float, str]]:
    """Fingers of one hand: MCML's name without side → (joint, how sure, "word")."""
    # A thumb may be a child of the wrist beside the hand: all children of the forearm are searched.
    top = next((arm.at(slot) for slot in ("low_arm", "wrist", "hand") if slot in arm.joints), -1)
    taken = {joint for joint, _, _ in arm.joints.values()}
    some = [
        joint
        for joint, reading in enumerate(readings)
        if reading.finger >= 0
        and sides[joint] == arm.side
        and not out[joint]
        and joint not in taken
        and (tree.is_flat or tree.is_above(top, joint))
    ]
    if top < 0 or not some:
        return {}
    # A joint of one finger comes before one of two, such as RingPinky.
    some.sort(key=lambda j: (tree.depth[j], len(readings[j].parts & _EVERY), readings[j].numbers[:2], tree.names[j], j))
    named: dict[int, int] = {}
    for joint in some:
        if readings[joint].finger > 0:
            named.setdefault(readings[joint].finger, joint)
    fingers, below = set(some), [False] * len(tree)
    for joint, parent in enumerate(tree.parents):
        below[joint] = parent >= 0 and (parent in fingers or below[parent])
    first = [joint for joint in some if not below[joint]]
    numbered = _number_fingers(tree, readings, first, has_thumb=1 in named)
    for number, joint in numbered.items():
        named.setdefault(number, joint)
    result = {_NAMES[number]: (joint, 0.95, "word") for number, joint in sorted(named.items()) if 1 <= number <= 5}
    plain = [joint for joint in first if readings[joint].finger == 0 and not readings[joint].numbers]
    if plain and not numbered:
        result[_NAMES[0]] = (plain[0], 0.9, "word")
    return result


def _number_fingers(tree: Tree, readings: Sequence[Reading], first: Sequence[int], has_thumb: bool) -> dict[int, int]:
    """Finger → joint of fingers that have numbers: with a 0 or a thumb among them 1 is the second, else the first."""
    numbers: dict[int, int] = {}
    for joint in first:
        reading = readings[joint]
        if reading.finger != 0 or not reading.numbers:
            continue
        number = reading.numbers[0]
        if reading.metacarpal:
            below = [each for each in tree.children[joint] if readings[each].finger == 0 and readings[each].numbers]
            number = readings[below[0]].numbers[0] if below else number
        numbers.setdefault(number, joint)
    shift = 1 if 0 in numbers or (has_thumb and 1 in numbers) else 0
    return {number + shift: joint for number, joint in sorted(numbers.items()) if 1 <= number + shift <= 5}
