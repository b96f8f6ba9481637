"""The roles of joints without a name of MCML's: jaws, eyes, joints of fingers after the first, twist bones, props."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from mcml.motion.rigs.fingers import is_of_palm
from mcml.motion.rigs.readings import Reading, read_names
from mcml.motion.rigs.tree import Tree
from mcml.motion.rigs.words import SIDES, read_words

BY_WORD: Final[Mapping[str, str]] = {
    "connector": "connector",
    "control": "control",
    "end": "end",
    "tip": "end",
    "half": "twist",
    "heel": "{side}heel",
    "jaw": "jaw",
    "face_part": "face",
    "eye": "{side}eye",
    "face": "face",
    "hair": "hair",
    "clothing": "clothing",
    "prop": "prop",
    "soft_tissue": "soft_tissue",
    "tail": "tail",
    "wing": "{side}wing",
}
"""Part of the vocabulary → role, the strongest first: the lid of an eye is of the face, its target a control."""
_TRUNK: Final = {"spine": "spine", "chest": "spine", "waist": "spine", "neck": "neck"}
_PASSED_ON: Final = frozenset({"clothing", "control", "face", "hair", "prop", "soft_tissue", "tail"})
"""Roles that a joint without telling words has from the one above."""
_DIGIT: Final = re.compile(r"(?:left|right)_(?:finger_\w+?|fingers|toe_\w+?|toes)(?:_(?P<number>\d+))?")
_PHALANGES: Final = 3
_FINGERS: Final = tuple(f"finger_{number}" for number in ("one", "two", "three", "four", "five"))
ORIGIN: Final = "origin"
"""Of a joint above the hips, which places the figure."""


def known_roles() -> list[str]:
    """Roles that a person may ask for: those by words, and the second and third joints of fingers."""
    sides = ("left_", "right_")
    found = [role.format(side=side) for role in BY_WORD.values() for side in (sides if "{" in role else ("",))]
    fingers = [f"{side}{name}_{number}" for side in sides for name in _FINGERS for number in (2, 3)]
    return list(dict.fromkeys([*found, *_TRUNK.values(), ORIGIN, *fingers]))


@dataclass(frozen=True)
class _Place:
    """A joint without a name. parent: the nearest joint above that is no connector; above: its name or role."""

    joint: int
    parent: int
    above: str
    reading: Reading


def find_roles(tree: Tree, named: Mapping[int, str]) -> dict[int, str]:
    """The roles of joints without a name of MCML's, as far as words and the tree tell.

    named: joint → MCML's name. Joints of a finger or toe beside the one with its name have that name and their number
    from the knuckle, `left_finger_one_2`; the fourth is its end. Bones of the palm have the finger's, as
    `left_metacarpal_two`. Sided roles begin with `left_` or `right_` where the side is known.
    """
    readings = read_names(tree.names, read_words(tree.names)[0])
    hips = next((joint for joint, name in named.items() if name == "Root"), -1)
    above_hips = set(tree.way_up(hips)) if hips >= 0 else set[int]()
    roles = dict[int, str]()
    for joint, parent in enumerate(tree.parents):
        if joint in named:
            continue
        while roles.get(parent) == "connector":
            parent = tree.parents[parent]
        place = _Place(joint, parent, named.get(parent, roles.get(parent, "")), readings[joint])
        role = ORIGIN if joint in above_hips else _by_words(tree, place, named) or _by_tree(tree, place, named)
        if role:
            roles[joint] = role
    return roles


def _by_words(tree: Tree, place: _Place, named: Mapping[int, str]) -> str:
    carries = any(tree.is_above(place.joint, other) for other in named)
    for part, role in BY_WORD.items():
        # "Top" and "tip" are ends only where no part of the body follows.
        if part in place.reading.parts and not (carries and role == "end"):
            side = place.reading.side if place.reading.side in SIDES else place.above.partition("_")[0]
            found = role.format(side=f"{side}_" if side in SIDES else "")
            return "connector" if carries and found == "control" else found
    return ""


def _by_tree(tree: Tree, place: _Place, named: Mapping[int, str]) -> str:
    above, reading = place.above, place.reading
    digit = _DIGIT.fullmatch(above)
    if digit is not None:
        first = 0 if is_of_palm(tree.names[place.parent]) else 1
        number = int(digit["number"] or first) + 1
        bare = above.removesuffix(f"_{digit['number']}")
        return "end" if number > _PHALANGES and not tree.children[place.joint] else f"{bare}_{number}"
    for child in tree.children[place.joint]:
        side, _, finger = named.get(child, "").partition("_finger_")
        if finger and is_of_palm(tree.names[place.joint]):
            return f"{side}_metacarpal_{finger}"
    if reading.trunk in _TRUNK and reading.side not in SIDES:
        return _TRUNK[reading.trunk]
    tells = bool(reading.limb or reading.trunk or reading.finger >= 0)
    return above if above in _PASSED_ON and not tells else ""
