"""Check landmarks by their positions: up is from the ankles to the pelvis, forward from its back to its front.

Names are kept in any case: positions cannot distinguish a mirrored trial from exchanged names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcml.motion.landmarks.recognise import MarkerBody
from mcml.motion.skeleton import Array

_PAIRS = ("asis", "psis", "greater_trochanter", "knee_lateral", "ankle_lateral", "heel", "acromion", "elbow_lateral")
"""Landmarks of both sides; the left one should be on the left."""
_BOTH_SIDES = (("knee_lateral", "knee_medial"), ("ankle_lateral", "ankle_medial"), ("elbow_lateral", "elbow_medial"))
"""Lateral landmarks, which are outside of medial ones in a standing body with hanging arms."""
_ORDER = (("ankle_lateral", "knee_lateral"), ("knee_lateral", "asis"), ("asis", "acromion"))
"""Landmarks of a side, one above the other."""
_WANDS = (("thigh_tracking", "knee", "asis", 0.5), ("shank_tracking", "ankle", "knee_lateral", 0.0))
"""A wand, the joint that is constructed in its plane, a landmark above, and how far behind it the joint above is, as a
share of the pelvis's depth."""
_BESIDE = 0.5
"""Cosine of the largest angle of a wand from the side, seen along the segment."""
_CLEAR = 0.02
"""Of the height from ankle to pelvis: a smaller step contradicts nothing."""


def fullest_frame(bodies: Sequence[MarkerBody], positions: Array) -> int:
    """The frame in which most landmarks are seen. positions: (n, J, 3), NaN where a marker is unknown."""
    indices = [index for body in bodies for index in body.landmarks]
    seen = np.isfinite(positions[:, indices]).all(axis=2).sum(axis=1)
    return int(seen.argmax())


def check_places(body: MarkerBody, places: Array) -> list[str]:
    """Return sentences about landmarks whose positions contradict their names; none if the pelvis or the feet are
    unknown.

    places: (J, 3) of one frame.
    """
    at = {name: places[index] for index, name in body.landmarks.items() if np.isfinite(places[index]).all()}
    front, ankles = _middle(at, "asis"), _middle(at, "ankle_lateral")
    back = at.get("sacrum", _middle(at, "psis"))
    if front is None or ankles is None or back is None:
        return []
    up = front - ankles
    height = float(np.linalg.norm(up))
    if not height > 0:
        return []
    up = up / height
    forward = front - back
    forward = forward - (forward @ up) * up
    left = np.cross(up, forward)
    size = float(np.linalg.norm(left))
    if not size > _CLEAR * height:
        return []
    left, clear = left / size, _CLEAR * height
    whose = f"{body.prefix}: " if body.prefix else ""
    told = [*_check_sides(at, left, clear), *_check_wands(at, front - back, clear)]
    low = [
        f"{side}_{lower} above {side}_{upper}"
        for side in ("left", "right")
        for lower, upper in _ORDER
        if {f"{side}_{lower}", f"{side}_{upper}"} <= at.keys()
        and (at[f"{side}_{upper}"] - at[f"{side}_{lower}"]) @ up < -clear
    ]
    # A knee above the pelvis is not an error; knees below their ankles on both sides are.
    if len(low) > 1:
        told.append(f"places contradict names: {', '.join(low)}")
    return [whose + sentence for sentence in told]


def _check_wands(at: Mapping[str, Array], depth: Array, clear: float) -> list[str]:
    """Joints without a medial marker are constructed in the plane of a wand, which is beside the segment.

    depth: from the back of the pelvis to its front, in whose middle the hips are.
    """
    turned, left = [], at["left_asis"] - at["right_asis"]
    for wand, low, high, back in _WANDS:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            names = (f"{side}_{wand}", f"{side}_{low}_lateral", f"{side}_{high}")
            if f"{side}_{low}_medial" in at or not at.keys() >= set(names):
                continue
            tip, joint, above = (at[name] for name in names)
            along = above - back * depth - joint
            if not np.linalg.norm(along) > clear:
                continue
            along = along / np.linalg.norm(along)
            away, outward = (step - (step @ along) * along for step in (tip - joint, sign * left))
            size = np.linalg.norm(away)
            if size > clear and away @ outward < _BESIDE * size * np.linalg.norm(outward):
                turned.append((names[0], low))
    return [
        f"{wand} is not beside its segment: angles of the {low} may be wrong by tens of degrees, unless a property "
        "states the rotation of the wand"
        for wand, low in turned
    ]


def _middle(at: Mapping[str, Array], landmark: str) -> Array | None:
    sides = [at.get(f"{side}_{landmark}") for side in ("left", "right")]
    return None if sides[0] is None or sides[1] is None else (sides[0] + sides[1]) / 2


def _check_sides(at: Mapping[str, Array], left: Array, clear: float) -> list[str]:
    checks: dict[str, float] = {}
    for part in _PAIRS:
        if {f"left_{part}", f"right_{part}"} <= at.keys():
            checks[f"left_{part}"] = float((at[f"left_{part}"] - at[f"right_{part}"]) @ left)
    for outer, inner in _BOTH_SIDES:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            if {f"{side}_{outer}", f"{side}_{inner}"} <= at.keys():
                step = (at[f"{side}_{outer}"] - at[f"{side}_{inner}"]) @ left
                checks[f"{side}_{outer} beside {side}_{inner}"] = float(step) * sign
    wrong = [name for name, step in checks.items() if step < -clear]
    right = [name for name, step in checks.items() if step > clear]
    if wrong and not right:
        return [
            "places contradict left and right of all names: the trial may be mirrored, or left and right exchanged; "
            "names are kept"
        ]
    return [f"places contradict left and right of {', '.join(wrong)}"] if wrong else []
