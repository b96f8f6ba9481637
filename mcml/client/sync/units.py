"""New files of a folder, grouped by clips and by calls."""

from __future__ import annotations

import posixpath
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import TypeAlias

from mcml.client.folders import ARCHIVES, MOST_BYTES, PAIRED, find_buffers, find_of_trial, find_of_trials
from mcml.files.companions import COMPANION_ENDINGS, trial_name
from mcml.files.gather_files import gathered
from mcml.files.limits import FileLimits
from mcml.files.on_disk import opened_files

Unit: TypeAlias = tuple[str, ...]
"""Paths of the files of one clip, or of one file with several."""

MOST_UNITS = 64
"""Limit of one call: as many are sent again after an interruption."""
_MOST_OPEN = 256


def make_unit(folder: Path, path: str) -> Unit:
    """A file with the buffers that it names, if it is a glTF, or the forces beside it, if it is a TRC."""
    file = folder / path
    near = sorted(file.parent.iterdir()) if file.suffix.lower() == ".trc" else []
    named = [other for other in near if trial_name(other.name) == trial_name(path)]
    beside = find_buffers(file) or find_of_trial(file, find_of_trials(named))
    return (*(each.relative_to(folder).as_posix() for each in beside), path)


def make_units(folder: Path, new: Iterable[str], present: Collection[str], *, complete: bool) -> Iterator[Unit]:
    """Group new files: an AMC with its ASF, a glTF with its buffers, a TRC with its forces, others alone.

    present: all files, among which an AMC finds its ASF. complete: whether an ASF without AMC is a clip.
    """
    pairs: dict[str, list[str]] = {}
    for path in new:
        extension = posixpath.splitext(path)[1].lower()
        if extension in PAIRED:
            pairs.setdefault(posixpath.dirname(path), []).append(path)
        elif extension not in COMPANION_ENDINGS and not find_of_trials([folder / path]):
            yield make_unit(folder, path)
    for place, paths in pairs.items():
        skeletons = [path for path in present if posixpath.dirname(path) == place and _is_skeleton(path)]
        yield from _pair(folder, paths, skeletons, complete=complete)


def _is_skeleton(path: str) -> bool:
    return posixpath.splitext(path)[1].lower() == PAIRED[0]


def _pair(folder: Path, new: list[str], skeletons: list[str], *, complete: bool) -> Iterator[Unit]:
    motions = [path for path in new if not _is_skeleton(path)]
    used: set[str] = set()
    for start in range(0, len(motions), _MOST_OPEN):
        paths = [*skeletons, *motions[start : start + _MOST_OPEN]]
        with opened_files([folder / path for path in paths]) as files:
            by_file = {id(file.stream): path for file, path in zip(files, paths, strict=True)}
            with gathered(files, FileLimits()) as clips:
                units = [
                    tuple(by_file.get(id(file.stream), "") for file in clip.files.values()) for clip in clips.clips
                ]
        for unit in units:
            if unit[-1] in motions:
                used.update(unit)
                yield unit
    # Without a skeleton, or damaged: the repository says why.
    yield from ((path,) for path in motions if path not in used)
    if complete:
        yield from ((path,) for path in new if _is_skeleton(path) and path not in used)


def _pairing_place(unit: Unit) -> str | None:
    """The folder of ASF and AMC, which are paired within it; None for other files."""
    return posixpath.dirname(unit[-1]) if posixpath.splitext(unit[-1])[1].lower() in PAIRED else None


def make_batches(folder: Path, units: Iterable[Unit]) -> Iterator[list[Unit]]:
    """Group units by calls. Problems name files without folders, so the names in one call are unique."""
    batch: list[Unit] = []
    paths: dict[str, str] = {}
    size = 0
    for unit in units:
        length = sum((folder / path).stat().st_size for path in unit if (folder / path).exists())
        names = {posixpath.basename(path): path for path in unit}
        place = _pairing_place(unit)
        is_archive = any(posixpath.splitext(path)[1].lower() in ARCHIVES for path in unit)
        clash = any(paths.get(name, path) != path for name, path in names.items())
        clash = clash or (bool(batch) and place != _pairing_place(batch[-1]))
        if batch and (is_archive or clash or len(batch) == MOST_UNITS or size + length > MOST_BYTES):
            yield batch
            batch, paths, size = [], {}, 0
        batch.append(unit)
        paths |= names
        size += length
        if is_archive:
            yield batch
            batch, paths, size = [], {}, 0
    if batch:
        yield batch
