"""Transitions between pieces: new frames, blended frames, or a difference that decays; with standing feet held."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.edits.phase_matching import WINDOW, find_meeting, walks
from mcml.motion.edits.seam_feet import SeamFeet
from mcml.motion.edits.splicing import (
    Placement,
    Poses,
    bridge,
    crossfade,
    going_on,
    inertialize,
    jerks,
    joined_poses,
    placed,
    steps,
)
from mcml.motion.feet.legs import Side
from mcml.motion.feet.seams import Stance
from mcml.motion.frames import rows_of
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import HubWriter, Shortfall
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import Reading

Style = Literal["bridge", "crossfade", "inertial"]
LARGEST_JUMP = 1.1
"""Of the largest step inside the pieces: how far a seam may go from frame to frame."""
_LONGEST = 2000
"""Frames after which a transition is not made any longer."""
_TRIES = 8
"""Lengths of a transition at which feet are tried to be held."""
_CALM = 1.0
"""Of the usual jerk inside the pieces: up to this, a transition with held feet is made no longer."""


@dataclass
class Stretch:
    """Pieces that follow one another in their source, at the frame rate of the result.

    pieces: (piece, its first frame in this part, below 0 where its first frames are left out). fixed: its placement is
    given and not to be found. stance: of the feet, as they are before it is placed.
    """

    pieces: list[tuple[int, int]]
    block: FrameBlock
    raw: Array
    poses: Poses
    values: Array
    placement: Placement
    shortfall: Shortfall
    fixed: bool = False
    stance: Stance | None = None

    def after(self, first: int) -> Stretch:
        """Without the frames before one."""
        end = len(self.poses)
        return replace(
            self,
            pieces=[(piece, start - first) for piece, start in self.pieces],
            block=rows_of(self.block, first, end),
            raw=self.raw[first:],
            poses=self.poses.rows(first, end),
            values=self.values[first:],
            stance=None if self.stance is None else self.stance.rows(first, end),
        )

    def standing(self, first: int, end: int, placement: Placement) -> Stance | None:
        """Feet of frames `first` up to before `end`, placed."""
        if self.stance is None:
            return None
        rows = self.stance.rows(first, end)
        return rows if placement.shift is None else rows.place(placement.turn(), placement.shift)


@dataclass(frozen=True)
class Ending:
    """The side before a transition: a part, its placed poses, and the frames of it that are free."""

    part: Stretch
    poses: Poses
    start: int
    end: int


@dataclass(frozen=True)
class Transition:
    """between: its frames. cut: where the frames before it end; cut_after: where those after it begin.

    placement: of the part after it. root, angle: its largest steps. jerk: the largest, in parts of the 99th percentile
    inside the pieces. around: its frames with those next to it. locked: sides of feet held.
    """

    between: Poses | None
    cut: int
    cut_after: int
    placement: Placement
    root: float
    angle: float
    jerk: float
    around: Poses
    locked: tuple[Side, ...] = ()

    @property
    def jump(self) -> float:
        """The largest of its steps, in parts of the largest inside the pieces."""
        return max(self.root, self.angle)


@dataclass(frozen=True)
class TransitionMaker:
    """carry: joints that carry the body. largest: (2,) steps of root and angles inside the pieces. jerk: the 99th
    percentile inside the pieces. feet: None without legs. lock_feet: hold them.
    """

    skeleton: Skeleton
    reading: Reading
    carry: tuple[int, ...]
    largest: Array
    jerk: float
    feet: SeamFeet | None
    lock_feet: bool

    def meet(self, last: Ending, part: Stretch, transition: int, style: Style) -> tuple[Ending, Stretch]:
        """Leave out frames at the end of a part and at the beginning of the next, where both walk, to meet in phase.

        Frames of the transition count: new ones take the place of as many of the first walk. Both stay as they are
        where one of them does not walk, or has its placement given, or too few frames.
        """
        if self.feet is None or last.part.stance is None or part.stance is None or part.fixed:
            return last, part
        seconds, half = self.feet.frame_time, transition // 2
        window = max(2, round(WINDOW / seconds))
        # Frames from the end of the first walk to the one in which the poses meet, and from the beginning of the other.
        ahead, begins = {"bridge": (transition, 0), "inertial": (0, 0), "crossfade": (half - transition, half)}[style]
        first, end = max(last.end - window, last.start + 2 + max(ahead, half)), last.end + min(ahead, 0)
        most = min(begins + window, len(part.poses) - transition - 2)
        if end - first < 2 or most - begins < 2:
            return last, part
        if not (walks(last.part.stance.rows(first, end)) and walks(part.stance.rows(begins, most))):
            return last, part
        one, two = last.part.poses.rows(first, end), part.poses.rows(begins, most)
        row, column = find_meeting(self.skeleton, one, two, self.carry[0], self.feet.up, seconds)
        return replace(last, end=first + row - ahead), part.after(column)

    def make(
        self, last: Ending, part: Stretch, transition: int, style: Style, align: bool, lengthen: bool
    ) -> Transition:
        """The transition to a part, of so many frames or longer.

        Without held feet it is made longer until nothing jumps. Then feet are held, if need be over some more frames
        for a step; where that makes a jump they are not held.
        """
        may_grow = lengthen and transition > 0 and bool(self.largest.all())
        most = self._room(last, part, style) if may_grow else transition
        frames = transition
        made = self._attempt(last, part, frames, style, align, None)
        while made.jump > LARGEST_JUMP and _longer(frames) <= most:
            frames = _longer(frames)
            made = self._attempt(last, part, frames, style, align, None)
        if not self.lock_feet or self.feet is None or made.between is None:
            return made
        calmest = made
        for _ in range(_TRIES):
            held = self._attempt(last, part, frames, style, align, self.feet)
            if held.jump <= max(LARGEST_JUMP, made.jump):
                if held.jerk <= max(_CALM, made.jerk):
                    return held
                if calmest is made or held.jerk < calmest.jerk:
                    calmest = held
            if _longer(frames) > most:
                break
            frames = _longer(frames)
        return calmest

    def _room(self, last: Ending, part: Stretch, style: Style) -> int:
        if style == "bridge":
            return _LONGEST
        rest = len(part.poses) - 1
        return rest if style == "inertial" else min(last.end - last.start - 1, rest)

    def _attempt(
        self, last: Ending, part: Stretch, frames: int, style: Style, align: bool, feet: SeamFeet | None
    ) -> Transition:
        if style != "bridge":
            frames = min(frames, len(part.poses), last.end - last.start if style == "crossfade" else frames)
        if style == "crossfade" and frames:
            # At the middle of the blend both are in the same place.
            first, half = last.end - frames, frames // 2
            placement = self._place(last, part, (first + half, half), 0.0, align, feet)
            after = self._after(part, frames + 2, placement)
            between = crossfade(last.poses.rows(first, last.end), after.rows(0, frames))
            return self._finish(last, part, between, (first, frames), placement, after.rows(frames, frames + 2), feet)
        own = frames if style == "inertial" else 0
        placement = self._place(last, part, (last.end - 1, 0), 1.0 if own else frames + 1.0, align, feet)
        after = self._after(part, own + 2, placement)
        before = last.poses.rows(max(last.end - 2, 0), last.end)
        made = inertialize(before, after, own) if own else bridge(before, after, frames) if frames else None
        return self._finish(last, part, made, (last.end, own), placement, after.rows(own, own + 2), feet)

    def _after(self, part: Stretch, frames: int, placement: Placement) -> Poses:
        return placed(self.skeleton, part.poses.rows(0, frames), self.carry, placement)

    def _place(
        self, last: Ending, part: Stretch, rows: tuple[int, int], ahead: float, align: bool, feet: SeamFeet | None
    ) -> Placement:
        """Place a part. rows: the frames of the last part and of this one that meet, `ahead` frames apart."""
        if not align or part.fixed:
            return part.placement
        one, two = rows
        points = all(joint.convention is Convention.MARKER for joint in self.skeleton.joints)
        before, after = last.poses.rows(max(one - 1, 0), one + 1), part.poses.rows(two, two + 2)
        placement = going_on(self.skeleton, before, after, self.carry, part.placement.up, ahead, points)
        standing = last.part.standing(one, one + 1, last.part.placement)
        if feet is None or standing is None or part.stance is None:
            return placement
        return feet.keep_foot(placement, standing, part.stance.rows(two, two + 1))

    def _finish(
        self,
        last: Ending,
        part: Stretch,
        between: Poses | None,
        cuts: tuple[int, int],
        placement: Placement,
        after: Poses,
        feet: SeamFeet | None,
    ) -> Transition:
        """The transition with feet held, as channels can represent it, beside its neighbours. after: from its end."""
        cut, cut_after = cuts
        locked: tuple[Side, ...] = ()
        if between is not None:
            between = self._nearest(between)
            frames = len(between)
            # New frames have on each side the pose of the frame that they lead from or to.
            ending = last.part.standing(min(cut, last.end - 1), last.end, last.part.placement)
            beginning = part.standing(0, max(cut_after, 1), placement)
            if feet is not None and ending is not None and beginning is not None:
                held, locked = feet.lock(
                    between, ending.over(frames), beginning.over(frames), HubWriter(self.skeleton, self.reading)
                )
                between = self._nearest(held)
        before = last.poses.rows(max(cut - 3, 0), cut)
        middle = [between] if between else []
        near = joined_poses([before.rows(len(before) - 1, len(before)), *middle, after.rows(0, 1)])
        around = joined_poses([before, *middle, after])
        return Transition(
            between, cut, cut_after, placement, *self._jump(near), self._suddenness(around), around, locked
        )

    def _nearest(self, poses: Poses) -> Poses:
        """Return the nearest poses that the channels can represent: joints may have fewer than three angles."""
        writer = HubWriter(self.skeleton, self.reading)
        values = writer.write(poses.translations, poses.rotations, poses.scales)
        ids = np.arange(len(values), dtype=np.int64)
        block = FrameBlock(values, writer.columns, (full_shape(writer.columns),), ids)
        hub = HubReader(self.skeleton, self.reading).read(block)
        return Poses(hub.translations, hub.rotations, hub.scales)

    def _jump(self, around: Poses) -> tuple[float, float]:
        """The largest steps, in parts of the largest inside the parts."""
        root, angle = (
            step / most if most else (0.0 if step < 1e-9 else np.inf)
            for step, most in zip(steps(self.skeleton, around, self.carry), self.largest, strict=True)
        )
        return float(root), float(angle)

    def _suddenness(self, around: Poses) -> float:
        largest = float(jerks(self.skeleton, around).max(initial=0.0))
        return largest / self.jerk if self.jerk else (0.0 if largest < 1e-9 else np.inf)


def _longer(frames: int) -> int:
    return frames + max(1, frames // 4)
