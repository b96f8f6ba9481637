"""Forward kinematics written out, joint by joint, with SciPy's rotations: the twin of the fast one.

Formulas of docs/conventions.md for BVH, ASF/AMC and HTR, each in its own convention, without the hub form.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mcml.motion.clip import ClipStream
from mcml.motion.skeleton import CHANNELS, Convention, Joint, numbers
from mcml.motion.units import reading_of


def positions(clip: ClipStream) -> np.ndarray:
    """(n, J, 3) world positions of the joints (ASF: the start of each bone)."""
    return np.stack(_walk(clip)[0], axis=1)


def tips(clip: ClipStream) -> dict[int, np.ndarray]:
    """(n, 3) world positions of the tip of each leaf, by joint."""
    skeleton = clip.head.skeleton
    ends = _walk(clip)[1]
    return {leaf: ends[leaf] for leaf in set(range(len(skeleton))) - {joint.parent for joint in skeleton.joints}}


Channels = dict[str, np.ndarray]


def _walk(clip: ClipStream) -> tuple[list[np.ndarray], list[np.ndarray]]:
    motion: list[Channels] = [{} for _ in clip.head.skeleton.joints]
    frames = 0
    for block in clip.blocks():
        frames += len(block)
        for (joint, channel), column in zip(block.columns, block.values.T, strict=True):
            before = motion[joint].get(CHANNELS[channel], np.empty(0))
            motion[joint][CHANNELS[channel]] = np.concatenate([before, column])
    walk = {Convention.LISTED: _bvh, Convention.FIXED: _asf, Convention.BASE: _htr}
    return walk[clip.head.skeleton.joints[0].convention](clip, motion, frames)


def _turns(values: Channels, letters: str, unit: float, frames: int) -> list[Rotation]:
    turns = []
    for letter in letters:
        angles = values.get(f"R{letter.lower()}", np.zeros(frames)) * unit
        turns.append(Rotation.from_rotvec(angles[:, None] * np.eye(3)["XYZ".index(letter)]))
    return turns


def _product(factors: list[Rotation], frames: int) -> Rotation:
    result = Rotation.from_rotvec(np.zeros((frames, 3)))
    for factor in factors:
        result = result * factor
    return result


def _translation(values: Channels, frames: int) -> np.ndarray:
    return np.stack([values.get(channel, np.zeros(frames)) for channel in ("Tx", "Ty", "Tz")], axis=-1)


def _bvh(clip: ClipStream, motion: list[Channels], frames: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    places: list[np.ndarray] = []
    turns: list[Rotation] = []
    ends: list[np.ndarray] = []
    for joint, values in zip(clip.head.skeleton.joints, motion, strict=True):
        local = _product(_turns(values, joint.rotation_order, np.pi / 180, frames), frames)
        offset = numbers(joint.offset)
        moved = np.tile(offset, (frames, 1))
        for axis, channel in enumerate(("Tx", "Ty", "Tz")):
            if channel in values:
                moved[:, axis] = values[channel] + (offset[axis] if joint.translation == "relative" else 0.0)
        _hang(joint, moved, local, places, turns)
        site = numbers(joint.end_sites[0].offset) if joint.end_sites else np.zeros(3)
        ends.append(places[-1] + turns[-1].apply(site))
    return places, ends


def _hang(joint: Joint, moved: np.ndarray, local: Rotation, places: list[np.ndarray], turns: list[Rotation]) -> None:
    """Appends where the joint is and how it is turned. moved, local: in the axes of its parent."""
    if joint.parent < 0:
        places.append(moved)
        turns.append(local)
    else:
        places.append(places[joint.parent] + turns[joint.parent].apply(moved))
        turns.append(turns[joint.parent] * local)


def _asf(clip: ClipStream, motion: list[Channels], frames: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    reading = reading_of(clip.head)
    starts: list[np.ndarray] = []
    turns: list[Rotation] = []
    ends: list[np.ndarray] = []
    for joint, values in zip(clip.head.skeleton.joints, motion, strict=True):
        # First listed is applied first, about fixed axes: the product is in reverse order.
        local = _product(_turns(values, joint.rotation_order, reading.motion_angle, frames)[::-1], frames)
        if joint.parent < 0:
            starts.append(numbers(joint.offset) + _translation(values, frames))
            turns.append(local)
            ends.append(starts[-1])
            continue
        axes = _rest_axes(joint, reading.rest_angle)
        parent = turns[joint.parent]
        starts.append(ends[joint.parent] + parent.apply(axes.apply(_translation(values, frames))))
        turns.append(parent * axes * local * axes.inv())
        direction = numbers(joint.direction)
        bone = direction * float(joint.length or 0) / np.linalg.norm(direction)
        ends.append(starts[-1] + turns[-1].apply(bone))
    return starts, ends


def _rest_axes(joint: Joint, unit: float) -> Rotation:
    """C: `axis a b c XYZ` turns about fixed axes, the first listed first."""
    return Rotation.from_euler((joint.axis_order or "XYZ").lower(), numbers(joint.axis) * unit)


def _htr(clip: ClipStream, motion: list[Channels], frames: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    reading = reading_of(clip.head)
    places: list[np.ndarray] = []
    turns: list[Rotation] = []
    ends: list[np.ndarray] = []
    for joint, values in zip(clip.head.skeleton.joints, motion, strict=True):
        base = {f"R{letter}": np.full(frames, angle) for letter, angle in zip("xyz", numbers(joint.axis), strict=True)}
        rest = _product(_turns(base, joint.rotation_order, reading.rest_angle, frames), frames)
        local = rest * _product(_turns(values, joint.rotation_order, reading.motion_angle, frames), frames)
        moved = numbers(joint.offset) + _translation(values, frames)
        _hang(joint, moved, local, places, turns)
        along = np.eye(3)[reading.bone_axis] * float(joint.length or 0) * values.get("SF", np.ones(frames))[:, None]
        ends.append(places[-1] + turns[-1].apply(along))
    return places, ends
