"""FBX, binary and text, versions 5.0 to 7.7: the file that most programs for animation write.

The format has no public specification; ufbx (https://github.com/ufbx/ufbx) reads and evaluates it: layers, pre- and
post-rotations, pivots, rotation orders, inherited scale. docs/formats/fbx.md describes the reading.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import BinaryIO

from mcml.formats.fbx.meshes import count_vertices, read_character
from mcml.formats.format import FileKind, ReadOptions, SourceFile
from mcml.formats.scenes.apart import list_takes_apart, read_apart
from mcml.formats.scenes.reader import SceneReader
from mcml.formats.scenes.scene import Scene
from mcml.motion.characters.rigged import RiggedCharacter

_TEXT = re.compile(rb"\s*;\s*FBX |(?:[^\n]*\n)*?\s*FBXHeaderExtension\s*:")


class Fbx(SceneReader):
    """The format `fbx`; see `mcml.formats.format.Reader`."""

    name = "fbx"
    title = "Autodesk FBX"
    label = "FBX"
    parts = (FileKind("fbx", (".fbx",), "Skeleton and motions"),)

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        if first_bytes.startswith(b"Kaydara FBX Binary  \0"):
            return "fbx"
        return "fbx" if b"\0" not in first_bytes and _TEXT.match(first_bytes) else None

    def read_character(self, files: Mapping[str, SourceFile], options: ReadOptions) -> RiggedCharacter | None:
        """See `mcml.formats.format.CharacterReader`."""
        with files["fbx"].blamed():
            return read_character(files["fbx"], options)

    def count_vertices(self, stream: BinaryIO) -> int:
        """See `mcml.formats.format.CharacterReader`."""
        return count_vertices(stream)

    def open_scene(self, files: Mapping[str, SourceFile], options: ReadOptions) -> Scene:
        return read_apart("mcml.processes.evaluate_fbx", files["fbx"], options)

    def list_takes(self, files: Mapping[str, SourceFile], options: ReadOptions) -> list[str]:
        return list_takes_apart("mcml.processes.evaluate_fbx", files["fbx"], options)
