"""Forward kinematics written out, joint by joint and frame by frame, with SciPy's rotations: the twin of the fast one.

Formulas of formats.md 1.4 (BVH), 2.2 and 2.3 (ASF/AMC), 4.2 (HTR), each in its own convention, without the hub form.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from service.motion.clip import ClipStream
from service.motion.skeleton import CHANNELS, Convention, Joint, numbers
from service.motion.units import reading_of


def positions(clip: ClipStream) -> np.ndarray:
    """(n, J, 3) world positions of the joints (ASF: the start of each bone)."""
    return np.array([_pose(clip, frame)[0] for frame in _frames(clip)])


def tips(clip: ClipStream) -> dict[int, np.ndarray]:
    """(n, 3) world positions of the tip of each leaf, by joint."""
    skeleton = clip.head.skeleton
    leaves = set(range(len(skeleton))) - {joint.parent for joint in skeleton.joints}
    found = [_pose(clip, frame)[1] for frame in _frames(clip)]
    return {leaf: np.array([frame[leaf] for frame in found]) for leaf in leaves}


def _frames(clip: ClipStream) -> list[list[dict[str, float]]]:
    frames = []
    for block in clip.blocks():
        for row in block.values.tolist():
            frame: list[dict[str, float]] = [{} for _ in clip.head.skeleton.joints]
            for (joint, channel), value in zip(block.columns, row, strict=True):
                frame[joint][CHANNELS[channel]] = value
            frames.append(frame)
    return frames


def _pose(clip: ClipStream, frame: list[dict[str, float]]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    walk = {Convention.LISTED: _bvh, Convention.FIXED: _asf, Convention.BASE: _htr}
    return walk[clip.head.skeleton.joints[0].convention](clip, frame)


def _angles(values: dict[str, float], letters: str, unit: float) -> list[Rotation]:
    return [
        Rotation.from_rotvec(np.eye(3)["XYZ".index(letter)] * values.get(f"R{letter.lower()}", 0.0) * unit)
        for letter in letters
    ]


def _product(factors: list[Rotation]) -> Rotation:
    result = Rotation.identity()
    for factor in factors:
        result = result * factor
    return result


def _translation(values: dict[str, float]) -> np.ndarray:
    return np.array([values.get(channel, 0.0) for channel in ("Tx", "Ty", "Tz")])


def _bvh(clip: ClipStream, frame: list[dict[str, float]]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    places: list[np.ndarray] = []
    turns: list[Rotation] = []
    ends: list[np.ndarray] = []
    for joint, values in zip(clip.head.skeleton.joints, frame, strict=True):
        local = _product(_angles(values, joint.rotation_order, np.pi / 180))
        offset = numbers(joint.offset)
        moved = offset.copy()
        for axis, channel in enumerate(("Tx", "Ty", "Tz")):
            if channel in values:
                moved[axis] = values[channel] + (offset[axis] if joint.translation == "relative" else 0.0)
        if joint.parent < 0:
            places.append(moved)
            turns.append(local)
        else:
            places.append(places[joint.parent] + turns[joint.parent].apply(moved))
            turns.append(turns[joint.parent] * local)
        site = numbers(joint.end_sites[0].offset) if joint.end_sites else np.zeros(3)
        ends.append(places[-1] + turns[-1].apply(site))
    return places, ends


def _asf(clip: ClipStream, frame: list[dict[str, float]]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    reading = reading_of(clip.head)
    starts: list[np.ndarray] = []
    turns: list[Rotation] = []
    ends: list[np.ndarray] = []
    for joint, values in zip(clip.head.skeleton.joints, frame, strict=True):
        # First listed is applied first, about fixed axes: the product is in reverse order.
        motion = _product(_angles(values, joint.rotation_order, reading.motion_angle)[::-1])
        if joint.parent < 0:
            starts.append(numbers(joint.offset) + _translation(values))
            turns.append(motion)
            ends.append(starts[-1])
            continue
        axes = _rest_axes(joint, reading.rest_angle)
        parent = turns[joint.parent]
        starts.append(ends[joint.parent] + parent.apply(axes.apply(_translation(values))))
        turns.append(parent * axes * motion * axes.inv())
        direction = numbers(joint.direction)
        bone = direction * float(joint.length or 0) / np.linalg.norm(direction)
        ends.append(starts[-1] + turns[-1].apply(bone))
    return starts, ends


def _rest_axes(joint: Joint, unit: float) -> Rotation:
    angles = numbers(joint.axis) * unit
    factors = [
        Rotation.from_rotvec(np.eye(3)["XYZ".index(letter)] * angle)
        for letter, angle in zip(joint.axis_order.upper() or "XYZ", angles, strict=True)
    ]
    return _product(factors[::-1])


def _htr(clip: ClipStream, frame: list[dict[str, float]]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    reading = reading_of(clip.head)
    places: list[np.ndarray] = []
    turns: list[Rotation] = []
    ends: list[np.ndarray] = []
    for joint, values in zip(clip.head.skeleton.joints, frame, strict=True):
        base = dict(zip(("Rx", "Ry", "Rz"), numbers(joint.axis).tolist(), strict=True))
        rest = _product(_angles(base, joint.rotation_order, reading.rest_angle))
        local = rest * _product(_angles(values, joint.rotation_order, reading.motion_angle))
        moved = numbers(joint.offset) + _translation(values)
        if joint.parent < 0:
            places.append(moved)
            turns.append(local)
        else:
            places.append(places[joint.parent] + turns[joint.parent].apply(moved))
            turns.append(turns[joint.parent] * local)
        along = np.eye(3)[reading.bone_axis] * float(joint.length or 0) * values.get("SF", 1.0)
        ends.append(places[-1] + turns[-1].apply(along))
    return places, ends
