"""The names of files in a zip. A flag marks a name as UTF-8; without it programs use the encoding of their system."""

from __future__ import annotations

import struct
import unicodedata
import zipfile
import zlib
from collections.abc import Sequence

from mcml.errors import Notice
from mcml.formats.text.plausible_text import EASTERN, plausible_codecs, title_of

_IS_UTF8 = 0x800
_UNICODE_PATH = 0x7075
_DOS = "cp437"


def member_names(members: Sequence[zipfile.ZipInfo]) -> tuple[dict[int, str], tuple[Notice, ...]]:
    """Return the path of each member, by its offset in the zip, and the guesses about them.

    Names without the UTF-8 flag are read together: all names of one zip have one encoding. Names of macOS are composed,
    as on other systems; backslashes between folders become slashes.
    """
    names: dict[int, str] = {}
    unsaid: dict[int, bytes] = {}
    for member in members:
        stated = member.orig_filename if member.flag_bits & _IS_UTF8 else _unicode_path(member)
        if stated is None:
            unsaid[member.header_offset] = _raw(member)
        else:
            names[member.header_offset] = _as_path(stated)
    text = b"\n".join(unsaid.values())
    codec = codec_of(text)
    names |= {place: _as_path(raw.decode(codec, errors="replace")) for place, raw in unsaid.items()}
    if text.isascii():
        return names, ()
    tried = ", ".join(map(title_of, ("utf-8", *EASTERN, _DOS)))
    what = f"the zip does not say how its names are encoded: of {tried} they are most plausible as {title_of(codec)}"
    return names, (Notice("guess", what),)


def _as_path(name: str) -> str:
    return unicodedata.normalize("NFC", name.partition("\0")[0].replace("\\", "/"))


def _raw(member: zipfile.ZipInfo) -> bytes:
    """The bytes of a name without the flag, which the library reads as CP437, where each byte is a character."""
    return member.orig_filename.encode(_DOS)


def codec_of(text: bytes) -> str:
    """The encoding of names: UTF-8 where they are that, else the most plausible one, else CP437."""
    for codec in ("utf-8", *plausible_codecs(text, _DOS)):
        try:
            text.decode(codec)
        except UnicodeDecodeError:
            continue
        return codec
    return _DOS


def _unicode_path(member: zipfile.ZipInfo) -> str | None:
    """The name in Info-ZIP's extra field, where it is of this very name."""
    extra = member.extra
    while len(extra) >= 4:
        kind, size = struct.unpack("<HH", extra[:4])
        content, extra = extra[4 : 4 + size], extra[4 + size :]
        if kind == _UNICODE_PATH and len(content) > 5 and content[0] == 1:
            same = struct.unpack("<I", content[1:5])[0] == zlib.crc32(_raw(member))
            return content[5:].decode("utf-8", errors="replace") if same else None
    return None
