"""Rigs of a person for figures: any rest pose, pieces of bones, and joints that some rigs lack."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from mcml.motion.clip import Reference
from mcml.motion.hub import rest_of, walked
from mcml.motion.rigs.tree import Tree
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import Array, Joint, Skeleton, numbers
from tests.builders import assign
from tests.motion.rigs.rig_builder import USUAL, person, skeleton_of

REST = Reference("Y")
"""Figures are bound in the rest pose."""
HANGING = {
    f"{side}_up_arm": Rotation.from_euler("z", turn, degrees=True) for side, turn in (("left", -80), ("right", 80))
}
"""From a T-pose to arms beside the body."""
SLOPING = {
    f"{side}_up_arm": Rotation.from_euler("z", turn, degrees=True) for side, turn in (("left", -40), ("right", 40))
} | {f"{side}_up_leg": Rotation.from_euler("z", turn, degrees=True) for side, turn in (("left", 20), ("right", -20))}
"""From a T-pose to an A-pose with the legs apart."""


def rig(names: Mapping[str, str] = USUAL, bent: Mapping[str, Rotation] | None = None, size: float = 1.0) -> Skeleton:
    """A person with the joints of these names, at rest in a T-pose bent at some joints, by MCML's names."""
    tree = person(names)
    places, tips = tree.places.copy() * size, [(joint, place * size) for joint, place in tree.tips]
    for name, turn in (bent or {}).items():
        joint = list(tree.names).index(names[name])
        below = [index for index in range(len(tree)) if _is_below(tree, index, joint)]
        places[below] = places[joint] + turn.apply(places[below] - places[joint])
        tips = [
            (owner, places[joint] + turn.apply(place - places[joint]) if owner in below and owner != joint else place)
            for owner, place in tips
        ]
    return assign(skeleton_of(Tree(tree.names, tree.parents, places, tips)))


def _is_below(tree: Tree, joint: int, above: int) -> bool:
    joint = tree.parents[joint]
    while joint >= 0 and joint != above:
        joint = tree.parents[joint]
    return joint == above


def divide(skeleton: Skeleton, above: str, pieces: int) -> Skeleton:
    """A rig with more joints on the bone that leads to one: a spine or a limb of many pieces. above: the upper one."""
    joints: list[Joint] = []
    place: dict[int, int] = {}
    for index, joint in enumerate(skeleton.joints):
        parent = place.get(joint.parent, -1)
        if joint.parent >= 0 and skeleton.joints[joint.parent].name == above and not joint.name.endswith("_up_leg"):
            x, y, z = (f"{value / pieces:.9g}" for value in numbers(joint.offset))
            part = x, y, z
            for number in range(pieces - 1):
                name = f"{joint.name}_piece{number}"
                extra = replace(
                    joint, name=name, source_name=name, parent=parent, offset=part, end_sites=(), mapped=False
                )
                joints.append(extra)
                parent = len(joints) - 1
            joint = replace(joint, offset=part)
        place[index] = len(joints)
        joints.append(replace(joint, parent=parent))
    return Skeleton(tuple(joints))


def pose_rig(skeleton: Skeleton, turns: Mapping[str, Rotation], frames: int = 1) -> tuple[Array, Array]:
    """Positions (n, J, 3) and rotations (n, J, 4) of a body whose joints are turned from rest, in their parents."""
    local = np.tile(IDENTITY, (frames, len(skeleton), 1))
    for name, turn in turns.items():
        local[:, skeleton.names.index(name)] = turn.as_quat()
    return walked(skeleton, np.tile(rest_of(skeleton).offsets, (frames, 1, 1)), local)
