"""The likely unit and up axis of a clip that does not state them. Guesses are shown as such, and never stored."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.anatomy.axes import BODY
from mcml.motion.carriers import chain
from mcml.motion.clip import ClipHead
from mcml.motion.floor_plates import kept_plates, normal_axis
from mcml.motion.landmarks.centres import bodies_of
from mcml.motion.skeleton import Array, Convention, Skeleton, once_a_skeleton
from mcml.motion.units import metres_of, metres_per_unit

HEIGHTS = (("m", 0.8, 3.0), ("ft", 3.5, 8.0), ("inch", 40.0, 95.0), ("cm", 95.0, 260.0), ("mm", 800.0, 2600.0))
"""Units, and between what heights a person is in them."""


_EXPORTED = (("dm", 12.0, 20.9, 0.1), ("inch/0.45", 20.9, 39.5, 0.0254 / 0.45))
"""Further units for the size of an exported person. The second is that of the files of Carnegie Mellon's database."""
FEWEST_NAMED = 6
"""Joints with names of MCML's that make a skeleton a person."""


def is_person(skeleton: Skeleton) -> bool:
    """Whether the joints are those of a person: several have names of MCML's, or markers that stand on a body."""
    return sum(bool(joint.mapped) for joint in skeleton.joints) >= FEWEST_NAMED or bool(bodies_of(skeleton))


def size_of_person(head: ClipHead, pose: Array) -> tuple[str, float] | None:
    """The likely unit of a person that leaves in metres, and its metres. None where the size fits none.

    pose: (J, 3) positions of one frame, NaN where unknown.
    """
    if not is_person(head.skeleton):
        return None
    unit, metres = likely_unit(head, pose)
    if unit is not None and metres is not None:
        return unit, metres
    seen = pose[np.isfinite(pose).all(axis=1)]
    extent = float(np.ptp(seen, axis=0).max()) if len(seen) > 1 and "units_length" not in head.fields else 0.0
    return next(((name, size) for name, low, high, size in _EXPORTED if low <= extent <= high), None)


def likely_units(height: float) -> list[str]:
    """Units in which a body of this height would be a person; several where they overlap."""
    return [name for name, low, high in HEIGHTS if low <= height <= high]


def likely_unit(head: ClipHead, pose: Array) -> tuple[str | None, float | None]:
    """The stated unit, else one in which a body of this size would be a person, and its metres; None for unknown.

    pose: (J, 3) positions, NaN where unknown. ASF states a factor: its values over it are inches in Vicon's files.
    """
    if stated := head.fields.get("calibration_unit"):
        return stated, metres_of(head)
    # A fixed root away from the body is not part of its height.
    aside = [joint for root in head.skeleton.roots for joint in chain(head.skeleton, root)[:-1]]
    pose = np.delete(pose, aside, axis=0)
    seen = pose[np.isfinite(pose).all(axis=1)]
    extent = float(np.ptp(seen, axis=0).max()) if len(seen) > 1 else 0.0
    factor = 0.0
    with suppress(ValueError):
        factor = float(head.fields.get("units_length", 0))
    if factor > 0:
        return (f"inch/{factor:g}", 0.0254 / factor) if "inch" in likely_units(extent / factor) else (None, None)
    units = likely_units(extent)
    return (units[0], metres_per_unit(units[0])) if units else (None, None)


_HEIGHTS = (
    (4.0, re.compile(r"head|[fb]hd\b|vertex|nose|eye|ear\b|chin|ariel|skull")),
    (3.5, re.compile(r"neck|\bc ?7\b")),
    (3.0, re.compile(r"shoulder|shldr|acrom|\b[lr]?sho\b|clav|collar|sternum|strn|scapula")),
    (2.0, re.compile(r"asis?\b|psis?\b|pelvis|hips?\b|sacr|up ?leg|waist|root|crest")),
    (1.0, re.compile(r"knee|\b[lr]?kne\b|low ?leg|shin|tibia")),
    (0.0, re.compile(r"heel|\b[lr]?hee\b|cal(?:c|can)|toe|ankle|\b[lr]?ank\b|mall?eol|foot|\b[lr]?mt\d|metatars")),
)
"""Relative heights of parts in a standing body, and words in their names."""
_NO_HEAD = re.compile(r"(?:met|mt|fib|rad|hum|uln|fem)\w* ?\d*\w* ?head|head ?(?:of|met|mt|fib|rad|hum|uln|fem)")
_UPPER = 3.0
_UPPER_LANDMARKS = frozenset({"jugular_notch", "xiphoid", "c7"})
"""Landmarks of the trunk without a word of `_HEIGHTS`, and their height."""
_LOW, _HIGH = 1.0, 2.0
"""Joints whose names decide the up axis: knees or feet, and hips or joints above."""
_ALONG = 0.9
"""Of the distance from the lower markers to the upper ones, along the axis that it is along. A lying body has less."""
_LOWEST = 10.0
"""Percent of the points of a frame that are its lowest."""
_MOVED = 0.01
"""Relative to the largest extent: less travel means that nothing moves."""
_WALKED = 0.5
"""Relative to the largest extent of all points in a frame: a longer travel along an axis means walking."""
_LEVEL = 4.0
"""How many times as far as along the axis of least travel."""
_CLEAR = 1.5
"""How many times as long a body is along the axis up as across it, at least."""


@dataclass(frozen=True)
class LikelyUp:
    """axis: "X", "Y", "Z", or with a minus.

    why: the reason, as text. sure: whether the evidence is more than the shape.
    """

    axis: str
    why: str
    sure: bool = True


def likely_up(skeleton: Skeleton, positions: Array, plates: Array | None = None) -> LikelyUp:
    """Guess the axis that points up.

    positions: (n, J, 3) of some frames, or (J, 3) of one, NaN where a point was not visible. plates: (P, 4, 3) corners
    of force plates in the same unit. Names and plates decide first (`told_up`). Otherwise axes along which points
    travel far are excluded, because a walkway is longer than a person. Of the others it is the one along which the
    points of a frame extend furthest, or travel least. Without a walkway it is the axis along which the lowest markers
    travel least; of a body with joints, and of markers that stay, the one along which points extend furthest. The
    reason states this. "Y" without any extent.
    """
    frames = positions if positions.ndim == 3 else positions[None]
    told = told_up(skeleton, frames, plates)
    if told is not None:
        return told
    extents = _extents(frames)
    if not extents.any():
        return LikelyUp("Y", "nothing tells it", sure=False)
    travel = _travel(frames)
    walked = (travel > _WALKED * extents.max()) & (travel > _LEVEL * travel.min())
    across = np.flatnonzero(~walked)
    lengths = np.where(walked, 0.0, extents)
    axis = int(lengths.argmax())
    if walked.any() and len(across) > 1 and lengths[axis] < _CLEAR * np.sort(lengths)[-2]:
        return LikelyUp("XYZ"[across[travel[across].argmin()]], "points travel least along it")
    if walked.any():
        return LikelyUp("XYZ"[axis], "points travel along another axis, and are longest along this one")
    lowest = _travel_of_lowest(frames)
    if _are_markers(skeleton) and lowest.max() > _MOVED * extents.max():
        why = "neither names nor a walkway tell it; the lowest points travel least along it"
        return LikelyUp("XYZ"[int(lowest.argmin())], why, sure=False)
    return LikelyUp("XYZ"[axis], "neither names nor travel tell it; points are longest along it", sure=False)


def told_up(skeleton: Skeleton, frames: Array, plates: Array | None = None) -> LikelyUp | None:
    """Return the axis that the names of points tell, else the one that force plates tell; None if neither does.

    frames: (n, J, 3), NaN where a point was not visible. plates: as for `likely_up`. Names of markers decide if at
    least 90 % of the distance from feet to hips, shoulders and heads is along one axis: a lying body, or a swimmer, has
    less. Plates decide where they contradict names: of a body that lies along an axis, or is upside down.
    """
    level = None if plates is None else normal_axis(plates, frames)
    markers = _are_markers(skeleton)
    towards = _from_lower_markers(skeleton, frames) if markers else _from_low_to_high(skeleton, frames)
    if towards is not None:
        share = 1.0 / float(np.linalg.norm(towards / np.abs(towards).max()))
        axis = _axis_along(towards)
        if not markers:
            return LikelyUp(axis, "heads and hips are above feet along it")
        if share >= _ALONG:
            if level is not None and level[-1] != axis[-1]:
                lying = f"heads and hips are above feet along {axis}: the body may lie"
                return LikelyUp(level, f"the force plates are level in it, although {lying}")
            if level is not None and level != axis:
                return LikelyUp(level, "heads and hips are below feet along it, and all are above the force plates")
            return LikelyUp(axis, f"heads and hips are above feet along it, by {share:.0%} of their distance")
    if level is None:
        return None
    return LikelyUp(level, "the force plates are level in it, and most points are above them")


def _are_markers(skeleton: Skeleton) -> bool:
    return bool(skeleton.joints) and all(joint.convention is Convention.MARKER for joint in skeleton.joints)


def up_of_head(head: ClipHead, positions: Array) -> LikelyUp:
    """Guess the axis that points up from the body and the force plates of a clip; see `likely_up`."""
    return likely_up(head.skeleton, positions, kept_plates(head))


def stated_up(head: ClipHead) -> str | None:
    """The axis up that a file states, None where it states none."""
    stated = head.fields.get("global_axis_of_gravity", "").strip().upper()
    return stated.removeprefix("+") if stated.removeprefix("-").removeprefix("+") in ("X", "Y", "Z") else None


def changed_up(head: ClipHead, positions: Array) -> tuple[str, str] | None:
    """Return the up axes of the earlier and the current guess, if they differ and no axis is stated.

    positions: (n, J, 3) of the clip, or of a sample of it, NaN where unknown; without frames of the rest pose.
    """
    if stated_up(head) is not None or not positions.size:
        return None
    before, now = longest_up(head.skeleton, positions), up_of_head(head, positions).axis
    return None if before == now else (before, now)


def longest_up(skeleton: Skeleton, positions: Array) -> str:
    """Return the up axis by the earlier rule, without names and travel, for files imported with it.

    positions: as for `likely_up`. From the root, or the feet, to the head, else the longest extent.
    """
    places = _mean_pose(positions if positions.ndim == 3 else positions[None])
    joints = {joint.name: index for index, joint in enumerate(skeleton.joints)}
    feet = [joints[name] for name in ("left_foot", "right_foot") if name in joints] or [joints.get("Root", 0)]
    if "Head" in joints and len(skeleton) > 1:
        towards = places[joints["Head"]] - places[feet].mean(axis=0)
        if np.isfinite(towards).all() and np.abs(towards).max() > 0:
            return _axis_along(towards)
    seen = places[np.isfinite(places).all(axis=1)]
    if len(seen) < 2 or not np.ptp(seen, axis=0).any():
        return "Y"
    return "XYZ"[int(np.ptp(seen, axis=0).argmax())]


@once_a_skeleton
def _heights(skeleton: Skeleton) -> tuple[float | None, ...]:
    """Return the relative height of each joint in a body, if its name decides it.

    Of a body with MCML's names others do not count, such as targets of inverse kinematics that stay on the floor.
    """
    heights = [_height_of(name) for name in skeleton.names]
    body = [height if name in BODY else None for name, height in zip(skeleton.names, heights, strict=True)]
    known = [height for height in body if height is not None]
    return tuple(body if known and max(known) >= _HIGH and min(known) <= _LOW else heights)


def _height_of(name: str) -> float | None:
    bare = name.rpartition(":")[2]
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", bare)
    words = re.sub(r"[\W_]+", " ", words).lower().strip()
    if _NO_HEAD.search(words):
        return None
    # "left_foot_head" or "ankle-knee" are ambiguous.
    found = [height for height, pattern in _HEIGHTS if pattern.search(words)]
    return found[0] if len(found) == 1 else None


def _from_low_to_high(skeleton: Skeleton, frames: Array) -> Array | None:
    """Return (3,) from the lowest parts to the highest in frames (n, J, 3) with both, None without such frames or
    names. Frame by frame, because on a walkway points may be visible at different times.
    """
    heights = np.array([np.nan if height is None else height for height in _heights(skeleton)])
    known = heights[np.isfinite(heights) & np.isfinite(frames).all(axis=2).any(axis=0)]
    if not len(known) or known.max() < _HIGH or known.min() > _LOW:
        return None
    # The outermost parts, else all high and all low ones.
    for high, low in ((heights == known.max(), heights == known.min()), (heights >= _HIGH, heights <= _LOW)):
        towards: Array = _mean_pose((_middle(frames[:, high]) - _middle(frames[:, low]))[:, None])[0]
        if np.isfinite(towards).all() and np.abs(towards).max() > 0:
            return towards
    return None


@once_a_skeleton
def _marker_heights(skeleton: Skeleton) -> Array:
    """(J,) the relative height of each marker in a body by its landmark, else by its name; NaN if neither decides."""
    heights = [np.nan if height is None else height for height in _heights(skeleton)]
    for index, landmark in landmarks_of(skeleton).items():
        height = _UPPER if landmark in _UPPER_LANDMARKS else _height_of(landmark)
        ambiguous = height is None or landmark.endswith(("_tracking", "_hand"))
        heights[index] = np.nan if ambiguous or height is None else height
    return np.array(heights)


def landmarks_of(skeleton: Skeleton) -> dict[int, str]:
    """The landmarks of markers, by their index, of all bodies."""
    return {index: landmark for body in bodies_of(skeleton) for index, landmark in body.landmarks.items()}


def _from_lower_markers(skeleton: Skeleton, frames: Array) -> Array | None:
    """Return (3,) from feet to hips, shoulders and heads: the median over frames (n, J, 3) of the difference of the
    medians of both. None without a frame that has both.
    """
    heights = _marker_heights(skeleton)
    upper, lower = frames[:, heights >= _HIGH], frames[:, heights == 0.0]
    there = _seen(upper).any(axis=1) & _seen(lower).any(axis=1)
    if not there.any():
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        steps = np.nanmedian(upper[there], axis=1) - np.nanmedian(lower[there], axis=1)
        towards: Array = np.median(steps, axis=0)
    return towards if np.isfinite(towards).all() and np.abs(towards).max() > 0 else None


def _seen(points: Array) -> NDArray[np.bool_]:
    """(n, P) whether points (n, P, 3) are seen."""
    return np.asarray(np.isfinite(points).all(axis=2))


def _middle(points: Array) -> Array:
    """(n, 3) the middle of those of points (n, P, 3) that are seen, NaN where none is."""
    return _mean_pose(points.transpose(1, 0, 2))


def _axis_along(towards: Array) -> str:
    axis = int(np.abs(towards).argmax())
    return ("-" if towards[axis] < 0 else "") + "XYZ"[axis]


def _travel(frames: Array) -> Array:
    """(3,) between what places the middle of all points is most of the time, along each axis; zero of a single frame.

    A point counts from where it is on the whole, so that none that comes or goes moves the middle.
    """
    seen = np.asarray(np.isfinite(frames).all(axis=2))
    counts = np.maximum(seen.sum(axis=1), 1)[:, None]
    away = np.where(seen[:, :, None], frames - _mean_pose(frames), 0.0).sum(axis=1) / counts
    there = np.asarray(seen.any(axis=1))
    if there.sum() < 2:
        return np.zeros(3)
    low, high = np.percentile(away[there], [5.0, 95.0], axis=0)
    travel: Array = high - low
    return travel


def _travel_of_lowest(frames: Array) -> Array:
    """(3,) how far the lowest points of a frame travel along each axis; zero of a single frame."""
    seen = _seen(frames)
    whole = np.where(seen[:, :, None], frames, np.nan)[seen.any(axis=1)]
    if len(whole) < 2:
        return np.zeros(3)
    low, high = np.percentile(np.nanpercentile(whole, _LOWEST, axis=1), [5.0, 95.0], axis=0)
    travel: Array = high - low
    return travel


def _extents(frames: Array) -> Array:
    """(3,) how long all points together are along each axis, the median over frames."""
    seen = np.asarray(np.isfinite(frames).all(axis=2))
    frames, seen = frames[seen.sum(axis=1) > 1], seen[seen.sum(axis=1) > 1]
    if not len(frames):
        return np.zeros(3)
    high = np.where(seen[:, :, None], frames, -np.inf).max(axis=1)
    low = np.where(seen[:, :, None], frames, np.inf).min(axis=1)
    extents: Array = np.median(high - low, axis=0)
    return extents


def _mean_pose(positions: Array) -> Array:
    """Return (J, 3) the mean positions of joints over frames (n, J, 3), NaN for one that is never visible: on
    average the head is above the feet.
    """
    if np.isfinite(positions.sum()) and len(positions):
        mean: Array = positions.sum(axis=0) / len(positions)
        return mean
    seen = np.isfinite(positions)
    counts = seen.sum(axis=0)
    total = np.where(seen, positions, 0.0).sum(axis=0)
    return np.where(counts > 0, total / np.maximum(counts, 1), np.nan)
