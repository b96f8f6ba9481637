"""Frames of the segments of a body whose joints are points, as centres of joints from markers are.

Columns of a frame point to the front, the left and up of the segment while it stands upright with its arms stretched to
the sides, palms down. One axis is the segment's bone, exactly; a second one comes from markers across the segment, from
the bend of the knee or elbow, or, where neither tells, from the segment above.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.motion.hub_writer import Flags
from mcml.motion.rotation_vectors import shortest_arcs
from mcml.motion.rotations import to_matrix
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, cross, dot, unit

FRONT, LEFT, UP = 0, 1, 2
"""Columns of a frame."""

BENT: Final = 15.0
"""Degrees from which two bones show the axis between them."""

_KNUCKLES = ("{}_mt3_hand",), ("{}_mt2_hand", "{}_mt5_hand"), ("{}_mt2_hand",)
_HEAD_BOXES = (
    (("left_head_front", "left_head_back"), ("right_head_front", "right_head_back"),
     ("left_head_front", "right_head_front"), ("left_head_back", "right_head_back")),
    (("left_ear",), ("right_ear",), ("nose",), ("left_ear", "right_ear")),
)  # fmt: skip
"""Landmarks of a head: left, right, front, back."""

Points = Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Landmarks:
    """centres: (n, 3) of joints by MCML's names. markers: (n, 3) by landmarks. lines: (n, 3) to the left of thighs and
    shanks by the names of their upper joints (`bone_axes`). All NaN where unknown."""

    centres: Points
    markers: Points
    lines: Points

    def middle(self, *names: str) -> Array | None:
        """(n, 3) the mean of some markers; None if the body lacks one."""
        if not all(name in self.markers for name in names):
            return None
        mean: Array = np.mean([self.markers[name] for name in names], axis=0)
        return mean

    def between(self, start: str, end: str) -> Array | None:
        """(n, 3) from one centre to another; None if the body lacks one."""
        known = start in self.centres and end in self.centres
        return self.centres[end] - self.centres[start] if known else None


def make_frames(main: Array, axis: int, hint: Array, hint_axis: int) -> Array:
    """(n, 3, 3) frames with one axis along vectors (n, 3) and another as near as possible to others (n, 3)."""
    first = unit(main)
    second = unit(hint - dot(hint, first)[:, None] * first)
    columns: list[Array] = [first] * 3
    columns[axis], columns[hint_axis] = first, second
    third = 3 - axis - hint_axis
    columns[third] = cross(columns[(third + 1) % 3], columns[(third + 2) % 3])
    return np.stack(columns, axis=2)


def turn_frames(above: Array, main: Array, axis: int) -> Array:
    """(n, 3, 3) the frames of the segment above, turned by the smallest angle that brings an axis along vectors."""
    start, end = above[:, :, axis], unit(main)
    seen = np.isfinite(start + end).all(axis=1)
    turned = np.full_like(above, np.nan)
    turned[seen] = to_matrix(shortest_arcs(start[seen], end[seen])) @ above[seen]
    return turned


def twist_frames(frames: Array, axis: int, hint: Array, hint_axis: int, clear: Flags) -> Array:
    """(n, 3, 3) frames turned about one axis so that another one is along a hint (n, 3), where that is clear (n,).

    Between clear frames the angle is interpolated, beyond them it is constant; without any the frames stay.
    """
    about, zero = frames[:, :, axis], frames[:, :, hint_axis]
    side = cross(about, zero)
    angles = np.arctan2(dot(hint, side), dot(hint, zero))
    rows = np.flatnonzero(clear & np.isfinite(angles))
    if not len(rows):
        return frames
    turns = np.interp(np.arange(len(frames)), rows, np.unwrap(angles[rows]))
    hinted = np.cos(turns)[:, None] * zero + np.sin(turns)[:, None] * side
    return make_frames(about, axis, hinted, hint_axis)


def segment_frames(body: Landmarks) -> dict[str, Array]:
    """(n, 3, 3) of each segment, by the name of the joint at its upper end; NaN where a point is unknown.

    body: has the centres "Root" and of both hips. Segments whose centres are unknown are left out.
    """
    found = {"Root": _pelvis(body)}
    _add_trunk(body, found)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        if "waist" in found:
            _add_arm(body, found, side, sign)
        _add_leg(body, found, side)
    return found


def _pelvis(body: Landmarks) -> Array:
    front = body.middle("left_asis", "right_asis")
    back = body.middle("left_psis", "right_psis")
    back = body.middle("sacrum") if back is None else back
    if front is not None and back is not None:
        left = body.markers["left_asis"] - body.markers["right_asis"]
        return make_frames(left, LEFT, front - back, FRONT)
    left = body.centres["left_up_leg"] - body.centres["right_up_leg"]
    up = body.between("Root", "neck1")
    if up is None:
        up = body.centres["Root"] - (body.centres["left_low_leg"] + body.centres["right_low_leg"]) / 2
    return make_frames(left, LEFT, up, UP)


def _add_trunk(body: Landmarks, found: dict[str, Array]) -> None:
    top = body.between("Root", "neck1")
    if top is None:
        return
    shoulders = body.between("right_up_arm", "left_up_arm")
    left = found["Root"][:, :, LEFT] if shoulders is None else shoulders
    found["waist"] = make_frames(top, UP, left, LEFT)
    neck = body.between("neck1", "Head")
    if neck is None:
        return
    head = _head(body)
    found["neck1"] = turn_frames(found["waist"], neck, UP)
    found["Head"] = found["neck1"] if head is None else head


def _head(body: Landmarks) -> Array | None:
    for box in _HEAD_BOXES:
        left, right, front, back = (body.middle(*names) for names in box)
        if left is not None and right is not None and front is not None and back is not None:
            return make_frames(left - right, LEFT, front - back, FRONT)
    return None


def _add_arm(body: Landmarks, found: dict[str, Array], side: str, sign: float) -> None:
    collar = body.between("neck1", f"{side}_up_arm")
    if collar is None:
        return
    shoulder, upper, lower, hand = (f"{side}_{part}" for part in ("shoulder", "up_arm", "low_arm", "hand"))
    found[shoulder] = make_frames(sign * collar, LEFT, found["waist"][:, :, UP], UP)
    above, forearm = body.between(upper, lower), body.between(lower, hand)
    if above is None:
        return
    found[upper] = turn_frames(found[shoulder], sign * above, LEFT)
    if forearm is None:
        return
    # The elbow bends to the front of an arm that is stretched to its side.
    bend = sign * cross(forearm, above)
    found[upper] = twist_frames(found[upper], LEFT, bend, UP, angle_between(above, forearm) > BENT)
    found[lower] = turn_frames(found[upper], sign * forearm, LEFT)
    radial, ulnar = (body.middle(f"{side}_wrist_{part}") for part in ("radial", "ulnar"))
    if radial is not None and ulnar is not None:
        found[lower] = make_frames(sign * forearm, LEFT, radial - ulnar, FRONT)
    for names in _KNUCKLES:
        knuckles = body.middle(*(name.format(side) for name in names))
        if knuckles is not None:
            found[hand] = turn_frames(found[lower], sign * (knuckles - body.centres[hand]), LEFT)
            return
    found[hand] = found[lower]


def _add_leg(body: Landmarks, found: dict[str, Array], side: str) -> None:
    hip, knee, ankle, toes = (f"{side}_{part}" for part in ("up_leg", "low_leg", "foot", "toes"))
    thigh, shank, foot = body.between(knee, hip), body.between(ankle, knee), body.between(ankle, toes)
    if thigh is None:
        return
    found[hip] = turn_frames(found["Root"], thigh, UP)
    if hip in body.lines:
        found[hip] = make_frames(thigh, UP, body.lines[hip], LEFT)
    elif shank is not None:
        found[hip] = twist_frames(found[hip], UP, cross(thigh, shank), LEFT, angle_between(thigh, shank) > BENT)
    if shank is None:
        return
    found[knee] = turn_frames(found[hip], shank, UP)
    if knee in body.lines:
        found[knee] = make_frames(shank, UP, body.lines[knee], LEFT)
    if foot is None:
        return
    heel = body.middle(f"{side}_heel")
    tips = (body.middle(f"{side}_mt2"), body.middle(f"{side}_big_toe"), body.centres[toes])
    tip = next(tip for tip in tips if tip is not None)
    if heel is None:
        found[ankle] = make_frames(foot, FRONT, found[knee][:, :, UP], UP)
    else:
        # The ankle is above the sole.
        found[ankle] = make_frames(tip - heel, FRONT, body.centres[ankle] - heel, UP)
