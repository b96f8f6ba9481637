"""How far parts of a retargeted body point elsewhere than in the source: limbs, hips, shoulders, trunk and head."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcml.motion.retargeting.checks import angles_between
from mcml.motion.retargeting.posed_bodies import PosedBody
from mcml.motion.retargeting.report import BoneError, PartError
from mcml.motion.skeleton import Array

_LIMBS = {
    f"{side} {limb}": (f"{side}_up_{limb}", f"{side}_low_{limb}")
    for limb in ("arm", "leg")
    for side in ("left", "right")
}
_LINES = {"hips": "up_leg", "shoulders": "up_arm"}


def part_errors(
    one: PosedBody,
    two: PosedBody,
    pairs: Mapping[int, int],
    bones: Sequence[BoneError],
    positions: Array,
    made: Array,
) -> tuple[PartError, ...]:
    """Measure parts of the body: bones of limbs and of the head, lines from right to left, and the trunk.

    pairs: joint of the target -> joint of the source. bones: of the whole body. positions: (n, J, 3) of the source,
    made: (n, J, 3) of the target, in the world. The trunk is the line from the middle of the hips to the middle of the
    shoulders. Parts whose joints have no match are left out.
    """
    names = two.skeleton.names
    at = {name: index for index, name in enumerate(names) if index in pairs}
    found = [_worst_of(what, [bone for bone in bones if names[bone.joint] in limb]) for what, limb in _LIMBS.items()]
    sides = {what: (at.get(f"left_{part}"), at.get(f"right_{part}")) for what, part in _LINES.items()}
    middles: list[tuple[Array, Array]] = []
    for what, (left, right) in sides.items():
        if left is None or right is None:
            continue
        source = positions[:, pairs[left]] - positions[:, pairs[right]]
        found.append(_line(what, left, source, made[:, left] - made[:, right], one, two))
        middles.append(
            (
                (positions[:, pairs[left]] + positions[:, pairs[right]]) / 2,
                (made[:, left] + made[:, right]) / 2,
            )
        )
    if len(middles) == len(_LINES):
        (low, made_low), (high, made_high) = middles
        joint = at.get("Root", at.get("left_up_leg", 0))
        found.append(_line("trunk", joint, high - low, made_high - made_low, one, two))
    found.append(_worst_of("head", [bone for bone in bones if names[bone.end] == "Head"]))
    return tuple(part for part in found if part is not None)


def _worst_of(what: str, bones: Sequence[BoneError]) -> PartError | None:
    """Return the bone that points farthest elsewhere, on the mean."""
    worst = max(bones, key=lambda bone: bone.mean, default=None)
    return None if worst is None else PartError(what, worst.joint, worst.largest, worst.mean, worst.frame)


def _line(what: str, joint: int, source: Array, made: Array, one: PosedBody, two: PosedBody) -> PartError | None:
    known = (np.linalg.norm(source, axis=1) > one.short) & (np.linalg.norm(made, axis=1) > two.short)
    if not known.any():
        return None
    angles = np.where(known, angles_between(source, made), 0.0)
    return PartError(what, joint, float(angles.max()), float(angles[known].mean()), int(angles.argmax()))
