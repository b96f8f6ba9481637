"""A new file for a stored document: its frames take the place of the old ones, as one revision."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConflictError, FormatError
from mcml.files.gather_files import Gathered, gathered, several_motions
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.open_clip import offering, open_clip
from mcml.formats.format import SourceFile
from mcml.language.elements import to_head
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.frames import in_columns, joined, rows_of
from mcml.motion.skeleton import CHANNELS, Array, Joint, Skeleton
from mcml_schemas.revisions import FileReplaced, LargestChange
from mcml_service.actions.editing.frame_splicing import splice_frames
from mcml_service.actions.editing.motion_processing import Whole, number_bones, read_whole
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

SAME_RATE = 1e-6
"""Relative difference of two frame times that count as equal."""


@dataclass(frozen=True)
class NewMotion:
    """The motion of a new file."""

    file_name: str
    head: ClipHead
    block: FrameBlock


def read_motion(files: list[SourceFile], options: ImportOptions, limits: FileLimits) -> NewMotion:
    """The one motion in the files, in memory. Raises what an import raises, FormatError for no or several motions."""
    with gathered(files, limits, options=options) as found:
        for _, error in found.problems:
            raise error
        return _read_one(found, options, limits)


def _read_one(found: Gathered, options: ImportOptions, limits: FileLimits) -> NewMotion:
    if len(found.clips) != 1:
        raise several_motions(found)
    clip = found.clips[0]
    with offering(clip):
        opened = open_clip(clip, options, limits)
        blocks = list(opened.stream.blocks())
        if not blocks:
            raise FormatError("The file has no frames.", remedy="Send a file with motion.")
        head = to_head(opened.document, opened.stream.head.frame_time)
        return NewMotion(clip.file_name, head, joined(blocks))


def replace_motion(tx: Transaction, stored: StoredDocument, new: NewMotion, *, dry_run: bool = False) -> FileReplaced:
    """Replace the frames that differ, as one revision; none where nothing differs. dry_run: only compare.

    Labels stay on their frame numbers. Raises ConflictError where skeleton or frame rate differ.
    """
    old = read_whole(tx, stored)
    _check_skeleton(old.head.skeleton, new.head.skeleton)
    _check_rate(old.head, new.head)
    columns = old.head.skeleton.columns()
    before, after = in_columns(old.block, columns), in_columns(new.block, columns)
    first, behind_old, behind_new = _range_of_changes(before, after)
    about = _describe(stored, old, before, after)
    if behind_old == first and behind_new == first:
        return about
    about = about.model_copy(update={"first": first + 1, "last": behind_new if behind_new > first else first + 1})
    if dry_run:
        return about
    kept = old.block.motion_names or [()] * len(before)
    names = [tuple(kept[row]) if row < len(before) else () for row in range(first, behind_new)]
    block = replace(rows_of(new.block, first, behind_new), motion_names=names)
    splice_frames(tx, stored, first + 1, behind_old - first, [number_bones(tx, stored, old, block)])
    tx.documents.add_revision(stored, "frames", f"replaced by {new.file_name}"[:200])
    current = tx.documents.get(stored.uuid)
    return about.model_copy(update={"revision": current.revision, "frames": current.frames})


def _check_skeleton(old: Skeleton, new: Skeleton) -> None:
    """Raises ConflictError where the joints differ in more than the names that people may change."""
    if len(old) != len(new):
        raise ConflictError(
            f"The file has {len(new)} joints, the document {len(old)}.", remedy="Import it as a document of its own."
        )
    for ours, theirs in zip(old.joints, new.joints, strict=True):
        fault = _differs(ours, theirs)
        if fault:
            raise ConflictError(
                f"Joint {ours.name!r} has another {fault} in the file.", remedy="Import it as a document of its own."
            )


def _differs(ours: Joint, theirs: Joint) -> str:
    """Which fact of two joints differs, "" for none."""
    if ours.source_name != theirs.source_name:
        return f"name ({theirs.source_name!r})"
    if ours.parent != theirs.parent:
        return "parent"
    if ours.channels != theirs.channels or ours.rotation_order != theirs.rotation_order:
        return "list of channels"
    facts = ("offset", "direction", "length", "axis", "axis_order", "convention", "translation")
    return next((fact for fact in facts if getattr(ours, fact) != getattr(theirs, fact)), "")


def _check_rate(old: ClipHead, new: ClipHead) -> None:
    ours, theirs = old.seconds_per_frame(), new.seconds_per_frame()
    if ours is None or theirs is None or abs(ours - theirs) <= SAME_RATE * ours:
        return
    raise ConflictError(
        f"The file has {1 / theirs:g} frames a second, the document {1 / ours:g}.",
        remedy="Import it as a document of its own, or change the rate of one of the two.",
    )


def _range_of_changes(before: Array, after: Array) -> tuple[int, int, int]:
    """(first, end in the old, end in the new) of the rows that differ, places from 0."""
    shared = min(len(before), len(after))
    from_start = _equal_rows(before[:shared], after[:shared])
    first = int(np.argmin(from_start)) if not from_start.all() else shared
    rest = shared - first
    from_end = _equal_rows(before[len(before) - rest :], after[len(after) - rest :])[::-1]
    last = int(np.argmin(from_end)) if not from_end.all() else rest
    return first, len(before) - last, len(after) - last


def _equal_rows(before: Array, after: Array) -> NDArray[np.bool_]:
    same: NDArray[np.bool_] = ((before == after) | (np.isnan(before) & np.isnan(after))).all(axis=1)
    return same


def _describe(stored: StoredDocument, old: Whole, before: Array, after: Array) -> FileReplaced:
    """The difference, before anything is written. Frames are compared by their positions."""
    shared = min(len(before), len(after))
    columns = old.head.skeleton.columns()
    differs = ~((before[:shared] == after[:shared]) | (np.isnan(before[:shared]) & np.isnan(after[:shared])))
    joints = sorted({columns[place][0] for place in np.flatnonzero(differs.any(axis=0))})
    away = np.nan_to_num(np.abs(after[:shared] - before[:shared]), nan=0.0)
    largest = None
    if away.size and away.max() > 0:
        row, place = np.unravel_index(int(away.argmax()), away.shape)
        joint, channel = columns[place]
        largest = LargestChange(
            bone=old.names[joint],
            channel=CHANNELS[channel],
            frame=int(row) + 1,
            before=float(before[row, place]),
            after=float(after[row, place]),
        )
    return FileReplaced(
        revision=stored.revision,
        frames=len(after),
        frames_before=len(before),
        joints=[old.names[joint] for joint in joints],
        largest=largest,
    )
