"""Repairs of text files that somebody asked for: bytes to bytes, before they are read. Nothing is repaired unasked.

`split-numbers`: a number whose minus touches the one before it (`0.0-7.5094748`) begins a number of its own.
`whole-frames`: of a motion that ends early the frames are kept that are whole. A last number without anything behind it
may lack digits, so its frame is none.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from dataclasses import replace

from service.errors import LimitError
from service.formats.format import SourceFile

MOST_BYTES = 256 << 20
"""Of a file that is repaired: it is looked at as a whole."""

_TOUCHING = re.compile(rb"(?<=[0-9.])-(?=[0-9.])")
_BVH_MOTION = re.compile(rb"^[ \t]*Frame[ \t]+Time[ \t]*:[^\n]*\n", re.IGNORECASE | re.MULTILINE)
_BVH_FRAMES = re.compile(rb"^([ \t]*Frames[ \t]*:[ \t]*)(\d+)", re.IGNORECASE | re.MULTILINE)
_BVH_CHANNELS = re.compile(rb"^[ \t]*CHANNELS[ \t]+(\d+)", re.IGNORECASE | re.MULTILINE)
_AMC_FRAME = re.compile(rb"^[ \t]*\d+[ \t\r]*$", re.MULTILINE)
_AMC_BONE = re.compile(rb"^([ \t]*[^\s#:]+)([ \t][^\n]*)$", re.MULTILINE)
_TOKEN = re.compile(rb"\S+")


def split_numbers(part: str, content: bytes) -> tuple[bytes, str]:
    """The file with numbers that touch apart, and what was done; no words where nothing was. part: of its format."""
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
    """The file with its whole frames alone, and what was done; no words where nothing was."""
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
    kept = body[: ends[frames * columns - 1]] + b"\n" if frames > 0 else b""
    head = content[: stated.start(2)] + b"%d" % max(frames, 0) + content[stated.end(2) : motion.end()]
    return head + kept, f"the motion ends early: {max(frames, 0)} of {int(stated[2])} frames are whole"


def _whole_amc(content: bytes) -> tuple[bytes, str]:
    starts = [found.start() for found in _AMC_FRAME.finditer(content)]
    if len(starts) < 2:
        return content, ""
    first = [len(line.split()) for line in content[starts[0] : starts[1]].splitlines() if line.strip()]
    last = [len(line.split()) for line in content[starts[-1] :].splitlines() if line.strip()]
    if last == first and content[-1:].isspace():
        return content, ""
    return content[: starts[-1]], f"the motion ends early: {len(starts) - 1} frames are whole"


REPAIRS: Mapping[str, Callable[[str, bytes], tuple[bytes, str]]] = {
    "split-numbers": split_numbers,
    "whole-frames": whole_frames,
}
"""By name, in the order in which they are made: what takes the part of a format and a file."""


def repaired(files: Mapping[str, SourceFile], names: tuple[str, ...]) -> tuple[dict[str, SourceFile], list[str]]:
    """Files, by part, with repairs made, and what was done. LimitError for files that are too large for that."""
    found, told = dict(files), []
    for part, file in files.items():
        content = _content(file)
        for name, repair in REPAIRS.items():
            if name in names:
                content, words = repair(part, content)
                told += [words] if words else []
        found[part] = replace(file, stream=io.BytesIO(content))
    return found, told


def offers(files: Mapping[str, SourceFile]) -> list[str]:
    """Which repairs would do something to the files, each behind those before it."""
    if any(file.stream.seek(0, io.SEEK_END) > MOST_BYTES for file in files.values()):
        return []
    found, told = files, []
    for name in REPAIRS:
        found, words = repaired(found, (name,))
        told += [name] if words else []
    return told


def _content(file: SourceFile) -> bytes:
    if file.stream.seek(0, io.SEEK_END) > MOST_BYTES:
        raise LimitError(f"The file has more than {MOST_BYTES >> 20} MiB.", remedy="Repair it before it is imported.")
    file.stream.seek(0)
    content = file.stream.read()
    file.stream.seek(0)
    return content
