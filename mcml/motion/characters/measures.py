"""The measures of a person: joints by their meaning, the directions of the body, and its height."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.anatomy.axes import Stance
from mcml.motion.skeleton import Array, Convention, Skeleton

SIDES = ("left", "right")
_CORE = ("up_arm", "low_arm", "up_leg", "low_leg", "foot")
_NECK = ("neck2", "neck1")
"""The joints of the neck, the lower one first."""
_LEG, _TRUNK = 0.491, 0.288
"""Hip to ankle, and hips to shoulders, of the height of a person (Winter 2009, Biomechanics and Motor Control of Human
Movement, figure 4.1)."""
_REMEDY = "Name its joints; until then it is shown as sticks."


@dataclass(frozen=True, eq=False)
class Person:
    """A person in a reference pose, in the clip's unit and axes.

    parents: (J,) of joints, -1 at a root. at: joints by MCML's names. places: (J, 3). tips: joint and place (3,) of the
    ends of chains. left, up, on: unit vectors (3,) of the body. height: of a person of these legs and this trunk.
    """

    parents: Sequence[int]
    at: Mapping[str, int]
    places: Array
    tips: Sequence[tuple[int, Array]]
    left: Array
    up: Array
    on: Array
    height: float

    def place(self, name: str) -> Array:
        """(3,) where a joint is."""
        return np.asarray(self.places[self.at[name]])

    def middle(self, part: str) -> Array:
        """(3,) between the left and the right joint of a name."""
        return np.asarray((self.place(f"left_{part}") + self.place(f"right_{part}")) / 2)

    def above(self, joint: int) -> list[int]:
        """A joint and all above it, the root last."""
        found = []
        while joint >= 0:
            found.append(joint)
            joint = self.parents[joint]
        return found

    def common(self, joints: Sequence[int]) -> int:
        """The lowest joint that is above all of these, or one of them; -1 where they hang from several roots."""
        first, *others = (self.above(joint) for joint in joints)
        return next((joint for joint in first if all(joint in other for other in others)), -1)

    def path(self, top: int, end: int) -> list[int]:
        """The joints from one to another that hangs from it, both included; empty where it does not."""
        line = self.above(end)
        return line[line.index(top) :: -1] if top in line else []

    def below(self, joint: int) -> list[int]:
        """All joints that hang from a joint, itself not included."""
        return [other for other in range(len(self.parents)) if other != joint and joint in self.above(other)]

    def children(self, joint: int) -> list[int]:
        return [other for other, parent in enumerate(self.parents) if parent == joint]

    def neck(self) -> list[int]:
        """The joints of the neck that lead to the head, the lowest first."""
        names = [name for name in _NECK if name in self.at]
        return sorted((self.at[name] for name in names), key=lambda joint: len(self.above(joint)))

    def hand(self, side: str) -> int:
        """The joint at the wrist."""
        return self.at.get(f"{side}_wrist", self.at.get(f"{side}_hand", -1))


def check_joints(skeleton: Skeleton) -> None:
    """Raises ConversionError with the reason where joints that a figure needs are not recognised."""
    if any(joint.convention is Convention.MARKER for joint in skeleton.joints):
        raise ConversionError("Markers have no bones that could carry a body.", remedy="They are shown as points.")
    names = set(skeleton.names)
    missing = [f"{side}_{part}" for part in _CORE for side in SIDES if f"{side}_{part}" not in names]
    missing += [f"{side}_hand" for side in SIDES if not {f"{side}_hand", f"{side}_wrist"} & names]
    missing += [] if {"Head", *_NECK} & names else ["Head"]
    if missing:
        listed = ", ".join(missing[:6]) + (f" and {len(missing) - 6} more" if len(missing) > 6 else "")
        raise ConversionError(f"A body needs joints that are not recognised: {listed}.", remedy=_REMEDY)


def measure_person(skeleton: Skeleton, stance: Stance, tips: Sequence[tuple[int, Array]]) -> Person:
    """Measure a person of a skeleton that has the joints of one.

    stance: the reference pose. tips: joint and place (3,) in it of the ends of chains. Raises ConversionError with the
    reason where joints of a limb are no chain or in one place.
    """
    at = {name: index for index, name in enumerate(skeleton.names)}
    if not np.isfinite(stance.positions).all():
        raise ConversionError("The places of some joints are not known.", remedy=_REMEDY)
    parents = [joint.parent for joint in skeleton.joints]
    person = Person(parents, at, stance.positions, tips, stance.left, stance.up, stance.on, 1.0)
    _check_limbs(person)
    legs = [person.place(f"{side}_up_leg") - person.place(f"{side}_low_leg") for side in SIDES]
    legs += [person.place(f"{side}_low_leg") - person.place(f"{side}_foot") for side in SIDES]
    leg = sum(float(np.linalg.norm(bone)) for bone in legs) / 2
    trunk = float(np.linalg.norm(person.middle("up_arm") - person.middle("up_leg")))
    if not leg > 0 or not trunk > 0.05 * leg:
        raise ConversionError("The joints of the legs or of the trunk are in one place.", remedy=_REMEDY)
    height = (leg / _LEG + trunk / _TRUNK) / 2
    return Person(parents, at, stance.positions, tips, stance.left, stance.up, stance.on, height)


def _check_limbs(person: Person) -> None:
    """Raises ConversionError where joints of a limb do not hang from each other, or are in one place."""
    for side in SIDES:
        hand = person.hand(side)
        for limb, joints in (
            ("arm", [person.at[f"{side}_up_arm"], person.at[f"{side}_low_arm"], hand]),
            ("leg", [person.at[f"{side}_{part}"] for part in ("up_leg", "low_leg", "foot")]),
        ):
            for upper, lower in itertools.pairwise(joints):
                if not person.path(upper, lower):
                    raise ConversionError(f"The joints of the {side} {limb} are no chain.", remedy=_REMEDY)
                if not np.linalg.norm(person.places[upper] - person.places[lower]) > 0:
                    raise ConversionError(f"Joints of the {side} {limb} are in one place.", remedy=_REMEDY)
    hips = [person.at[f"{side}_up_leg"] for side in SIDES]
    arms = [person.at[f"{side}_up_arm"] for side in SIDES]
    if min(person.common(hips), person.common(arms), person.common([*hips, *arms])) < 0:
        raise ConversionError("Arms and legs hang from different roots.", remedy=_REMEDY)
