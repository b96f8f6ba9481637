"""Plain: a line `plain`, then for each frame and marker a line of name and place in metres."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from mcml.errors import FormatError
from mcml.formats.format import FileKind, ReadOptions, SourceFile
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.skeleton import Convention, Joint, Skeleton


class Plain:
    """The format `plain`; see `mcml.formats.format.Format`."""

    name = "plain"
    title = "Plain markers"
    label = "Plain"
    parts = (FileKind("plain", (".plain",), "Markers"),)
    convention = Convention.MARKER
    media_type = "text/plain"
    bodies, markers = False, True
    needs = frozenset[str]()
    assumes = ""
    states = frozenset[str]()

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        return "plain" if first_bytes.startswith(b"plain\n") else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        rows = [line.split() for line in files["plain"].stream.read().decode().splitlines()[1:]]
        if any(len(row) != 4 for row in rows):
            raise FormatError("a line is no name and place", remedy="Write `name x y z`.")
        names = list(dict.fromkeys(row[0] for row in rows))
        joints = [Joint(name, -1, name, Convention.MARKER, channels=("Tx", "Ty", "Tz")) for name in names]
        values = np.array([row[1:] for row in rows], float).reshape(-1, 3 * len(names))
        columns = tuple((joint, channel) for joint in range(len(names)) for channel in range(3))
        shape = tuple((joint, 0b111) for joint in range(len(names)))
        block = FrameBlock(values, columns, (shape,), np.arange(1, len(values) + 1))
        return ClipStream(ClipHead("plain", Skeleton(tuple(joints))), lambda: iter([block]), len(values))

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        yield b"plain\n"
        for block in clip.blocks():
            for row in block.values.reshape(len(block), -1, 3):
                for joint, place in zip(clip.head.skeleton.joints, row.tolist(), strict=True):
                    yield f"{joint.source_name} {' '.join(map(repr, place))}\n".encode()
