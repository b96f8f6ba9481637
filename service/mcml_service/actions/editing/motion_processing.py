"""Recompute samples of frames: mirror, smooth, filter, fill, unroll, lock feet, pose, offset and scale, resample, keep
in place, change speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import DocumentError
from mcml.language.elements import header_of
from mcml.motion.bodies.positions import clip_positions, filled
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.edits.despiking import despike
from mcml.motion.edits.foot_locking import lock_clip_feet
from mcml.motion.edits.gap_filling import fill_gaps
from mcml.motion.edits.in_place import ground_path, stay_in_place
from mcml.motion.edits.low_pass import low_pass, suggest_cutoff
from mcml.motion.edits.mirroring import mirrored
from mcml.motion.edits.resampling import resampled, sampled
from mcml.motion.edits.retiming import speed_places
from mcml.motion.edits.smoothing import smoothed
from mcml.motion.edits.unrolling import unroll
from mcml.motion.floor_plates import kept_plates
from mcml.motion.frames import adjusted, eased, joined, rows_of
from mcml.motion.skeleton import CHANNEL_INDEX, Array
from mcml.motion.solving.posing import Handle, HandleMove, pose_frames
from mcml.motion.units import Reading, reading_of
from mcml_schemas.frames import (
    AdjustFrames,
    DespikeFrames,
    FillFrames,
    InPlaceFrames,
    LockFrames,
    LowPassFrames,
    MirrorFrames,
    PoseFrames,
    ResampleFrames,
    SmoothFrames,
    SpeedFrames,
    UnrollFrames,
)
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.editing.edit_report import EditReport
from mcml_service.actions.editing.frame_splicing import check_range, splice_frames
from mcml_service.actions.editing.single_element import Change, apply_change
from mcml_service.clips.bodies import read_up
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

_SECONDS_AROUND = 2.0
_MISSED = 1e-3
"""Of the size of the body: a handle that misses its goal by more is told."""

Reshaping = (
    MirrorFrames
    | SmoothFrames
    | AdjustFrames
    | ResampleFrames
    | FillFrames
    | LowPassFrames
    | DespikeFrames
    | UnrollFrames
    | LockFrames
    | PoseFrames
    | SpeedFrames
    | InPlaceFrames
)


@dataclass(frozen=True)
class Whole:
    """All frames of a document as one block, joints as its skeleton numbers them. up: the axis that points up."""

    head: ClipHead
    block: FrameBlock
    names: tuple[str, ...]
    up: str

    @property
    def reading(self) -> Reading:
        return reading_of(self.head)

    def joints(self, bones: Sequence[str]) -> list[int]:
        """Numbers of bones by their names, all without any. DocumentError."""
        unknown = [bone for bone in bones if bone not in self.names]
        if unknown:
            raise DocumentError(
                f"The document has no bone {unknown[0]!r}.", remedy=f"It has: {', '.join(self.names[:60])}."
            )
        return [self.names.index(bone) for bone in bones] or list(range(len(self.names)))


def read_whole(tx: Transaction, stored: StoredDocument, first: int = 1, last: int | None = None) -> Whole:
    """Frames first to last (positions from 1) in memory."""
    source = read_clip(tx, stored, first=first, last=last)
    head = source.clip.head
    return Whole(head, joined(source.clip.blocks()), source.names, read_up(tx, stored, head))


def reshape(tx: Transaction, stored: StoredDocument, edit: Reshaping, report: EditReport) -> None:
    """Recompute samples of frames; unchanged samples keep their bits. Writes no revision.

    report: gets numbers of filled samples by method, a chosen cut-off, replaced samples.
    """
    if isinstance(edit, ResampleFrames):
        _resample(tx, stored, edit)
    elif isinstance(edit, UnrollFrames):
        report.notes += _unroll(tx, stored, edit)
    else:
        check_range(stored, edit.first, edit.last)
        if isinstance(edit, FillFrames):
            report.notes += _fill(tx, stored, edit, report)
        elif isinstance(edit, DespikeFrames):
            report.notes += _despike(tx, stored, edit, report)
        elif isinstance(edit, LockFrames):
            report.notes += _lock_feet(tx, stored, edit)
        elif isinstance(edit, PoseFrames):
            report.notes += _pose(tx, stored, edit)
        elif isinstance(edit, SpeedFrames):
            report.notes += _change_speed(tx, stored, edit)
        elif isinstance(edit, InPlaceFrames):
            report.notes += _keep_in_place(tx, stored, edit)
        else:
            _process(tx, stored, edit, report.notes)


def _process(
    tx: Transaction,
    stored: StoredDocument,
    edit: MirrorFrames | SmoothFrames | AdjustFrames | LowPassFrames,
    notes: list[str],
) -> None:
    first, last = edit.first, edit.last
    mirror = isinstance(edit, MirrorFrames)
    if isinstance(edit, MirrorFrames):
        whole = read_whole(tx, stored, first, last)
        block = mirrored(whole.head.skeleton, whole.block, up=whole.up, reading=whole.reading).block
    else:
        # The neighbouring frames make the ends of the range continuous.
        around = 0
        if isinstance(edit, SmoothFrames):
            around = round(4 * edit.seconds * _rate(stored)) + 1
        elif isinstance(edit, LowPassFrames):
            # A filter that runs both ways needs the whole course.
            around = stored.frames
        start, end = max(1, first - around), min(stored.frames, last + around)
        whole = read_whole(tx, stored, start, end)
        strength = eased(end - start + 1, first - start, last - start, edit.ease)
        if isinstance(edit, SmoothFrames):
            block = _smooth(whole, edit, strength, _rate(stored))
        elif isinstance(edit, LowPassFrames):
            block = _low_pass(whole, edit, strength, _rate(stored), notes)
        else:
            block = _adjust(whole, edit, strength)
        block = rows_of(block, first - start, last - start + 1)
    blocks = [number_bones(tx, stored, whole, block)]
    splice_frames(tx, stored, first, last - first + 1, blocks, renumber=mirror, same_instants=not mirror)


def _rate(stored: StoredDocument) -> float:
    return 1.0 / seconds_of(stored)


def _smooth(whole: Whole, edit: SmoothFrames, strength: Array, rate: float) -> FrameBlock:
    joints = whole.joints(edit.bones)
    return smoothed(whole.head.skeleton, whole.block, edit.seconds * rate, strength, joints, whole.reading).block


def _low_pass(whole: Whole, edit: LowPassFrames, strength: Array, rate: float, notes: list[str]) -> FrameBlock:
    joints = whole.joints(edit.bones)
    hertz = edit.hertz
    if hertz is None:
        skeleton = whole.head.skeleton
        (positions,) = clip_positions(skeleton, [filled(skeleton, [whole.block])], whole.reading)
        hertz = suggest_cutoff(positions[:, joints], rate)
        if hertz is None:
            raise DocumentError(
                "The motion does not suggest a cut-off: it has no noise that residuals show.", remedy="Give `hertz`."
            )
        hertz = round(hertz, 1)
        notes.append(f"cut-off {hertz:g} Hz, by residual analysis")
    return low_pass(whole.head.skeleton, whole.block, hertz, rate, strength, joints, whole.reading).block


def _fill(tx: Transaction, stored: StoredDocument, edit: FillFrames, report: EditReport) -> list[str]:
    rate = _rate(stored)
    whole = read_whole(tx, stored)
    rows = slice(edit.first - 1, edit.last)
    joints = whole.joints(edit.bones)
    short, longest = (max(0, round(seconds * rate)) for seconds in (edit.seconds, edit.longest))
    made = fill_gaps(whole.head.skeleton, whole.block, rows, short, longest, joints, whole.reading)
    notes = [f"{count:,} samples filled by {method}" for method, count in made.counts.items()]
    if made.left:
        notes.append(f"{made.left:,} samples stay missing: gaps over {edit.longest:g} s, or that no other marker tells")
    if made.counts:
        block = rows_of(made.block, rows.start, rows.stop)
        report.add_replaced(whole.names, rows_of(whole.block, rows.start, rows.stop), block, edit.first)
        blocks = [number_bones(tx, stored, whole, block)]
        splice_frames(tx, stored, edit.first, edit.last - edit.first + 1, blocks, renumber=False, same_instants=True)
    return notes or ["no gaps between known samples"]


def _despike(tx: Transaction, stored: StoredDocument, edit: DespikeFrames, report: EditReport) -> list[str]:
    if edit.window % 2 == 0:
        raise DocumentError(f"A window of {edit.window} frames has no middle.", remedy="Give an odd number.")
    start, end = max(1, edit.first - edit.window - 10), min(stored.frames, edit.last + edit.window + 10)
    whole = read_whole(tx, stored, start, end)
    rows = slice(edit.first - start, edit.last - start + 1)
    joints = whole.joints(edit.bones)
    made = despike(whole.head.skeleton, whole.block, rows, edit.deviations, edit.window, joints, whole.reading)
    if made.counts:
        block = rows_of(made.block, rows.start, rows.stop)
        report.add_replaced(whole.names, rows_of(whole.block, rows.start, rows.stop), block, edit.first)
        blocks = [number_bones(tx, stored, whole, block)]
        splice_frames(tx, stored, edit.first, edit.last - edit.first + 1, blocks, renumber=False, same_instants=True)
    names = [f"{whole.names[joint]} {count:,}" for joint, count in made.counts.most_common(10)]
    notes = []
    if made.frames:
        notes.append(f"spikes replaced: {made.counts.total():,} ({', '.join(names)})")
        notes.append(f"first in frame {made.frames[0] + start}, last in frame {made.frames[-1] + start}")
    if made.left:
        notes.append(f"spikes left: {made.left:,}, as no known sample is before or after them")
    return notes or ["no spikes"]


def _lock_feet(tx: Transaction, stored: StoredDocument, edit: LockFrames) -> list[str]:
    whole = read_whole(tx, stored)
    rows = slice(edit.first - 1, edit.last)
    frame_time = 1 / _rate(stored)
    made = lock_clip_feet(whole.head.skeleton, whole.block, rows, frame_time, edit.sides, whole.up, whole.reading)
    contacts = sum(len(foot.contacts) for _, foot in made.feet)
    if contacts:
        blocks = [number_bones(tx, stored, whole, rows_of(made.edited.block, rows.start, rows.stop))]
        splice_frames(tx, stored, edit.first, edit.last - edit.first + 1, blocks, renumber=False, same_instants=True)
    notes = [
        f"{leg.side} foot: {len(foot.contacts)} contacts, slides {foot.before:.2f} leg lengths before, "
        f"{'; '.join([f'{foot.after:.2f} after', *foot.shortcomings()])}"
        for leg, foot in made.feet
    ]
    notes += [notice.what for notice in made.edited.shortfall.notices(whole.head.skeleton)]
    return notes if contacts else ["no foot stands in these frames"]


def _pose(tx: Transaction, stored: StoredDocument, edit: PoseFrames) -> list[str]:
    moves: dict[Handle, HandleMove] = {
        each.handle: HandleMove(np.array(each.move), np.radians(each.turn)) for each in edit.handles
    }
    if len(moves) < len(edit.handles):
        raise DocumentError("A handle is moved twice.", remedy="Give each handle once, with its whole way and turn.")
    # Frames around them tell how knees and elbows bend.
    around = round(_SECONDS_AROUND * _rate(stored))
    start, end = max(1, edit.first - around), min(stored.frames, edit.last + around)
    whole = read_whole(tx, stored, start, end)
    strength = eased(stored.frames, edit.first - 1, edit.last - 1, edit.ease)[start - 1 : end]
    made = pose_frames(whole.head.skeleton, whole.block, moves, strength, edit.hold, whole.reading)
    block = rows_of(made.edited.block, edit.first - start, edit.last - start + 1)
    blocks = [number_bones(tx, stored, whole, block)]
    splice_frames(tx, stored, edit.first, edit.last - edit.first + 1, blocks, renumber=False, same_instants=True)
    unit = whole.head.fields.get("calibration_unit", "").strip() or "units"
    notes = [
        f"{handle.replace('_', ' ')}: up to {missed:.3g} {unit} from its goal"
        for handle, missed in made.missed.items()
        if missed > _MISSED * made.size
    ]
    return notes + [notice.what for notice in made.edited.shortfall.notices(whole.head.skeleton)]


def _unroll(tx: Transaction, stored: StoredDocument, edit: UnrollFrames) -> list[str]:
    whole = read_whole(tx, stored)
    block, changed = unroll(whole.head.skeleton, whole.block, whole.joints(edit.bones), whole.reading)
    if changed:
        blocks = [number_bones(tx, stored, whole, block)]
        splice_frames(tx, stored, 1, stored.frames, blocks, renumber=False, same_instants=True)
    return [f"{changed:,} rotations have other angles"]


def _change_speed(tx: Transaction, stored: StoredDocument, edit: SpeedFrames) -> list[str]:
    after = min(edit.last + 1, stored.frames)
    count = edit.last - edit.first + 1
    places = speed_places(count, edit.factors, follows=after > edit.last)
    whole = read_whole(tx, stored, edit.first, after)
    made = sampled(whole.head.skeleton, whole.block, places, whole.reading)
    splice_frames(tx, stored, edit.first, count, [number_bones(tx, stored, whole, made.block)])
    return [f"frames of the range: {count:,} before, {len(places):,} after"]


def _keep_in_place(tx: Transaction, stored: StoredDocument, edit: InPlaceFrames) -> list[str]:
    whole = read_whole(tx, stored, edit.first)
    skeleton, count = whole.head.skeleton, edit.last - edit.first + 1
    path = ground_path(skeleton, rows_of(whole.block, 0, count), whole.up, whole.reading)
    if not path.any():
        return ["the body does not travel in these frames"]
    made = stay_in_place(skeleton, whole.block, 0, count - 1, whole.up, whole.reading)
    blocks = [number_bones(tx, stored, whole, made.block)]
    splice_frames(tx, stored, edit.first, len(made.block), blocks, renumber=False, same_instants=True)
    unit = whole.head.fields.get("calibration_unit", "").strip()
    notes = [f"a way of {np.hypot.reduce(path[-1]):.4g} {unit or 'units'} was taken out"]
    if edit.last < stored.frames:
        notes.append(f"the frames from {edit.last + 1:,} on go on from there")
    if len(kept_plates(whole.head)):
        notes.append("force plates stay where they are: their forces no longer act under the feet")
    return notes + [notice.what for notice in made.shortfall.notices(skeleton)]


def _adjust(whole: Whole, edit: AdjustFrames, strength: Array) -> FrameBlock:
    wanted = {CHANNEL_INDEX[channel] for channel in edit.channels}
    joints = set(whole.joints(edit.bones))
    columns = [column for column in whole.block.columns if column[0] in joints and column[1] in wanted]
    if not columns:
        raise DocumentError("None of these bones has such a channel.", remedy="See its channels in the document.")
    return adjusted(whole.block, columns, strength, edit.factor, edit.offset)


def _resample(tx: Transaction, stored: StoredDocument, edit: ResampleFrames) -> None:
    old, new = 1 / _rate(stored), 1 / edit.rate
    whole = read_whole(tx, stored)
    made = resampled(whole.head.skeleton, whole.block, old, new, whole.reading)
    splice_frames(tx, stored, 1, stored.frames, [number_bones(tx, stored, whole, made.block)])
    current = tx.documents.get(stored.uuid)
    if header_of(tx.heads.document(current)).first("dataframe_rate") is not None:
        apply_change(tx, current, "/mcml/header/dataframe_rate", Change({}, f"{edit.rate:.15g}"))
        current = tx.documents.get(stored.uuid)
    if current.frame_time is not None:
        apply_change(tx, current, "/mcml/motion/frametime", Change({}, repr(new)))


def number_bones(tx: Transaction, stored: StoredDocument, whole: Whole, block: FrameBlock) -> FrameBlock:
    """The block with bones as the store numbers them."""
    numbers = {name: number for number, name in tx.heads.bone_names(stored.key).items()}
    bones = [numbers[name] for name in whole.names]
    return replace(
        block,
        columns=tuple((bones[joint], channel) for joint, channel in block.columns),
        shapes=tuple(tuple((bones[joint], bits) for joint, bits in shape) for shape in block.shapes),
    )
