"""Clips: a head, and blocks of frames that stream.

The source's own numbers and units are kept; nothing is scaled or rotated here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.errors import Notice
from mcml.motion.skeleton import Array, Skeleton

if TYPE_CHECKING:
    from mcml.motion.skin import Character

Shape: TypeAlias = tuple[tuple[int, int], ...]
"""The sequence of frame_bones in a frame: (joint index, bits of its channels).

Bit i is for `CHANNELS[i]`; no bits: the source listed the joint but has no sample (a missing marker).
"""


@dataclass(frozen=True)
class SourcePart:
    """One file of the source (BVH: one; ASF/AMC: two), with the data of its format other than motion.

    part: the format's part name ("bvh", "asf", "amc", "htr"). name: file name without folders.
    encoding: Python codec name. keywords: header keywords in the file's order and spelling ("FileType" …).
    flags: AMC's `:FULLY-SPECIFIED`, `:DEGREES` lines, verbatim, in order.
    comments: comment lines verbatim, without line end. sections: (keyword line, verbatim text) of sections without a
    place in the model, such as ASF's `:documentation` and `:skin`.
    missing: the text of a missing sample in the source (HTR: "9999999"), "" if it has none.
    """

    part: str
    name: str = ""
    encoding: str = "utf-8"
    keywords: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    comments: tuple[str, ...] = ()
    sections: tuple[tuple[str, str], ...] = ()
    missing: str = ""


@dataclass(frozen=True)
class ReferencePose:
    """A pose to measure others from. positions: (J, 3), rotations: (J, 4) from rest, of each joint in the world."""

    positions: tuple[tuple[float, ...], ...]
    rotations: tuple[tuple[float, ...], ...]

    def fits(self, skeleton: Skeleton) -> bool:
        """Whether it has a place and a rotation for each joint."""
        return len(self.positions) == len(self.rotations) == len(skeleton)

    def to_json(self) -> list[list[float]]:
        """Of each joint its position and its rotation, x y z and x y z w."""
        return [[*place, *turn] for place, turn in zip(self.positions, self.rotations, strict=True)]

    @classmethod
    def from_json(cls, values: Sequence[Sequence[float]]) -> ReferencePose:
        """Read the output of `to_json`."""
        return cls(tuple(tuple(one[:3]) for one in values), tuple(tuple(one[3:]) for one in values))


@dataclass(frozen=True)
class Reference:
    """Where angles from rotations start. up: the axis that points up in it. pose: None for the rest pose.

    frame, of: which frame (from 0) of which clip a pose was found in, None and "" for the clip itself. stated: the up
    axis that was stated where it was looked for, None where it was guessed. hinges: by the upper joint of a thigh or
    shank, the line to its left by the axis of its knee in the axes of rest, x y z, and how far (rms, degrees) single
    bends are from it.
    """

    up: str
    pose: ReferencePose | None = None
    frame: int | None = None
    of: str = ""
    stated: str | None = None
    hinges: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        pose = None if self.pose is None else self.pose.to_json()
        told = {"up": self.up, "pose": pose, "frame": self.frame, "of": self.of, "stated": self.stated}
        return {**told, "hinges": {name: list(hinge) for name, hinge in self.hinges.items()}}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Reference:
        """Read the output of `to_json`."""
        pose = None if values["pose"] is None else ReferencePose.from_json(values["pose"])
        hinges = {name: tuple(hinge) for name, hinge in values["hinges"].items()}
        return cls(**{**values, "pose": pose, "hinges": hinges})


_SAME_RATE = 1e-4
"""Relative difference of a rate and of a frame time with few decimals that say the same."""


def seconds_from(frame_time: str | None, rate: str | None) -> float | None:
    """Seconds a frame: the frame time, else 1 / rate. None where it is not usable: positive, and so is its inverse."""
    text = frame_time if frame_time is not None else rate
    value = 0.0 if text is None else float(text)
    if not (value > 0 and math.isfinite(value) and math.isfinite(1.0 / value)):
        return None
    return value if frame_time is not None else 1.0 / value


@dataclass(frozen=True)
class ClipHead:
    """A clip without its frames.

    fields: header values as lexemes, by MCML's header element names: filetype datatype filename version skeleton_name
        num_segments num_frames dataframe_rate euler_rotation_order calibration_unit global_axis_of_gravity
        bone_length_axis scale_factor; and units_mass units_length units_angle (the attributes of `units`).
        Only values that the source states.
    format: the catalogue name of the source format ("bvh", "asf-amc", "htr", …).
    frame_time: seconds a frame as the file writes it, None if the source has none (AMC, and HTR with its rate).
    number_style: "shortest", "fixed:N" or "general:N": the source's format of motion numbers; used only for writing the
    source format again, and only if it gives the same double.
    description, properties: set by people; properties are (name, value, unit or "").
    reference: the skeleton's reference pose, if known from elsewhere, such as its other clips.
    """

    format: str
    skeleton: Skeleton
    fields: dict[str, str] = field(default_factory=dict)
    frame_time: str | None = None
    number_style: str = "shortest"
    sources: tuple[SourcePart, ...] = ()
    description: str = ""
    properties: tuple[tuple[str, str, str], ...] = ()
    reference: Reference | None = None

    def seconds_per_frame(self) -> float | None:
        """Frame time as a number, from `frame_time` or else 1 / dataframe_rate; None where neither is usable."""
        return seconds_from(self.frame_time, self.fields.get("dataframe_rate"))

    def rate_text(self) -> str | None:
        """Frames a second as a text: the header's, unless the frame time says another rate; None where unknown."""
        seconds, stated = self.seconds_per_frame(), self.fields.get("dataframe_rate")
        if seconds is None:
            return None
        if stated is not None and abs(seconds * float(stated) - 1) < _SAME_RATE:
            return stated
        return repr(1 / seconds).removesuffix(".0")

    def every(self, step: int) -> ClipHead:
        """The head of every step-th frame: a frame lasts that much longer, where the rate is stated."""
        if step == 1:
            return self
        fields, frame_time = dict(self.fields), self.frame_time
        if "dataframe_rate" in fields:
            fields["dataframe_rate"] = repr(float(fields["dataframe_rate"]) / step)
        if frame_time is not None:
            frame_time = repr(float(frame_time) * step)
        return replace(self, fields=fields, frame_time=frame_time)


@dataclass(frozen=True)
class FrameBlock:
    """Consecutive frames.

    values: (n, D) float64, NaN where a frame's shape has no such channel, finite everywhere else.
    columns: (joint, channel) of each of the D columns.
    shapes, shape_of: frame i has the shape `shapes[shape_of[i]]`; shape_of None: all have `shapes[0]`.
    ids: frame ids as written: (n,) int64 where each is a plain decimal integer, else a list of texts.
    motion_names: for each frame its motion names in order, or None where no frame of the block has any.
    """

    values: Array
    columns: tuple[tuple[int, int], ...]
    shapes: tuple[Shape, ...]
    ids: NDArray[np.int64] | list[str]
    shape_of: NDArray[np.intp] | None = None
    motion_names: Sequence[tuple[str, ...]] | None = None

    def __len__(self) -> int:
        return int(self.values.shape[0])


@dataclass(frozen=True)
class Original:
    """The file that the frames of a clip came from, for data that only the file has, such as its analog channels.

    read_channels: reads them, as `mcml.formats.c3d.analog.Channels`, as long as the clip is read. factor: of lengths,
    from those of the file to those of the clip. is_resized: whether the size of the clip changed, not only its unit.
    is_resampled: whether its frames are those of another rate. axes: for x, y and z of the clip, the axis of the file
    (from 0) and the sign.
    """

    read_channels: Callable[[], Any]
    factor: float = 1.0
    is_resized: bool = False
    is_resampled: bool = False
    axes: tuple[tuple[int, float], ...] = ((0, 1.0), (1, 1.0), (2, 1.0))

    @property
    def is_turned(self) -> bool:
        return self.axes != Original.axes

    def scale(self, factor: float, *, resizes: bool) -> Original:
        """Return the same file for a clip whose lengths were multiplied."""
        return replace(self, factor=self.factor * factor, is_resized=self.is_resized or (resizes and factor != 1.0))

    def turn(self, target: Mapping[int, int], sign: Mapping[int, float]) -> Original:
        """Return the same file for a clip that was turned. target, sign: of each axis before."""
        turned = {target[axis]: (self.axes[axis][0], self.axes[axis][1] * sign[axis]) for axis in range(3)}
        return replace(self, axes=(turned[0], turned[1], turned[2]))


@dataclass
class ClipStream:
    """A clip whose frames are read in blocks, each time `blocks()` is called, from the first frame on.

    frames: the number of frames if it is known before reading, else None.
    notices: guesses and repairs of the reader; complete once the blocks were read to the end.
    original: the file of its frames, for writers of the same format that take more from it.
    character: whether writers that can (`SKINNED`) give it a body with a skin instead of bones: True for the own
    figure, or the body itself, bound to the joints of the clip in its unit and axes.
    """

    head: ClipHead
    blocks: Callable[[], Iterator[FrameBlock]]
    frames: int | None = None
    notices: list[Notice] = field(default_factory=list)
    original: Original | None = None
    character: bool | Character = False

    def with_head(self, head: ClipHead) -> ClipStream:
        return replace(self, head=head)


@lru_cache(maxsize=64)
def full_shape(columns: tuple[tuple[int, int], ...]) -> Shape:
    """The shape of a frame that has every column, frame_bones in the order in which the columns name them."""
    bits: dict[int, int] = {}
    for joint, channel in columns:
        bits[joint] = bits.get(joint, 0) | 1 << channel
    return tuple(bits.items())
