"""Where joints are, frame by frame with matrices: the kinematics of the slow twin."""

from __future__ import annotations

import math

import numpy as np

from mcml.motion.clip import ClipStream
from mcml.motion.skeleton import CHANNELS, Convention, Joint
from mcml.motion.units import reading_of

Matrix = np.ndarray


def about_axis(letter: str, angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    if letter == "X":
        return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    if letter == "Y":
        return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def product(matrices: list[Matrix]) -> Matrix:
    result = np.eye(3)
    for matrix in matrices:
        result = result @ matrix
    return result


def triple_of(lexemes: tuple[str, str, str] | None) -> np.ndarray:
    return np.array([float(text) for text in lexemes or ("0", "0", "0")])


Pose = tuple[dict[str, np.ndarray], dict[str, Matrix]]
"""Where each joint is in the world, and its axes."""


def frame_poses(clip: ClipStream) -> list[Pose]:
    found = []
    for block in clip.blocks():
        for row in block.values:
            channels: list[dict[str, float]] = [{} for _ in clip.head.skeleton.joints]
            for (joint, channel), value in zip(block.columns, row, strict=True):
                channels[joint][CHANNELS[channel]] = float(value)
            found.append(_walk(clip, channels))
    return found


def rest_pose(clip: ClipStream) -> Pose:
    return _walk(clip, [{} for _ in clip.head.skeleton.joints])


def _walk(clip: ClipStream, channels: list[dict[str, float]]) -> Pose:
    reading = reading_of(clip.head)
    places: list[np.ndarray] = []
    ends: list[np.ndarray] = []
    turned: list[Matrix] = []
    for joint, values in zip(clip.head.skeleton.joints, channels, strict=True):
        moved = np.array([values.get(name, 0.0) for name in ("Tx", "Ty", "Tz")])
        above, carried = (places[joint.parent], turned[joint.parent]) if joint.parent >= 0 else (0.0, np.eye(3))
        turns = [
            about_axis(letter, values.get(f"R{letter.lower()}", 0.0) * reading.motion_angle)
            for letter in joint.rotation_order.upper()
        ]
        if joint.convention is Convention.LISTED:
            at = triple_of(joint.offset)
            if joint.translation == "absolute":
                for axis, name in enumerate(("Tx", "Ty", "Tz")):
                    at[axis] = values.get(name, at[axis])
            elif joint.translation == "relative":
                at = at + moved
            places.append(above + carried @ at)
            turned.append(carried @ product(turns))
            ends.append(places[-1])
        elif joint.convention is Convention.BASE:
            places.append(above + carried @ (triple_of(joint.offset) + moved))
            turned.append(carried @ _rest(joint, joint.rotation_order, reading.rest_angle) @ product(turns))
            ends.append(places[-1])
        else:
            axes = _rest(joint, (joint.axis_order or "XYZ")[::-1], reading.rest_angle)
            start = ends[joint.parent] if joint.parent >= 0 else triple_of(joint.offset)
            places.append(start + carried @ axes @ moved if joint.parent >= 0 else start + moved)
            turned.append(carried @ axes @ product(turns[::-1]) @ axes.T)
            along = triple_of(joint.direction)
            size = math.sqrt(float(along @ along))
            bone = along / size * float(joint.length or 0) if size else along
            ends.append(places[-1] + turned[-1] @ bone)
    names = clip.head.skeleton.names
    return dict(zip(names, places, strict=True)), dict(zip(names, turned, strict=True))


def _rest(joint: Joint, order: str, unit: float) -> Matrix:
    angles = dict(zip("XYZ", triple_of(joint.axis), strict=True))
    if joint.convention is Convention.FIXED:
        angles = dict(zip((joint.axis_order or "XYZ").upper(), triple_of(joint.axis), strict=True))
    return product([about_axis(letter, angles[letter] * unit) for letter in order.upper()])
