"""From files as they arrive to complete clips: zips opened, formats recognised, AMC files given their ASF."""

from __future__ import annotations

import codecs
import posixpath
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import TypeAlias

from mcml.errors import FormatError, McmlError, NotFoundError, Place
from mcml.files.clip_files import Clip, Gathered
from mcml.files.companions import Companions
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.unpack import unpacked
from mcml.formats import READERS, find_format
from mcml.formats.format import SourceFile, TakesReader
from mcml.formats.other_formats import refuse_other_xml, root_of
from mcml.formats.text.lines import utf16_codec

SNIFF_BYTES = 4096


def several_motions(found: Gathered) -> FormatError:
    """The error for files that hold no motion, or several, where one is wanted."""
    takes = [clip.take for clip in found.clips if clip.take is not None]
    remedy = f"Say which, with `take`: {', '.join(takes[:60])}." if takes else "Give one motion at a time."
    return FormatError(f"The files hold {len(found.clips)} motions, not one.", remedy=remedy)


SkeletonLookup: TypeAlias = Callable[[], SourceFile | None]


@contextmanager
def gathered(
    files: list[SourceFile],
    limits: FileLimits,
    lookup: SkeletonLookup | None = None,
    options: ImportOptions | None = None,
) -> Iterator[Gathered]:
    """Clips among the files, one for each motion of a file that holds several.

    lookup: finds the stored skeleton for motion without one. options: `take` and `rate` of them are heeded.
    """
    options = options or ImportOptions()
    result = Gathered()
    with ExitStack() as stack:
        parts: dict[str, dict[str, list[SourceFile]]] = {}
        companions = Companions()
        for file in unpacked(files, limits, stack, result.problems):
            if companions.take(file):
                continue
            try:
                format_name, part = recognise(file)
            except McmlError as error:
                result.problems.append((file.name, error.in_file(file.name)))
                continue
            if format_name == "mcml" or len(READERS[format_name].parts) == 1:
                result.clips.append(Clip(format_name, {part: file}))
            else:
                parts.setdefault(format_name, {}).setdefault(part, []).append(file)
        for format_name, by_part in parts.items():
            _pair(format_name, by_part, result, lookup)
        companions.attach(result)
        result.clips = [each for clip in result.clips for each in _split_takes(clip, limits, options, result)]
        yield result


def _split_takes(clip: Clip, limits: FileLimits, options: ImportOptions, result: Gathered) -> Iterator[Clip]:
    """The clip once for each of its takes, or for the one that is asked for."""
    reader = READERS.get(clip.format)
    if not isinstance(reader, TakesReader):
        yield clip
        return
    try:
        takes = reader.takes(clip.files, options.for_reader(limits))
    except McmlError as error:
        result.problems.append((clip.name, error.in_file(clip.name)))
        return
    if options.take is None and len(takes) == 1:
        yield clip
    elif options.take is None or options.take in takes:
        yield from (replace(clip, take=take) for take in takes if options.take in (None, take))
    else:
        missing = NotFoundError(
            f"the file has no take {options.take!r}",
            at=Place(file=clip.name),
            remedy=f"It has: {', '.join(takes[:60])}.",
        )
        result.problems.append((clip.name, missing))


def recognise(file: SourceFile) -> tuple[str, str]:
    """(format, part) of a file by its first bytes and its name; ("mcml", "mcml") for MCML. FormatError."""
    file.stream.seek(0)
    head = file.stream.read(SNIFF_BYTES)
    file.stream.seek(0)
    text = _xml(head)
    if text is not None:
        xml = next((name for name, reader in READERS.items() if reader.sniff(file.name, text)), None)
        if xml is not None and root_of(text) == xml.encode():
            return xml, READERS[xml].parts[0].name
        refuse_other_xml(file.name, text)
        return "mcml", "mcml"
    format_, part = find_format(file.name, head)
    return format_.name, part


def _xml(head: bytes) -> bytes | None:
    """The beginning of XML in UTF-8, None for anything else.

    MCML is the language, recognised before the formats: no capture format begins with an angle bracket.
    """
    if head.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        return b""
    codec = utf16_codec(head)
    text = head.decode(codec, errors="replace").encode() if codec else head
    text = text.removeprefix(codecs.BOM_UTF8).lstrip()
    return text if text.startswith(b"<") else None


def _pair(
    format_name: str, by_part: dict[str, list[SourceFile]], result: Gathered, lookup: SkeletonLookup | None
) -> None:
    skeleton_part, motion_part = (part.name for part in READERS[format_name].parts)
    skeletons = by_part.get(skeleton_part, [])
    used: set[int] = set()
    stored: SourceFile | None = None
    for motion in by_part.get(motion_part, []):
        try:
            found = _skeleton_for(motion, skeletons)
        except FormatError as ambiguous:
            result.problems.append((motion.name, ambiguous))
            continue
        if found is None and lookup is not None:
            stored = stored or lookup()
            found = stored
        if found is None:
            result.problems.append((motion.name, _without_skeleton(format_name, motion, skeletons, result)))
            continue
        used.add(id(found))
        result.clips.append(Clip(format_name, {skeleton_part: found, motion_part: motion}))
    for skeleton in skeletons:
        if id(skeleton) not in used:
            result.clips.append(Clip(format_name, {skeleton_part: skeleton}))


def _without_skeleton(
    format_name: str, motion: SourceFile, skeletons: list[SourceFile], result: Gathered
) -> FormatError:
    """The error for a motion whose skeleton is not there, cannot be read, or cannot be told among several."""
    skeleton_part, motion_part = READERS[format_name].parts
    refused = [name for name, _ in result.problems if name.lower().endswith(skeleton_part.extensions)]
    names = ", ".join(sorted(file.name for file in skeletons)) or "none"
    word = f".{skeleton_part.name}"
    if skeletons:
        remedy = f"Give the {word} the name of its motion, put the two into one folder, or send them alone."
    elif refused:
        names, remedy = f"{', '.join(refused)}, which cannot be read", f"Mend the {word}; its own problem says how."
    else:
        remedy = f"Send the {word} in the same request, or name a stored document with `skeleton`."
    return FormatError(
        f"{motion_part.name.upper()} needs its {skeleton_part.name.upper()} skeleton; sent with it: {names}.",
        at=Place(file=motion.name),
        remedy=remedy,
    )


_NAMED_SKELETON = re.compile(rb"^\s*#!\s*OML\s*:\s*ASF\s+([^\r\n]+)", re.IGNORECASE)


def _skeleton_for(motion: SourceFile, skeletons: list[SourceFile]) -> SourceFile | None:
    """Return the skeleton of a motion by its name; for several with that name, or without matching names, the one in
    its folder. Raises FormatError if several with one name remain.
    """
    by_name: dict[str, list[SourceFile]] = {}
    for file in skeletons:
        by_name.setdefault(posixpath.basename(file.name).lower(), []).append(file)
    name = _skeleton_name(motion, list(by_name))
    meant = skeletons if name is None else by_name[name]
    near = [file for file in meant if posixpath.dirname(file.name) == posixpath.dirname(motion.name)]
    if len(near) == 1 or len(meant) == 1:
        return near[0] if near else meant[0]
    if name is None:
        return None
    raise FormatError(
        f"{len(meant)} skeletons are called {posixpath.basename(meant[0].name)}, and none of them alone stands in the "
        "motion's folder.",
        at=Place(file=motion.name),
        remedy="Put each motion into one folder with its skeleton, or send them apart.",
    )


def _skeleton_name(motion: SourceFile, names: list[str]) -> str | None:
    """Which of the skeletons' names the motion states, else that of its stem, a prefix of it, or its first word."""
    by_stem = {name.rsplit(".", 1)[0]: name for name in names}
    motion.stream.seek(0)
    named = _NAMED_SKELETON.match(motion.stream.read(SNIFF_BYTES))
    motion.stream.seek(0)
    if named:
        wanted = re.split(r"[\\/]", named[1].decode("latin-1").strip())[-1].lower()
        if wanted in names:
            return wanted
    stem = posixpath.basename(motion.name).lower().rsplit(".", 1)[0]
    if stem in by_stem:
        return by_stem[stem]
    prefixes = [other for other in by_stem if _begins(stem, other)]
    if prefixes:
        return by_stem[max(prefixes, key=len)]
    # CMU copies are named 07-walk.asf and 07_05-walk.amc: the subject is the first word.
    subject = _WORDS.findall(stem)[:1]
    same = [name for other, name in by_stem.items() if subject and _WORDS.findall(other)[:1] == subject]
    return same[0] if len(same) == 1 else None


_WORDS = re.compile(r"[^\W_]+")


def _begins(stem: str, prefix: str) -> bool:
    """Whether a stem is a prefix and more, cut between words or between a word and a number."""
    rest = stem.removeprefix(prefix)
    if rest == stem or not rest or not prefix:
        return False
    return not rest[0].isalnum() or rest[0].isdigit() != prefix[-1].isdigit()
