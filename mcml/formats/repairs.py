"""Repairs of text files on request: bytes to bytes, before they are read. Nothing is repaired automatically.

`split-numbers`: a number whose minus touches the one before it (`0.0-7.5094748`) begins a new number. `decimal-commas`:
`0,5` becomes `0.5`. `missing-samples`: `nan` and similar words in a BVH are missing samples. `stated-dof`, `three-dof`:
see `asf_amc.repairs`. `whole-frames`: of a motion that ends early only complete frames are kept. A last number at the
end of the file may lack digits, so its frame is not complete.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

from mcml.errors import LimitError
from mcml.formats.asf_amc.repairs import stated_dof, three_dof
from mcml.formats.bvh.motion import MISSING
from mcml.formats.format import SourceFile

MOST_BYTES = 256 << 20
"""Of a file that is repaired: it is looked at as a whole."""

_TOUCHING = re.compile(rb"(?<=[0-9.])-(?=[0-9.])")
_BVH_MOTION = re.compile(rb"^[ \t]*Frame[ \t]+Time[ \t]*:[^\n]*\n", re.IGNORECASE | re.MULTILINE)
_BVH_FRAMES = re.compile(rb"^([ \t]*Frames[ \t]*:[ \t]*)(\d+)", re.IGNORECASE | re.MULTILINE)
_BVH_CHANNELS = re.compile(rb"^[ \t]*CHANNELS[ \t]+(\d+)", re.IGNORECASE | re.MULTILINE)
_AMC_FRAME = re.compile(rb"^[ \t]*\d+[ \t\r]*$", re.MULTILINE)
_AMC_BONE = re.compile(rb"^([ \t]*[^\s#:]+)([ \t][^\n]*)$", re.MULTILINE)
_TOKEN = re.compile(rb"\S+")
_DECIMAL_COMMA = re.compile(rb"(?<!\S)([+-]?[0-9]+),([0-9]+(?:[eE][+-]?[0-9]+)?)(?!\S)")
_NO_NUMBER = re.compile(rb"(?<!\S)[+-]?(?:nan(?:\([a-z]*\))?|inf(?:inity)?|1\.#[a-z]+0*)(?!\S)", re.IGNORECASE)


def split_numbers(part: str, content: bytes) -> tuple[bytes, str]:
    """Separate joined numbers; return the file and a description, empty if nothing changed. part: of its format."""
    count = 0

    def apart(text: bytes) -> bytes:
        nonlocal count
        found, some = _TOUCHING.subn(b" -", text)
        count += some
        return found

    if part == "bvh":
        motion = _BVH_MOTION.search(content)
        start = len(content) if motion is None else motion.end()
        content = content[:start] + apart(content[start:])
    elif part == "amc":
        content = _AMC_BONE.sub(lambda line: line[1] + apart(line[2]), content)
    return content, f"{count} numbers that touched the one before them were set apart" if count else ""


def whole_frames(part: str, content: bytes) -> tuple[bytes, str]:
    """Keep only whole frames; return the file and a description, empty if nothing changed."""
    if part == "bvh":
        return _whole_bvh(content)
    return _whole_amc(content) if part == "amc" else (content, "")


def _whole_bvh(content: bytes) -> tuple[bytes, str]:
    motion, stated = _BVH_MOTION.search(content), _BVH_FRAMES.search(content)
    columns = sum(int(found[1]) for found in _BVH_CHANNELS.finditer(content))
    if motion is None or stated is None or not columns:
        return content, ""
    body = content[motion.end() :]
    ends = [token.end() for token in _TOKEN.finditer(body)]
    if len(ends) >= int(stated[2]) * columns:
        return content, ""
    frames = len(ends) // columns
    if ends and ends[-1] == len(body) and len(ends) % columns == 0:
        frames -= 1
    if frames < 1:
        return content, ""
    kept = body[: ends[frames * columns - 1]] + b"\n"
    head = content[: stated.start(2)] + b"%d" % frames + content[stated.end(2) : motion.end()]
    return head + kept, f"the motion ends early: {frames} of {int(stated[2])} frames are whole"


def _whole_amc(content: bytes) -> tuple[bytes, str]:
    starts = [found.start() for found in _AMC_FRAME.finditer(content)]
    if len(starts) < 2:
        return content, ""
    first = [len(line.split()) for line in content[starts[0] : starts[1]].splitlines() if line.strip()]
    last = [len(line.split()) for line in content[starts[-1] :].splitlines() if line.strip()]
    if last == first and content[-1:].isspace():
        return content, ""
    return content[: starts[-1]], f"the motion ends early: {len(starts) - 1} frames are whole"


def decimal_commas(part: str, content: bytes) -> tuple[bytes, str]:
    """Replace decimal commas; return the file and a description, empty if nothing changed."""
    if part not in ("bvh", "amc", "htr", "trc"):
        return content, ""
    content, count = _DECIMAL_COMMA.subn(rb"\1.\2", content)
    return content, f"{count} decimal commas became points" if count else ""


def missing_samples(part: str, content: bytes) -> tuple[bytes, str]:
    """Replace samples that are not numbers by the word for missing samples; return the file and a description."""
    motion = _BVH_MOTION.search(content) if part == "bvh" else None
    if motion is None:
        return content, ""
    body, count = _NO_NUMBER.subn(MISSING, content[motion.end() :])
    return content[: motion.end()] + body, f"{count} samples that are no number are missing" if count else ""


def _of_each(repair: Callable[[str, bytes], tuple[bytes, str]]) -> Repair:
    """A repair of each file on its own."""

    def repaired_each(files: Mapping[str, bytes]) -> tuple[dict[str, bytes], str]:
        found, told = {}, []
        for part, content in files.items():
            found[part], words = repair(part, content)
            told += [words] if words else []
        return found, "; ".join(told)

    return repaired_each


Repair: TypeAlias = Callable[[Mapping[str, bytes]], tuple[dict[str, bytes], str]]

REPAIRS: Mapping[str, Repair] = {
    "split-numbers": _of_each(split_numbers),
    "decimal-commas": _of_each(decimal_commas),
    "missing-samples": _of_each(missing_samples),
    "stated-dof": stated_dof,
    "three-dof": three_dof,
    "whole-frames": _of_each(whole_frames),
}
"""Repairs by name, in the order of their use. Each takes the contents of files, by part of a format."""

ALTERNATIVES = frozenset({"stated-dof", "three-dof"})
"""Repairs of the same fault, of which one is to be chosen."""


def repaired(files: Mapping[str, SourceFile], names: tuple[str, ...]) -> tuple[dict[str, SourceFile], list[str]]:
    """Apply repairs to files, by part; return them with descriptions. Raises LimitError for too large files."""
    contents, told = {part: _content(file) for part, file in files.items()}, []
    for name, repair in REPAIRS.items():
        if name in names:
            contents, words = repair(contents)
            told += [words] if words else []
    return {part: replace(file, stream=io.BytesIO(contents[part])) for part, file in files.items()}, told


def offers(files: Mapping[str, SourceFile]) -> list[str]:
    """Which repairs would do something to the files, each behind those before it."""
    if any(file.stream.seek(0, io.SEEK_END) > MOST_BYTES for file in files.values()):
        return []
    contents, told = {part: _content(file) for part, file in files.items()}, []
    for name, repair in REPAIRS.items():
        mended, words = repair(contents)
        told += [name] if words else []
        if name not in ALTERNATIVES:
            contents = mended
    return told


def _content(file: SourceFile) -> bytes:
    if file.stream.seek(0, io.SEEK_END) > MOST_BYTES:
        raise LimitError(f"The file has more than {MOST_BYTES >> 20} MiB.", remedy="Repair it before it is imported.")
    file.stream.seek(0)
    content = file.stream.read()
    file.stream.seek(0)
    return content
