"""Frames of a clip in one array: joined, reversed, their channels moved and scaled; missing samples stay missing.

Unchanged numbers of a clip stay equal bit by bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock, Shape, full_shape
from mcml.motion.hub_writer import Flags, Shortfall
from mcml.motion.skeleton import Array

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Edited:
    """Frames after an operation, and the loss if the skeleton's channels cannot represent it."""

    block: FrameBlock
    shortfall: Shortfall


def joined(blocks: Iterable[FrameBlock]) -> FrameBlock:
    """One block of all frames.

    Blocks may differ in their columns: a frame has NaN for columns that its own block lacks. Raises ConversionError
    without blocks.
    """
    parts = list(blocks)
    if not parts:
        raise ConversionError("a clip without frames has nothing to edit", remedy="Import it with its frames.")
    if len(parts) == 1:
        return parts[0]
    columns = tuple(dict.fromkeys(column for part in parts for column in part.columns))
    shapes = tuple(dict.fromkeys(shape for part in parts for shape in part.shapes))
    place = {shape: index for index, shape in enumerate(shapes)}
    shape_of = np.concatenate(
        [
            np.array([place[shape] for shape in part.shapes], dtype=np.intp)[
                np.zeros(len(part), dtype=np.intp) if part.shape_of is None else part.shape_of
            ]
            for part in parts
        ]
    )
    ids: NDArray[np.int64] | list[str]
    if any(isinstance(part.ids, list) for part in parts):
        ids = [str(one) for part in parts for one in part.ids]
    else:
        ids = np.concatenate([np.asarray(part.ids, dtype=np.int64) for part in parts])
    names: list[tuple[str, ...]] | None = None
    if any(part.motion_names is not None for part in parts):
        names = [
            name
            for part in parts
            for name in (part.motion_names if part.motion_names is not None else [()] * len(part))
        ]
    values = np.concatenate([in_columns(part, columns) for part in parts])
    return FrameBlock(values, columns, shapes, ids, None if len(shapes) == 1 else shape_of, names)


def in_columns(block: FrameBlock, columns: Sequence[tuple[int, int]]) -> Array:
    """The values (n, D) in other columns, NaN where the block has no such column."""
    if tuple(columns) == block.columns:
        return block.values
    place = {column: index for index, column in enumerate(block.columns)}
    values = np.full((len(block), len(columns)), np.nan)
    for index, column in enumerate(columns):
        if column in place:
            values[:, index] = block.values[:, place[column]]
    return values


def present(values: Array, columns: Sequence[tuple[int, int]], joints: int) -> Flags:
    """(n, J) where every channel that a joint has in `columns` has a sample."""
    found = np.ones((len(values), joints), dtype=bool)
    gaps = np.isnan(values)
    if gaps.any():
        for index, (joint, _) in enumerate(columns):
            found[:, joint] &= ~gaps[:, index]
    return found


def leave_out(block: FrameBlock, known: Flags) -> FrameBlock:
    """The same frames without the samples of joints where these are unknown.

    known: (n, J). The block has all of its columns in every frame.
    """
    if known.all():
        return block
    patterns, shape_of = np.unique(known, axis=0, return_inverse=True)
    values = block.values.copy()
    values[~known[:, [joint for joint, _ in block.columns]]] = np.nan
    whole = full_shape(block.columns)
    shapes = tuple(tuple((joint, bits if pattern[joint] else 0) for joint, bits in whole) for pattern in patterns)
    places = None if len(shapes) == 1 else shape_of.reshape(-1).astype(np.intp)
    return replace(block, values=values, shapes=shapes, shape_of=places)


def reversed_frames(block: FrameBlock) -> FrameBlock:
    """The frames in the opposite order, under the ids in their old order."""
    return replace(
        block,
        values=block.values[::-1].copy(),
        shape_of=None if block.shape_of is None else block.shape_of[::-1].copy(),
        motion_names=None if block.motion_names is None else list(block.motion_names)[::-1],
    )


def rows_of(block: FrameBlock, start: int, end: int) -> FrameBlock:
    """Frames start to end - 1 of a block, places from 0."""
    return replace(
        block,
        values=block.values[start:end],
        ids=block.ids[start:end],
        shape_of=None if block.shape_of is None else block.shape_of[start:end],
        motion_names=None if block.motion_names is None else list(block.motion_names)[start:end],
    )


def eased(frames: int, first: int, last: int, ease: int = 0) -> Array:
    """Strength (n,) of an edit of the frames first to last, both included: 0 outside, 1 inside.

    ease: number of frames at each end, inside the range, over which the strength grows as half a period of a cosine;
    not at the ends of the clip, which need no transition. Raises ConversionError for a range that is not in the clip.

    >>> eased(6, 1, 4, 2).round(3).tolist()
    [0.0, 0.25, 0.75, 0.75, 0.25, 0.0]
    """
    if not 0 <= first <= last < frames:
        raise ConversionError(
            f"frames {first + 1} to {last + 1} are not a range of a clip of {frames}",
            remedy="Give a first and a last frame inside the clip.",
        )
    strength = np.zeros(frames)
    strength[first : last + 1] = 1.0
    ease = max(0, min(ease, (last - first + 1 + 1) // 2))
    if ease:
        ramp = 0.5 - 0.5 * np.cos(np.pi * (np.arange(1, ease + 1)) / (ease + 1))
        if first > 0:
            strength[first : first + ease] = np.minimum(strength[first : first + ease], ramp)
        if last < frames - 1:
            strength[last - ease + 1 : last + 1] = np.minimum(strength[last - ease + 1 : last + 1], ramp[::-1])
    return strength


def adjusted(
    block: FrameBlock, columns: Sequence[tuple[int, int]], strength: Array, factor: float = 1.0, offset: float = 0.0
) -> FrameBlock:
    """Channels multiplied, then moved: v becomes v + s (v factor + offset - v).

    columns: (joint, channel) of those meant. strength: (n,) of `eased`; frames where it is 0 keep their bits.
    offset: in the channel's own unit. Missing samples stay missing. Raises ConversionError for a channel that the
    frames do not have, and where a number would not be finite.
    """
    place = {column: index for index, column in enumerate(block.columns)}
    missing = [column for column in columns if column not in place]
    if missing:
        raise ConversionError(
            f"the frames have no channel {missing[0][1]} of joint {missing[0][0]}", remedy="Name a channel they have."
        )
    values = block.values.copy()
    rows = np.flatnonzero(strength)
    part = strength[rows]
    for column in columns:
        old = block.values[rows, place[column]]
        new = old * factor + offset
        values[rows, place[column]] = np.where(part == 1.0, new, old + part * (new - old))
    if np.isinf(values).any() or (np.isnan(values) & ~np.isnan(block.values)).any():
        raise ConversionError("the result is not finite", remedy="Give a smaller factor or offset.")
    return replace(block, values=values)


def remade(
    block: FrameBlock,
    columns: tuple[tuple[int, int], ...],
    values: Array,
    rows: Rows,
    ids: NDArray[np.int64] | list[str] | None = None,
    partners: Rows | None = None,
) -> FrameBlock:
    """A block of new values (n, D), NaN where samples are missing, made of frames `rows` (n,) of another block.

    Joints listed without a sample stay listed; motion names are kept. partners: (J,) the joint whose place in the list
    a joint takes. ids: default 1, 2, …
    """
    ids = np.arange(1, len(rows) + 1, dtype=np.int64) if ids is None else ids
    names = None if block.motion_names is None else [block.motion_names[int(row)] for row in rows]
    if not np.isnan(values).any() and all({joint for joint, _ in s} >= {j for j, _ in columns} for s in block.shapes):
        empty = tuple((joint, 0) for joint, bits in _listed(block.shapes, partners) if not bits)
        return FrameBlock(values, columns, (full_shape(columns) + empty,), ids, None, names)
    order = [joint for joint, _ in _listed(block.shapes, partners)]
    old = np.zeros(len(rows), dtype=np.intp) if block.shape_of is None else block.shape_of[rows]
    there = ~np.isnan(values)
    keys = np.column_stack([old, there])
    unique, shape_of = np.unique(keys, axis=0, return_inverse=True)
    shapes = []
    for key in unique:
        bits: dict[int, int] = {}
        listed = {joint for joint, _ in _listed((block.shapes[int(key[0])],), partners)}
        for (joint, channel), has in zip(columns, key[1:], strict=True):
            if has:
                bits[joint] = bits.get(joint, 0) | 1 << channel
        shapes.append(tuple((joint, bits.get(joint, 0)) for joint in order if joint in bits or joint in listed))
    places: dict[Shape, int] = {}
    for shape in shapes:
        places.setdefault(shape, len(places))
    merged = np.array([places[shape] for shape in shapes], dtype=np.intp)[shape_of.reshape(-1)]
    return FrameBlock(values, columns, tuple(places), ids, None if len(places) == 1 else merged, names)


def _listed(shapes: Sequence[Shape], partners: Rows | None) -> list[tuple[int, int]]:
    """(joint, all bits it ever has) of every joint that a shape lists, in the order of their first mention."""
    found: dict[int, int] = {}
    for shape in shapes:
        for joint, bits in shape:
            found[joint] = found.get(joint, 0) | bits
    if partners is None:
        return list(found.items())
    inverse = {int(partner): joint for joint, partner in enumerate(partners)}
    swapped = {inverse[joint]: bits for joint, bits in found.items()}
    # In the order of the source's list, as far as it names them.
    return [(joint, swapped.pop(joint)) for joint in found if joint in swapped] + list(swapped.items())
