"""Compare two revisions of a document: elements of the head, frames, labels, samples, poses."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mcml.language.elements import Element, addresses
from mcml.motion.hub import HubReader
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import CHANNELS, Array
from mcml.motion.units import reading_of
from mcml_schemas.revisions import (
    BoneDifference,
    Difference,
    ElementDifference,
    FrameRange,
    KeptFrames,
    LabelDifference,
)
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.timelines import Run, common_frames
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.undo.differences import find_changed_chunks, missing, within_chunks
from mcml_service.storage.undo.frame_pairs import join_runs

MOST_HEAD = 1000
"""Limit of differing elements of the head that are listed."""


def compare_revisions(
    before: Transaction, one: StoredDocument, after: Transaction, other: StoredDocument
) -> Difference:
    """The later revision against the earlier one. before, after: the transaction at the commit of each."""
    old = before.tracks.pieces(one.key, 1, one.frames)
    new = after.tracks.pieces(other.key, 1, other.frames)
    runs = common_frames(old, new)
    gone = missing([(run.before, run.count) for run in runs], one.frames)
    come = missing([(run.after, run.count) for run in runs], other.frames)
    changed = within_chunks(runs, new, find_changed_chunks(before, after, one.key))
    spans = [
        {(span.name, span.first, span.last) for span in tx.spans.of(item.key)}
        for tx, item in ((before, one), (after, other))
    ]
    return Difference(
        before=one.revision,
        after=other.revision,
        elements=_head(before.heads.document(one), after.heads.document(other)),
        frames_before=one.frames,
        frames_after=other.frames,
        frames_removed=[FrameRange(first=first, last=last) for first, last in gone],
        frames_added=[FrameRange(first=first, last=last) for first, last in come],
        frames_kept=[KeptFrames(before=run.before, after=run.after, count=run.count) for run in join_runs(runs)],
        frames_moved=any(a.before > b.before for a, b in pairwise(runs)),
        labels_removed=[_label(item) for item in sorted(spans[0] - spans[1], key=lambda item: item[1:])],
        labels_added=[_label(item) for item in sorted(spans[1] - spans[0], key=lambda item: item[1:])],
        bones=_bones(before, one, after, other, changed),
    )


def _label(item: tuple[str, int, int]) -> LabelDifference:
    return LabelDifference(name=item[0], first=item[1], last=item[2])


def _head(before: Element, after: Element) -> list[ElementDifference]:
    old_elements, other = (
        {address: (dict(element.attributes), element.text) for address, element in addresses(document)}
        for document in (before, after)
    )
    differences: list[ElementDifference] = []
    for address in [*old_elements, *(address for address in other if address not in old_elements)]:
        old, new = old_elements.get(address), other.get(address)
        if old != new and len(differences) < MOST_HEAD:
            differences.append(ElementDifference(address=address, before=_words(old), after=_words(new)))
    return differences


def _words(element: tuple[dict[str, str], str] | None) -> str | None:
    """An element of the head as one line: its attributes and its text."""
    if element is None:
        return None
    return " ".join([*(f'{name}="{value}"' for name, value in element[0].items()), element[1]]).strip()


def _bones(
    before: Transaction, one: StoredDocument, after: Transaction, other: StoredDocument, runs: list[Run]
) -> list[BoneDifference]:
    by_bone: dict[str, BoneDifference] = {}
    for run in runs:
        for name, position, channels, angles in _compare_frame_bones(before, one, after, other, run):
            bone = by_bone.setdefault(
                name, BoneDifference(bone=name, first=position, last=position, frames=0, channels={}, angle=None)
            )
            bone.first, bone.last = min(bone.first, position), max(bone.last, position)
            bone.frames += 1
            for channel, size in channels.items():
                bone.channels[channel] = max(bone.channels.get(channel, 0.0), size)
            if angles is not None:
                bone.angle = max(bone.angle or 0.0, angles)
    return sorted(by_bone.values(), key=lambda bone: (bone.first, bone.bone))


def _compare_frame_bones(
    before: Transaction, one: StoredDocument, after: Transaction, other: StoredDocument, run: Run
) -> Iterator[tuple[str, int, dict[str, float], float | None]]:
    """Each changed frame_bone: bone, position, difference of each channel, degrees between the rotations."""
    old, old_turns, old_names = _samples(before, one, run.before, run.count)
    new, new_turns, new_names = _samples(after, other, run.after, run.count)
    for name in dict.fromkeys([*old_names, *new_names]):
        values = [_of(table, names, name) for table, names in ((old, old_names), (new, new_names))]
        columns = sorted(set(values[0]) | set(values[1]))
        lacking = np.full(run.count, np.nan)
        pairs = [(values[0].get(channel, lacking), values[1].get(channel, lacking)) for channel in columns]
        rows = np.zeros(run.count, dtype=bool)
        for a, b in pairs:
            rows |= ~((a == b) | (np.isnan(a) & np.isnan(b)))
        if not rows.any():
            continue
        angles: NDArray[np.float64] | None = None
        if name in old_turns and name in new_turns:
            between = multiply(inverse(old_turns[name]), new_turns[name])
            angles = np.degrees(2 * np.arctan2(np.linalg.norm(between[:, :3], axis=1), np.abs(between[:, 3])))
        for row in np.flatnonzero(rows).tolist():
            sizes = {
                CHANNELS[channel]: 0.0 if np.isnan(b[row] - a[row]) else float(abs(b[row] - a[row]))
                for channel, (a, b) in zip(columns, pairs, strict=True)
                if a[row] != b[row] and not (np.isnan(a[row]) and np.isnan(b[row]))
            }
            yield name, run.after + row, sizes, None if angles is None else float(angles[row])


def _of(table: tuple[Array, tuple[tuple[int, int], ...]], names: tuple[str, ...], name: str) -> dict[int, Array]:
    values, columns = table
    return {channel: values[:, i] for i, (joint, channel) in enumerate(columns) if names[joint] == name}


def _samples(
    tx: Transaction, stored: StoredDocument, first: int, count: int
) -> tuple[tuple[Array, tuple[tuple[int, int], ...]], dict[str, Array], tuple[str, ...]]:
    """Channel values and rotations of some frames, and the names of the joints. At most a chunk."""
    clip = read_clip(tx, stored, first=first, last=first + count - 1)
    blocks = list(clip.clip.blocks())
    columns = tuple(dict.fromkeys(column for block in blocks for column in block.columns))
    values = np.full((count, len(columns)), np.nan)
    row = 0
    reader = HubReader(clip.clip.head.skeleton, reading_of(clip.clip.head))
    turns = []
    for block in blocks:
        values[row : row + len(block), [columns.index(column) for column in block.columns]] = block.values
        turns.append(reader.read(block).rotations)
        row += len(block)
    rotations = np.concatenate(turns)
    turning = {
        joint.name: rotations[:, index]
        for index, joint in enumerate(clip.clip.head.skeleton.joints)
        if any(channel[0] == "R" for channel in joint.channels)
    }
    return (values, columns), turning, clip.names
