"""Files grouped by the documents that an import makes of them."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field

from mcml.errors import McmlError
from mcml.files.check_names import name_of_file
from mcml.formats.format import SourceFile


@dataclass
class Clip:
    """The files of one document to be.

    format: catalogue name, or "mcml". files: by part of the format. take: which motion, where the files hold several.
    """

    format: str
    files: dict[str, SourceFile]
    take: str | None = None

    @property
    def name(self) -> str:
        """The name of the file that holds the motion, with the take where there are several."""
        name = list(self.files.values())[-1].name
        return name if self.take is None else f"{name}#{self.take}"

    @property
    def file_name(self) -> str:
        """The name without folders."""
        name = posixpath.basename(list(self.files.values())[-1].name)
        return name if self.take is None else f"{name}#{self.take}"

    @property
    def document_name(self) -> str:
        """The name that a document of it gets."""
        name = name_of_file(list(self.files.values())[-1].name)
        return name if self.take is None else f"{name}#{self.take}"

    @property
    def kept_files(self) -> dict[str, SourceFile]:
        """The files by the names of parts that a store keeps them under: `fbx`, or `fbx#Walk` for a take."""
        return {part if self.take is None else f"{part}#{self.take}": file for part, file in self.files.items()}

    @classmethod
    def of_kept(cls, format_name: str, files: dict[str, SourceFile]) -> Clip:
        """The clip of files under the names that `kept_files` gives them."""
        takes = {part.partition("#")[2] for part in files}
        return cls(format_name, {part.partition("#")[0]: file for part, file in files.items()}, takes.pop() or None)


@dataclass
class Gathered:
    """problems: (file name, error) of files that belong to no clip."""

    clips: list[Clip] = field(default_factory=list)
    problems: list[tuple[str, McmlError]] = field(default_factory=list)
