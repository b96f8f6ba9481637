"""Bodies that are no person's, though their joints have a person's words: by names, and by how the rest pose stands.

Their joints get no names of MCML: a dog's front paw is no hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from mcml.motion.kinematics import rest_positions
from mcml.motion.skeleton import Array, Skeleton

NOT_A_PERSON = "not a person"

_LEGS = frozenset(
    ["leg", "legs", "foot", "feet", "thigh", "shin", "calf", "toe", "toes", "femur", "tibia", "hoof", "paw"]
)
_LIMBS = _LEGS | frozenset(["hip", "knee", "ankle", "shoulder", "upper", "lower"])
_REAR = frozenset({"hind", "rear", "back"})
_ANIMAL = frozenset(
    ["paw", "paws", "hoof", "hooves", "snout", "beak", "muzzle", "hindleg", "hindfoot", "hindpaw", "horselink"]
)
_FRONT, _HIND = ("fl", "fr"), ("rl", "rr", "bl", "br", "hl", "hr")
_AWAY = frozenset({"tail", "wing", "wings"})
_LYING = 45.0, 135.0
"""Degrees between the trunk and the legs of a body that stands on four."""
_FOREMOST = 0.45, 50.0
"""How long arms are at least that are legs, in parts of the legs, and the degrees from the direction of these."""


def not_a_person(skeleton: Skeleton, given: Mapping[int, str]) -> str | None:
    """Why a body is no person's; None where nothing says so. given: the names of MCML that its joints would get."""
    words = [_words(joint.source_name) for joint in skeleton.joints]
    every: frozenset[str] = frozenset().union(*words)
    for joint, own in zip(skeleton.joints, words, strict=True):
        if own & _ANIMAL or (own & _REAR and own & _LEGS):
            return f"it has {joint.source_name!r}"
    limbs: frozenset[str] = frozenset().union(*(own for own in words if own & _LIMBS))
    if set(_FRONT) <= limbs and sum(word in limbs for word in _HIND) >= 2:
        return "its legs are in front and behind"
    parts = {name.partition("_")[2] for name in given.values() if name.startswith(("left_", "right_"))}
    if every & _AWAY and parts & {"up_leg", "low_leg"} and parts.isdisjoint({"up_arm", "low_arm", "hand"}):
        return "it has a tail or wings, and no arms"
    if _stands_on_four({name: index for index, name in given.items()}, skeleton, bool(every & _AWAY)):
        return "its trunk lies over its legs in the rest pose"
    return None


def _words(name: str) -> frozenset[str]:
    """The words of a name, in small letters."""
    bare = name.rpartition(":")[2]
    parts = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|(?<=[A-Za-z])(?=[0-9])", " ", bare)
    return frozenset(re.split(r"[\W_]+", parts.lower())) - {""}


def _stands_on_four(at: Mapping[str, int], skeleton: Skeleton, has_tail: bool) -> bool:
    trunk_end = next((name for name in ("Head", "neck1", "torso7") if name in at), None)
    if "Root" not in at or trunk_end is None:
        return False
    rest = rest_positions(skeleton)

    def limb(starts: tuple[str, ...], ends: tuple[str, ...]) -> Array | None:
        """The mean of both sides, (3,)."""
        found = []
        for side in ("left", "right"):
            start = next((at[f"{side}_{part}"] for part in starts if f"{side}_{part}" in at), None)
            end = next((at[f"{side}_{part}"] for part in ends if f"{side}_{part}" in at), None)
            if start is None or end is None or start == end:
                return None
            found.append(rest[end] - rest[start])
        mean: Array = np.mean(found, axis=0)
        return mean

    trunk = rest[at[trunk_end]] - rest[at["Root"]]
    legs = limb(("up_leg", "low_leg"), ("foot", "toes", "low_leg"))
    if legs is None or not _LYING[0] <= _degrees(trunk, legs) <= _LYING[1]:
        return False
    if has_tail:
        return True
    arms = limb(("up_arm", "shoulder", "low_arm"), ("hand", "wrist", "low_arm"))
    share, apart = _FOREMOST
    return (
        arms is not None
        and float(np.linalg.norm(arms)) >= share * float(np.linalg.norm(legs))
        and _degrees(arms, legs) <= apart
    )


def _degrees(one: Array, other: Array) -> float:
    """Between two vectors (3,); NaN where one has no length."""
    lengths = float(np.linalg.norm(one) * np.linalg.norm(other))
    if not 0 < lengths < np.inf:
        return float("nan")
    return float(np.degrees(np.arccos(np.clip(one @ other / lengths, -1.0, 1.0))))
