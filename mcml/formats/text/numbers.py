"""Convert text of numbers to arrays of doubles, exactly and fast.

simdjson reads a JSON array at hundreds of megabytes a second, orjson at half of that: it serves where simdjson has no
wheel for the version of Python. The grammar of JSON is narrower than that of motion files and its integers have no sign
of zero, so the text is converted to JSON first. Text that these parsers refuse is read by the slow exact parser, which
also finds the wrong token.
"""

from __future__ import annotations

import math
import re
import threading
from importlib.util import find_spec
from typing import Any, BinaryIO, Final, Protocol

import numpy as np
import orjson
from numpy.typing import NDArray

from mcml.errors import FormatError
from mcml.formats.text.lines import blocks_of, line_and_column, shown
from mcml.motion.skeleton import Array

BLOCK_BYTES: Final = 1 << 18
"""Size of text parsed at once: a block that fits the processor's cache is twice as fast as a megabyte."""

LONGEST_NUMBER: Final = 400
"""Characters; the exact decimal of a double needs up to 1075, but no writer of motion gives more than a few dozen."""

_DECIMAL = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_SEPARATORS = bytes(44 if chr(code) in " \t\n\r\v\f" else code for code in range(256))
_IS_BLANK = bytes(chr(code) in " \t\n\r\v\f" for code in range(256))
_COMMA: Final = ord(",")
_BLANK: Final = ord(" ")
_ZERO: Final = ord("0")
_MINUS: Final = ord("-")
_GLUED = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?[+-][0-9.].*")
_TOKEN = re.compile(rb"[^ \t\n\r\v\f]+")


def is_number(text: str) -> bool:
    """Whether the text is a finite decimal number: `-1.5`, `.5`, `+1`, `4.4e-011`."""
    if len(text) > LONGEST_NUMBER:
        return False
    return _DECIMAL.fullmatch(text) is not None and math.isfinite(float(text))


def is_whole(text: str) -> bool:
    """Whether the text is a whole number that fits 64 bits."""
    return re.fullmatch(r"[+-]?[0-9]{1,18}", text) is not None


def what_is_wrong(token: str) -> str:
    """Why a token is no finite number, for a message."""
    if len(token) <= LONGEST_NUMBER:
        if "," in token and is_number(token.replace(",", ".", 1)):
            return f"{shown(token)} uses a decimal comma"
        if _GLUED.fullmatch(token) and not is_number(token):
            return f"two numbers without a space: {shown(token)}"
    return f"{shown(token)} is not a finite number"


class Parser(Protocol):
    """A parser of JSON, for its arrays of numbers."""

    def doubles(self, text: bytes | memoryview) -> Array | None:
        """The doubles of a JSON array, None for any other text."""


class Simdjson(threading.local):
    """A parser for each thread: parsers cannot be shared, and their buffers are too large to be allocated each time."""

    def __init__(self) -> None:
        import simdjson

        self.parser: Any = simdjson.Parser()

    def doubles(self, text: bytes | memoryview) -> Array | None:
        try:
            buffer = self.parser.parse(text).as_buffer(of_type="d")  # AttributeError: no array
        except (ValueError, RuntimeError, TypeError, AttributeError):
            return None
        return np.frombuffer(buffer, dtype=np.float64)


class Orjson:
    """A parser that has wheels for each version of Python; each number is an object of Python between."""

    def doubles(self, text: bytes | memoryview) -> Array | None:
        text = bytes(text)
        if any(mark in text for mark in (b"u", b"l", b'"')):  # true, false, null and "1" would be numbers
            return None
        try:
            values = orjson.loads(text)
            return np.fromiter(values, dtype=np.float64, count=len(values))
        except (ValueError, TypeError):
            return None


PARSER: Final[Parser] = Simdjson() if find_spec("simdjson") else Orjson()


LOOKED_AT = 4096
"""Bytes at the beginning of a text that tell how its numbers are separated."""


def parse_numbers(text: bytes, parser: Parser = PARSER) -> Array | None:
    """The numbers of a text separated by white space, bit for bit; None if a token is not a number (see
    `bad_token`).
    """
    text = text.strip()
    if not text:
        return np.empty(0)
    # Commas and brackets would be JSON of another meaning.
    if b"," not in text and b"[" not in text:
        values = _parse_json(b"[" + text.translate(_SEPARATORS) + b"]", parser)
        if values is not None:
            return values
    return _parse_slowly(text)


def _parse_json(text: bytes, parser: Parser) -> Array | None:
    """The array of a JSON text with doubled commas, None where it is anything else."""
    # To search all of a text for doubled commas takes nearly as long as to parse it: its first lines tell.
    source = _with_single_commas(text) if b",," in text[:LOOKED_AT] else text
    values = parser.doubles(source)
    if values is None and source is text:
        source = _with_single_commas(text)
        values = None if source is text else parser.doubles(source)
    if values is None and (b",." in text or b"-." in text):
        source = _with_single_commas(text.replace(b",.", b",0.").replace(b"-.", b"-0."))
        values = parser.doubles(source)
    return None if values is None else _with_negative_zeros(values, source)


def _with_single_commas(text: bytes) -> bytes | memoryview:
    """All commas of a run but the last become blanks, which JSON allows: no byte moves."""
    if b",," not in text:
        return text
    characters = np.frombuffer(bytearray(text), dtype=np.uint8)
    commas = characters == _COMMA
    runs = (commas[:-1] & commas[1:]).view(np.uint8)
    runs *= _COMMA - _BLANK
    characters[:-1] -= runs
    return characters.data


def _with_negative_zeros(values: Array, source: bytes | memoryview) -> Array:
    """The parsed values with the sign of every `-0`, which simdjson reads as an integer without one."""
    characters = np.frombuffer(source, dtype=np.uint8)
    # Three comparisons of the whole text are six times faster than a search for b"-0,".
    found = characters[2:] <= _COMMA
    found &= characters[1:-1] == _ZERO
    found &= characters[:-2] == _MINUS
    places = np.flatnonzero(found)
    if source[-3:] == b"-0]":
        places = np.append(places, len(source) - 3)
    # In 1e-0 the sign is the exponent's.
    places = places[characters[places - 1] != ord("e")]
    places = places[characters[places - 1] != ord("E")]
    if not len(places):
        return values
    signed = values.copy()
    signed[np.searchsorted(np.flatnonzero(characters == _COMMA), places)] = -0.0
    return signed


def _parse_slowly(text: bytes) -> Array | None:
    # Only with these characters does float() read nothing but decimal numbers.
    if text.translate(None, b"0123456789+-.eE \t\n\r\v\f"):
        return None
    tokens = text.split()
    if max(map(len, tokens)) > LONGEST_NUMBER:
        return None
    try:
        values = np.fromiter(map(float, tokens), dtype=np.float64, count=len(tokens))
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def bad_token(text: bytes) -> tuple[int, int, str] | None:
    """(index among the tokens, byte offset, token) of the first token that is no finite number."""
    for index, match in enumerate(_TOKEN.finditer(text)):
        token = match.group().decode("latin-1")
        if not is_number(token):
            return index, match.start(), token
    return None


class NumberStream:
    """The numbers of a file from a byte offset on, in arrays, with the offset of each array's text."""

    def __init__(self, stream: BinaryIO, start: int, block: int = BLOCK_BYTES) -> None:
        self.offset = start
        """Byte offset behind the last text that was given out."""
        self._stream = stream
        self._blocks = blocks_of(stream, start, block)
        self._rest = b""
        self._longest = block

    def next(self) -> tuple[bytes, int] | None:
        """(text, byte offset) of the next whole tokens, None at the end. Raises FormatError for an endless token."""
        for block in self._blocks:
            text = self._rest + block
            cut = max(text.rfind(b"\n"), text.rfind(b"\r"))
            if cut < 0:
                cut = max(text.rfind(b" "), text.rfind(b"\t"), text.rfind(b"\v"), text.rfind(b"\f"))
            if cut < 0:
                if len(text) > 2 * self._longest:
                    raise FormatError(
                        f"a single word is longer than {self._longest} bytes",
                        at=line_and_column(self._stream, self.offset),
                    )
                self._rest = text
                continue
            self._rest = text[cut + 1 :]
            return self._given(text[: cut + 1])
        if not self._rest:
            return None
        text, self._rest = self._rest, b""
        return self._given(text)

    def _given(self, text: bytes) -> tuple[bytes, int]:
        start = self.offset
        self.offset += len(text)
        return text, start


def token_bounds(text: bytes) -> NDArray[np.intp]:
    """(n, 2): where each of the words separated by white space begins and ends, in bytes.

    Several times faster than to split the text, where only some of the words are looked at.
    """
    blank = np.frombuffer(b"\1%b\1" % text.translate(_IS_BLANK), dtype=np.bool_)
    return np.flatnonzero(blank[1:] != blank[:-1]).reshape(-1, 2)


def count_tokens(text: bytes) -> int:
    """How many words separated by white space a text has."""
    return len(token_bounds(text))
