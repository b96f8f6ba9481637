"""glTF 2.0 as `.glb`, `.gltf`, `.vrm` and `.vrma`: skeletons of skins, or the humanoid of a VRM.

Sources: glTF 2.0 specification, Khronos Group 2021; VRM 0.x, VRM 1.0 and VRM Animation 1.0 specifications, VRM
Consortium. docs/formats/glb.md describes the reading.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import BinaryIO

from mcml.formats.format import FileKind, ReadOptions, SourceFile
from mcml.formats.gltf.document import Document
from mcml.formats.gltf.meshes import count_vertices, read_character
from mcml.formats.gltf.reading import SceneReading
from mcml.formats.scenes.reader import SceneReader, read_all
from mcml.formats.scenes.scene import Scene
from mcml.motion.characters.rigged import RiggedCharacter

_TEXT = re.compile(rb"\s*\{")


class Gltf(SceneReader):
    """The format `glb`; see `mcml.formats.format.Reader`."""

    name = "glb"
    title = "glTF 2.0"
    label = "glTF"
    parts = (FileKind("glb", (".glb", ".gltf", ".vrm", ".vrma"), "Skeleton and motions"),)
    media_type = "model/gltf-binary"

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        if first_bytes.startswith(b"glTF"):
            return "glb"
        is_text = _TEXT.match(first_bytes.removeprefix(b"\xef\xbb\xbf")) is not None
        if is_text and (name.lower().endswith(".gltf") or re.search(rb'"asset"\s*:\s*\{', first_bytes)):
            return "glb"
        return None

    def open_scene(self, files: Mapping[str, SourceFile], options: ReadOptions) -> Scene:
        return _open(files, options).scene()

    def read_character(self, files: Mapping[str, SourceFile], options: ReadOptions) -> RiggedCharacter | None:
        """See `mcml.formats.format.CharacterReader`."""
        with files["glb"].blamed():
            return read_character(_open(files, options))

    def count_vertices(self, stream: BinaryIO) -> int:
        """See `mcml.formats.format.CharacterReader`."""
        stream.seek(0)
        return count_vertices(stream.read())


def _open(files: Mapping[str, SourceFile], options: ReadOptions) -> SceneReading:
    companions = {file.name.rsplit("/", 1)[-1]: file for part, file in files.items() if part != "glb"}

    def companion(name: str) -> bytes | None:
        return read_all(companions[name]) if name in companions else None

    return SceneReading(Document(read_all(files["glb"]), companion), options)
