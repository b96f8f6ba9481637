"""The record of a synced folder: which files are which documents, at which revision."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mcml.errors import ConflictError, DocumentError
from mcml.files.on_disk import write_file

STATE = ".mcml-sync.json"
"""The name of the record in its folder."""
_VERSION = 1


@dataclass
class Coming:
    """A download that is about to get its names: the files by SHA-256, and their revision."""

    revision: int
    files: dict[str, str]


@dataclass
class Binding:
    """A document and files of the folder that hold its frames.

    revision: the one with the frames of the files. files: SHA-256 by path in the folder, with slashes. take: the motion
    of a file that holds several. A document has several bindings where copies of it are in the folder. is_copy: whether
    changed files become a document of their own, as other files are the document's.
    """

    document: str
    revision: int
    files: dict[str, str]
    take: str | None = None
    is_copy: bool = False
    coming: Coming | None = None


class Bindings:
    """All bindings of a folder. Changes are on the disk after `save`."""

    def __init__(self, path: Path, repository: str, project: str) -> None:
        self._path = path
        self._repository = repository
        self._project = project
        self._all: list[Binding] = []
        self._by_path: dict[str, list[Binding]] = {}
        self._by_document: dict[str, list[Binding]] = {}

    @classmethod
    def read(cls, folder: Path, repository: str, project: str) -> Bindings:
        """Read the record of a folder; a new one is empty.

        repository: the address of the server or the store. Raises ConflictError for a folder of another repository or
        project, DocumentError for a damaged record.
        """
        record = cls(folder / STATE, repository, project)
        if record._path.exists():
            try:
                record._take(json.loads(record._path.read_text("utf-8")))
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                raise DocumentError(f"{record._path} is damaged.", remedy=_ANEW) from error
        return record

    def _take(self, stored: dict[str, Any]) -> None:
        if stored["version"] != _VERSION:
            raise ValueError(stored["version"])
        for name, asked, known in (
            ("the repository", self._repository, stored["repository"]),
            ("the project", self._project, stored["project"]),
        ):
            if asked != known:
                raise ConflictError(
                    f"{self._path.parent} is synced with {name} {known}, not {asked}.", remedy=f"Name that one. {_ANEW}"
                )
        for row in stored["bindings"]:
            coming = row["coming"] and Coming(int(row["coming"]["revision"]), dict(row["coming"]["files"]))
            files = dict(row["files"])
            made = Binding(str(row["document"]), int(row["revision"]), files, row["take"], bool(row["is_copy"]), coming)
            self.add(made)

    def save(self) -> None:
        """Write the record, whole or not at all."""
        rows = [asdict(binding) for binding in self._all]
        facts = {"version": _VERSION, "repository": self._repository, "project": self._project, "bindings": rows}
        write_file(self._path, [json.dumps(facts, indent=1).encode()], force=True)

    def of_path(self, path: str) -> list[Binding]:
        """Bindings that have this file."""
        return list(self._by_path.get(path, ()))

    def of_document(self, uuid: str) -> list[Binding]:
        return list(self._by_document.get(uuid, ()))

    def all(self) -> list[Binding]:
        return list(self._all)

    def add(self, binding: Binding) -> None:
        self._all.append(binding)
        self._by_document.setdefault(binding.document, []).append(binding)
        self._index(binding, binding.files)

    def remove(self, binding: Binding) -> None:
        self._all.remove(binding)
        self._by_document[binding.document].remove(binding)
        for path in binding.files:
            self._by_path[path].remove(binding)

    def update(self, binding: Binding, revision: int, files: dict[str, str]) -> None:
        """Let a binding be of another revision, with these sums of its files."""
        for path in binding.files:
            self._by_path[path].remove(binding)
        self._index(binding, files)
        binding.revision, binding.files = revision, files

    def finish_downloads(self, sums: dict[str, str]) -> None:
        """Complete the bindings of a run that was stopped while a download got its names. sums: of the folder now."""
        for binding in [each for each in self._all if each.coming is not None]:
            coming, binding.coming = binding.coming, None
            if coming is not None and all(sums.get(path) == digest for path, digest in coming.files.items()):
                self.update(binding, coming.revision, coming.files)
            elif not binding.files:
                self.remove(binding)

    def _index(self, binding: Binding, paths: Iterable[str]) -> None:
        for path in paths:
            self._by_path.setdefault(path, []).append(binding)


_ANEW = f"Or delete {STATE}, to start over: clips with equal files are recognised."
