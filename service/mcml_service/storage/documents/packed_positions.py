"""Rounded positions of joints (`mcml.motion.bodies.positions`) as bytes: a few joints at a time, so that one of them
is read without the others."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray
from pcodec import ChunkConfig, DeltaSpec, ModeSpec, standalone

from mcml.errors import StoreError

Steps = NDArray[np.int32]

BLOCK = 16_384
"""Frames that are packed together."""
TOGETHER = 4096
"""Numbers of joints that are compressed together: a separate stream for each costs a tenth more."""
_HEAD = struct.Struct("<III")


@cache
def _config() -> ChunkConfig:
    # Movement is smooth: the residual after linear extrapolation from the last two positions is smallest.
    return ChunkConfig(compression_level=6, delta_spec=DeltaSpec.try_consecutive(2), mode_spec=ModeSpec.classic())


def pack(steps: Steps) -> list[bytes]:
    """Pack (n, J, 3) into blocks of up to BLOCK frames; one block for no frames."""
    return [_block(steps[first : first + BLOCK]) for first in range(0, max(len(steps), 1), BLOCK)]


def pack_parts(parts: Iterable[Steps]) -> Iterator[bytes]:
    """Yield the blocks of (n, J, 3), given in parts with any numbers of frames."""
    waiting: list[Steps] = []
    for part in parts:
        waiting.append(part)
        if sum(map(len, waiting)) >= BLOCK:
            together = np.concatenate(waiting)
            whole = len(together) // BLOCK * BLOCK
            yield from pack(together[:whole])
            waiting = [together[whole:]]
    if waiting and len(waiting[-1]):
        yield from pack(np.concatenate(waiting))


def _block(steps: Steps) -> bytes:
    frames, joints, _ = steps.shape
    columns = np.ascontiguousarray(steps.transpose(1, 2, 0))
    some = max(1, TOGETHER // max(1, 3 * frames))
    together = [columns[at : at + some].ravel() for at in range(0, joints, some)] if frames else []
    parts = [bytes(standalone.simple_compress(numbers, _config())) for numbers in together]
    head = _HEAD.pack(frames, joints, some) + struct.pack(f"<{len(parts)}I", *map(len, parts))
    return head + b"".join(parts)


def unpack(blocks: tuple[bytes, ...], joints: Sequence[int]) -> list[Steps]:
    """(n, 3) of each of some joints. StoreError where the bytes are damaged."""
    try:
        parts = [_unpack(block, joints) for block in blocks]
    except (RuntimeError, ValueError, TypeError, IndexError, struct.error) as error:
        raise StoreError(
            f"Positions of joints are damaged: {error}", remedy="Derive them again: mcml db derive."
        ) from error
    return parts[0] if len(parts) == 1 else [np.concatenate(own) for own in zip(*parts, strict=True)]


def _unpack(block: bytes, joints: Sequence[int]) -> list[Steps]:
    frames, count, some = _HEAD.unpack_from(block)
    parts = -(-count // some) if frames else 0
    sizes = struct.unpack_from(f"<{parts}I", block, _HEAD.size)
    ends = list(accumulate(sizes, initial=_HEAD.size + 4 * len(sizes)))
    if ends[-1] != len(block):
        raise ValueError("a block ends elsewhere")
    if not frames:
        return [np.empty((0, 3), np.int32) for _ in joints]
    held: dict[int, Steps] = {}
    for part in {joint // some for joint in joints}:
        numbers = standalone.simple_decompress(block[ends[part] : ends[part + 1]])
        held[part] = np.asarray(numbers, np.int32).reshape(-1, 3, frames)
    return [held[joint // some][joint % some].T for joint in joints]
