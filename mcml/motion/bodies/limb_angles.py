"""Angles of the body by the names of its movements, from positions of joints: no rig's axes, no rest pose.

Hinges are angles between two bones, and never negative: an elbow bent backwards shows as flexion. Limbs swing relative
to the trunk, as with a goniometer: flexion about the line from right to left, abduction about the one from back to
front, each by the bone's projection on the perpendicular plane; a bone too near to that line has no such angle. Both
range from -90 to 270 degrees, so that a raised arm does not jump from 180 to -180. Clinical angles, in the pelvis and
signed, are in `pelvis_angles` and `bone_angles`.

The opposite movement has the opposite sign. Names are `[side-]part-movement`, without synonyms.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Final, TypeAlias

import numpy as np

from mcml.errors import UnsupportedError, VocabularyError
from mcml.motion.bodies.bone_angles import (
    measure_hip_rotation,
    measure_knee_flexion,
    measure_knee_rotation,
    measure_knee_varus,
)
from mcml.motion.bodies.bone_axes import FORWARD, line_of
from mcml.motion.bodies.pelvis_angles import (
    PELVIS_BONES,
    PELVIS_NEEDS,
    measure_ankle,
    measure_hip_adduction,
    measure_hip_flexion,
    measure_pelvis_obliquity,
    measure_pelvis_tilt,
)
from mcml.motion.bodies.reference import PELVIS, dorsiflexion_of
from mcml.motion.bodies.stretch import HIPS, NECK, SHOULDERS, Stretch
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, cross, dot, length

AWAY = 0.35
"""Sine of a bone's angle to an axis below which it has no angle about that axis."""
RAISED = 0.7
"""The same for horizontal movements: the limb is lifted by 45 degrees."""

FOREARM_END = "{side}_wrist|{side}_hand"

Measured: TypeAlias = Callable[[Stretch, str], Array]
"""(n,) degrees of a side ("left", "right" or "")."""


@dataclass(frozen=True)
class Angle:
    """An angle of a limb.

    needs: joints, `{side}` for the side, alternatives with `|`. sign: -1 for the opposite movement. bones: whose line
    to the left it takes where the body has one. zero: of a standing body, by its name in a calibration. markers: lines
    that only markers tell, which it takes where the body has them.
    """

    needs: tuple[str, ...]
    measured: Measured
    sign: float = 1.0
    bones: tuple[str, ...] = ()
    zero: str = ""
    markers: tuple[str, ...] = ()

    def joints(self, side: str) -> tuple[str, ...]:
        """The joints that it is measured from."""
        return tuple(one.format(side=side) for one in self.needs)

    def lines(self, side: str) -> tuple[str, ...]:
        """The names of the lines that it takes."""
        return tuple(line_of(bone.format(side=side)) for bone in (*self.bones, *self.markers))

    def anatomy(self, side: str) -> tuple[str, ...]:
        """The bones and the zero that it takes, by their names in a calibration."""
        return tuple(each.format(side=side) for each in (*self.bones, self.zero) if each)

    def compute(self, stretch: Stretch, side: str) -> Array:
        """(n,) degrees, NaN where unknown."""
        degrees: Array = self.sign * self.measured(stretch, side)
        return degrees


def _elbow(stretch: Stretch, side: str) -> Array:
    elbow = f"{side}_low_arm"
    end = FOREARM_END.format(side=side)
    return angle_between(stretch.between(f"{side}_up_arm", elbow), stretch.between(elbow, end))


def _ankle(stretch: Stretch, side: str) -> Array:
    """Return 90 degrees minus the angle between the shank and the line from ankle to toes: a flat foot is below 0,
    because the ankle is higher than the toes (0 to 40 degrees, depending on the rig).
    """
    return dorsiflexion_of(*(stretch.at(f"{side}_{joint}") for joint in ("low_leg", "foot", "toes")))


def about(bone: Array, start: Array, towards: Array, away: float = AWAY) -> Array:
    """Return (n,) degrees from -90 to 270 by which a bone has swung from one direction to another, about the axis
    across both.

    bone: (n, 3). start, towards: (n, 3) unit vectors. NaN where the bone is nearer to the axis than `away` (a sine).
    """
    one, two = dot(bone, start), dot(bone, towards)
    degrees = np.degrees(np.arctan2(two, one))
    degrees = np.where(degrees < -90.0, degrees + 360.0, degrees)
    return np.where(np.hypot(one, two) > away * length(bone), degrees, np.nan)


def _outwards(left: Array, side: str) -> Array:
    return -left if side == "right" else left


@dataclass(frozen=True)
class _Limb:
    """start, end: of its bone, `{side}` for the side. sides: joints whose line defines left."""

    start: str
    end: str
    sides: tuple[str, str]

    @property
    def needs(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((self.start, self.end, *self.sides, *HIPS, NECK)))

    def bone(self, stretch: Stretch, side: str) -> Array:
        return stretch.between(self.start.format(side=side), self.end.format(side=side))

    def flexion(self, stretch: Stretch, side: str) -> Array:
        _, up, on = stretch.trunk_axes(self.sides)
        return about(self.bone(stretch, side), -up, on)

    def abduction(self, stretch: Stretch, side: str) -> Array:
        left, up, _ = stretch.trunk_axes(self.sides)
        return about(self.bone(stretch, side), -up, _outwards(left, side))

    def horizontal_abduction(self, stretch: Stretch, side: str) -> Array:
        """0 where it points on, 90 where it points outwards."""
        left, _, on = stretch.trunk_axes(self.sides)
        return about(self.bone(stretch, side), on, _outwards(left, side), RAISED)


_ARM = _Limb("{side}_up_arm", "{side}_low_arm", SHOULDERS)
_LEG = _Limb("{side}_up_leg", "{side}_low_leg", HIPS)
_TRUNK = (*HIPS, NECK)


def _trunk_flexion(stretch: Stretch, side: str) -> Array:
    """Of the line from between the hips to the neck, from upright, to where the body faces."""
    up = np.broadcast_to(stretch.up, (stretch.frames, 3))
    return about(stretch.at(NECK) - stretch.middle(HIPS), up, cross(stretch.level_left(), up))


def _trunk_to_the_right(stretch: Stretch, side: str) -> Array:
    up = np.broadcast_to(stretch.up, (stretch.frames, 3))
    return about(stretch.at(NECK) - stretch.middle(HIPS), up, -stretch.level_left())


def _trunk_to_the_left_about_itself(stretch: Stretch, side: str) -> Array:
    """Of the line through the shoulders from the one through the hips, about the trunk."""
    left, _, on = stretch.trunk_axes(HIPS)
    shoulders, _, _ = stretch.trunk_axes(SHOULDERS)
    return _within_half_a_turn(about(shoulders, left, -on))


def _within_half_a_turn(degrees: Array) -> Array:
    return np.where(degrees > 180.0, degrees - 360.0, degrees)


def _both_ways(
    part: str,
    movement: str,
    opposite: str,
    needs: tuple[str, ...],
    measured: Measured,
    bones: tuple[str, ...] = (),
    zero: str = "",
    markers: tuple[str, ...] = (),
) -> dict[tuple[str, str], Angle]:
    angle = Angle(needs, measured, 1.0, bones, zero, markers)
    return {(part, movement): angle, (part, opposite): replace(angle, sign=-1.0)}


_THIGH, _SHANK = ("{side}_up_leg",), ("{side}_up_leg", "{side}_low_leg")
_KNEE = ("{side}_up_leg", "{side}_low_leg", "{side}_foot")


ANGLES: Final[Mapping[tuple[str, str], Angle]] = {
    **_both_ways("knee", "flexion", "extension", _KNEE, measure_knee_flexion, _THIGH),
    **_both_ways("elbow", "flexion", "extension", ("{side}_up_arm", "{side}_low_arm", FOREARM_END), _elbow),
    **_both_ways("foot", "dorsiflexion", "plantarflexion", ("{side}_low_leg", "{side}_foot", "{side}_toes"), _ankle),
    **_both_ways("arm", "flexion", "extension", _ARM.needs, _ARM.flexion),
    **_both_ways("arm", "abduction", "adduction", _ARM.needs, _ARM.abduction),
    **_both_ways("arm", "horizontal-abduction", "horizontal-adduction", _ARM.needs, _ARM.horizontal_abduction),
    **_both_ways("leg", "flexion", "extension", _LEG.needs, _LEG.flexion),
    **_both_ways("leg", "abduction", "adduction", _LEG.needs, _LEG.abduction),
    **_both_ways("leg", "horizontal-abduction", "horizontal-adduction", _LEG.needs, _LEG.horizontal_abduction),
    **_both_ways("trunk", "flexion", "extension", _TRUNK, _trunk_flexion),
    **_both_ways("trunk", "right-lateral-flexion", "left-lateral-flexion", _TRUNK, _trunk_to_the_right),
    **_both_ways(
        "trunk", "left-rotation", "right-rotation", (*_TRUNK, *SHOULDERS), _trunk_to_the_left_about_itself
    ),
    **_both_ways("pelvis", "right-lateral-flexion", "left-lateral-flexion", HIPS, measure_pelvis_obliquity),
}  # fmt: skip
"""(part, movement): angles that positions of joints tell, in the vocabulary of motion names."""

_ROTATION = ("internal-rotation", "external-rotation")
_THIGHS, _HIP = (*HIPS, "{side}_low_leg"), (*PELVIS_NEEDS, "{side}_low_leg")
_FOOT_LINE = (f"{{side}}_foot{FORWARD}",)
_FOOT = ("{side}_low_leg", "{side}_foot", "{side}_toes")

CLINICAL: Final[Mapping[tuple[str, str], Angle]] = {
    **_both_ways("hip", "flexion", "extension", _HIP, measure_hip_flexion, (), PELVIS, PELVIS_BONES),
    **_both_ways("hip", "adduction", "abduction", _THIGHS, measure_hip_adduction, markers=PELVIS_BONES),
    **_both_ways("hip", *_ROTATION, _THIGHS, measure_hip_rotation, _THIGH, "", PELVIS_BONES),
    **_both_ways("knee", "varus", "valgus", _KNEE, measure_knee_varus, _THIGH),
    **_both_ways("knee", *_ROTATION, _KNEE, measure_knee_rotation, _SHANK),
    **_both_ways("ankle", "dorsiflexion", "plantarflexion", _FOOT, measure_ankle, (), "{side}_foot", _FOOT_LINE),
    ("pelvis", "tilt"): Angle(PELVIS_NEEDS, measure_pelvis_tilt, zero=PELVIS, markers=PELVIS_BONES),
    ("pelvis", "obliquity"): Angle(HIPS, measure_pelvis_obliquity, markers=PELVIS_BONES),
}  # fmt: skip
"""(part, movement): clinical angles beside the vocabulary of motion names."""

_GONIOMETER: Final[Mapping[str, str]] = {
    "leg-flexion": "hip-flexion",
    "leg-extension": "hip-extension",
    "leg-abduction": "hip-abduction",
    "leg-adduction": "hip-adduction",
    "leg-medial-rotation": "hip-internal-rotation",
    "leg-lateral-rotation": "hip-external-rotation",
    "knee-medial-rotation": "knee-internal-rotation",
    "knee-lateral-rotation": "knee-external-rotation",
    "foot-dorsiflexion": "ankle-dorsiflexion",
    "foot-plantarflexion": "ankle-plantarflexion",
}
"""Angles of legs as with a goniometer, or by twist: the clinical angle of the same movement."""

_BENDING = ("flexion", "extension")
_FINGERS = ("thumb", "finger-two", "finger-four", "finger-five")
_TOES = ("toes", "toe-one", "toe-two", "toe-three", "toe-four", "toe-five")
_UPRIGHT = (*_BENDING, "left-rotation", "right-rotation", "left-lateral-flexion", "right-lateral-flexion")

NEEDS_ROTATIONS: Final[Mapping[str, tuple[str, ...]]] = {
    "head": _UPRIGHT,
    "neck": _UPRIGHT,
    "pelvis": ("anterior-tilt", "posterior-tilt", "left-rotation", "right-rotation"),
    "shoulder": ("elevation", "depression", "protraction", "retraction"),
    "arm": ("medial-rotation", "lateral-rotation"),
    "forearm": ("pronation", "supination"),
    "wrist": (*_BENDING, "abduction", "adduction"),
    **dict.fromkeys(_FINGERS, (*_BENDING, "abduction", "adduction")),
    **dict.fromkeys(("fingers", "finger-three"), _BENDING),
    "leg": ("medial-rotation", "lateral-rotation"),
    "knee": ("medial-rotation", "lateral-rotation"),
    "foot": ("inversion", "eversion"),
    **dict.fromkeys(_TOES, _BENDING),
}
"""By part, movements whose angles positions do not tell: turns of a bone about itself, and parts whose place at rest
differs between rigs. They take rotations from the reference pose: `turned_angles`."""

_MIDDLE = ("trunk", "pelvis", "head", "neck")


def _named(part: str, movement: str) -> list[tuple[str, str]]:
    """(name, side) of a movement."""
    sides = ("",) if part in _MIDDLE else ("left", "right")
    return [("-".join(word for word in (side, part, movement) if word), side) for side in sides]


_BY_NAME = {name: (angle, side) for key, angle in {**ANGLES, **CLINICAL}.items() for name, side in _named(*key)}
_TURNED = {
    name: (part, side, movement)
    for part, movements in NEEDS_ROTATIONS.items()
    for movement in movements
    for name, side in _named(part, movement)
}


def angle_names() -> list[str]:
    """All names of angles."""
    return [*_BY_NAME, *_TURNED]


def clinical_name(name: str) -> str | None:
    """The clinical angle of the movement of a goniometer's angle, such as `left-hip-flexion` for `left-leg-flexion`;
    None for others."""
    side, _, rest = name.partition("-")
    if name == "pelvis-anterior-tilt":
        return "pelvis-tilt"
    return f"{side}-{_GONIOMETER[rest]}" if side in ("left", "right") and rest in _GONIOMETER else None


def anatomy_of(name: str) -> tuple[str, ...]:
    """The bones whose line to the left an angle takes, and the zero of a standing body, by their names in a
    calibration; of unknown names none."""
    angle, side = _BY_NAME.get(name, (None, ""))
    return () if angle is None else angle.anatomy(side)


def turn_named(name: str) -> tuple[str, str, str] | None:
    """(part, side, movement) of the name of an angle that needs rotations, None for others."""
    return _TURNED.get(name)


def angle_named(name: str) -> tuple[Angle, str]:
    """The angle and the side of a name such as `left-knee-flexion`.

    Raises UnsupportedError for one that positions do not decide, VocabularyError for an unknown one.
    """
    if name in _TURNED:
        raise UnsupportedError(
            f"{name} cannot be measured from positions alone: it takes rotations",
            remedy="Ask for an angle between joints, or for the channels of the joint.",
        )
    if name not in _BY_NAME:
        near = get_close_matches(name, angle_names(), 3)
        raise VocabularyError(
            f"{name!r} is not the name of an angle",
            remedy=f"Did you mean {' or '.join(near)}?" if near else "Name one such as left-knee-flexion.",
        )
    return _BY_NAME[name]
