"""Limbs of two bones, legs and arms, bent in the joints of a skeleton so that their ends are at goals."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mcml.motion.feet.two_bones import hinge_of, two_bones
from mcml.motion.hub import walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.rotations import IDENTITY, inverse, multiply, rotate
from mcml.motion.skeleton import Array, Skeleton

Limb: TypeAlias = tuple[int, int, int, int]
"""Joints: of the upper bone, of the lower bone, its end, and the tip that is to be at a goal (the end itself, or below
it)."""

_ROUNDS = 4
"""Of bending a limb whose joints cannot turn freely."""


def limb_hinge(places: Array, world: Array, limb: Limb) -> Array | None:
    """(3,) unit axis of a knee or elbow in the frame of the upper joint, over frames (n, J, 3), (n, J, 4) in the
    world; None for a limb that never bends.
    """
    upper, lower, end, _ = limb
    back = inverse(world[:, upper])
    return hinge_of(rotate(back, places[:, lower] - places[:, upper]), rotate(back, places[:, end] - places[:, lower]))


def bend_limb(
    skeleton: Skeleton,
    limb: Limb,
    translations: Array,
    rotations: Array,
    goals: Array,
    faces: Array,
    hinge: Array | None,
    writer: HubWriter,
) -> Array:
    """Return rotations (n, J, 4) with the tip of a limb at its goals (n, 3) as nearly as the limb can.

    translations (n, J, 3), rotations: hub form. faces: (n, 4) rotations of the end in the world. hinge: see
    `limb_hinge`. writer: knows the channels of the joints.
    """
    upper, lower, end, tip = limb
    places, world = walked(skeleton, translations, rotations)
    rotations = rotations.copy()
    targets = places[:, end] + goals - places[:, tip]
    size = max(1.0, float(np.abs(goals).max()))
    for _ in range(_ROUNDS):
        axes = None if hinge is None else rotate(world[:, upper], hinge)
        swing, bend = two_bones(places[:, upper], places[:, lower], places[:, end], targets, axes)
        above, last = None, -1
        for joint, wanted in (
            (upper, multiply(swing, world[:, upper])),
            (lower, multiply(multiply(swing, bend), world[:, lower])),
            (end, faces),
        ):
            parent = skeleton.joints[joint].parent
            before = world[:, parent] if parent >= 0 else IDENTITY[None]
            # Joints between the two turn with the upper one.
            above = before if above is None else multiply(multiply(above, inverse(world[:, last])), before)
            rotations[:, joint] = writer.nearest(joint, multiply(inverse(above), wanted))
            above, last = multiply(above, rotations[:, joint]), joint
        places, world = walked(skeleton, translations, rotations)
        missed = goals - places[:, tip]
        if float(np.abs(missed).max()) < 1e-9 * size:
            break
        targets = places[:, end] + missed
    return rotations
