"""The figure of this project: a calm mannequin of a few thousand triangles, made to the measure of a person's rig.

Its shape is a table of half-axes in body heights along the lines between joints, after the breadths and girths of
adults (NASA-STD-3000 volume I, 1995, section 3; Winter 2009, figure 4.1). Bones of limbs have the rig's own lengths.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.anatomy.axes import Stance
from mcml.motion.bodies.reference import stance_of
from mcml.motion.characters.extremities import make_foot, make_hand
from mcml.motion.characters.measures import SIDES, Person, check_joints, measure_person
from mcml.motion.characters.surfaces import Drive, Line, Rings, Surface, axes_along, join, make_surface, vertex_normals
from mcml.motion.clip import Reference
from mcml.motion.hub import Rest, rest_of
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.skin import Character
from mcml.motion.units import Reading

_LEG = (
    (0, -0.70, 0.000, 0.000), (0, -0.60, 0.030, 0.030), (0, -0.36, 0.046, 0.046), (0, 0.00, 0.052, 0.054),
    (0, 0.25, 0.049, 0.053), (0, 0.55, 0.041, 0.045), (0, 0.82, 0.033, 0.036), (1, 0.00, 0.0300, 0.0330),
    (1, 0.12, 0.0285, 0.0320), (1, 0.30, 0.0305, 0.0350), (1, 0.50, 0.0270, 0.0310), (1, 0.75, 0.0200, 0.0230),
    (1, 0.93, 0.0185, 0.0205), (1, 1.00, 0.0185, 0.0205), (1, 1.05, 0.0120, 0.0140), (1, 1.07, 0.000, 0.000),
)  # fmt: skip
_ARM = (
    (0, -0.80, 0.000, 0.000), (0, -0.68, 0.017, 0.017), (0, -0.38, 0.029, 0.029), (0, 0.00, 0.034, 0.034),
    (0, 0.22, 0.032, 0.032), (0, 0.50, 0.0275, 0.0275), (0, 0.82, 0.0225, 0.0230), (1, 0.00, 0.0220, 0.0215),
    (1, 0.12, 0.0225, 0.0225), (1, 0.28, 0.0235, 0.0220), (1, 0.60, 0.0185, 0.0170), (1, 0.90, 0.0150, 0.0125),
    (1, 1.00, 0.0145, 0.0120), (1, 1.06, 0.0110, 0.0090), (1, 1.09, 0.000, 0.000),
)  # fmt: skip
"""Rings of a limb: its upper or its lower bone, the part of that bone (negative: of the limb's half-axis at its start,
before it), and both half-axes in body heights; of legs across and ahead, of arms ahead and up in a T-pose."""
_TRUNK = (
    (-0.34, 0.000, 0.000, 0.000), (-0.31, 0.032, 0.034, 0.000), (-0.23, 0.070, 0.056, -0.002),
    (-0.10, 0.091, 0.066, -0.005), (0.05, 0.090, 0.065, -0.005), (0.20, 0.080, 0.057, 0.000),
    (0.36, 0.0735, 0.052, 0.002), (0.50, 0.0745, 0.053, 0.001), (0.66, 0.0835, 0.060, 0.000),
    (0.82, 0.0925, 0.064, -0.001), (0.94, 0.0925, 0.060, -0.004), (1.03, 0.078, 0.050, -0.007),
    (1.10, 0.055, 0.040, -0.008), (1.16, 0.034, 0.031, -0.006), (1.20, 0.000, 0.000, -0.004),
)  # fmt: skip
"""Rings of the trunk: part of the line from the middle of the hips to that of the shoulders, half-axes across and
ahead, and how far ahead of the line, in body heights."""
_HIPS, _SHOULDERS = 0.050, 0.100
"""Half the distances between the hips and between the shoulders that the table is made for."""
_HEAD = (
    (0.00, 0.00, 0.00, 0.020), (0.03, 0.42, 0.38, 0.019), (0.14, 0.66, 0.66, 0.015), (0.28, 0.83, 0.84, 0.011),
    (0.42, 0.94, 0.94, 0.008), (0.56, 1.00, 1.00, 0.006), (0.70, 0.99, 1.00, 0.004), (0.82, 0.88, 0.90, 0.003),
    (0.92, 0.64, 0.67, 0.003), (0.98, 0.32, 0.34, 0.003), (1.00, 0.00, 0.00, 0.003),
)  # fmt: skip
"""Rings of the head: part of its height from chin to crown, half-axes of its widest, and how far ahead of its joint."""
_HEAD_HEIGHT, _HEAD_WIDTH, _HEAD_DEPTH = 0.134, 0.0455, 0.0560
_CHIN = 0.022
"""How far the chin is below the joint of the head."""
_NOSE = 0.35, 0.60, 0.010
"""Between which parts of the head's height the nose is, and how far it stands out."""
_ABOVE_SHOULDERS = 0.062
"""How far the joint of a head is above the line between the shoulders at least: rigs without a neck have it lower."""
_NECK = 0.0315, 0.0335
_SHORT = 0.42
"""Part of the shorter bone at a joint, on either side, whose weights change from one bone to the next at most."""


def bind_character(skeleton: Skeleton, reading: Reading, reference: Reference) -> Character:
    """The figure to the measure of a rig, in the reference pose of its calibration.

    Raises ConversionError with the reason where joints that it needs are not recognised, or that pose is not known.
    """
    check_joints(skeleton)
    stance = stance_of(reference, skeleton, reading)
    if stance is None:
        raise ConversionError("The reference pose of the body is not known.", remedy="Set it: `mcml calibrate`.")
    return make_character(skeleton, rest_of(skeleton, reading), stance)


def make_character(skeleton: Skeleton, rest: Rest, stance: Stance) -> Character:
    """The figure to the measure of a rig, in a pose in which the body stands.

    skeleton: one that `check_joints` accepts. Raises ConversionError with the reason where joints of a limb are no
    chain or in one place.
    """
    tips = [(joint, stance.positions[joint] + rotate(stance.turned[joint], vector)) for joint, vector in rest.tips]
    person = measure_person(skeleton, stance, tips)
    parts = [_trunk(person), _neck(person), _head(person)]
    for side in SIDES:
        parts += [_limb(person, side, "leg"), _limb(person, side, "arm"), _collar(person, side)]
        parts += [make_foot(person, side), *make_hand(person, side)]
    whole = join(parts)
    normals = vertex_normals(whole.points, whole.faces)
    return Character(
        whole.points, normals, whole.faces, whole.joints, whole.weights, stance.positions, stance.turned
    )  # fmt: skip


def _limb(person: Person, side: str, limb: str) -> Surface:
    """An arm or a leg, from its first joint to the wrist or the ankle."""
    table = _LEG if limb == "leg" else _ARM
    upper, lower = person.at[f"{side}_up_{limb}"], person.at[f"{side}_low_{limb}"]
    end = person.at[f"{side}_foot"] if limb == "leg" else person.hand(side)
    joints = [*person.path(upper, lower), *person.path(lower, end)[1:]]
    line = Line(person.places[joints])
    lengths = line.lengths
    bend = float(lengths[joints.index(lower)])
    widest = person.height * max(row[2] for row in table)
    along = np.array([
        part * widest if part < 0 else part * bend if not bone else bend + part * (lengths[-1] - bend)
        for bone, part, _, _ in table
    ])  # fmt: skip
    outwards = person.left if side == "left" else -person.left
    usual, across = (-person.up, person.left) if limb == "leg" else (outwards, person.on)
    if limb == "arm" and side == "left":
        across = -across
    first, second = axes_along(line.headings(along, widest), usual, across)
    widths, depths = (person.height * np.array([row[column] for row in table]) for column in (2, 3))
    drive = _drive(person, joints, lengths, widest)
    return make_surface(Rings(line.at(along), first, second, widths, depths, along), drive, 14 if limb == "leg" else 12)


def _drive(person: Person, joints: Sequence[int], starts: Array, width: float) -> Drive:
    """The joints of a line, after the one above the first, which the line comes out of."""
    above = person.parents[joints[0]]
    steps = np.diff(starts)
    bones = np.array([max(float(step), 1e-12) for step in steps])
    before, after = np.concatenate([[width], bones]), np.concatenate([bones, [width]])
    widths = np.minimum(1.6 * width, 2 * _SHORT * np.minimum(before, after))
    if above < 0:
        return Drive(tuple(joints), starts, widths)
    return Drive((above, *joints), np.concatenate([[-np.inf], starts]), np.concatenate([[1.0], widths]))


def _axis(person: Person) -> tuple[Array, Array, Array, Array, float]:
    """Of the trunk its start between the hips, the directions up, across and ahead (3,), and its length."""
    start, end = person.middle("up_leg"), person.middle("up_arm")
    length = float(np.linalg.norm(end - start))
    up = (end - start) / length
    across = person.left - (person.left @ up) * up
    across /= np.linalg.norm(across)
    return start, up, across, np.cross(across, up), length


def _chest(person: Person) -> int:
    """The joint that both arms hang from."""
    return person.common([person.at[f"{side}_up_arm"] for side in SIDES])


def _trunk(person: Person) -> Surface:
    start, up, across, ahead, length = _axis(person)
    table = np.array(_TRUNK)
    along = table[:, 0] * length
    wide, narrow = (
        float(np.linalg.norm(person.place(f"left_{part}") - person.place(f"right_{part}"))) / 2
        for part in ("up_arm", "up_leg")
    )
    # The rig's own breadth of hips and shoulders, as far as it is a person's.
    hips = np.clip(narrow / person.height / _HIPS, 0.85, 1.35)
    shoulders = np.clip(wide / person.height / _SHOULDERS, 0.85, 1.35)
    breadth = np.interp(table[:, 0], [0.0, 0.4, 0.9], [hips, (hips + shoulders) / 2, shoulders])
    rings = Rings(
        start + along[:, None] * up + person.height * table[:, 3:] * ahead,
        np.broadcast_to(ahead, (len(table), 3)),
        np.broadcast_to(across, (len(table), 3)),
        person.height * table[:, 2],
        person.height * table[:, 1] * breadth,
        along,
    )
    # From the joint that both legs hang from up the spine.
    pelvis, chest = person.common([person.at[f"{side}_up_leg"] for side in SIDES]), _chest(person)
    shared = person.common([pelvis, chest])
    spine = person.path(shared, chest)[1:]
    heights = (person.places[spine] - start) @ up if spine else np.empty(0)
    starts = np.concatenate([[-np.inf], np.maximum.accumulate(heights)])
    drive = Drive((pelvis, *spine), starts, np.full(len(starts), 0.22 * length))
    return make_surface(rings, drive, 20)


def _skull(person: Person) -> tuple[int, Array, float]:
    """The joint that carries the head, the place (3,) that the head turns about, and its height from chin to crown."""
    neck = person.neck()
    joint = person.at.get("Head", neck[-1] if neck else -1)
    place = person.places[joint]
    up, height = person.up, person.height
    if "Head" not in person.at:
        place = place + 0.04 * height * up
    size = _HEAD_HEIGHT * height
    crowns = [float((tip - place) @ up) for owner, tip in person.tips if owner == joint]
    crown = max(crowns, default=0.0)
    if crown > 0.05 * height:
        size = min(max(crown + _CHIN * height, 0.85 * size), 1.12 * size)
        place = place + max(0.0, crown + _CHIN * height - size) * up
    low = float((person.middle("up_arm") - place) @ up) + _ABOVE_SHOULDERS * height
    return joint, place + max(0.0, low) * up, size


def _head(person: Person) -> Surface:
    joint, place, size = _skull(person)
    table = np.array(_HEAD)
    grown = size / _HEAD_HEIGHT
    along = table[:, 0] * size - _CHIN * person.height
    rings = Rings(
        place + along[:, None] * person.up + person.height * table[:, 3:] * person.on,
        np.broadcast_to(person.on, (len(table), 3)),
        np.broadcast_to(person.left, (len(table), 3)),
        _HEAD_DEPTH * grown * table[:, 2],
        _HEAD_WIDTH * grown * table[:, 1],
        along,
    )
    made = make_surface(rings, Drive((joint,), np.array([-np.inf]), np.ones(1)), 16)
    inside = table[1:-1, 0]
    low, high, out = _NOSE
    # The first vertex of each ring is the one ahead.
    ahead = np.flatnonzero((inside >= low) & (inside <= high)) * 16
    made.points[ahead] += out * person.height * person.on
    return made


def _neck(person: Person) -> Surface:
    joint, place, _ = _skull(person)
    start, up, _, ahead, length = _axis(person)
    chest = _chest(person)
    between = person.path(chest, joint)[1:-1] or [one for one in person.neck() if one != joint]
    base = start + (1.08 * length) * up - 0.004 * person.height * ahead
    axis = place - base
    reach = float(np.linalg.norm(axis))
    line = Line(np.stack([base, place]))
    along = reach * np.array([-0.35, -0.25, 0.0, 0.3, 0.6, 0.9, 1.1, 1.2])
    heights = ((person.places[between] - base) @ axis) / reach if between else np.empty(0)
    starts = np.concatenate([[-np.inf], np.minimum(np.maximum.accumulate(heights), 0.8 * reach), [reach]])
    drive = Drive((chest, *between, joint), starts, np.full(len(starts), 0.6 * reach))
    headings = line.headings(along, reach)
    ahead_of, left_of = axes_along(headings, person.up, person.on)
    shape = np.array([0.0, 1.0, 1.08, 1.0, 0.98, 1.0, 0.9, 0.0])
    wide, deep = _NECK
    halves = person.height * shape
    return make_surface(Rings(line.at(along), ahead_of, left_of, deep * halves, wide * halves, along), drive, 12)


def _collar(person: Person, side: str) -> Surface:
    """The shoulder: from beside the neck to the joint of the upper arm, which its last bone carries."""
    start, up, _, ahead, length = _axis(person)
    shoulder, chest = person.at[f"{side}_up_arm"], _chest(person)
    end = person.places[shoulder]
    middle = start + length * up
    begin = middle + 0.25 * (end - middle) + 0.030 * person.height * up - 0.006 * person.height * ahead
    line = Line(np.stack([begin, end]))
    reach = float(line.lengths[-1])
    along = reach * np.array([-0.30, -0.20, 0.0, 0.30, 0.60, 0.85, 1.05, 1.22, 1.30])
    outwards = person.left if side == "left" else -person.left
    across = person.on if side == "right" else -person.on
    first, second = axes_along(line.headings(along, reach), outwards, across)
    shape = np.array([[0, 0], [0.030, 0.020], [0.036, 0.026], [0.039, 0.030], [0.038, 0.032], [0.036, 0.033],
                      [0.032, 0.031], [0.020, 0.020], [0, 0]])  # fmt: skip
    halves = person.height * shape
    collar = person.path(chest, shoulder)[1:-1]
    starts = np.concatenate([[-np.inf], np.linspace(0.15, 0.4, len(collar)) * reach if collar else []])
    drive = Drive((chest, *collar), starts, np.full(len(starts), 0.7 * reach))
    return make_surface(Rings(line.at(along), first, second, halves[:, 0], halves[:, 1], along), drive, 12)
