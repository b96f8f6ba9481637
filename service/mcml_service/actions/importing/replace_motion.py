"""A new file for a stored document: its frames take the place of the old ones, as one revision."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConflictError, FormatError
from mcml.files.clip_files import Gathered
from mcml.files.gather_files import gathered, several_motions
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.open_clip import offering, open_clip
from mcml.formats.format import SourceFile
from mcml.language.elements import to_head
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.frames import in_columns, joined, rows_of
from mcml.motion.skeleton import CHANNELS, Array
from mcml_schemas.revisions import FileReplaced, LargestChange, SkeletonReplaced
from mcml_service.actions.editing.frame_splicing import splice_frames
from mcml_service.actions.editing.motion_processing import Whole, number_bones, read_whole
from mcml_service.actions.editing.single_element import write_head
from mcml_service.actions.importing.import_motion import skeleton_lookup
from mcml_service.actions.importing.skeleton_difference import compare_heads
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


@dataclass(frozen=True)
class NewMotion:
    """The motion of a new file."""

    file_name: str
    head: ClipHead
    block: FrameBlock


def read_motion(
    database: Database, uuid: str, files: list[SourceFile], options: ImportOptions, limits: FileLimits
) -> NewMotion:
    """The one motion in the files, in memory, named as an import into the document's project names it.

    uuid: of the document, whose ASF is used for an AMC without one. Raises what an import raises, FormatError for no or
    several motions.
    """
    with database.read() as tx:
        options = replace(options, aliases=tx.aliases.of(tx.documents.get(uuid).project).pairs)
    with gathered(files, limits, skeleton_lookup(database, uuid), options) as found:
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


def replace_motion(
    tx: Transaction, stored: StoredDocument, new: NewMotion, *, replace_skeleton: bool = False, dry_run: bool = False
) -> FileReplaced:
    """Replace the frames that differ, as one revision; none where nothing differs. dry_run: only compare.

    Labels stay on their frame numbers. replace_skeleton: where skeleton, unit or frame rate differ, all frames are
    replaced, and these with them; else such a file raises ConflictError.
    """
    old = read_whole(tx, stored)
    difference = compare_heads(old.head, new.head)
    if difference is None:
        return _replace_frames(tx, stored, old, new, dry_run=dry_run)
    if not replace_skeleton:
        raise ConflictError(
            difference.reason,
            code="other-skeleton",
            remedy="Import it as a document of its own, or replace the skeleton too, with `replace_skeleton`.",
        )
    return _replace_all(tx, stored, old, new, difference.skeleton, dry_run=dry_run)


def _replace_frames(
    tx: Transaction, stored: StoredDocument, old: Whole, new: NewMotion, *, dry_run: bool
) -> FileReplaced:
    """Replace the frames that differ, of one skeleton."""
    columns = old.head.skeleton.columns()
    before, after = in_columns(old.block, columns), in_columns(new.block, columns)
    first, behind_old, behind_new = _range_of_changes(before, after)
    about = _describe(stored, old, before, after)
    if behind_old == first and behind_new == first:
        return about
    about = about.model_copy(update={"first": first + 1, "last": behind_new if behind_new > first else first + 1})
    if dry_run:
        return about
    block = rows_of(_with_labels(old, new.block), first, behind_new)
    splice_frames(tx, stored, first + 1, behind_old - first, [number_bones(tx, stored, old, block)])
    return _add_revision(tx, stored, new, about)


def _replace_all(
    tx: Transaction, stored: StoredDocument, old: Whole, new: NewMotion, skeleton: SkeletonReplaced, *, dry_run: bool
) -> FileReplaced:
    """Replace skeleton, unit, axes, frame rate and all frames by those of the file."""
    count = len(new.block)
    about = FileReplaced(
        revision=stored.revision,
        frames=count,
        frames_before=len(old.block),
        first=1,
        last=max(count, 1),
        skeleton=skeleton,
    )
    if dry_run:
        return about
    head = _merge_heads(old.head, new.head)
    stored = write_head(tx, stored, head, new.block)
    whole = Whole(head, new.block, head.skeleton.names, old.up)
    block = number_bones(tx, stored, whole, _with_labels(old, new.block))
    splice_frames(tx, stored, 1, len(old.block), [block], renumber=False)
    return _add_revision(tx, stored, new, about)


def _merge_heads(old: ClipHead, new: ClipHead) -> ClipHead:
    """The head of the file, with the description, the properties, and the frame rate of the document if it has none.

    It has no sources: the uploaded file that is kept is not the one that these frames come from.
    """
    own = {item[0].casefold() for item in new.properties}
    merged = replace(
        new,
        sources=(),
        description=old.description or new.description,
        properties=(*(item for item in old.properties if item[0].casefold() not in own), *new.properties),
    )
    if new.seconds_per_frame() is not None:
        return merged
    rate = {name: text for name, text in old.fields.items() if name == "dataframe_rate"}
    return replace(merged, frame_time=old.frame_time, fields=merged.fields | rate)


def _with_labels(old: Whole, block: FrameBlock) -> FrameBlock:
    """The frames of a file with the labels that the document has at their places."""
    kept = old.block.motion_names or [()] * len(old.block)
    return replace(block, motion_names=[tuple(kept[row]) if row < len(kept) else () for row in range(len(block))])


def _add_revision(tx: Transaction, stored: StoredDocument, new: NewMotion, about: FileReplaced) -> FileReplaced:
    tx.documents.add_revision(stored, "frames", f"replaced by {new.file_name}"[:200])
    current = tx.documents.get(stored.uuid)
    return about.model_copy(update={"revision": current.revision, "frames": current.frames})


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
