"""A new clip of pieces of others, one after the other.

Raw values stay bit by bit wherever nothing was changed: pieces that follow one another in their source are one piece.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.carriers import carriers
from mcml.motion.clip import FrameBlock
from mcml.motion.edits.resampling import frame_places, sampled
from mcml.motion.edits.seam_feet import SeamFeet
from mcml.motion.edits.splicing import Placement, Poses, jerks, joined_poses, placed, steps
from mcml.motion.edits.transitions import Ending, Stretch, Style, Transition, TransitionMaker
from mcml.motion.feet.legs import Side
from mcml.motion.frames import Rows, in_columns, joined, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import Flags, HubWriter, Known, Shortfall
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading
from mcml.numerics.runs import find_true


@dataclass(frozen=True)
class Piece:
    """Frames of a clip, on the skeleton of the result (`retarget` brings them there).

    frame_time: seconds. source: which clip, "" for none. first: the place of the first frame in it. placement: where
    it is placed, if that is given; it follows no other piece then.
    """

    block: FrameBlock
    frame_time: float
    source: str = ""
    first: int = 0
    placement: Placement | None = None


@dataclass(frozen=True)
class Seam:
    """Where two pieces meet, in frames of the result from 0.

    piece: the one that begins. frames: of the transition; first: its first one, or the first frame of the piece.
    turn: radians about the axis up and shift (3,) by which the piece was placed. root_step, angle_step: the largest
    step over the seam, in parts of the largest inside the pieces (0 where nothing moves in them nor there). jerk: the
    largest of any joint over the seam, in parts of the 99th percentile inside the pieces. slide: mean speed over the
    ground of the foot that moves least, in leg lengths a second; None without legs. locked: sides of feet held.
    left_out: frames at the end of the piece before and at the beginning of this one, so that both meet in phase.
    """

    piece: int
    first: int
    frames: int
    turn: float
    shift: Array
    root_step: float
    angle_step: float
    jerk: float
    slide: float | None
    locked: tuple[Side, ...]
    left_out: tuple[int, int] = (0, 0)


@dataclass(frozen=True)
class Composed:
    """The result of a composition.

    spans: (piece, first frame, last frame, frame of the piece) of the part of each piece outside transitions: first and
    last in the result, from 0, and the first in the piece at the frame rate of the result; omitted if empty.
    """

    block: FrameBlock
    shortfall: Shortfall
    seams: tuple[Seam, ...]
    spans: tuple[tuple[int, int, int, int], ...]


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
    match_phase: bool = False,
    lock_feet: bool = True,
    up: str = "Y",
    reading: Reading = DEGREES,
) -> Composed:
    """Compose pieces one after the other, on one skeleton, at one frame time (seconds).

    transition: frames between pieces that are not consecutive in their source; transitions: before each of the pieces,
    if they differ (None: as `transition`); styles likewise. "bridge" makes new frames between them, "crossfade" blends
    existing ones of both, "inertial" lets the difference at the seam decay over the first frames of the second; 0:
    none. lengthen: add frames until no step of the root or of a joint angle is larger than 1.1 times the largest inside
    the pieces (blended frames only as far as the pieces go). align: rotate each piece about the up axis and shift it on
    the ground so that the body continues, unless its placement is given; else it keeps its place. match_phase: where
    both sides of a seam walk, leave out up to 1.2 s of each so that they meet in the same phase. lock_feet: feet that
    stand at a seam stay where they stand during its transition. Raises ConversionError without pieces, for empty ones
    and for a negative transition.
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
    feet = SeamFeet.of(skeleton, [part.poses for part in parts], frame_time, axis)
    for part in parts:
        part.stance = None if feet is None else feet.stance(part.poses)
    inside = np.concatenate([jerks(skeleton, part.poses) for part in parts])
    usual = float(np.percentile(inside, 99)) if len(inside) else 0.0
    track = _Track(TransitionMaker(skeleton, reading, carry, largest, usual, feet, lock_feet))
    track.start(parts[0])
    for part in parts[1:]:
        piece = part.pieces[0][0]
        own = transitions[piece] if piece < len(transitions) else None
        how = styles[piece] if piece < len(styles) else None
        track.add(part, transition if own is None else own, how or style, align, lengthen, match_phase)
    return track.finish()


def _runs(pieces: Sequence[Piece]) -> list[list[tuple[int, Piece]]]:
    runs: list[list[tuple[int, Piece]]] = []
    for index, piece in enumerate(pieces):
        last = runs[-1][-1][1] if runs else None
        follows = (
            last is not None
            and bool(piece.source)
            and piece.placement is None
            and piece.source == last.source
            and piece.frame_time == last.frame_time
            and piece.first == last.first + len(last.block)
        )
        if follows:
            runs[-1].append((index, piece))
        else:
            runs.append([(index, piece)])
    return runs


def _part(skeleton: Skeleton, run: list[tuple[int, Piece]], frame_time: float, up: Array, reading: Reading) -> Stretch:
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
    given = run[0][1].placement
    return Stretch(first, block, raw, poses, hub.values, given or Placement(up), shortfall, fixed=given is not None)


class _Track:
    """The frames so far: ranges of parts, and transitions between them."""

    def __init__(self, maker: TransitionMaker) -> None:
        self._maker = maker
        self._skeleton, self._reading, self._carry = maker.skeleton, maker.reading, maker.carry
        self._parts: list[Stretch] = []
        self._placed: list[Poses] = []
        self._cuts: list[tuple[int, int]] = []
        """(first, after the last) of the unchanged frames of each part."""
        self._seams: list[Transition] = []
        self._left_out: list[tuple[int, int]] = []

    def start(self, part: Stretch) -> None:
        self._parts.append(part)
        self._placed.append(placed(self._skeleton, part.poses, self._carry, part.placement))
        self._cuts.append((0, len(part.poses)))

    def add(self, part: Stretch, transition: int, style: Style, align: bool, lengthen: bool, match_phase: bool) -> None:
        start, end = self._cuts[-1]
        last, whole = Ending(self._parts[-1], self._placed[-1], start, end), len(part.poses)
        if match_phase:
            last, part = self._maker.meet(last, part, transition, style)
        self._left_out.append((end - last.end, whole - len(part.poses)))
        seam = self._maker.make(last, part, transition, style, align, lengthen)
        part.placement = seam.placement
        self._cuts[-1] = (start, seam.cut)
        self._parts.append(part)
        self._placed.append(placed(self._skeleton, part.poses, self._carry, part.placement))
        self._cuts.append((seam.cut_after, len(part.poses)))
        self._seams.append(seam)

    def finish(self) -> Composed:
        parts = self._parts
        columns = self._skeleton.columns()
        source = joined(part.block for part in parts)
        starts = np.cumsum([0, *(len(part.poses) for part in parts)])
        poses: list[Poses] = []
        rows: list[Rows] = []
        made: list[Flags] = []
        kept: list[Flags] = []
        seams: list[Seam] = []
        spans: list[tuple[int, int, int, int]] = []
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
            seam = self._seams[place]
            between = seam.between
            frames = 0 if between is None else len(between)
            following = parts[place + 1].placement
            shift = np.zeros(3) if following.shift is None else following.shift
            seams.append(
                Seam(
                    parts[place + 1].pieces[0][0],
                    at,
                    frames,
                    following.angle,
                    shift,
                    seam.root,
                    seam.angle,
                    seam.jerk,
                    None if self._maker.feet is None else self._maker.feet.slide(seam.around),
                    seam.locked,
                    self._left_out[place],
                )
            )
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

    def _leave_gaps(self, parts: list[Stretch], new: Flags, raw: Array, values: Array, starts: Rows) -> None:
        """A transition has no sample where either of its ends has none."""
        seams = [place for place, seam in enumerate(self._seams) if seam.between is not None and len(seam.between)]
        for (first, end), place in zip(find_true(new), seams, strict=False):
            cut, following = self._cuts[place][1], self._cuts[place + 1][0]
            last = raw[starts[place] + min(max(cut - 1, 0), len(parts[place].raw) - 1)]
            after = raw[starts[place + 1] + min(following, len(parts[place + 1].raw) - 1)]
            values[first:end, np.isnan(last) | np.isnan(after)] = np.nan


def _spans(part: Stretch, first: int, end: int, at: int) -> list[tuple[int, int, int, int]]:
    edges = [*(start for _, start in part.pieces), len(part.poses)]
    found = []
    for (index, start), stop in zip(part.pieces, edges[1:], strict=True):
        low, high = max(start, first), min(stop, end)
        if low < high:
            found.append((index, at + low - first, at + high - first - 1, low - start))
    return found
