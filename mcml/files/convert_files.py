"""Files of one format to files of another, without a store."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePath

from mcml.errors import Notice, UnsupportedError
from mcml.files.check_names import check_frame_time
from mcml.files.gather_files import gathered, several_motions
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.open_clip import open_clip
from mcml.files.presets import choose_format, choose_shape, find_preset, fit_shape
from mcml.files.reshape_clip import Reshaping, fit_height, need_stated_facts, parse_range, reshape
from mcml.files.targets import check_character, convert_clip, part_without_frames, targets
from mcml.files.wear_character import check_own, wear_file
from mcml.formats import WRITERS
from mcml.formats.analog_files import analog_part, channels_reader
from mcml.formats.format import SourceFile
from mcml.language.elements import from_head, refresh_counts, to_head
from mcml.language.writer import write_document
from mcml.motion.clip import ClipStream, Original


@dataclass
class Converted:
    """files: extension -> content, in the order of the format's parts. notices: complete once all was read."""

    files: dict[str, Iterator[bytes]]
    notices: Callable[[], list[Notice]]


@contextmanager
def convert_files(
    files: list[SourceFile],
    target: str | None,
    limits: FileLimits,
    *,
    frame_time: str | float | None = None,
    encoding: str | None = None,
    names: str | None = None,
    unit: str | None = None,
    up: str | None = None,
    take: str | None = None,
    rate: float | None = None,
    frames: str | None = None,
    fps: float | None = None,
    scale: float | None = None,
    height: float | None = None,
    in_place: bool = False,
    guesses: bool = True,
    character: str | SourceFile | None = None,
    for_: str | None = None,
    stem: str = "motion",
) -> Iterator[Converted]:
    """Convert the only clip among the files to another format. Raises the errors of readers and writers.

    target: the format, None for that of the preset. for_: a preset of `PRESETS`; target, fps and scale win over it.
    frame_time, unit, up: facts that the files do not state; nothing is scaled or turned. take: which motion of a
    file that holds several. rate: frames a second at which its keys are sampled. frames: FIRST-LAST, from 1. fps:
    frames a second of the result. scale: factor of all lengths. height: metres that the body stands tall in the result.
    in_place: without travel over the ground. guesses: False refuses where a format needs a unit or
    an up axis that the files do not state. character: a body with a skin instead of bones, in glTF and USD: "own" for
    this project's figure, or a file with a skinned mesh, on whose rig the clip is retargeted.
    """
    known, preset = targets(), None if for_ is None else find_preset(for_)
    if target is None and preset is None:
        raise UnsupportedError("No format is stated.", remedy="Say `to`, or `for` with the program that reads it.")
    if target is not None and (target not in known or target == "csv"):
        raise UnsupportedError(
            f"Unknown format {target!r}.", remedy=f"Use one of: {', '.join(sorted(set(known) - {'csv'}))}."
        )
    frame_time = None if frame_time is None else check_frame_time(frame_time)
    options = ImportOptions(encoding=encoding, frame_time=frame_time, unit=unit, up=up, take=take, rate=rate)
    with gathered(files, limits, options=options) as found:
        for _, error in found.problems:
            raise error
        if len(found.clips) != 1:
            raise several_motions(found)
        opened = open_clip(found.clips[0], options, limits)
        stream = opened.stream
        head = to_head(opened.document, frame_time or stream.head.frame_time)
        # Analog channels and force plates are in the file, not in documents.
        source = found.clips[0].files.get(analog_part(head) or "")
        original = None if source is None else Original(channels_reader(head, source.stream))
        clip = ClipStream(head, stream.blocks, stream.frames, stream.notices, original)
        first, last = parse_range(frames)
        target = choose_format(preset, target, character=character is not None)
        clip = reshape(clip, Reshaping(first, last))
        if isinstance(character, SourceFile):
            clip = wear_file(clip, character, limits)
        elif character is not None:
            check_own(character)
            clip = replace(clip, character=True)
        shape = None if preset is None else choose_shape(preset, clip.head.skeleton, target)
        fps = fps or (shape.fps if shape else None)
        clip = reshape(clip, Reshaping(1, None, in_place, fps, scale, height))
        if preset is not None and shape is not None:
            target, clip = shape.format, fit_shape(clip, shape, preset, guesses=guesses)
        clip = fit_height(clip, height, guesses=guesses)
        assert target is not None
        name, part = known[target]
        if character is not None:
            check_character(name)
        part = part_without_frames(name) if clip.frames == 0 and part is None else part
        if name == "mcml":
            yield Converted({".mcml": _mcml(clip)}, lambda: clip.notices)
            return
        if not guesses:
            need_stated_facts(clip.head, name)
        result = convert_clip(clip, name, names)
        parts = [item for item in WRITERS[name].parts if part is None or item.name == part]
        content = {item.extensions[0]: WRITERS[name].write(result, item.name) for item in parts}
        yield Converted(content, lambda: result.notices)


def format_of(file_name: str) -> str:
    """Return the format of a file by its name. Raises UnsupportedError if the name does not decide it."""
    extension = PurePath(file_name).suffix.lower()
    if extension in (".mcml", ".xml"):
        return "mcml"
    if extension == ".csv":
        return "csv"
    for name, format_ in WRITERS.items():
        if any(extension in part.extensions for part in format_.parts):
            return name
    raise UnsupportedError(
        f"{file_name!r} does not say which format to write.",
        remedy=f"Say the format (--to, in Python to=): one of: {', '.join(sorted(targets()))}.",
    )


def stated_format(result: Path, to: str | None, for_: str | None) -> str | None:
    """Return the format of a file to write: `to`, else by its name; None if the preset decides it.

    Raises UnsupportedError if nothing decides it, or for a name with the ending of another format.
    """
    if for_ is not None and to is None and not result.suffix:
        return None
    form = to or format_of(result.name)
    if result.suffix:
        files_to_write(result, form)
    return form


def result_paths(result: Path, done: Converted, form: str | None) -> list[tuple[Path, Iterator[bytes]]]:
    """Return the files to write, each with its content. form: of `stated_format`."""
    keeps_name = len(done.files) == 1 and form is not None
    return [
        (result if keeps_name else result.with_suffix(extension), content) for extension, content in done.files.items()
    ]


def files_to_write(path: Path, target: str) -> list[tuple[Path, str]]:
    """Return the files of an export to a path, each with its target: ASF and AMC if the name has one of these endings.

    target: as `targets` names it. Raises UnsupportedError for a name with the ending of another format.
    """
    extension = path.suffix.lower()
    name, part = targets().get(target, (target, None))
    parts = [item for item in WRITERS[name].parts if part in (None, item.name)] if name in WRITERS else []
    own = [ending for item in parts for ending in item.extensions] or [f".{target}"]
    if len(parts) > 1 and extension in own:
        return [(path.with_suffix(item.extensions[0]), item.name) for item in parts]
    if len(parts) > 1:
        own.append(".zip")
    elif not extension or extension not in _endings():
        return [(path, target)]
    if extension not in (*own, ".xml" if target == "mcml" else own[0]):
        endings = ", ".join(own)
        raise UnsupportedError(
            f"{path.name!r} is no name for {target}.", remedy=f"Give it the ending {endings}, or say another format."
        )
    return [(path, target)]


def _endings() -> set[str]:
    """All endings of files that are written."""
    return {".mcml", ".xml", ".csv", ".zip"} | {
        ending for writer in WRITERS.values() for part in writer.parts for ending in part.extensions
    }


def _mcml(clip: ClipStream) -> Iterator[bytes]:
    """MCML states the number of frames before them, so a stream that does not know it is read twice."""
    frames = clip.frames if clip.frames is not None else sum(len(block) for block in clip.blocks())
    document = refresh_counts(from_head(replace(clip.head)), frames)
    names = clip.head.skeleton.names
    yield from write_document(document, frames, clip.head.frame_time, clip.blocks(), names)
