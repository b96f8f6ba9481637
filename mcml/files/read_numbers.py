"""Frames of a clip as numbers: chosen channels, or positions or rotations of joints in the world."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcml.errors import NotFoundError
from mcml.motion.clip import ClipStream
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.skeleton import CHANNELS, Array
from mcml.motion.units import reading_of
from mcml.numerics.runs import evenly

Space = Literal["channels", "positions", "rotations"]
_PARTS = {"positions": "xyz", "rotations": "xyzw"}


@dataclass(frozen=True)
class Numbers:
    """Numbers of frames. columns: names of the numbers of a frame: BONE.CHANNEL, or bones if each has a vector.

    shape: of one frame, (columns,) or (bones, 3) or (bones, 4). blocks: (numbers (F, *shape), ids of the frames).
    units: of the columns, if some are quantities of the body; channels have none here.
    """

    columns: list[str]
    shape: tuple[int, ...]
    blocks: Callable[[], Iterator[tuple[Array, NDArray[np.int64] | list[str]]]]
    units: list[str] | None = None

    @property
    def flat_columns(self) -> list[str]:
        """A name for each number: BONE.x where each bone has a vector."""
        if len(self.shape) == 1:
            return self.columns
        return [f"{bone}.{part}" for bone in self.columns for part in "xyzw"[: self.shape[1]]]


def read_numbers(
    clip: ClipStream,
    names: Sequence[str],
    bones: list[str] | None,
    space: Space,
    *,
    origin: Array | None = None,
    held: bool = True,
    tips: bool = False,
) -> Numbers:
    """Numbers of a clip. names: of its joints. bones: which, in this order; default all. NotFoundError for others.

    Channels are the source's own numbers and units, missing samples NaN; positions (x y z) and rotations (x y z w) are
    global, by forward kinematics.
    origin: (3,) is taken off positions. held: positions and rotations of missing samples are those of the last ones
    before, among the frames that are read; else they are NaN. tips: the ends of chains follow, in the order that the
    skeleton lists them, called after their bones.
    """
    wanted = chosen_bones(names, bones)
    skeleton = clip.head.skeleton
    if space == "channels":
        columns = [column for column in skeleton.columns() if column[0] in wanted]
        labels = [f"{names[number]}.{CHANNELS[channel]}" for number, channel in columns]
        shape: tuple[int, ...] = (len(columns),)
    else:
        order = list(wanted)
        labels = list(wanted.values())
        if tips:
            tipped = [joint for joint, _ in rest_of(skeleton, reading_of(clip.head)).tips]
            order += [len(skeleton) + place for place, joint in enumerate(tipped) if joint in wanted]
            labels += [f"{wanted[joint]}.tip" for joint in tipped if joint in wanted]
        shape = (len(order), len(_PARTS[space]))

    def blocks() -> Iterator[tuple[Array, NDArray[np.int64] | list[str]]]:
        walker = None if space == "channels" else Walker(skeleton, reading_of(clip.head))
        for block in clip.blocks():
            if walker is None:
                place = {column: index for index, column in enumerate(block.columns)}
                chosen = np.array([place[column] for column in columns], np.int64)
                values = block.values[:, evenly(chosen) if len(chosen) else chosen]
            else:
                positions, rotations, ends = walker.poses_with_tips(block)
                poses = positions if space == "positions" else rotations
                hidden = None if held else unseen(skeleton, block)
                if hidden is not None:
                    poses[hidden] = np.nan
                if tips:
                    if hidden is not None:
                        ends[hidden[:, tipped]] = np.nan
                    poses = np.concatenate([poses, ends], axis=1)
                if origin is not None:
                    poses -= origin
                values = poses[:, evenly(np.array(order, np.int64))] if order else poses[:, order]
            yield values, block.ids

    return Numbers(labels, shape, blocks)


def chosen_bones(names: Sequence[str], wanted: list[str] | None) -> dict[int, str]:
    """Return numbers of bones with their names. Raises NotFoundError for an unknown name."""
    if not wanted:
        return dict(enumerate(names))
    known = {name: number for number, name in enumerate(names)}
    unknown = [name for name in wanted if name not in known]
    if unknown:
        raise NotFoundError(f"The document has no bone {unknown[0]!r}.", remedy=f"It has: {', '.join(names[:60])}.")
    return {known[name]: name for name in wanted}
