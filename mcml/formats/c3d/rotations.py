"""C3D files of rotations alone, as markerless systems write them: joints with a matrix in every frame.

Source: The C3D File Format User Guide (c3d.org), "The ROTATION Group": 4 × 4 matrices by columns, from the joint to the
world, each with a reliability behind it that is negative where the sample is missing.
"""

from __future__ import annotations

import io
from functools import partial
from typing import BinaryIO

import numpy as np

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.c3d.parameters import BLOCK, Statements
from mcml.formats.c3d.quantities import texts_of
from mcml.formats.format import ReadOptions, note
from mcml.formats.scenes.make_clip import make_clip
from mcml.formats.scenes.scene import Rig, Scene, Take
from mcml.motion.clip import ClipStream, SourcePart
from mcml.motion.skeleton import Array, unique_names

_NUMBERS = 17
_ENDING = "_4X4"


def count_rotations(said: Statements) -> int:
    """How many rotations each frame has."""
    return int(said.number("ROTATION:USED") or 0)


def read_rotations(
    stream: BinaryIO, said: Statements, rate: float, unit: str, up: str, source: SourcePart, options: ReadOptions
) -> ClipStream:
    """The clip of a file of rotations without points: joints beside each other, each with its place and rotation in the
    world.

    rate: of the points, frames a second. unit: of lengths, up: "X", "Y", "Z" or "". Raises FormatError where the file
    is cut off, LimitError.
    """
    count, ratio = count_rotations(said), int(said.number("ROTATION:RATIO") or 1)
    frames = _frames_of(said) * ratio
    options.limits.check_size(frames, _NUMBERS * count)
    if count > options.limits.joints:
        raise LimitError(f"the file has {count} rotations, the limit is {options.limits.joints}", remedy="Remove some.")
    first = (int(said.number("ROTATION:DATA_START") or 0) - 1) * BLOCK
    size = stream.seek(0, io.SEEK_END)
    notices: list[Notice] = []
    there = max(0, size - first) // (4 * _NUMBERS * count)
    if first < BLOCK or not there or not frames:
        raise FormatError("the file states rotations and has none", remedy="Send the whole file.")
    if there < frames:
        note(notices, "warning", f"the file states {frames} frames of rotations and has {there}: these were read")
    labels = [text.decode("utf-8", "replace") for text in texts_of(said, "ROTATION:LABELS")][:count]
    labels += ["unnamed"] * (count - len(labels))
    names = unique_names([label[: -len(_ENDING)] if label.upper().endswith(_ENDING) else label for label in labels])
    for name in names:
        options.limits.check_name(name)
    still = np.tile(np.eye(3, 4), (count, 1, 1))
    rig = Rig(tuple(names), np.full(count, -1, np.intp), still)
    read = partial(_poses, stream, said, first, count)
    rate = float(said.number("ROTATION:RATE") or rate * ratio)
    take = Take("", rig, min(frames, there), rate, read)
    note(notices, "note", f"the file has no points: {count} joints come from its rotations, each beside the others")
    scene = Scene((take,), unit, up, tuple(notices))
    return make_clip(scene, take, "c3d", source, options.limits)


def _frames_of(said: Statements) -> int:
    """Frames of the capture in the file, by TRIAL or by the header."""
    start, end = said.long("TRIAL:ACTUAL_START_FIELD"), said.long("TRIAL:ACTUAL_END_FIELD")
    if start is not None and end is not None and end >= start:
        return end - start + 1
    return max(0, int(said.words[4]) - int(said.words[3]) + 1)


def _poses(stream: BinaryIO, said: Statements, start: int, count: int, first: int, end: int) -> Array:
    """(n, count, 3, 4) from each joint to the world; NaN where a sample is missing."""
    size = 4 * _NUMBERS * count
    stream.seek(start + first * size)
    data = stream.read((end - first) * size)
    numbers = said.machine.floats(data[: len(data) // size * size]).reshape(-1, count, _NUMBERS)
    poses = numbers[..., :16].reshape(-1, count, 4, 4).swapaxes(-1, -2)[..., :3, :].copy()
    poses[numbers[..., 16] < 0] = np.nan
    return poses
