"""Bodies to recognise: a person's rest pose with any names, from MCML's names or from a tree written in lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mcml.motion.rigs.recognise import Recognition, recognise
from mcml.motion.rigs.tree import Tree
from mcml.motion.skeleton import Convention, EndSite, Joint, Skeleton

SIDES = ("left", "right")
CORE = ["Root", "Head"] + [
    f"{side}_{slot}" for side in SIDES for slot in ("up_arm", "low_arm", "hand", "up_leg", "low_leg", "foot")
]
TRUNK = ["Root", "waist", "torso2", "torso3", "torso4", "torso5", "torso6", "torso7", "neck2", "neck1", "Head"]
ARM, LEG = ["shoulder", "up_arm", "low_arm", "wrist", "hand"], ["hip", "up_leg", "low_leg", "foot", "toes"]
FINGERS = ["fingers", "finger_one", "finger_two", "finger_three", "finger_four", "finger_five"]

PLACES: dict[str, tuple[float, float, float]] = {
    "Root": (0, 95, 0), "waist": (0, 105, 0), "torso2": (0, 112, 0), "torso3": (0, 119, 0), "torso4": (0, 124, 0),
    "torso5": (0, 129, 0), "torso6": (0, 132, 0), "torso7": (0, 136, 0), "neck2": (0, 150, 0), "neck1": (0, 155, 0),
    "Head": (0, 163, 0),
}  # fmt: skip
"""Of each of MCML's names where its joint stands in a person of 1.83 m, in cm: +Y is up, +Z forward, +X left."""
PLACES |= {
    f"{side}_{name}": (sign * x, y, z)
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True)
    for name, (x, y, z) in {
        "shoulder": (4.0, 146.0, 0.0), "up_arm": (18.0, 146.0, 0.0), "low_arm": (45.0, 146.0, 0.0),
        "wrist": (68.0, 146.0, 0.0), "hand": (71.0, 146.0, 0.0), "fingers": (78.0, 146.0, 0.0),
        "finger_one": (74.0, 145.0, 3.0), "finger_two": (80.0, 146.0, 2.0), "finger_three": (81.0, 146.0, 1.0),
        "finger_four": (80.0, 146.0, -1.0), "finger_five": (79.0, 146.0, -2.0), "hip": (3.0, 93.0, 0.0),
        "up_leg": (9.0, 92.0, 0.0), "low_leg": (9.0, 50.0, 0.0), "foot": (9.0, 8.0, 0.0), "toes": (9.0, 2.0, 13.0),
    }.items()
}  # fmt: skip


def person(names: Mapping[str, str], lengths: bool = True) -> Tree:
    """A person whose joints have some names. names: MCML's name → the rig's, of the joints that it has."""
    above: dict[str, str] = {}
    trunk = [name for name in TRUNK if name in names]
    above |= dict(zip(trunk[1:], trunk, strict=False))
    chest = next((name for name in reversed(trunk) if not name.startswith(("neck", "Head"))), "")
    for side in SIDES:
        for chain, top in ((ARM, chest), (LEG, "Root" if "Root" in names else "")):
            last = top
            for name in (f"{side}_{slot}" for slot in chain):
                if name in names:
                    above[name] = last
                    last = name
            if chain is ARM:
                above |= {f"{side}_{finger}": last for finger in FINGERS if f"{side}_{finger}" in names}
    order: list[str] = []
    waiting = [name for name in names if not above.get(name)][::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += [name for name in names if above.get(name) == order[-1]][::-1]
    index = {name: place for place, name in enumerate(order)}
    places = np.array([PLACES[name] for name in order], float).reshape(-1, 3)
    tips = [(index["Head"], places[index["Head"]] + (0, 20, 0))] if "Head" in index else []
    return Tree(
        [names[name] for name in order],
        [index[above[name]] if above.get(name) else -1 for name in order],
        places if lengths else np.zeros((len(order), 3)),
        tips if lengths else (),
    )


def chain(*names: str) -> Tree:
    """Joints that hang from one another, without lengths."""
    return Tree(list(names), list(range(-1, len(names) - 1)), np.zeros((len(names), 3)))


def tree(text: str) -> Tree:
    """A rig written in lines `name x y z`, each indented below the joint that it hangs from; places are absolute."""
    names: list[str] = []
    parents: list[int] = []
    places: list[list[float]] = []
    open_joints: list[tuple[int, int]] = []
    for line in text.strip("\n").splitlines():
        depth = len(line) - len(line.lstrip())
        name, *numbers = line.split()
        while open_joints and open_joints[-1][0] >= depth:
            open_joints.pop()
        parents.append(open_joints[-1][1] if open_joints else -1)
        open_joints.append((depth, len(names)))
        names.append(name.replace("~", " "))
        places.append([float(number) for number in numbers] or [0.0, 0.0, 0.0])
    return Tree(names, parents, np.array(places))


def names_of(rig: Tree, recognition: Recognition | None = None) -> dict[str, str]:
    """MCML's name → the rig's, as it is recognised."""
    found = recognition or recognise(rig)
    return {each.name: rig.names[each.joint] for each in found.joints}


def mirrored(names: Mapping[str, str], swaps: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Names of the left side and the trunk, and the same of the right side."""
    result = dict(names)
    for name, own in names.items():
        if name.startswith("left_"):
            for left, right in swaps:
                own = own.replace(left, right)
            result[name.replace("left_", "right_")] = own
    return result


USUAL = mirrored(
    {
        "Root": "Hips", "waist": "Spine", "torso2": "Spine1", "torso7": "Spine2", "neck1": "Neck", "Head": "Head",
        "left_shoulder": "LeftShoulder", "left_up_arm": "LeftArm", "left_low_arm": "LeftForeArm",
        "left_hand": "LeftHand", "left_up_leg": "LeftUpLeg", "left_low_leg": "LeftLeg", "left_foot": "LeftFoot",
        "left_toes": "LeftToeBase",
    },
    [("Left", "Right")],
)  # fmt: skip
"""A person with the words that most BVH files have."""


def skeleton_of(rig: Tree) -> Skeleton:
    """A rig as the skeleton of a BVH file."""
    joints = []
    for joint, (name, parent) in enumerate(zip(rig.names, rig.parents, strict=True)):
        offset = rig.places[joint] - (rig.places[parent] if parent >= 0 else 0)
        channels = ("Rz", "Rx", "Ry") if parent >= 0 else ("Tx", "Ty", "Tz", "Rz", "Rx", "Ry")
        ends = tuple(EndSite(_lexemes(tip - rig.places[joint])) for tip in rig.tips_of(joint))
        kind, translation = Convention.LISTED, "absolute" if parent < 0 else ""
        whole = Joint(name, parent, name, kind, channels, "ZXY", offset=_lexemes(offset), translation=translation)
        joints.append(replace(whole, end_sites=ends))
    return Skeleton(tuple(joints))


def _lexemes(vector: np.ndarray) -> tuple[str, str, str]:
    x, y, z = (f"{float(number):g}" for number in vector)
    return x, y, z
