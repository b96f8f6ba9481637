"""A new clip of pieces of others: one after the other, or the bones of one on the body of another.

Raw values stay bit by bit wherever nothing was changed: pieces that follow one another in their source are one piece.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.carriers import carriers
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.edits.resampling import frame_places, sampled
from mcml.motion.edits.splicing import Placement, Poses, bridge, crossfade, going_on, joined_poses, placed, steps
from mcml.motion.frames import Edited, Rows, in_columns, joined, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import Flags, HubWriter, Known, Shortfall
from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading
from mcml.numerics.runs import find_true

Style = Literal["bridge", "crossfade"]
LARGEST_JUMP = 1.1
"""Of the largest step inside the pieces: how far a seam may go from frame to frame."""
_LONGEST = 2000
"""Frames after which a transition is not made any longer."""


@dataclass(frozen=True)
class Piece:
    """Frames of a clip, on the skeleton of the result (`retarget` brings them there).

    frame_time: seconds. source: which clip, "" for none. first: the place of the first frame in it.
    """

    block: FrameBlock
    frame_time: float
    source: str = ""
    first: int = 0


@dataclass(frozen=True)
class Seam:
    """Where two pieces meet, in frames of the result from 0.

    piece: the one that begins. frames: of the transition; first: its first one, or the first frame of the piece.
    turn: radians about the axis up and shift (3,) by which the piece was placed. root_step, angle_step: the largest
    step over the seam, in parts of the largest inside the pieces (0 where nothing moves in them nor there).
    """

    piece: int
    first: int
    frames: int
    turn: float
    shift: Array
    root_step: float
    angle_step: float


@dataclass(frozen=True)
class Composed:
    """The result of a composition.

    spans: (piece, first frame, last frame) in the result, from 0, of the part of each piece outside transitions;
    omitted if empty.
    """

    block: FrameBlock
    shortfall: Shortfall
    seams: tuple[Seam, ...]
    spans: tuple[tuple[int, int, int], ...]


@dataclass
class _Stretch:
    """Pieces that follow one another in their source, at the frame rate of the result."""

    pieces: list[tuple[int, int]]
    """(piece, its first frame in this part)."""
    block: FrameBlock
    raw: Array
    poses: Poses
    values: Array
    placement: Placement
    shortfall: Shortfall


def compose(
    skeleton: Skeleton,
    pieces: Sequence[Piece],
    frame_time: float,
    *,
    transition: int = 0,
    transitions: Sequence[int | None] = (),
    style: Style = "bridge",
    styles: Sequence[Style | None] = (),
    lengthen: bool = True,
    align: bool = True,
    up: str = "Y",
    reading: Reading = DEGREES,
) -> Composed:
    """Compose pieces one after the other, on one skeleton, at one frame time (seconds).

    transition: frames between pieces that are not consecutive in their source; transitions: before each of the pieces,
    if they differ (None: as `transition`); styles likewise. "bridge" makes new frames between them, "crossfade" blends
    existing ones; 0: none. lengthen: add frames until no step of the root or of a joint angle is larger than 1.1 times
    the largest inside the pieces (a crossfade only as far as the pieces go). align: rotate each piece about the up axis
    and shift it on the ground so that the body continues; else it keeps its place. Raises ConversionError without
    pieces, for empty ones and for a negative transition.
    """
    if not pieces or any(not len(piece.block) for piece in pieces):
        raise ConversionError("there is nothing to compose", remedy="Name pieces that have frames.")
    if not len(skeleton):
        raise ConversionError("the skeleton has no joints to move", remedy="Leave documents without joints out.")
    least = min([transition, *(own for own in transitions if own is not None)])
    if least < 0:
        raise ConversionError(f"{least} frames are no transition", remedy="Give 0 or more.")
    axis = np.eye(3)["XYZ".index(up.upper())]
    parts = [_part(skeleton, run, frame_time, axis, reading) for run in _runs(pieces)]
    carry = carriers(skeleton, *(part.poses.translations for part in parts))
    largest = np.max([steps(skeleton, part.poses, carry) for part in parts], axis=0)
    track = _Track(skeleton, reading, carry, largest, lengthen)
    track.start(parts[0])
    for part in parts[1:]:
        piece = part.pieces[0][0]
        own = transitions[piece] if piece < len(transitions) else None
        how = styles[piece] if piece < len(styles) else None
        track.add(part, transition if own is None else own, how or style, align)
    return track.finish(parts)


def _runs(pieces: Sequence[Piece]) -> list[list[tuple[int, Piece]]]:
    runs: list[list[tuple[int, Piece]]] = []
    for index, piece in enumerate(pieces):
        last = runs[-1][-1][1] if runs else None
        follows = (
            last is not None
            and bool(piece.source)
            and piece.source == last.source
            and piece.frame_time == last.frame_time
            and piece.first == last.first + len(last.block)
        )
        if follows:
            runs[-1].append((index, piece))
        else:
            runs.append([(index, piece)])
    return runs


def _part(skeleton: Skeleton, run: list[tuple[int, Piece]], frame_time: float, up: Array, reading: Reading) -> _Stretch:
    block = joined(piece.block for _, piece in run)
    starts = np.cumsum([0, *(len(piece.block) for _, piece in run[:-1])])
    old = run[0][1].frame_time
    shortfall = Shortfall(np.zeros(len(skeleton)), np.zeros(len(skeleton)))
    if old != frame_time:
        places = frame_places(len(block), old, frame_time)
        edited = sampled(skeleton, block, places, reading)
        block, shortfall = edited.block, edited.shortfall
        starts = np.searchsorted(places, starts)
    hub = HubReader(skeleton, reading).read(block)
    first = [(index, int(start)) for (index, _), start in zip(run, starts, strict=True)]
    raw = in_columns(block, skeleton.columns())
    poses = Poses(hub.translations, hub.rotations, hub.scales)
    return _Stretch(first, block, raw, poses, hub.values, Placement(up), shortfall)


_Attempt: TypeAlias = tuple[Poses | None, int, int, float, float]
"""A transition: its frames, where the frames before it end, where those after it begin, its largest steps."""


class _Track:
    """The frames so far: ranges of parts, and transitions between them."""

    def __init__(
        self, skeleton: Skeleton, reading: Reading, carry: tuple[int, ...], largest: Array, lengthen: bool
    ) -> None:
        self._skeleton, self._reading, self._carry = skeleton, reading, carry
        self._largest, self._lengthen = largest, lengthen
        self._points = all(joint.convention is Convention.MARKER for joint in skeleton.joints)
        self._parts: list[_Stretch] = []
        self._placed: list[Poses] = []
        self._cuts: list[tuple[int, int]] = []
        """(first, after the last) of the unchanged frames of each part."""
        self._between: list[Poses | None] = []
        self._seams: list[tuple[int, float, float]] = []

    def start(self, part: _Stretch) -> None:
        self._parts.append(part)
        self._placed.append(part.poses)
        self._cuts.append((0, len(part.poses)))

    def add(self, part: _Stretch, transition: int, style: Style, align: bool) -> None:
        frames = transition
        while True:
            attempt = (
                self._crossfaded(part, frames, align) if style == "crossfade" else self._bridged(part, frames, align)
            )
            between, cut, cut_after, root, angle = attempt
            done = max(root, angle) <= LARGEST_JUMP or not self._lengthen or not transition
            longer = frames + max(1, frames // 4)
            if done or longer > self._room(part, style) or not self._largest.all():
                break
            frames = longer
        self._cuts[-1] = (self._cuts[-1][0], cut)
        self._parts.append(part)
        self._placed.append(placed(self._skeleton, part.poses, self._carry, part.placement))
        self._cuts.append((cut_after, len(part.poses)))
        self._between.append(between)
        self._seams.append((0 if between is None else len(between), root, angle))

    def _room(self, part: _Stretch, style: Style) -> int:
        start, end = self._cuts[-1]
        return _LONGEST if style == "bridge" else min(end - start, len(part.poses)) - 1

    def _bridged(self, part: _Stretch, frames: int, align: bool) -> _Attempt:
        end = self._cuts[-1][1]
        before = self._placed[-1].rows(max(end - 2, 0), end)
        self._place(part, before, part.poses.rows(0, 2), frames + 1.0, align)
        after = placed(self._skeleton, part.poses.rows(0, 2), self._carry, part.placement)
        between = self._held(bridge(before, after, frames)) if frames else None
        around = [before.rows(len(before) - 1, len(before)), *([between] if between else []), after.rows(0, 1)]
        return between, end, 0, *self._jump(around)

    def _crossfaded(self, part: _Stretch, frames: int, align: bool) -> _Attempt:
        start, end = self._cuts[-1]
        frames = min(frames, end - start, len(part.poses))
        if not frames:
            return self._bridged(part, 0, align)
        # At the middle of the blend both are in the same place.
        first, half = end - frames, frames // 2
        before = self._placed[-1]
        middle = first + half + 1
        self._place(part, before.rows(max(middle - 2, 0), middle), part.poses.rows(half, half + 2), 0.0, align)
        after = placed(self._skeleton, part.poses.rows(0, frames + 1), self._carry, part.placement)
        between = self._held(crossfade(before.rows(first, end), after.rows(0, frames)))
        around = [before.rows(max(first - 1, 0), first), between, after.rows(frames, frames + 1)]
        return between, first, frames, *self._jump(around)

    def _place(self, part: _Stretch, before: Poses, after: Poses, ahead: float, align: bool) -> None:
        if align:
            up = part.placement.up
            part.placement = going_on(self._skeleton, before, after, self._carry, up, ahead, self._points)

    def _held(self, poses: Poses) -> Poses:
        """Return the nearest poses that the channels can represent: joints may have fewer than three angles."""
        writer = HubWriter(self._skeleton, self._reading)
        values = writer.write(poses.translations, poses.rotations, poses.scales)
        ids = np.arange(len(values), dtype=np.int64)
        block = FrameBlock(values, writer.columns, (full_shape(writer.columns),), ids)
        hub = HubReader(self._skeleton, self._reading).read(block)
        return Poses(hub.translations, hub.rotations, hub.scales)

    def _jump(self, around: list[Poses]) -> tuple[float, float]:
        """The largest steps, in parts of the largest inside the parts."""
        found = steps(self._skeleton, joined_poses(around), self._carry)
        root, angle = (
            step / most if most else (0.0 if step < 1e-9 else np.inf)
            for step, most in zip(found, self._largest, strict=True)
        )
        return float(root), float(angle)

    def finish(self, parts: list[_Stretch]) -> Composed:
        columns = self._skeleton.columns()
        source = joined(part.block for part in parts)
        starts = np.cumsum([0, *(len(part.poses) for part in parts)])
        poses: list[Poses] = []
        rows: list[Rows] = []
        made: list[Flags] = []
        kept: list[Flags] = []
        seams: list[Seam] = []
        spans: list[tuple[int, int, int]] = []
        at = 0
        for place, part in enumerate(parts):
            first, end = self._cuts[place]
            holds = np.ones((end - first, len(self._skeleton)), dtype=bool)
            if not part.placement.is_nothing:
                holds[:, list(self._carry)] = False
            spans += _spans(part, first, end, at)
            poses.append(self._placed[place].rows(first, end))
            rows.append(starts[place] + np.arange(first, end))
            made.append(np.zeros(end - first, dtype=bool))
            kept.append(holds)
            at += end - first
            if place == len(parts) - 1:
                break
            frames, root, angle = self._seams[place]
            following = parts[place + 1].placement
            shift = np.zeros(3) if following.shift is None else following.shift
            seams.append(Seam(parts[place + 1].pieces[0][0], at, frames, following.angle, shift, root, angle))
            between = self._between[place]
            if between is not None:
                poses.append(between)
                middle = np.arange(frames) < frames / 2
                rows.append(np.where(middle, starts[place] + max(end - 1, 0), starts[place + 1]))
                made.append(np.ones(frames, dtype=bool))
                kept.append(np.zeros((frames, len(self._skeleton)), dtype=bool))
                at += frames
        row, new = np.concatenate(rows), np.concatenate(made)
        whole = joined_poses(poses)
        writer = HubWriter(self._skeleton, self._reading)
        known = Known(np.concatenate([part.values for part in parts])[row], np.concatenate(kept))
        values = writer.write(whole.translations, whole.rotations, whole.scales, known)
        raw = np.concatenate([part.raw for part in parts])
        values[np.isnan(raw[row])] = np.nan
        self._leave_gaps(parts, new, raw, values, starts)
        block = remade(source, columns, values, row)
        if block.motion_names is not None:
            names = [() if fresh else name for fresh, name in zip(new, block.motion_names, strict=True)]
            block = replace(block, motion_names=names)
        shortfall = writer.shortfall
        for part in parts:
            shortfall = shortfall.worse_of(part.shortfall)
        return Composed(block, shortfall, tuple(seams), tuple(spans))

    def _leave_gaps(self, parts: list[_Stretch], new: Flags, raw: Array, values: Array, starts: Rows) -> None:
        """A transition has no sample where either of its ends has none."""
        seams = [place for place, between in enumerate(self._between) if between is not None and len(between)]
        for (first, end), place in zip(find_true(new), seams, strict=False):
            cut, following = self._cuts[place][1], self._cuts[place + 1][0]
            last = raw[starts[place] + min(max(cut - 1, 0), len(parts[place].raw) - 1)]
            after = raw[starts[place + 1] + min(following, len(parts[place + 1].raw) - 1)]
            values[first:end, np.isnan(last) | np.isnan(after)] = np.nan


def _spans(part: _Stretch, first: int, end: int, at: int) -> list[tuple[int, int, int]]:
    edges = [*(start for _, start in part.pieces), len(part.poses)]
    found = []
    for (index, start), stop in zip(part.pieces, edges[1:], strict=True):
        low, high = max(start, first), min(stop, end)
        if low < high:
            found.append((index, at + low - first, at + high - first - 1))
    return found


def layered(
    skeleton: Skeleton,
    base: FrameBlock,
    over: FrameBlock,
    joints: Sequence[int],
    strength: Array,
    reading: Reading = DEGREES,
    first: int = 0,
) -> Edited:
    """Joints of one clip on the body of another, frame by frame: the arms of a wave on the legs of a walk.

    joints: they rotate, and move in their parents, as in `over`; the others as in `base`. strength: (n,) for the frames
    of the base: 0 its own, 1 the other's, bit by bit; in between, interpolated. first: frame of the base, from 0, where
    `over` begins. Before it, and after the end of `over`, the base is unchanged.
    """
    columns = skeleton.columns()
    place = np.arange(len(base)) - first
    rows = np.clip(place, 0, max(len(over) - 1, 0))
    share = np.where((place >= 0) & (place < len(over)), strength, 0.0)
    one, two = (HubReader(skeleton, reading).read(block) for block in (base, over))
    chosen = np.unique(np.array(joints, dtype=np.intp))
    moved, turned, scales = one.translations.copy(), one.rotations.copy(), one.scales.copy()
    part = np.broadcast_to(share[:, None], (len(base), len(chosen)))
    moved[:, chosen] += part[..., None] * (two.translations[rows][:, chosen] - moved[:, chosen])
    scales[:, chosen] += part * (two.scales[rows][:, chosen] - scales[:, chosen])
    turned[:, chosen] = slerp(turned[:, chosen], two.rotations[rows][:, chosen], part)
    values, holds = one.values.copy(), np.ones((len(base), len(skeleton)), dtype=bool)
    holds[:, chosen] = ((share == 0) | (share == 1))[:, None]
    taken = np.array([joint in set(chosen.tolist()) for joint, _ in columns], dtype=bool)
    whole = np.ix_(np.flatnonzero(share == 1), np.flatnonzero(taken))
    values[whole] = two.values[rows][whole]
    writer = HubWriter(skeleton, reading)
    written = writer.write(moved, turned, scales, Known(values, holds))
    gaps, others = np.isnan(in_columns(base, columns)), np.isnan(in_columns(over, columns))[rows]
    gaps = np.where(taken, (gaps & (share < 1)[:, None]) | (others & (share > 0)[:, None]), gaps)
    written[gaps] = np.nan
    return Edited(remade(base, columns, written, np.arange(len(base), dtype=np.intp), base.ids), writer.shortfall)
