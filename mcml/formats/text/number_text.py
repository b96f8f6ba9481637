"""Arrays of doubles to text, exactly and fast, in the style of the source.

Styles: "shortest" (the fewest digits that read back as the same double, orjson's), "fixed:N" (N decimals, C's %.Nf),
"general:N" (N significant digits, C's %.Ng). A value that a style would change is written in its shortest form, and so
are all of a style with more than 80 decimals.
"""

from __future__ import annotations

import operator
import re

import numpy as np
import orjson
from numpy.typing import NDArray

from mcml.formats.text.numbers import parse_numbers, token_bounds
from mcml.motion.skeleton import Array

SHORTEST = "shortest"
SAMPLE_TOKENS, FEW_TOKENS = 300, 100
MOST_DECIMALS = 15
"""With which numbers of motion are still on a grid that a double can tell."""

MOST_STYLED = 80
"""Decimals of a style: with the 309 digits that a double can have before them, still a number that readers take."""

_FRACTION = re.compile(rb"\.([0-9]*)(?![0-9eE])")
_EXPONENT = re.compile(rb"[eE][+-]?[0-9]*")
_STYLE = re.compile(r"(fixed|general):([0-9]{1,2})")
_TO_LINES = {
    separator: bytes(ord(separator) if code == ord(",") else code for code in range(256)) for separator in " \t"
}


def detect_style(sample: bytes, bounds: NDArray[np.intp] | None = None) -> str:
    """The style in which most numbers of a text are written; SHORTEST where none fits more than half.

    bounds: of its words, where they are known (`token_bounds`).
    """
    bounds = token_bounds(sample) if bounds is None else bounds
    uniform = _uniform_style(sample, bounds)
    if uniform is not None:
        return uniform
    tokens = _spread(sample, bounds, SAMPLE_TOKENS)
    text = b" ".join(tokens)
    values = parse_numbers(text)
    if values is None or not tokens:
        return SHORTEST
    decimals = list(map(len, _FRACTION.findall(text)))
    usual = max(set(decimals), key=decimals.count) if decimals else MOST_STYLED + 1
    fixed = [f"fixed:{usual}"] if usual <= MOST_STYLED else []
    mantissas = _EXPONENT.sub(b"", text).translate(None, b"+-.").split(b" ")
    digits = min(17, max(1, *(len(mantissa.lstrip(b"0")) for mantissa in mantissas)))
    general = f"general:{digits}"
    # Where several fit alike, few digits are a program's %g; a dozen are the value itself.
    candidates = [general, SHORTEST, *fixed] if digits <= 9 else [SHORTEST, *fixed, general]
    shortest = number_tokens(values)
    best, largest = SHORTEST, 0.5
    for style in candidates:
        share = _share(tokens, values, style, shortest)
        if share > largest:
            best, largest = style, share
        if share == 1:
            break
    return best


def _spread(sample: bytes, bounds: NDArray[np.intp], most: int) -> list[bytes]:
    """Some of the words, spread over the sample: the first frame is often a pose of zeros."""
    return [sample[start:end] for start, end in bounds[:: len(bounds) // most + 1].tolist()]


def _uniform_style(sample: bytes, bounds: NDArray[np.intp]) -> str | None:
    """The style in which all of a few words are written, where no other could have written them; most programs'."""
    tokens = _spread(sample, bounds, FEW_TOKENS)
    text = b" ".join(tokens)
    decimals = list(map(len, _FRACTION.findall(text)))
    if len(decimals) != len(tokens) or not 1 < min(decimals, default=0) == max(decimals) <= MOST_STYLED:
        return None
    # Zeros behind the first decimal are of no other style.
    if b"0 " not in text and not text.endswith(b"0"):
        return None
    values = parse_numbers(text)
    style = f"fixed:{decimals[0]}"
    return style if values is not None and _written(values, style) == tokens else None


def decimals_of(style: str) -> int | None:
    """How many decimals all numbers of a style have, None where that varies or is more than a double has."""
    match = _STYLE.fullmatch(style)
    return int(match[2]) if match and match[1] == "fixed" and int(match[2]) <= MOST_DECIMALS else None


def _share(tokens: list[bytes], values: Array, style: str, shortest: list[bytes]) -> float:
    """Return the share of tokens that equal those of `number_tokens`, without reading all numbers again."""
    if style == SHORTEST:
        return _equal(tokens, shortest) / len(tokens)
    written = _written(values, style)
    if written == tokens:
        return 1.0
    mended: int = sum(
        token == short != text and float(text) != value
        for token, short, text, value in zip(tokens, shortest, written, values.tolist(), strict=True)
    )
    return (_equal(tokens, written) + mended) / len(tokens)


def _written(values: Array, style: str) -> list[bytes]:
    """Each value in a style other than the shortest, whether or not that changes it."""
    plain: list[float] = values.tolist()
    return (" ".join([f"{_template(style)}"] * len(plain)) % tuple(plain)).encode().split(b" ")


def _equal(tokens: list[bytes], others: list[bytes]) -> int:
    return sum(map(operator.eq, tokens, others))


def number_tokens(values: Array, style: str = SHORTEST) -> list[bytes]:
    """Each value as text. values: any shape, finite."""
    return rows_of_text(values.reshape(1, -1), style, " ")[0].split(b" ") if values.size else []


def rows_of_text(values: Array, style: str = SHORTEST, separator: str = " ") -> list[bytes]:
    """Each row as text without line end. values: (n, D), finite. separator: blank or tab."""
    rows, columns = values.shape
    if not rows or not columns:
        return [b""] * rows
    template = _template(style)
    if template is None:
        text = orjson.dumps(np.ascontiguousarray(values), option=orjson.OPT_SERIALIZE_NUMPY)
        return text.translate(_TO_LINES[separator])[2:-2].split(b"]%c[" % separator.encode())
    line = separator.join([template] * columns)
    written = [(line % tuple(row)).encode() for row in values.tolist()]
    # Whether the style keeps the value: the text is read again.
    read = parse_numbers(b"\n".join(written))
    flat = np.ascontiguousarray(values).reshape(-1)
    if read is not None and np.array_equal(read.view(np.int64), flat.view(np.int64)):
        return written
    return [_mended(row, text, separator) for row, text in zip(values, written, strict=True)]


def _mended(row: Array, text: bytes, separator: str) -> bytes:
    """The text of a row with the shortest form for the values that the style would change."""
    tokens = text.split(separator.encode())
    read = np.array([float(token) for token in tokens])
    changed = np.flatnonzero(read.view(np.int64) != np.ascontiguousarray(row).view(np.int64))
    if len(changed):
        for index, token in zip(changed.tolist(), number_tokens(row[changed]), strict=True):
            tokens[index] = token
    return separator.encode().join(tokens)


def _template(style: str) -> str | None:
    match = _STYLE.fullmatch(style)
    if match is None or int(match[2]) > MOST_STYLED:
        return None
    return f"%.{match[2]}{'f' if match[1] == 'fixed' else 'g'}"
