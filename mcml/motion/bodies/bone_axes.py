"""The line to the left of thighs and shanks, constant in each bone: the zero of turns about it, and the sign of knees.

It comes from the reference pose of the skeleton, if that is a rest pose in which a body could stand, or a person chose
it. Otherwise the knee itself tells: most rigs bend it about one axis, which any stretch of any clip shows. That axis is
pooled over clips of the skeleton and kept with its reference, so that all of them, and all cuts, have the same zero. A
knee without one axis leaves the most upright frame. Of markers, the lateral one of a knee and its centre tell; those of
the pelvis and of a foot also tell where they point forwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.anatomy.axes import Stance
from mcml.motion.bodies.positions import Steps, rounded, world_directions
from mcml.motion.bodies.reference import DECIMALS, stance_of
from mcml.motion.clip import Reference
from mcml.motion.landmarks.centres import bodies_of, body_names, centres_of
from mcml.motion.rotations import inverse, multiply, rotate, to_matrix
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import Reading
from mcml.motion.vectors import angle_between, cross, dot, unit

SIDES: Final = ("left", "right")
HIPS: Final = ("left_up_leg", "right_up_leg")
BONES: Final[Mapping[str, tuple[str, str]]] = {
    f"{side}_{bone}": (f"{side}_{end}", f"{side}_{landmark}")
    for side in SIDES
    for bone, end, landmark in (("up_leg", "low_leg", "knee"), ("low_leg", "foot", "ankle"))
}
"""Joint at the upper end of a bone: joint at its lower end, and the beginning of the names of landmarks there."""
PELVIS: Final = "Root"
FORWARD: Final = " forward"
"""End of the name of a line forwards, of markers: "Root forward", "left_foot forward"."""

_SPINES: Final = ("left_asis", "right_asis")
_MARKER_LINES: Final[Mapping[str, tuple[tuple[str, ...], ...]]] = {
    PELVIS: (_SPINES,),
    f"{PELVIS}{FORWARD}": ((*_SPINES, "left_psis", "right_psis"), (*_SPINES, "sacrum", "sacrum")),
    **{f"{side}_foot{FORWARD}": ((f"{side}_mt2", f"{side}_heel"),) for side in SIDES},
}
"""Lines of landmarks: the ways to make each, as `BoneAxis.across` has them, the best first."""

MARKER_ZEROS: Final[Mapping[str, str]] = {"pelvis": f"{PELVIS}{FORWARD}"} | {
    f"{side}_foot": f"{side}_foot{FORWARD}" for side in SIDES
}
"""Constants of a standing body, by their names in a calibration, that are 0 where a line of landmarks is known."""

BENT: Final = 20.0
"""Degrees of flexion from which a knee shows its axis."""
ONE_AXIS: Final = 6.0
"""Degrees (rms) between the axis of a knee and its single bends up to which it is one axis."""
LINE: Final = 10_000
"""Steps of a unit vector to the left of a bone: rounding turns it by at most 0.005 degrees."""
FIRM: Final = np.cos(np.radians(30.0))
"""Cosine between a bone and its direction by its rotation below which rotations and positions contradict each other."""


@dataclass(frozen=True)
class BoneAxis:
    """Where a bone's line to its left comes from.

    origin: "rest" (pose in which a body could stand), "hinge", "pose" (most upright frame, or a frame that people
    chose) or "markers". left, along: (3,) unit vectors to the left and along the bone, in the bone, in the axes of
    rest; (0, 0, 0) of markers. across: points of a body; the line is from the middle of the second half of them to that
    of the first half; none of others.
    """

    origin: str
    left: tuple[float, ...] = (0.0, 0.0, 0.0)
    along: tuple[float, ...] = (0.0, 0.0, 0.0)
    across: tuple[str, ...] = ()

    def to_json(self) -> list[Any]:
        """Plain values for JSON."""
        return [self.origin, list(self.left), list(self.along), list(self.across)]

    @classmethod
    def from_json(cls, values: list[Any]) -> BoneAxis:
        """Read the output of `to_json`."""
        origin, left, along, across = values
        return cls(origin, tuple(left), tuple(along), tuple(across))


@dataclass(frozen=True, eq=False)
class HingeSums:
    """Sums over frames, in the axes of rest of a thigh, of which the axis of its knee is made: they add up over clips.

    bends: (3,) of thigh x shank, unit vectors. spread: (3, 3) of products of unit bends beyond BENT with themselves.
    count: of those. across: (3,) to the left hip. shank: (3, 3) of rotations from the thigh's axes to the shank's.
    """

    bends: Array
    spread: Array
    count: int
    across: Array
    shank: Array

    def __add__(self, other: HingeSums) -> HingeSums:
        return HingeSums(
            self.bends + other.bends,
            self.spread + other.spread,
            self.count + other.count,
            self.across + other.across,
            self.shank + other.shank,
        )

    def axis(self) -> tuple[Array, float] | None:
        """(3,) unit vector to the left, and its rms angle in degrees to single bends; None for a knee without one."""
        size = float(np.linalg.norm(self.bends))
        if not self.count or not size > 0:
            return None
        axis = self.bends / size
        if axis @ self.across < 0:
            axis = -axis
        sine = 1.0 - float(axis @ self.spread @ axis) / self.count
        rms = float(np.degrees(np.arcsin(np.sqrt(np.clip(sine, 0.0, 1.0)))))
        return (axis, rms) if rms <= ONE_AXIS else None


def has_rotations(skeleton: Skeleton, name: str) -> bool:
    """Tell whether a joint is in a skeleton and has channels of rotation."""
    return name in skeleton.names and any(
        channel[0] == "R" for channel in skeleton.joints[skeleton.names.index(name)].channels
    )


def sum_hinges(skeleton: Skeleton, positions: Array, rotations: Array) -> dict[str, HingeSums]:
    """Sum the directions in which knees bend in some frames, by the names of thighs.

    positions: (n, J, 3), NaN where unknown; rotations: (n, J, 4) from rest, in the world.
    """
    places = {name: index for index, name in enumerate(skeleton.names)}
    found: dict[str, HingeSums] = {}
    for side in SIDES:
        hip, knee, ankle = names = f"{side}_up_leg", f"{side}_low_leg", f"{side}_foot"
        if not all(name in places for name in (*names, *HIPS)) or not has_rotations(skeleton, hip):
            continue
        thigh = unit(positions[:, places[knee]] - positions[:, places[hip]])
        shank = unit(positions[:, places[ankle]] - positions[:, places[knee]])
        across = unit(positions[:, places[HIPS[0]]] - positions[:, places[HIPS[1]]])
        seen = np.isfinite(thigh + shank + across).all(axis=1)
        thigh, shank, across = thigh[seen], shank[seen], across[seen]
        turn, low = rotations[seen, places[hip]], rotations[seen, places[knee]]
        bends = rotate(inverse(turn), cross(thigh, shank))
        single = unit(bends[angle_between(thigh, shank) > BENT])
        found[hip] = HingeSums(
            bends.sum(axis=0),
            single.T @ single,
            len(single),
            rotate(inverse(turn), across).sum(axis=0),
            to_matrix(multiply(inverse(low), turn)).sum(axis=0),
        )
    return found


def pool_hinges(clips: Iterable[Mapping[str, HingeSums]]) -> dict[str, tuple[float, ...]]:
    """The line to the left of thighs and shanks whose knees have an axis, x y z, and its rms angle to single bends.

    clips: sums of some clips of a skeleton. A knee that bends about one axis within ONE_AXIS has one.
    """
    pooled: dict[str, HingeSums] = {}
    for sums in clips:
        for name, own in sums.items():
            pooled[name] = pooled[name] + own if name in pooled else own
    found: dict[str, tuple[float, ...]] = {}
    for name, whole in pooled.items():
        if (told := whole.axis()) is not None:
            axis, rms = told
            shank = whole.shank @ axis
            low = BONES[name][0]
            for bone, left in ((name, axis), (low, shank)):
                size = float(np.linalg.norm(left))
                if size > 0:
                    found[bone] = (*np.round(left / size, DECIMALS).tolist(), round(rms, DECIMALS))
    return found


def bone_axes(skeleton: Skeleton, reading: Reading, start: Reference, *, chosen: bool = False) -> dict[str, BoneAxis]:
    """The bones of a body whose line to the left is known, by the names of their upper joints.

    start: the reference of its skeleton. chosen: whether a person set it, so that it counts before hinges.
    """
    found = _of_markers(skeleton)
    stance: Stance | None = None
    # If left and right are unknown, no rotation has a zero.
    with suppress(ConversionError):
        stance = stance_of(start, skeleton, reading)
    if stance is None:
        return found
    places = {name: index for index, name in enumerate(skeleton.names)}
    for bone, (end, _) in BONES.items():
        if not has_rotations(skeleton, bone) or end not in places:
            continue
        back = inverse(stance.turned[places[bone]])
        along = stance.positions[places[end]] - stance.positions[places[bone]]
        size = float(np.linalg.norm(along))
        if not size > 0:
            continue
        hinge = None if chosen else start.hinges.get(bone)
        left = rotate(back, stance.left) if hinge is None else np.array(hinge[:3])
        origin = "hinge" if hinge is not None else "rest" if start.pose is None else "pose"
        told = (np.round(vector, DECIMALS).tolist() for vector in (left, rotate(back, along / size)))
        found[bone] = BoneAxis(origin, *map(tuple, told))
    return found


def _of_markers(skeleton: Skeleton) -> dict[str, BoneAxis]:
    """The bones of the people whose markers a skeleton has; names of several begin with the prefix of their markers."""
    bodies = bodies_of(skeleton)
    found: dict[str, BoneAxis] = {}
    for body in bodies:
        begin = f"{body.prefix}:" if body.prefix and len(bodies) > 1 else ""
        markers = {landmark: skeleton.names[index] for index, landmark in body.landmarks.items()}
        found |= {begin + bone: axis for bone, axis in _of_person(skeleton, markers, begin).items()}
    return found


def _of_person(skeleton: Skeleton, markers: Mapping[str, str], begin: str) -> dict[str, BoneAxis]:
    """The bones of a person. markers: by landmark. begin: of the names of the person's centres."""
    found: dict[str, BoneAxis] = {}
    guesses = {centre.name for centre in centres_of(skeleton) if centre.is_guess}
    for bone, (end, landmark) in BONES.items():
        centre = begin + end
        known = centre if centre in body_names(skeleton) and centre not in guesses else None
        inner = markers.get(f"{landmark}_medial", known)
        if inner is not None and f"{landmark}_lateral" in markers:
            outer = markers[f"{landmark}_lateral"]
            found[bone] = BoneAxis("markers", across=(outer, inner) if bone.startswith("left") else (inner, outer))
    for bone, ways in _MARKER_LINES.items():
        way = next((way for way in ways if all(landmark in markers for landmark in way)), None)
        if way is not None:
            found[bone] = BoneAxis("markers", across=tuple(markers[landmark] for landmark in way))
    return found


def line_of(bone: str) -> str:
    """The name under which a body has a bone's line to the left, or a line forwards, beside positions of joints."""
    return bone if bone.endswith(FORWARD) else f"{bone} left"


def line_steps(
    skeleton: Skeleton, bones: Mapping[str, BoneAxis], positions: Array, values: Array | None, reading: Reading
) -> tuple[tuple[str, ...], Steps]:
    """Names and unit vectors in the world (n, bones, 3) of lines to the left of bones, as whole numbers of 1 / LINE.

    positions: (n, J + C, 3) of the points of `body_names`, NaN where unknown. values: (n, D) of the skeleton's columns,
    None for positions alone. UNSEEN where a sample that a line depends on is missing, or rotations and positions of a
    bone contradict each other.
    """
    at = {name: index for index, name in enumerate(body_names(skeleton))}
    known = {bone: axis for bone, axis in bones.items() if axis.origin == "markers" or values is not None}
    found = np.empty((len(positions), len(known), 3))
    turned = [(place, bone, axis) for place, (bone, axis) in enumerate(known.items()) if axis.origin != "markers"]
    fixed = [(at[bone], np.array(told)) for _, bone, axis in turned for told in (axis.left, axis.along)]
    if values is not None and fixed:
        directions = world_directions(skeleton, values, fixed, reading)
        for row, (place, bone, _) in enumerate(turned):
            found[:, place] = directions[:, 2 * row]
            along = unit(positions[:, at[BONES[bone][0]]] - positions[:, at[bone]])
            # NaN is not above anything either.
            found[~(dot(directions[:, 2 * row + 1], along) > FIRM), place] = np.nan
    for place, axis in enumerate(known.values()):
        if axis.origin == "markers":
            ends = positions[:, [at[marker] for marker in axis.across]]
            half = len(axis.across) // 2
            found[:, place] = unit(ends[:, :half].mean(axis=1) - ends[:, half:].mean(axis=1))
    return tuple(map(line_of, known)), rounded(found, 1.0 / LINE)
