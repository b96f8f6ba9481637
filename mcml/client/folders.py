"""Files and folders sent to a repository, many in a call."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any, TypeAlias

from mcml.answers import UploadError
from mcml.client.client import Client
from mcml.errors import UnsupportedError
from mcml.files.companions import OF_TRIALS, part_beside, trial_name
from mcml.files.on_disk import name_of, opened_files
from mcml.formats import READERS
from mcml.formats.gltf.document import BUFFER, find_uris
from mcml.formats.trc.force_table import HEAD_BYTES
from mcml_schemas.documents import UploadResult

ARCHIVES = {".zip", ".7z", ".gz", ".tgz", ".tar"}
EXTENSIONS = {".mcml", ".xml", *ARCHIVES}.union(
    extension for format_ in READERS.values() for part in format_.parts for extension in part.extensions
)
"""Of files that are looked for in folders."""

PAIRED = (".asf", ".amc")

MOST_FILES, MOST_BYTES = 512, 128 << 20
"""Limit for one call: its files are open together, and its results arrive when all are stored."""

Told: TypeAlias = Callable[[int, int, str], None]
"""How far an import is: files done, of how many, the name of the one that is read."""


def import_paths(
    client: Client, paths: list[Path], options: dict[str, Any], told: Told | None = None
) -> Iterator[UploadResult]:
    """Upload files, folders with all their files, and zips; return a result for each call.

    options: of the operation upload_documents; by default, existing files are skipped. Raises UnsupportedError for a
    path that does not exist, or without readable files.
    """
    # A name is for the one document of a call.
    groups = list(groups_of(paths, MOST_FILES if options.get("name") is None else 1))
    if not groups:
        known = " ".join(sorted(EXTENSIONS))
        raise UnsupportedError("There is nothing here that can be read.", remedy=f"Files end in {known}.")
    files = sum(map(len, groups))
    done = 0
    for group in groups:
        teller = _Teller(told, done, files)
        teller(name_of(group[0]))
        yield _upload(client, group, {"on_duplicate": "skip", **options}, teller)
        done += len(group)
    if told is not None:
        told(done, files, "")


class _Teller:
    """Turns the progress of one call into the progress of all calls."""

    def __init__(self, told: Told | None, done: int, of: int) -> None:
        self._told, self._done, self._of = told, done, of
        self._names: set[str] = set()

    def __call__(self, name: str, _frames: int = 0, _most: int | None = None) -> None:
        self._names.add(name)
        if self._told is not None:
            self._told(self._done + len(self._names) - 1, self._of, name)


def _upload(client: Client, paths: list[Path], options: dict[str, Any], progress: Callable[..., None]) -> UploadResult:
    """Upload files in one call and return the result."""
    with opened_files(paths) as files:
        try:
            result: UploadResult = client.call("upload_documents", file=files, progress=progress, **options)
        except UploadError as error:
            return UploadResult(documents=[], problems=error.problems)
        return result


def groups_of(paths: list[Path], most: int) -> Iterator[list[Path]]:
    """Group files by calls: ASF with the AMC files of its folder, glTF with its buffers, TRC with its forces, a zip
    alone, at most `most` others together.
    """
    others: list[Path] = []
    for path in paths:
        if not path.exists():
            raise UnsupportedError(f"{path} does not exist.")
        if not path.is_dir():
            others += [] if path.suffix.lower() in PAIRED else [path]
            continue
        paired: dict[Path, list[Path]] = {}
        found = sorted(entry for entry in path.rglob("*") if entry.suffix.lower() in {*EXTENSIONS, *OF_TRIALS})
        of_trials = find_of_trials(found)
        taken: set[Path] = set()
        for file in found:
            beside = find_buffers(file) or find_of_trial(file, of_trials)
            taken.update(beside)
            if file.suffix.lower() in PAIRED:
                paired.setdefault(file.parent, []).append(file)
            elif beside:
                yield [*beside, file]
            elif file.suffix.lower() in EXTENSIONS and file not in of_trials:
                others.append(file)
        others += [file for file in of_trials if file not in taken]
        yield from paired.values()
    yield from _split(others, most)
    loose = [path for path in paths if path.is_file() and path.suffix.lower() in PAIRED]
    if loose:
        yield loose


def find_buffers(file: Path) -> list[Path]:
    """Return the files that hold the numbers of a .gltf, in its folder and below; none for other files."""
    if file.suffix.lower() != ".gltf" or not file.is_file():
        return []
    with file.open("rb") as stream:
        paths = [PurePosixPath(path) for path in sorted(find_uris(stream)) if path.lower().endswith(BUFFER)]
    # A file from elsewhere must not name other files of this machine.
    inside = [path for path in paths if not path.is_absolute() and ".." not in path.parts]
    return [file.parent / path for path in inside if (file.parent / path).is_file()]


def find_of_trials(files: Iterable[Path]) -> dict[Path, str]:
    """Return the tables of forces and the external loads among files, each with its part of a TRC clip."""
    parts: dict[Path, str] = {}
    for file in files:
        if file.suffix.lower() in OF_TRIALS and file.is_file():
            with file.open("rb") as stream:
                part = part_beside(file.name, stream.read(HEAD_BYTES))
            if part is not None:
                parts[file] = part
    return parts


def find_of_trial(file: Path, beside: Mapping[Path, str]) -> list[Path]:
    """Return the files that have the name of a TRC, one of each part, near ones first; none for other files."""
    named = [other for other in beside if trial_name(other.name) == trial_name(file.name)]
    chosen: list[Path] = []
    for part in dict.fromkeys(beside.values()) if file.suffix.lower() == ".trc" else ():
        own = [other for other in named if beside[other] == part]
        near = [other for other in own if other.parent == file.parent]
        chosen += near if len(near) == 1 else own[: len(own) == 1]
    return chosen


def _split(files: list[Path], most: int) -> Iterator[list[Path]]:
    group: list[Path] = []
    size = 0
    for file in files:
        if file.suffix.lower() in ARCHIVES:
            # Its ASF and AMC files are looked for among all of a call.
            yield [file]
            continue
        size += file.stat().st_size
        if group and (len(group) == most or size > MOST_BYTES):
            yield group
            group, size = [], file.stat().st_size
        group.append(file)
    if group:
        yield group
