"""The body of a clip in space: the positions of its joints in every frame, and its calibration."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.bodies.calibration import Calibration, Shared, calibrate, calibration_frames
from mcml.motion.bodies.positions import Filled, Steps, clip_positions, filled, rounded
from mcml.motion.bodies.quantities import AskedQuantity, compute
from mcml.motion.bodies.reference import pose_in, stance_of
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.bodies.turned_angles import turned_angle
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, ReferencePose
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.landmarks.centres import body_names, centres_of, with_centres
from mcml.motion.layout import Held
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of

FRAMES_TOGETHER = 8192
"""Frames of which all joints are in memory at a time, where few are wanted of each."""


@dataclass(frozen=True, eq=False)
class ClipBody:
    """names: of the joints, MCML's where they are known, and of centres that markers tell. steps: (frames, points, 3)
    positions as whole steps of the calibration. frame_time: seconds, None where unknown. doubtful: names of MCML's that
    are guesses."""

    names: tuple[str, ...]
    steps: Steps
    calibration: Calibration
    frame_time: float | None
    doubtful: tuple[str, ...] = ()

    def stretch(self, joints: Collection[str]) -> Stretch:
        """All frames, with the joints of these names that it has."""
        places = {name: self.steps[:, place] for place, name in enumerate(self.names) if name in joints}
        return Stretch(places, len(self.steps), self.frame_time, self.calibration)


def body_of(head: ClipHead, blocks: Iterable[FrameBlock]) -> ClipBody:
    """The body of a clip. blocks: from the first frame on."""
    skeleton = head.skeleton
    frames = filled(skeleton, blocks)
    (positions,) = clip_positions(skeleton, [frames], reading_of(head))
    return body_at(head, positions, frames.values)


def body_at(head: ClipHead, positions: Array, values: Array | None = None, shared: Shared | None = None) -> ClipBody:
    """The body of a clip whose joints are at positions (n, J, 3), in source units, NaN where unknown.

    values: (n, D) of the skeleton's columns, as far as the clip has more than positions. shared: as `calibrate` takes
    it.
    """
    frames = calibration_frames(len(positions))
    sample = positions if len(frames) == len(positions) else positions[frames]
    pose_at = None if values is None else partial(pose_of_frame, head, values)
    calibration = calibrate(head, sample, frames=frames, pose_at=pose_at, shared=shared)
    steps = rounded(with_centres(centres_of(head.skeleton), positions), calibration.step)
    return ClipBody(body_names(head.skeleton), steps, calibration, head.seconds_per_frame(), head.skeleton.doubtful)


def calibrate_clip(
    clip: ClipStream, frames: int, overrides: Mapping[str, Any] | None = None, shared: Shared | None = None
) -> Calibration:
    """Calibrate a clip with a known number of frames; it is read once, in blocks.

    overrides, shared: as for `calibrate`.
    """
    rows = calibration_frames(frames)
    wanted = set(rows.tolist())
    sample = [np.empty((0, len(clip.head.skeleton), 3))]
    kept: dict[int, Array] = {}
    for first, values, positions in _walked(clip):
        chosen = rows[(rows >= first) & (rows < first + len(values))] - first
        sample.append(positions[chosen])
        kept.update(zip((chosen + first).tolist(), values[chosen], strict=True))

    def pose_at(frame: int) -> ReferencePose:
        if frame not in wanted:
            row = next(values[frame - at] for at, values, _ in _walked(clip) if frame < at + len(values))
            return pose_in(clip.head.skeleton, reading_of(clip.head), row)
        return pose_in(clip.head.skeleton, reading_of(clip.head), kept[frame])

    return calibrate(clip.head, np.concatenate(sample), overrides, rows, pose_at=pose_at, shared=shared)


def steps_of(clip: ClipStream, step: float) -> Iterator[Steps]:
    """Rounded positions of a clip, (n, points, 3) in the order of `body_names`, some frames at a time."""
    centres = centres_of(clip.head.skeleton)
    for _, _, positions in _walked(clip):
        yield rounded(with_centres(centres, positions), step)


def _walked(clip: ClipStream) -> Iterator[tuple[int, Array, Array]]:
    """(place of the first, values (n, D) without gaps, positions (n, J, 3), NaN where unknown) of frames in turn."""
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    held, first = Held(skeleton), 0
    for blocks in _together(clip.blocks()):
        values = np.concatenate([held.values(block) for block in blocks])
        gaps = np.concatenate([unseen(skeleton, block) for block in blocks]) if held.missing else None
        (positions,) = clip_positions(skeleton, [Filled(values, gaps)], reading)
        yield first, values, positions
        first += len(values)


def pose_of_frame(head: ClipHead, values: Array, frame: int) -> ReferencePose:
    """The pose of one frame, as a reference for angles. values: (n, D) of the skeleton's columns."""
    return pose_in(head.skeleton, reading_of(head), values[frame])


def turned_degrees(clip: ClipStream, name: str, calibration: Calibration) -> Array:
    """(n,) degrees of an angle that takes rotations (`limb_angles.turn_named`), NaN where unknown. Some frames at a
    time are in memory with all joints."""
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    stance = None
    # If left and right are unknown there are no such angles.
    with suppress(ConversionError):
        stance = stance_of(calibration.start, skeleton, reading)
    walker, held = Walker(skeleton, reading), Held(skeleton)
    rest = rest_of(skeleton, reading)
    found: list[Array] = [np.empty(0)]
    for blocks in _together(clip.blocks()):
        values = np.concatenate([held.values(block) for block in blocks])
        if stance is None:
            found.append(np.full(len(values), np.nan))
            continue
        gaps = np.concatenate([unseen(skeleton, block) for block in blocks]) if held.missing else None
        _, rotations = walker.poses_at(values)
        found.append(turned_angle(name, skeleton, rest, stance, rotations, gaps))
    degrees = np.concatenate(found)
    degrees[: calibration.skipped] = np.nan
    return degrees


def _together(blocks: Iterable[FrameBlock]) -> Iterator[list[FrameBlock]]:
    """Join consecutive blocks until they have enough frames for efficient work on one array."""
    some: list[FrameBlock] = []
    for block in blocks:
        some.append(block)
        if sum(map(len, some)) >= FRAMES_TOGETHER:
            yield some
            some = []
    if some:
        yield some


def quantity_values(clip: ClipStream, body: ClipBody, asked: AskedQuantity) -> Array:
    """(n,) values of a quantity in every frame, NaN where unknown. NotFoundError for a joint that the body has not."""
    asked.check_joints(body.names)
    if asked.needs_rotations:
        return turned_degrees(clip, asked.arguments[0], body.calibration)
    return compute(asked.name, asked.arguments, body.stretch(asked.joints(body.names)))
