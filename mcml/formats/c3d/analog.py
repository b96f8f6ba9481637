"""Analog channels of C3D files: force plates, electromyography and other signals, at their own rate.

Source: The C3D File Format User Guide (c3d.org), "The ANALOG Group": a value is (raw - OFFSET) × SCALE × GEN_SCALE.
This program's reading of it is in docs/formats/c3d.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np

from mcml.errors import LimitError, Notice
from mcml.formats.c3d.data import find_data, first_frame, frames_at_a_time, read_rows
from mcml.formats.c3d.layout import Layout
from mcml.formats.c3d.parameters import BLOCK, Statements, read_statements
from mcml.formats.c3d.quantities import plain_text, texts_of
from mcml.formats.format import note
from mcml.motion.skeleton import Array, unique_names

_MOST_CHANNELS: Final = 65_535
_MODULUS: Final = 65_536
_TOLERANCE: Final = 1e-3
"""Relative difference of two statements of one rate, which single precision and rounded rates do not reach."""


@dataclass(frozen=True, eq=False)
class Channels:
    """The analog channels of a file. The stream must stay open for `read`.

    labels: unique, the second `Fx` is `Fx#2`. units: as the file writes them, "" where it states none. rate: samples a
    second, NaN if unknown. samples: of a channel in a frame. frames: of the file; first: number of the first one.
    scales, offsets: (channels,), SCALE × GEN_SCALE and OFFSET. unsigned: whether integers have no sign. assumptions:
    about the force plates of all of them. has_surfaces: whether the corners of the plates are their own.
    """

    stream: BinaryIO
    said: Statements
    layout: Layout
    labels: tuple[str, ...]
    descriptions: tuple[str, ...]
    units: tuple[str, ...]
    rate: float
    samples: int
    first: int
    scales: Array
    offsets: Array
    unsigned: bool
    notices: tuple[Notice, ...]
    assumptions: tuple[str, ...] = ()
    has_surfaces: bool = True

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def frames(self) -> int:
        return self.layout.frames

    @property
    def block(self) -> int:
        """How many frames to read at a time."""
        return frames_at_a_time(self.layout) if self.layout.frame_bytes else 1

    def read(self, first: int = 0, count: int | None = None, channels: Sequence[int] | None = None) -> Array:
        """(n × samples, channels) values of n frames from `first` on, counted from 0; fewer at the end of the file.

        count: all frames by default. channels: places of some channels, in the order of the result; all by default.
        """
        places, values = self._places(channels), self.read_raw(first, count, channels)
        values -= self.offsets[places]
        values *= self.scales[places]
        return values

    def read_raw(self, first: int = 0, count: int | None = None, channels: Sequence[int] | None = None) -> Array:
        """Numbers as they are stored, before scale and offset; arguments and shape as of `read`."""
        if first < 0:
            raise ValueError(f"frames count from 0, not from {first}")
        places, layout = self._places(channels), self.layout
        count = max(0, min(self.frames if count is None else count, self.frames - first))
        raw = np.empty((count * self.samples, len(places)))
        begin = 4 * layout.points * (4 if layout.real else 2)
        for start in range(0, count if len(places) else 0, self.block):
            rows = read_rows(self.stream, layout, first + start, min(self.block, count - start))
            numbers = self._numbers(np.ascontiguousarray(rows[:, begin:]).tobytes()).reshape(-1, len(self))
            raw[start * self.samples :][: len(numbers)] = numbers[:, places]
        return raw

    def means(self, channels: Sequence[int], *, around_instant: bool = False) -> Array:
        """(frames of the file, channels) means of the samples of each frame.

        around_instant: of the samples within half a frame before and after the first one of each, the instant of its
        points.
        """
        means, half = np.empty((self.frames, len(channels))), self.samples // 2
        before, count = np.zeros(len(channels)), 0
        for first in range(0, self.frames, self.block):
            samples = self.read(first, self.block, channels).reshape(-1, self.samples, len(channels))
            if not around_instant:
                means[first : first + self.block] = samples.mean(axis=1)
                continue
            late = samples[:, self.samples - half :].sum(axis=1)
            sums = samples[:, : half + 1].sum(axis=1) + np.concatenate([before[None], late[:-1]])
            counts = np.full((len(samples), 1), 2 * half + 1)
            counts[0] = half + 1 + count
            means[first : first + self.block] = sums / counts
            before, count = late[-1], half
        return means

    def _places(self, channels: Sequence[int] | None) -> list[int]:
        places = list(range(len(self)) if channels is None else channels)
        if any(not 0 <= place < len(self) for place in places):
            raise ValueError(f"channels are {places}, and the file has {len(self)}, counted from 0")
        return places

    def _numbers(self, data: bytes) -> Array:
        machine = self.said.machine
        if self.layout.real:
            return machine.floats(data)
        integers: Array = (machine.words if self.unsigned else machine.integers)(data).astype(np.float64)
        return integers


def read_channels(stream: BinaryIO) -> Channels:
    """Read the statements about analog channels of a file, which may have no points; the samples are read by `read`.

    A file without analog channels has none. Raises FormatError where the file cannot be read, LimitError for more
    channels than the format can state.
    """
    notices: list[Notice] = []
    said = read_statements(stream, notices)
    stated = (said.words[1], said.words[2], said.number("POINT:USED"), said.number("ANALOG:USED"))
    layout = find_data(stream, said, notices, analog_alone=True) if any(stated) else Layout(BLOCK, 0, 0, 0, True)
    count, samples = _split(said, layout.analog, notices)
    if count > _MOST_CHANNELS:
        raise LimitError(
            f"the file states {count} analog channels, the limit is {_MOST_CHANNELS}",
            remedy="Send the C3D file itself.",
        )
    labels = [plain_text(text) or "unnamed" for text in texts_of(said, "ANALOG:LABELS")][:count]
    if len(labels) < count:
        note(notices, "warning", f"{count} analog channels have {len(labels)} labels: the others are unnamed")
    unsigned = any(plain_text(text).upper() == "UNSIGNED" for text in said.texts("ANALOG:FORMAT"))
    offsets = _per_channel(said, "ANALOG:OFFSET", 0.0, count, notices, signed=not unsigned)
    scales = _per_channel(said, "ANALOG:SCALE", 1.0, count, notices)
    general = said.number("ANALOG:GEN_SCALE")
    return Channels(
        stream,
        said,
        layout,
        tuple(unique_names([*labels, *["unnamed"] * (count - len(labels))])),
        _texts(said, "ANALOG:DESCRIPTIONS", count),
        _texts(said, "ANALOG:UNITS", count),
        _rate(said, samples, notices) if count else math.nan,
        samples,
        first_frame(said, layout.frames),
        scales * (1.0 if general is None else general),
        np.mod(offsets, _MODULUS) if unsigned else offsets,
        unsigned,
        tuple(notices),
    )


def _split(said: Statements, values: int, notices: list[Notice]) -> tuple[int, int]:
    """Return (channels, samples of each) for the analog values of a frame."""
    if not values:
        return 0, 1
    used, samples = round(said.number("ANALOG:USED") or 0), int(said.words[9]) or 1
    if used * samples == values:
        return used, samples
    # The number of channels has a second witness, their labels; that of samples is only in the header.
    if used > 0 and values % used == 0:
        choice = used, values // used
    else:
        choice = (values // samples, samples) if values % samples == 0 else (values, 1)
    what = f"{values} analog values a frame count as {choice[0]} channels of {choice[1]} samples"
    note(notices, "warning", f"{what}; the file states {used} channels of {samples}")
    return choice


def _per_channel(
    said: Statements, name: str, default: float, count: int, notices: list[Notice], *, signed: bool = False
) -> Array:
    """(channels,) numbers of a parameter, the default where there are fewer."""
    numbers = said.numbers(name, signed=signed)[:count]
    if len(numbers) < count:
        note(notices, "warning", f"{name} has {len(numbers)} of {count} numbers: {default:g} counts for the others")
    return np.array([*numbers, *[default] * (count - len(numbers))], dtype=np.float64)


def _texts(said: Statements, name: str, count: int) -> tuple[str, ...]:
    texts = [plain_text(text) for text in texts_of(said, name)[:count]]
    return (*texts, *[""] * (count - len(texts)))


def _rate(said: Statements, samples: int, notices: list[Notice]) -> float:
    """Samples a second: as ANALOG:RATE states, unless the rate of the frames contradicts it."""
    stated, frames = said.number("ANALOG:RATE") or 0.0, said.number("POINT:RATE") or said.rate
    implied = frames * samples if math.isfinite(frames) and frames > 0 else 0.0
    if stated > 0 and implied > 0 and abs(stated - implied) > _TOLERANCE * implied:
        what = f"ANALOG:RATE is {stated:g}, frames have {samples} samples and a rate of {frames:g}"
        note(notices, "warning", f"{what}: {implied:g} samples a second count")
        return implied
    return stated if stated > 0 else implied or math.nan
