"""The file of a clip that has analog channels and force plates, and its reader."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import BinaryIO

from mcml.formats.c3d.analog import Channels, read_channels
from mcml.formats.trc.forces import PART as FORCES
from mcml.formats.trc.forces import read_forces
from mcml.motion.clip import ClipHead


def analog_part(head: ClipHead) -> str | None:
    """The part of the source whose analog channels belong to frames, by the numbers that these have as ids."""
    return next((source.part for source in head.sources if source.part in ("c3d", FORCES)), None)


def channels_reader(head: ClipHead, stream: BinaryIO) -> Callable[[], Channels]:
    """Return what reads the analog channels of a file. stream: of `analog_part`, open as long as it is used."""
    return partial(read_forces, head, stream) if analog_part(head) == FORCES else partial(read_channels, stream)
