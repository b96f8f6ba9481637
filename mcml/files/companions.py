"""Files that stand beside a motion: the buffers of a glTF, the forces and external loads of a TRC."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping, Sequence
from typing import Final

from mcml.errors import FormatError, Place
from mcml.files.clip_files import Clip, Gathered
from mcml.formats.format import SourceFile
from mcml.formats.gltf.document import BUFFER, find_uris
from mcml.formats.trc.force_table import ENDINGS, HEAD_BYTES, has_forces
from mcml.formats.trc.forces import PART

BESIDE: Final[Mapping[str, tuple[str, ...]]] = {"glb": (BUFFER,), "trc": ENDINGS}
"""Endings of files that may stand beside those of a format."""

STATES_BESIDE: Final[Mapping[str, tuple[str, ...]]] = {"trc": ("force_plates",)}
"""Facts of a document that such files hold; see `mcml.formats.format.Reader`."""

COMPANION_ENDINGS: Final = tuple(ending for endings in BESIDE.values() for ending in endings)

_XML: Final = ".xml"
OF_TRIALS: Final = (*ENDINGS, _XML)
"""Endings of files that may stand beside a TRC."""

LOADS: Final = "loads"
"""The part of a TRC clip that says which columns of its forces load which body. It is kept, not read."""

_LOADS: Final = re.compile(rb"(?s)\s*(?:<\?xml.*?\?>\s*)?<OpenSimDocument\b[^>]*>\s*<ExternalLoads\b")
_KINDS: Final = re.compile(
    r"grfs?|forces?|kinetics|mot|trc|markers?|motion|capture|mocap|ground|reactions?|ext|external|loads?|trajector(?:y|ies)"
)
"""Words that tell files of one trial apart."""


def part_beside(name: str, first_bytes: bytes) -> str | None:
    """The part of a TRC clip that a file of this name and these first HEAD_BYTES is; None for another file."""
    if name.lower().endswith(ENDINGS):
        return PART if has_forces(first_bytes) else None
    return LOADS if name.lower().endswith(_XML) and _LOADS.match(first_bytes) else None


class Companions:
    """Files that belong to others. buffers: of glTF. tables, loads: of TRC, forces and external loads."""

    def __init__(self) -> None:
        self._buffers: list[SourceFile] = []
        self._tables: list[SourceFile] = []
        self._loads: list[SourceFile] = []

    def take(self, file: SourceFile) -> bool:
        """Whether a file belongs to another; it is kept then."""
        if file.name.lower().endswith(BUFFER):
            self._buffers.append(file)
            return True
        part = part_beside(file.name, _head(file)) if file.name.lower().endswith(OF_TRIALS) else None
        if part is not None:
            (self._tables if part == PART else self._loads).append(file)
        return part is not None

    def attach(self, result: Gathered) -> None:
        """Give the files to their clips; those without one are problems."""
        _attach_buffers(self._buffers, result)
        trials = [clip for clip in result.clips if clip.format == "trc"]
        for part, files in ((PART, self._tables), (LOADS, self._loads)):
            for file in files:
                self._attach(part, file, files, trials, result)

    def _attach(
        self, part: str, file: SourceFile, files: Sequence[SourceFile], trials: Sequence[Clip], result: Gathered
    ) -> None:
        own = _of_trial(file, files, trials)
        if len(own) == 1 and part not in own[0].files:
            # The file with the motion comes last.
            own[0].files = {part: file} | own[0].files
            return
        what = "forces of the ground" if part == PART else "external loads of OpenSim"
        if not trials:
            told, remedy = "no TRC was sent with it", "Send it together with the .trc of its trial."
        elif len(own) == 1:
            told, remedy = f"{own[0].files[part].name} already belongs to {own[0].file_name}", "Send one of them."
        else:
            told = f"none of the {len(trials)} TRC alone has its name"
            remedy = "Name it like its TRC, such as walk_grf.mot beside walk.trc."
        error = FormatError(f"the file holds {what}, and {told}", at=Place(file=file.name), remedy=remedy)
        result.problems.append((file.name, error))


def _head(file: SourceFile) -> bytes:
    file.stream.seek(0)
    head = file.stream.read(HEAD_BYTES)
    file.stream.seek(0)
    return head


def _of_trial(file: SourceFile, files: Sequence[SourceFile], trials: Sequence[Clip]) -> list[Clip]:
    """The trials with the name of a file, near ones first; else the only trial in its folder, or at all."""
    named = [trial for trial in trials if trial_name(trial.name) == trial_name(file.name)]
    for chosen, others in ((named, ()), (trials, files)):
        folder = posixpath.dirname(file.name)
        near = [trial for trial in chosen if posixpath.dirname(trial.name) == folder]
        beside = [other for other in others if posixpath.dirname(other.name) == folder]
        if len(near) == 1 and len(beside) <= 1:
            return near
        if len(chosen) == 1 and len(others) <= 1:
            return list(chosen)
    return []


def trial_name(name: str) -> tuple[str, ...]:
    """Words of a file's name without folder, ending and the words for its kind."""
    stem = posixpath.basename(name).lower().rsplit(".", 1)[0]
    return tuple(word for word in re.findall(r"[^\W_]+", stem) if not _KINDS.fullmatch(word))


def _attach_buffers(buffers: Sequence[SourceFile], result: Gathered) -> None:
    """Give the buffers of glTF files to those that name them; the others are problems."""
    used: set[int] = set()
    for clip in result.clips:
        if clip.format != "glb" or not buffers:
            continue
        file = clip.files["glb"]
        wanted = {posixpath.basename(path) for path in find_uris(file.stream)}
        near = [each for each in buffers if posixpath.basename(each.name) in wanted]
        near.sort(key=lambda each: posixpath.dirname(each.name) != posixpath.dirname(file.name))
        chosen = {posixpath.basename(each.name): each for each in reversed(near)}
        used |= {id(each) for each in chosen.values()}
        # The file with the motion comes last.
        clip.files = {f"buffer{number}": each for number, each in enumerate(chosen.values(), 1)} | clip.files
    for each in buffers:
        if id(each) not in used:
            error = FormatError(
                "the file holds numbers that no glTF file sent with it names",
                at=Place(file=each.name),
                remedy="Send it together with its .gltf.",
            )
            result.problems.append((each.name, error))
