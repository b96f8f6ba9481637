"""The part that all readers of scenes share: a scene opened once, its takes by their names, each a clip."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from mcml.errors import NotFoundError
from mcml.formats.format import FileKind, ReadOptions, SourceFile
from mcml.formats.scenes.make_clip import make_clip
from mcml.formats.scenes.scene import Scene
from mcml.motion.clip import ClipStream, SourcePart
from mcml.motion.skeleton import Convention, unique_names

KEPT_BYTES = 64 << 20
"""Of the scene that was opened last: its takes are mostly read one after the other."""


class SceneReader(ABC):
    """A reader of scenes; see `mcml.formats.format.Reader`. A subclass gives the facts, `sniff` and `open_scene`."""

    name: ClassVar[str]
    title: ClassVar[str]
    label: ClassVar[str]
    parts: ClassVar[tuple[FileKind, ...]]
    media_type: ClassVar[str] = "application/octet-stream"
    convention = Convention.BASE
    states = frozenset({"unit", "up", "frame_time", "blend_shapes"})

    def __init__(self) -> None:
        self._last: tuple[tuple[object, ...], Scene] | None = None

    @abstractmethod
    def open_scene(self, files: Mapping[str, SourceFile], options: ReadOptions) -> Scene:
        """The scene in the files. Raises as `read` does."""

    def list_takes(self, files: Mapping[str, SourceFile], options: ReadOptions) -> list[str]:
        """The names of the takes, as the file has them."""
        return [take.name for take in self._scene(files, options).takes]

    def takes(self, files: Mapping[str, SourceFile], options: ReadOptions) -> tuple[str, ...]:
        """See `mcml.formats.format.TakesReader`."""
        with files[self.parts[0].name].blamed():
            return _unique(self.list_takes(files, options))

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        """See `mcml.formats.format.Reader`. The first take where `options` names none; NotFoundError for another."""
        file = files[self.parts[0].name]
        with file.blamed():
            scene = self._scene(files, options)
            names = _unique([take.name for take in scene.takes])
            if options.take is not None and options.take not in names:
                raise NotFoundError(
                    f"the file has no take {options.take!r}", remedy=f"It has: {', '.join(names[:60])}."
                )
            take = scene.takes[0 if options.take is None else names.index(options.take)]
            part = SourcePart(self.parts[0].name, file.name.rsplit("/", 1)[-1])
            return make_clip(scene, take, self.name, part, options.limits)

    def _scene(self, files: Mapping[str, SourceFile], options: ReadOptions) -> Scene:
        key = (*(_digest(file) for file in files.values()), options.rate, options.limits)
        last = self._last
        if last is not None and last[0] == key:
            return last[1]
        scene = self.open_scene(files, options)
        self._last = (key, scene) if scene.size <= KEPT_BYTES else None
        return scene


def _unique(names: list[str]) -> tuple[str, ...]:
    return tuple(unique_names([name or "take" for name in names]))


def _digest(file: SourceFile) -> str:
    file.stream.seek(0)
    digest = hashlib.sha256()
    while block := file.stream.read(1 << 20):
        digest.update(block)
    file.stream.seek(0)
    return digest.hexdigest()


def read_all(file: SourceFile) -> bytes:
    """The bytes of a file."""
    file.stream.seek(0)
    return file.stream.read()
