"""Frames of a document, from parser events to blocks of numbers.

Which frame_bones and attributes a frame has is its shape. A shape is checked against the content model once, when it
first occurs; after that a frame costs a look-up for each frame_bone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress

import numpy as np
import orjson
from numpy.typing import NDArray

from mcml.errors import DocumentError, LimitError, Place
from mcml.language.addresses import address_attribute, address_child, address_frame
from mcml.language.content import declarations
from mcml.language.lexical import WHITE_SPACE, is_decimal, unescape
from mcml.language.repeats import Pattern, pattern_of
from mcml.language.vocabulary import FRAME, FRAME_BONE, MOTION_NAME, NAME
from mcml.motion.clip import FrameBlock, Shape
from mcml.motion.skeleton import CHANNEL_INDEX, CHANNELS, Array

BLOCK_FRAMES = 256
BLOCK_VALUES = 1 << 17
"""A block ends with the frame that reaches either."""

KNOWN_SHAPES = 1024
"""Shapes remembered from block to block; beyond, a document of ever new ones would fill the memory."""

_NUMBER_BYTES = b"0123456789+-.eE,"


class FrameReader:
    """Takes the parser's events between `<frame …>` and `</frame>`, gives blocks.

    joints: joint index by name as frames write it. line: the parser's current line.
    max_frames, max_names, max_text: limits of the document, of motion names a frame, of a text's characters.
    """

    def __init__(
        self,
        joints: Mapping[str, int],
        line: Callable[[], int],
        max_frames: int,
        max_names: int,
        max_text: int,
    ) -> None:
        self.blocks: list[FrameBlock] = []
        self.total = 0
        self.first_channels: dict[int, tuple[str, ...]] = {}
        self._joints = joints
        self._line = line
        self._max_frames = max_frames
        self._max_names = max_names
        self._max_text = max_text
        self._frame = declarations()[FRAME]
        self._sets: dict[tuple[str, ...], tuple[int, list[int] | None]] = {}
        self._known: dict[Shape, int] = {}
        self._state = 0
        self._open = ""
        self._text: list[str] = []
        self._text_size = 0
        self._shape: list[tuple[int, int]] = []
        self._names: list[str] = []
        self._id = ""
        self._begin_block()

    def begin(self, attributes: list[str]) -> None:
        """`<frame …>`: attributes as name, value, name, value …"""
        error = self._frame.attribute_error(dict(zip(attributes[0::2], attributes[1::2], strict=True)))
        if error:
            raise DocumentError(error, at=self._place())
        self._check_total()
        self._id = attributes[1]
        self._state = 0
        self._shape = []
        self._names = []

    def start(self, tag: str, attributes: list[str]) -> None:
        """A start tag within a frame."""
        if self._open:
            raise DocumentError(declarations()[self._open].child_error(0, tag), at=self._place())
        state = self._frame.steps[self._state].get(tag)
        if state is None:
            raise DocumentError(self._frame.child_error(self._state, tag), at=self._place())
        self._state = state
        self._open = tag
        if tag != FRAME_BONE:
            self._text, self._text_size = [], 0
            if attributes:
                raise DocumentError(f"{tag} has no attribute {attributes[0]}", at=self._place())
            return
        names = tuple(attributes[0::2])
        bits, order = self._sets.get(names) or self._check_attributes(names)
        bone, values = attributes[1], attributes[3::2]
        if order is not None:
            bone = attributes[2 * order[0] + 1]
            values = [attributes[2 * place + 1] for place in order[1:]]
        joint = self._joints.get(bone)
        if joint is None:
            joint = self._find_joint(bone)
        self._shape.append((joint, bits))
        if len(self._shape) > len(self._joints):
            self._refuse_twice()
        self._lines.append(self._line())
        self._values += values

    def end(self, tag: str) -> None:
        """An end tag within a frame."""
        self._open = ""
        if tag == MOTION_NAME:
            name = unescape("".join(self._text).strip(WHITE_SPACE))
            if not name:
                raise DocumentError("a motion name is empty", at=self._place(), remedy="Write one, or remove it.")
            if len(self._names) >= self._max_names:
                raise LimitError(f"the frame has more than {self._max_names} motion names", at=self._place())
            self._names.append(name)

    def text(self, text: str) -> None:
        """Characters within a frame."""
        if self._open == MOTION_NAME:
            self._text.append(text)
            self._text_size += len(text)
            if self._text_size > self._max_text:
                raise LimitError(f"a motion name has more than {self._max_text} characters", at=self._place())
        elif self._open or text.strip(WHITE_SPACE):
            tag = self._open or FRAME
            raise DocumentError(f"{tag} cannot hold text, found {text.strip()[:40]!r}", at=self._place())

    def inside_empty(self) -> bool:
        """Whether the parser is within a frame_bone, where not even a comment is allowed."""
        return self._open == FRAME_BONE

    def finish(self) -> None:
        """`</frame>`."""
        shape = tuple(self._shape)
        index = self._known.get(shape)
        if index is None:
            index = self._check_shape(shape)
        if not self.total:
            self.first_channels = {
                joint: tuple(channel for place, channel in enumerate(CHANNELS) if bits >> place & 1)
                for joint, bits in shape
            }
        self.total += 1
        self._ids.append(self._id)
        self._shape_of.append(index)
        self._motion_names.append(tuple(self._names))
        if len(self._ids) >= BLOCK_FRAMES or len(self._values) >= BLOCK_VALUES:
            self.flush()

    def pattern(self, raw: bytes) -> Pattern | None:
        """The pattern of the frame just finished, from its bytes up to its end tag."""
        return pattern_of(raw, tuple(self._shape), tuple(self._names))

    def repeat(self, pattern: Pattern, identity: str, numbers: tuple[str, ...]) -> None:
        """Add a frame that repeats a pattern except for its id and numbers."""
        line = self._line()
        self._id = identity
        self._names = list(pattern.motion_names)
        self._shape = list(pattern.shape)
        self._values += numbers
        self._lines += [line + place for place in pattern.lines]
        self._check_total()
        self.finish()

    def flush(self) -> None:
        """Makes a block of the frames since the last one. Raises DocumentError for a value that is no number."""
        if not self._ids:
            return
        shapes = list(self._known)
        used = list(dict.fromkeys(self._shape_of))
        columns = tuple(dict.fromkeys(column for index in used for column in _columns(shapes[index])))
        numbers = self._numbers()
        shape_of: NDArray[np.intp] | None = None
        if len(used) == 1:
            values = numbers.reshape(len(self._ids), len(columns))
        else:
            place = {index: local for local, index in enumerate(used)}
            shape_of = np.array([place[index] for index in self._shape_of], dtype=np.intp)
            values = _spread(numbers, [_columns(shapes[index]) for index in used], shape_of, columns)
        self.blocks.append(
            FrameBlock(
                values,
                columns,
                tuple(shapes[index] for index in used),
                _ids(self._ids),
                shape_of,
                self._motion_names if any(self._motion_names) else None,
            )
        )
        if len(self._known) > KNOWN_SHAPES:
            self._known.clear()
        self._begin_block()

    def _check_total(self) -> None:
        if self.total >= self._max_frames:
            raise LimitError(f"the document has more than {self._max_frames} frames", limit=self._max_frames)

    def _begin_block(self) -> None:
        self._values: list[str] = []
        self._lines: list[int] = []
        self._ids: list[str] = []
        self._shape_of: list[int] = []
        self._motion_names: list[tuple[str, ...]] = []

    def _check_attributes(self, names: tuple[str, ...]) -> tuple[int, list[int] | None]:
        """Return the bits of the channels, and the indices of name and channels in order, None if they are already
        in order.
        """
        error = declarations()[FRAME_BONE].attribute_error(dict.fromkeys(names, ""))
        if error:
            raise DocumentError(error, at=self._place())
        bits = sum(1 << CHANNEL_INDEX[name] for name in names if name != NAME)
        wanted = [NAME, *(channel for channel in CHANNELS if channel in names)]
        order = None if list(names) == wanted else [names.index(name) for name in wanted]
        self._sets[names] = bits, order
        return bits, order

    def _find_joint(self, bone: str) -> int:
        joint = self._joints.get(bone.strip(WHITE_SPACE))
        if joint is None:
            raise DocumentError(
                f"no bone is named {bone!r}", at=self._place(), remedy="Name a bone of the skeleton, or its root."
            )
        return joint

    def _check_shape(self, shape: Shape) -> int:
        if len({joint for joint, _ in shape}) != len(shape):
            self._refuse_twice()
        index = self._known[shape] = len(self._known)
        return index

    def _refuse_twice(self) -> None:
        joints = [joint for joint, _ in self._shape]
        twice = next(joint for place, joint in enumerate(joints) if joint in joints[:place])
        name = next(name for name, joint in self._joints.items() if joint == twice)
        raise DocumentError(f"the frame has the bone {name!r} twice", at=self._place())

    def _numbers(self) -> Array:
        texts = self._values
        try:
            joined = ",".join(texts).encode("ascii")
            # float() also takes "nan", "1_0" and digits of other scripts: one look at all letters excludes them.
            if not joined.translate(None, _NUMBER_BYTES):
                numbers = np.array(_decimals(joined, texts), dtype=np.float64)
                if np.isfinite(numbers).all():
                    return numbers
        except ValueError:
            pass
        raise self._bad_number()

    def _bad_number(self) -> DocumentError:
        """The error for the first value of the block that is no finite decimal."""
        shapes = list(self._known)
        texts = iter(self._values)
        lines = iter(self._lines)
        names = {joint: name for name, joint in self._joints.items()}
        for place, index in enumerate(self._shape_of):
            for ordinal, (joint, bits) in enumerate(shapes[index], start=1):
                line = next(lines)
                for channel in _channels(bits):
                    text = next(texts)
                    if not is_decimal(text):
                        frame = self.total - len(self._ids) + place + 1
                        bone = address_child(frame, FRAME_BONE, ordinal)
                        return DocumentError(
                            f"{CHANNELS[channel]} of {names[joint]!r} is {text[:40]!r}, not a finite decimal number",
                            at=Place(line=line, element=address_attribute(bone, CHANNELS[channel])),
                            remedy="Leave the attribute out where there is no sample.",
                        )
        raise ValueError("every number of the block is a decimal")

    def _place(self) -> Place:
        return Place(line=self._line(), element=address_frame(self.total + 1))


def _decimals(joined: bytes, texts: list[str]) -> list[float]:
    """The doubles of texts, which `joined` holds between commas. ValueError where one is no number."""
    # JSON has no .5, +1 and 1., and reads -0 as the integer 0. Where all texts are as JSON wants them, it is faster.
    if b"-0," not in joined + b",":
        with suppress(orjson.JSONDecodeError):
            numbers: list[float] = orjson.loads(b"[" + joined + b"]")
            if len(numbers) == len(texts):
                return numbers
    return list(map(float, texts))


def _channels(bits: int) -> tuple[int, ...]:
    return tuple(channel for channel in range(len(CHANNELS)) if bits >> channel & 1)


def _columns(shape: Shape) -> tuple[tuple[int, int], ...]:
    return tuple((joint, channel) for joint, bits in shape for channel in _channels(bits))


def _spread(
    numbers: Array,
    columns_of: list[tuple[tuple[int, int], ...]],
    shape_of: NDArray[np.intp],
    columns: tuple[tuple[int, int], ...],
) -> Array:
    """Numbers of frames of different shapes, (n, D), NaN where a frame's shape lacks the column."""
    place = {column: index for index, column in enumerate(columns)}
    widths = np.array([len(own) for own in columns_of])
    ends = np.cumsum(widths[shape_of])
    values = np.full((len(shape_of), len(columns)), np.nan)
    for index, own in enumerate(columns_of):
        frames = np.flatnonzero(shape_of == index)
        target = np.array([place[column] for column in own], dtype=np.intp)
        source = (ends[frames] - len(own))[:, None] + np.arange(len(own))
        values[frames[:, None], target] = numbers[source]
    return values


def _ids(texts: list[str]) -> NDArray[np.int64] | list[str]:
    """Ids as numbers where that keeps every letter of them."""
    try:
        numbers = np.array(list(map(int, texts)), dtype=np.int64)
    except (ValueError, OverflowError):
        return texts
    return numbers if list(map(str, numbers.tolist())) == texts else texts
