"""Positions of a motion that is not stored, for those who look at it before it is."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import NotFoundError, SizeError
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.guesses import up_of_head
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker
from mcml.motion.units import metres_of, reading_of
from mcml_schemas.frames import PreviewMotion

MOST_FRAMES = 4096
"""Of one answer."""


@dataclass(frozen=True)
class Window:
    """Every step-th of frames first to last, from 1; None: as many as an answer holds."""

    first: int = 1
    last: int | None = None
    step: int = 1

    @property
    def end(self) -> int:
        """The last returned frame. Raises SizeError if an answer would be too large."""
        most = self.first + MOST_FRAMES * self.step - 1
        if self.last is not None and self.last > most:
            raise SizeError(f"A response holds {MOST_FRAMES} frames.", remedy=f"Ask for {self.first} to {most} first.")
        return most if self.last is None else self.last


def preview_motion(
    head: ClipHead, blocks: Iterable[FrameBlock], window: Window, seconds: float | None
) -> PreviewMotion:
    """Return global positions of the joints, then of the ends of chains, as in `format=block`, relative to their
    origin. blocks: the whole motion. A missing sample keeps its last value, from the first frame of the motion on.
    Raises NotFoundError outside the motion.
    """
    skeleton = head.skeleton
    walker = Walker(skeleton, reading_of(head))
    end, at = window.end, 0
    parts: list[np.ndarray] = []
    origin = np.zeros(3)
    pose = np.zeros((len(skeleton), 3))
    for block in blocks:
        if at >= end:
            break
        some = block if len(block) <= end - at else _beginning(block, end - at)
        positions, _, ends = walker.poses_with_tips(some)
        if at == 0 and len(positions) and len(skeleton):
            pose, origin = positions[0], positions[0, 0].copy()
        points = np.concatenate([positions, ends], axis=1) - origin
        # The first row of this block in the window, on its steps.
        skipped = window.first - 1 - at
        parts.append(points[skipped if skipped >= 0 else skipped % window.step :: window.step])
        at += len(some)
    tips = [joint for joint, _ in rest_of(skeleton, reading_of(head)).tips]
    every_position = np.concatenate([*parts, np.empty((0, len(skeleton) + len(tips), 3))])
    if not len(every_position) and at:
        raise NotFoundError(f"The motion has {at} frames.", remedy="Ask for frames within it.")
    return PreviewMotion(
        first=window.first,
        shape=list(every_position.shape),
        bones=list(skeleton.names),
        parents=[*(joint.parent for joint in skeleton.joints), *tips],
        origin=origin.tolist(),
        seconds_per_frame=seconds,
        up=head.fields.get("global_axis_of_gravity", "").strip().upper() or up_of_head(head, pose).axis,
        metres=metres_of(head),
        data=base64.b64encode(every_position.astype("<f4").tobytes()).decode(),
    )


def _beginning(block: FrameBlock, frames: int) -> FrameBlock:
    shape_of = None if block.shape_of is None else block.shape_of[:frames]
    return replace(block, values=block.values[:frames], ids=block.ids[:frames], shape_of=shape_of, motion_names=None)
