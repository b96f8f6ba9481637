"""C3D files from the specification's words, one number at a time. Shares no code with the reader that it tests."""

from __future__ import annotations

import io
import math
import struct
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from mcml.formats.c3d.analog import read_channels
from mcml.motion.clip import Original

INTEL, DEC, MIPS = 84, 85, 86

Value = tuple[int, Sequence[int], Sequence[float] | bytes]
"""(type, dimensions, numbers or characters) of a parameter."""


def texts(*words: str) -> Value:
    """A parameter of texts, filled up with blanks to one length."""
    longest = max(1, *map(len, words))
    return -1, (longest, len(words)), "".join(word.ljust(longest) for word in words).encode()


def word(value: int, processor: int) -> bytes:
    return struct.pack(">H" if processor == MIPS else "<H", value & 0xFFFF)


def number(value: float, processor: int) -> bytes:
    """A float of a machine. DEC: sign, exponent and the high bits of the fraction in the first of two words."""
    if processor != DEC:
        return struct.pack(">f" if processor == MIPS else "<f", value)
    if value == 0:
        return bytes(4)
    part, exponent = math.frexp(abs(value))
    fraction = int(part * 2**24) - 2**23
    high = (value < 0) << 15 | (exponent + 128) << 7 | fraction >> 16
    return struct.pack("<HH", high, fraction & 0xFFFF)


def c3d_bytes(
    points: np.ndarray,
    fourth: np.ndarray | None = None,
    *,
    scale: float = -1.0,
    processor: int = INTEL,
    analog: np.ndarray | None = None,
    samples: int = 1,
    rate: float = 100.0,
    first: int = 1,
    labels: Sequence[str] | None = None,
    header: Mapping[int, int] | None = None,
    parameters: Mapping[str, Value | None] | None = None,
    behind: bytes | None = None,
) -> bytes:
    """A file of points.

    points: (frames, points, 3); whole numbers, to be multiplied by the scale, where that is positive. fourth: (frames,
    points) the fourth word of each point. analog: (frames, samples × channels). header: words of the header, counted
    from 1, that say something else. parameters: those that say something else, or nothing (None). behind: what stands
    after the data instead of zeros to the end of the block.
    """
    frames, count = points.shape[:2]
    fourth = np.zeros((frames, count)) if fourth is None else fourth
    analog = np.zeros((frames, 0)) if analog is None else analog
    channels = analog.shape[1] // samples
    names = [f"p{index}" for index in range(count)] if labels is None else list(labels)
    longest = max(map(len, names))
    said: dict[str, Value | None] = {
        "POINT:USED": (2, (), [count]),
        "POINT:SCALE": (4, (), [scale]),
        "POINT:RATE": (4, (), [rate]),
        "POINT:FRAMES": (2, (), [min(frames, 65535)]),
        "POINT:LABELS": (-1, (longest, count), "".join(name.ljust(longest) for name in names).encode()),
        "POINT:UNITS": (-1, (4,), b"mm  "),
        "ANALOG:USED": (2, (), [channels]),
        "ANALOG:RATE": (4, (), [rate * samples]),
    } | dict(parameters or {})
    blocks = (sum(len(record(name, value, processor)) for name, value in said.items() if value) + 200) // 512 + 1
    start = 2 + blocks
    said = {"POINT:DATA_START": (2, (), [start])} | said
    section = bytes([1, 0x50, blocks, processor])
    for index, group in enumerate(dict.fromkeys(name.split(":")[0] for name in said), 1):
        section += bytes([len(group), 256 - index]) + group.encode() + word(3, processor) + b"\0"
        for name, value in said.items():
            if value and name.split(":")[0] == group:
                section += record(name, value, processor, index)
    words = {2: count, 3: analog.shape[1], 4: first, 5: min(first + frames - 1, 65535), 9: start}
    words |= {10: samples if channels else 0} | dict(header or {})
    head = b"".join(word(words.get(index, 0), processor) for index in range(1, 257))
    head = b"\x02\x50" + head[2:12] + number(scale, processor) + head[16:20] + number(rate, processor) + head[24:]
    data = b""
    for frame in range(frames):
        row = [*np.concatenate([points[frame], fourth[frame, :, None]], axis=1).ravel(), *analog[frame]]
        if scale < 0:
            data += b"".join(number(float(value), processor) for value in row)
        else:
            data += b"".join(word(int(value), processor) for value in row)
    return head + section.ljust(512 * blocks, b"\0") + data + (bytes(-len(data) % 512) if behind is None else behind)


def record(name: str, value: Value, processor: int, group: int = 1) -> bytes:
    """A parameter: name, distance to the next, type, dimensions, data, no description."""
    kind, dimensions, content = value
    if not isinstance(content, bytes):
        write = {2: lambda item: word(int(item), processor), 4: lambda item: number(item, processor)}[kind]
        content = b"".join(write(item) for item in content)
    plain = name.split(":")[1].encode()
    rest = bytes([kind & 0xFF, len(dimensions), *dimensions]) + content + b"\0"
    return bytes([len(plain), group]) + plain + word(len(rest) + 2, processor) + rest


def kept_c3d(data: bytes) -> Original:
    """A file that frames came from."""
    return Original(partial(read_channels, io.BytesIO(data)))
