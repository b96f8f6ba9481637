"""The body of a clip in space: the positions of its joints in every frame, and its calibration."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.bodies.bone_axes import HingeSums, line_of, line_steps, sum_hinges
from mcml.motion.bodies.calibration import Calibration, Shared, calibrate, calibration_frames
from mcml.motion.bodies.positions import Filled, Steps, clip_positions, filled, rounded
from mcml.motion.bodies.quantities import AskedQuantity, compute
from mcml.motion.bodies.reference import pose_in, stance_of
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.bodies.turned_angles import turned_angle
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, ReferencePose
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.landmarks.centres import body_names, centres_of, doubtful_names, with_centres
from mcml.motion.landmarks.sizes import sizes_of
from mcml.motion.layout import Held
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of

FRAMES_TOGETHER = 8192
"""Frames of which all joints are in memory at a time, where few are wanted of each."""


@dataclass(frozen=True, eq=False)
class ClipBody:
    """names: of the joints, MCML's where they are known, and of centres that markers tell. steps: (frames, points, 3)
    positions as whole steps of the calibration, then the lines to the left of bones (`bone_axes.line_steps`). lines:
    names of these. frame_time: seconds, None where unknown. doubtful: names of MCML's that are guesses."""

    names: tuple[str, ...]
    steps: Steps
    calibration: Calibration
    frame_time: float | None
    doubtful: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()

    def stretch(self, joints: Collection[str]) -> Stretch:
        """All frames, with the joints, and the lines to the left, of these names that it has."""
        every = enumerate((*self.names, *self.lines))
        places = {name: self.steps[:, place] for place, name in every if name in joints}
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
    hinges_of = None if values is None else lambda: _hinges_in(head, sample, values[frames])
    calibration = calibrate(head, sample, frames=frames, pose_at=pose_at, shared=shared, hinges_of=hinges_of)
    lines, steps = _steps(head, calibration, positions, values)
    names, doubtful = body_names(head.skeleton), doubtful_names(head.skeleton)
    return ClipBody(names, steps, calibration, head.seconds_per_frame(), doubtful, lines)


def _steps(
    head: ClipHead, calibration: Calibration, positions: Array, values: Array | None
) -> tuple[tuple[str, ...], Steps]:
    """The names of lines to the left, and positions and lines as whole steps."""
    points = with_centres(centres_of(head.skeleton), positions, sizes_of(head, calibration.metres))
    lines, sides = line_steps(head.skeleton, calibration.bones, points, values, reading_of(head))
    steps = rounded(points, calibration.step)
    return lines, np.concatenate([steps, sides], axis=1) if lines else steps


def calibrate_clip(
    clip: ClipStream, frames: int, overrides: Mapping[str, Any] | None = None, shared: Shared | None = None
) -> Calibration:
    """Calibrate a clip with a known number of frames; it is read once, in blocks.

    overrides, shared: as for `calibrate`.
    """
    rows = calibration_frames(frames)
    place = {frame: index for index, frame in enumerate(rows.tolist())}
    positions, kept = _sample(clip, frames)

    def pose_at(frame: int) -> ReferencePose:
        if frame not in place:
            row = next(values[frame - at] for at, values, _ in _walked(clip) if frame < at + len(values))
            return pose_in(clip.head.skeleton, reading_of(clip.head), row)
        return pose_in(clip.head.skeleton, reading_of(clip.head), kept[place[frame]])

    def hinges_of() -> dict[str, HingeSums]:
        return _hinges_in(clip.head, positions, kept)

    return calibrate(clip.head, positions, overrides, rows, pose_at=pose_at, shared=shared, hinges_of=hinges_of)


def hinges_in_clip(clip: ClipStream, frames: int) -> dict[str, HingeSums]:
    """Sum the bends of the knees of a clip with a known number of frames, see `pool_hinges`."""
    return _hinges_in(clip.head, *_sample(clip, frames))


def _sample(clip: ClipStream, frames: int) -> tuple[Array, Array]:
    """Positions (n, J, 3) and values (n, D) of the frames that a calibration looks at."""
    rows = calibration_frames(frames)
    skeleton = clip.head.skeleton
    places, kept = [np.empty((0, len(skeleton), 3))], [np.empty((0, len(skeleton.columns())))]
    for first, values, positions in _walked(clip):
        chosen = rows[(rows >= first) & (rows < first + len(values))] - first
        places.append(positions[chosen])
        kept.append(values[chosen])
    return np.concatenate(places), np.concatenate(kept)


def _hinges_in(head: ClipHead, positions: Array, values: Array) -> dict[str, HingeSums]:
    """Of positions (n, J, 3), NaN where unknown, and values (n, D) of the skeleton's columns."""
    _, rotations = Walker(head.skeleton, reading_of(head)).poses_at(values)
    return sum_hinges(head.skeleton, positions, rotations)


def lines_of(calibration: Calibration) -> tuple[str, ...]:
    """The names of the lines to the left in a body with rotations."""
    return tuple(map(line_of, calibration.bones))


def steps_of(clip: ClipStream, calibration: Calibration) -> Iterator[Steps]:
    """Rounded positions of a clip in the order of `body_names`, then those of `lines_of`, (n, points, 3), some frames
    at a time."""
    for _, values, positions in _walked(clip):
        yield _steps(clip.head, calibration, positions, values)[1]


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
