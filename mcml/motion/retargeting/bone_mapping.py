"""Which joint of one skeleton is which of another: suggested with a reason and how sure it is, for people to change."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from mcml.errors import ConversionError
from mcml.motion.retargeting.finger_chains import is_finger, pair_fingers
from mcml.motion.rigs.skeletons import recognise_skeleton
from mcml.motion.skeleton import Joint, Skeleton

_STAND_INS = (
    ("*_wrist", "*_hand"),
    ("neck1", "neck2"),
    ("torso7", "waist"),
    ("torso7", "torso2"),
    ("torso2", "waist"),
    ("*_hip", "*_up_leg"),
    ("*_finger_three", "*_fingers"),
)
"""MCML names of joints that can replace each other if a skeleton has only one of them; `*` for the side."""


@dataclass(frozen=True, slots=True)
class Match:
    """A joint of the source and one of the target, by index. confidence: 0 to 1. reason: for people."""

    source: int
    target: int
    confidence: float
    reason: str


def suggest_matches(source: Skeleton, target: Skeleton) -> tuple[Match, ...]:
    """Suggest matches in the order of the target, each joint in at most one.

    By MCML's names, of the documents and recognised ones, fingers from the knuckle on, then by names of the source
    files, then by joints that can replace each other. A match whose joints do not have matching parents gets a lower
    confidence.
    """
    found: dict[int, Match] = {}
    taken: set[int] = set()

    def add(one: int, other: int, confidence: float, reason: str) -> None:
        if one not in taken and other not in found:
            taken.add(one)
            found[other] = Match(one, other, confidence, reason)

    known, wanted = _known_names(source), _known_names(target)
    names, places = ({name: index for name, (index, _) in each.items()} for each in (known, wanted))
    same = tuple(map(_shape, source.joints)) == tuple(map(_shape, target.joints))
    # In skeletons with the same joints every finger is its own pair.
    fingers = (
        {joint: joint for joint in range(len(source))} if same else dict(pair_fingers(source, target, names, places))
    )
    for name, (index, sure) in sorted(wanted.items(), key=lambda item: item[1][0]):
        if name in known and (not is_finger(name) or fingers.get(known[name][0]) == index):
            confidence = min(sure, known[name][1])
            add(
                known[name][0],
                index,
                confidence,
                "both are called so in MCML" if confidence == 1 else f"both are {name}",
            )
    for own, matching in () if same else fingers.items():
        add(own, matching, 0.9, "the same joint of the same finger")
    by_key: dict[str, int] = {}
    for index, joint in enumerate(source.joints):
        by_key.setdefault(_key(joint), index)
    for index, joint in enumerate(target.joints):
        if same:
            add(index, index, 1.0, "the two skeletons have the same joints")
        elif _key(joint) in by_key:
            add(by_key[_key(joint)], index, 0.9, "their files call them so")
    for pair in _STAND_INS:
        for one, other in (pair, pair[::-1]):
            for side in ("left", "right") if "*" in one else ("",):
                here, there = names.get(one.replace("*", side)), places.get(other.replace("*", side))
                if here is not None and there is not None and _fits(source, target, here, there, found):
                    add(here, there, 0.6, "the nearest of the same limb")
    return tuple(_weighed(source, target, found[index], found) for index in sorted(found))


def _known_names(skeleton: Skeleton) -> dict[str, tuple[int, float]]:
    """Return MCML's names of joints with their confidence: existing names, then recognised ones."""
    names = {
        joint.name: (index, 1.0 if joint.confidence is None else float(joint.confidence))
        for index, joint in enumerate(skeleton.joints)
        if joint.mapped
    }
    taken = {index for index, _ in names.values()}
    for each in recognise_skeleton(skeleton).joints:
        if each.joint not in taken and each.name not in names:
            names[each.name] = (each.joint, each.confidence)
    return names


def check_matches(source: Skeleton, target: Skeleton, matches: Sequence[Match]) -> None:
    """Raises ConversionError for joints that do not exist and for a target that is named twice."""
    seen: set[int] = set()
    for match in matches:
        if not (0 <= match.source < len(source) and 0 <= match.target < len(target)):
            raise ConversionError("the mapping names a joint that is not there", remedy="Take names of both skeletons.")
        if match.target in seen:
            name = target.joints[match.target].name
            raise ConversionError(f"the mapping names {name!r} twice", remedy="Give each joint one source.")
        seen.add(match.target)


def _key(joint: Joint) -> str:
    return re.sub(r"[\W_]+", "", joint.source_name.rpartition(":")[2].lower())


def _shape(joint: Joint) -> tuple[str, int]:
    return joint.source_name, joint.parent


def _above(skeleton: Skeleton, index: int, chosen: set[int]) -> int:
    """The nearest joint above that is one of `chosen`, -1 for none."""
    parent = skeleton.joints[index].parent
    while parent >= 0 and parent not in chosen:
        parent = skeleton.joints[parent].parent
    return parent


def _fits(source: Skeleton, target: Skeleton, one: int, other: int, found: dict[int, Match]) -> bool:
    """Whether matched joints above both are a match of each other."""
    above = _above(target, other, set(found))
    return above < 0 or found[above].source == _above(source, one, {match.source for match in found.values()})


def _weighed(source: Skeleton, target: Skeleton, match: Match, found: dict[int, Match]) -> Match:
    if _fits(source, target, match.source, match.target, found):
        return match
    return Match(match.source, match.target, match.confidence / 2, f"{match.reason}, but they hang elsewhere")
