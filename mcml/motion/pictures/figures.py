"""The figure in a thumbnail of a body or of markers: its points, the lines between them, and the view direction.

A point is a joint or the tip of a chain (`tips` of the rest pose), joints first; each labelled point is one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.hub import Rest
from mcml.motion.landmarks.centres import body_names
from mcml.motion.sides import is_left, partners, sagittal
from mcml.motion.skeleton import Array, Convention, Skeleton, once_a_skeleton

CENTRE, LEFT, RIGHT = 0, 1, 2

MOST_JOINTS, MOST_MARKERS = 32, 48

TURN = np.radians(35.0)
"""Angle from the facing direction to the view direction, towards the left: so both sides and their movements are
visible.
"""

MOSTLY = 0.5
"""Of the poses in which a centre is known at least, to be drawn."""
_LEGS = tuple(f"{side}_{joint}" for side in ("left", "right") for joint in ("up_leg", "low_leg", "foot"))
_LINES = {
    "Root": ("left_up_leg", "right_up_leg", "neck1"),
    "neck1": ("Head", "left_up_arm", "right_up_arm"),
} | {
    f"{side}_{start}": (f"{side}_{end}",)
    for side in ("left", "right")
    for start, end in (("up_leg", "low_leg"), ("low_leg", "foot"), ("foot", "toes"), ("up_arm", "low_arm"),
                       ("low_arm", "hand"))
}  # fmt: skip
"""Lines between centres of joints, each once: from the middle of the body outwards."""

_DIGIT = re.compile(r"finger|thumb|toe|index|pinky|(?:^|[_ ])(?:mid|middle|ring)(?:[_ \d]|$)", re.I)
_OF_FACE = re.compile(r"brow|lip|mouth|cheek|nose|eye|jaw|chin|fore_?head", re.I)
_NOSE = re.compile("nose", re.I)
_NOT_DRAWN = frozenset({"control", "twist"})
"""Roles of joints."""


@dataclass(frozen=True)
class Figure:
    """points: (P,) which of the points are drawn. bones: pairs of places among these. sides: (P,) CENTRE, LEFT, RIGHT.

    root: the place that carries the body along the ground; None of markers, of which the middle does.
    """

    points: tuple[int, ...]
    bones: tuple[tuple[int, int], ...]
    sides: tuple[int, ...]
    root: int | None
    markers: bool = False
    face: bool = False


@once_a_skeleton
def figure_of(skeleton: Skeleton, rest: Rest, carrier: int) -> Figure:
    """Return the figure of a body: all its points, or the most important ones.

    carrier: the joint that moves the body; joints above it do not move, and are not drawn, nor are twist bones and
    targets of inverse kinematics. Fingers and toes are dropped first, then ends of chains, then the shortest bones;
    roots stay. Children of a dropped point are connected to the point above.
    """
    joints = len(skeleton)
    parents = [joint.parent for joint in skeleton.joints] + [joint for joint, _ in rest.tips]
    names = [f"{joint.name} {joint.source_name}" for joint in skeleton.joints]
    names += [names[joint] for joint, _ in rest.tips]
    lengths = [float(np.linalg.norm(offset)) for offset in rest.offsets]
    lengths += [float(np.linalg.norm(vector)) for _, vector in rest.tips]

    def worth(point: int) -> tuple[int, float, int]:
        kind = 0 if _DIGIT.search(names[point]) else 1 if point >= joints else 2
        return kind, lengths[point], -point

    aside = {index for index, joint in enumerate(skeleton.joints) if joint.role in _NOT_DRAWN and index != carrier}
    aside |= {joints + index for index, (joint, _) in enumerate(rest.tips) if joint in aside}
    above = parents[carrier]
    while above >= 0:
        aside.add(above)
        above = parents[above]
    body = [point for point in range(len(parents)) if point not in aside]
    going = sorted((point for point in body if parents[point] >= 0 and point != carrier), key=worth)
    gone = set(going[: max(0, len(body) - MOST_JOINTS)])
    points = [point for point in body if point not in gone][:MOST_JOINTS]
    place = {point: index for index, point in enumerate(points)}
    bones = []
    for point in points:
        above = parents[point]
        while above >= 0 and above not in place:
            above = parents[above]
        if above >= 0:
            bones.append((place[above], place[point]))
    sides = _sides(skeleton)
    sides += [sides[joint] for joint, _ in rest.tips]
    return Figure(tuple(points), tuple(bones), tuple(sides[point] for point in points), place.get(carrier, 0))


def marker_figure(skeleton: Skeleton, pose: Array) -> Figure:
    """The figure of labelled points: those that are farthest from each other. pose: (J, 3), NaN where never seen."""
    seen = np.flatnonzero(np.isfinite(pose).all(axis=1))
    chosen = farthest(pose[seen], MOST_MARKERS)
    points = tuple(sorted(int(seen[place]) for place in chosen))
    sides = _sides(skeleton)
    faces = sum(bool(_OF_FACE.search(joint.name)) for joint in skeleton.joints)
    return Figure(points, (), tuple(sides[p] for p in points), None, True, 5 * faces >= 2 * max(1, len(skeleton)))


def marker_body_figure(skeleton: Skeleton, points: Array) -> Figure | None:
    """The figure of the people that markers tell: lines between centres of joints; None without legs and head.

    points: (n, P, 3) of `body_names` in some poses, NaN where unknown. A centre that is unknown in most is left out.
    """
    names = body_names(skeleton)
    known = np.isfinite(points).all(axis=2).mean(axis=0) >= MOSTLY
    places: dict[str, int] = {name: index for index, name in enumerate(names) if known[index]}
    prefixes = [name.removesuffix(_LEGS[0]) for name in places if name.endswith(_LEGS[0])]
    people = [prefix for prefix in prefixes if all(prefix + joint in places for joint in (*_LEGS, "Head"))]
    pairs = [
        (prefix + start, prefix + end) for prefix in people for start, ends in _LINES.items() for end in ends
        if prefix + start in places and prefix + end in places
    ]  # fmt: skip
    if not pairs:
        return None
    used = list(dict.fromkeys(name for pair in pairs for name in pair))[:MOST_MARKERS]
    at = {name: index for index, name in enumerate(used)}
    bones = tuple((at[start], at[end]) for start, end in pairs if start in at and end in at)
    sides = tuple(LEFT if "left_" in name else RIGHT if "right_" in name else CENTRE for name in used)
    return Figure(tuple(places[name] for name in used), bones, sides, 0 if len(people) == 1 else None)


def farthest(points: Array, count: int) -> list[int]:
    """Return a number of the points (n, 3), each the farthest from the previous ones; all if there are fewer."""
    if len(points) <= count:
        return list(range(len(points)))
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    found = [int(away.argmax())]
    nearest = np.linalg.norm(points - points[found[0]], axis=1)
    while len(found) < count:
        found.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[found[-1]], axis=1))
    return found


def _sides(skeleton: Skeleton) -> list[int]:
    others = partners(skeleton).tolist()
    return [
        CENTRE if other == index else LEFT if is_left(skeleton, index, other) else RIGHT
        for index, other in enumerate(others)
    ]


def is_markers(skeleton: Skeleton) -> bool:
    """Whether a skeleton is of labelled points, without hierarchy."""
    return any(joint.convention is Convention.MARKER for joint in skeleton.joints)


def axis_of(name: str) -> Array:
    """(3,) the unit vector of an axis such as "Y" or "-Z"."""
    vector = np.zeros(3)
    vector["XYZ".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
    return vector


def left_of(skeleton: Skeleton, figure: Figure, pose: Array, up: Array) -> Array:
    """(3,) the level unit vector to the left of a figure. pose: (J, 3) of joints, or more points of a body of markers.

    Raises ConversionError if left and right are unknown.
    """
    if not is_markers(skeleton):
        return sagittal(skeleton, pose, up).normal
    names = body_names(skeleton)
    hips = [[names.index(name) for name in names if name.endswith(leg)][:1] for leg in (_LEGS[0], _LEGS[3])]
    if figure.markers or not all(hips):
        raise ConversionError("points do not face anywhere")
    across = pose[hips[0][0]] - pose[hips[1][0]]
    level = across - (across @ up) * up
    size = float(np.linalg.norm(level))
    if not size > 0:
        raise ConversionError("left and right of the hips are unknown")
    return np.asarray(level / size)


def view_of(skeleton: Skeleton, figure: Figure, pose: Array, up: Array) -> Array:
    """(3, 3) unit vectors of the picture: to its right, up, and towards who looks.

    pose: (J, 3) positions of the joints, or of the points of a body of markers. Bodies are seen from TURN off where
    they face; those whose names tell no sides, and points, from TURN off across their widest extent; faces from the
    front.
    """
    if figure.face:
        front = -_narrowest(pose, up)
        nose = [index for index, joint in enumerate(skeleton.joints) if _NOSE.search(joint.name)]
        if nose and np.nanmean(pose[nose] @ front) < np.nanmean(pose @ front):
            front = -front
        return np.stack([np.cross(up, front), up, front])
    try:
        left = left_of(skeleton, figure, pose, up)
        front = np.cross(left, up)
    except ConversionError:
        front = _narrowest(pose, up)
        left = np.cross(up, front)
    toward = np.cos(TURN) * front + np.sin(TURN) * left
    return np.stack([np.cross(up, toward), up, toward])


def _narrowest(pose: Array, up: Array) -> Array:
    """(3,) the level unit vector along which a pose extends least."""
    axes = [axis for axis in np.eye(3) if abs(axis @ up) < 0.5]
    seen = pose[np.isfinite(pose).all(axis=1)]
    if len(seen) > 2:
        level = (seen - seen.mean(axis=0)) @ np.array(axes).T
        _, vectors = np.linalg.eigh(level.T @ level)
        found: Array = vectors[0, 0] * axes[0] + vectors[1, 0] * axes[1]
        # Of the two ways along a line the one nearer to the positive axes, so that equal clips look alike.
        return found if found.sum() >= 0 else -found
    return np.asarray(axes[-1])


def finite(points: Sequence[Array] | Array) -> Array:
    """Positions (F, P, 3) without gaps: a point that is not seen is where it was last, before that where it will be."""
    values = np.clip(np.array(points, dtype=np.float64), -1e100, 1e100)
    if np.isfinite(values).all():
        return values
    gaps = np.isnan(values).any(axis=2)
    if gaps.any():
        rows = np.arange(len(values))[:, None]
        last = np.maximum.accumulate(np.where(gaps, -1, rows), axis=0)
        first = np.where(gaps, len(values), rows).min(axis=0)
        source = np.where(last < 0, np.minimum(first, len(values) - 1), last)
        values = np.take_along_axis(values, source[:, :, None], axis=0)
    return np.nan_to_num(values)
