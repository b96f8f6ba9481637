"""Frames that look like one the parser has accepted, read without the parser.

Nearly all frames of a motion differ from the one before in their id and their numbers only. A frame whose bytes
outside of those are the same as those of an accepted frame is well-formed and valid because that one was, so only its
id and numbers are looked at. Any other frame, even with a small difference, is parsed: this skips work with a known
result, and decides nothing itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter
from typing import Any

from mcml.language.vocabulary import FRAME, NAME
from mcml.motion.clip import Shape
from mcml.motion.skeleton import CHANNELS

END = f"</{FRAME}>".encode()
_NUMBER_LETTERS = str.maketrans("", "", "0123456789+-.eE")


@dataclass(frozen=True, slots=True)
class Pattern:
    """An accepted frame.

    text: its text without the values in double quotes. quoted: number of quoted values. names: the bones' names, at the
    indices `name_places` of the quoted values; numbers are at `number_places`. shape,
    motion_names: of the frame. lines: line feeds before each frame_bone, and in the whole frame.
    """

    text: list[str]
    quoted: int
    names: Any
    name_places: Any
    number_places: Any
    shape: Shape
    motion_names: tuple[str, ...]
    lines: tuple[int, ...]
    line_feeds: int


def pattern_of(raw: bytes, shape: Shape, motion_names: tuple[str, ...]) -> Pattern | None:
    """Return the pattern of a frame from its bytes (with white space before `<frame`, without `</frame>`) and the
    parsed frame; None if the bytes are not in the plain form that patterns support.
    """
    if b"'" in raw or b"<!" in raw or b"<?" in raw or len(shape) < 2:
        return None
    parts = raw.decode().split('"')
    text, quoted = parts[0::2], parts[1::2]
    names, numbers, lines = [], [], []
    found: list[tuple[str, ...]] = []
    feeds = 0
    for place in range(len(quoted)):
        feeds += text[place].count("\n")
        attribute = text[place].split()[-1].rstrip("=") if text[place].split() else ""
        if place == 0:
            if attribute != "id":
                return None
        elif attribute == NAME:
            names.append(place)
            lines.append(feeds)
            found.append(())
        elif attribute in CHANNELS and found:
            numbers.append(place)
            found[-1] += (attribute,)
        else:
            return None
    wanted = [tuple(name for bit, name in enumerate(CHANNELS) if bits >> bit & 1) for _, bits in shape]
    if found != wanted or len(numbers) < 2:
        return None
    name_places = itemgetter(*names)
    return Pattern(
        text,
        len(quoted),
        name_places(quoted),
        name_places,
        itemgetter(*numbers),
        shape,
        motion_names,
        tuple(lines),
        feeds + text[-1].count("\n"),
    )


def match(raw: bytes, pattern: Pattern) -> tuple[str, tuple[str, ...]] | None:
    """Return the id and number texts of a frame that differs from the pattern only in those, else None.

    The numbers consist of the letters of numbers, so an XML parser would read the same texts; the reader checks that
    they are numbers.
    """
    try:
        parts = raw.decode().split('"')
    except UnicodeDecodeError:
        return None
    if parts[0::2] != pattern.text:
        return None
    quoted = parts[1::2]
    if pattern.name_places(quoted) != pattern.names:
        return None
    identity = quoted[0]
    numbers: tuple[str, ...] = pattern.number_places(quoted)
    if not (identity.isascii() and identity.isdigit()) or "".join(numbers).translate(_NUMBER_LETTERS):
        return None
    return identity, numbers
