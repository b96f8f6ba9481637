"""What readers of scenes give, as places and rotations in the world, and files made for tests."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

import numpy as np

from mcml.errors import McmlError
from mcml.formats import READERS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.clip import ClipStream
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of
from mcml.testing import frames


def read_clip(name: str, data: bytes | Mapping[str, bytes], file_name: str = "", **options: object) -> ClipStream:
    """The clip of a file of a format of the catalogue."""
    part = READERS[name].parts[0].name
    parts = data if isinstance(data, Mapping) else {part: data}
    files = {each: SourceFile(file_name or f"clip.{each}", io.BytesIO(content)) for each, content in parts.items()}
    return READERS[name].read(files, ReadOptions(**options))  # type: ignore[arg-type]


def reads_or_refuses(name: str, data: bytes) -> None:
    """A damaged file is read to its end, or refused in words of ours; nothing else happens."""
    try:
        frames(read_clip(name, data))
    except McmlError:
        return


def spoil(data: bytes, chance: np.random.Generator, bytes_each: int = 3) -> bytes:
    """The data with some bytes changed."""
    spoilt = bytearray(data)
    for place in chance.integers(0, len(data), bytes_each):
        spoilt[place] = int(chance.integers(0, 256))
    return bytes(spoilt)


def places_of(clip: ClipStream) -> Array:
    """(frames, J, 3) of the joints in the world."""
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    return np.concatenate([walker.poses(block)[0] for block in clip.blocks()])


def rotations_of(clip: ClipStream) -> Array:
    """(frames, J, 4) of the joints' axes in the world, from those at rest."""
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    return np.concatenate([walker.poses(block)[1] for block in clip.blocks()])


def npz(**arrays: object) -> bytes:
    """An NPZ file of arrays."""
    target = io.BytesIO()
    np.savez(target, **arrays)  # type: ignore[arg-type]
    return target.getvalue()


def zipped(files: Mapping[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A zip of files."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return target.getvalue()
