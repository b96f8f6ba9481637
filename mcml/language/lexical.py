r"""Text that XML cannot represent directly, and lists in attributes.

XML 1.0 has no control characters except tab, line feed and carriage return, and no surrogates. MCML trims the text of
leaves and separates list items by white space. Lost characters are written as `\u{HEX}`: those characters, white space
at either end of a text, white space within a list item, and the backslash of a literal `\u{`. An empty list item is
`\u{}`. A backslash elsewhere does not change, so that `F:\VICON\data` remains readable.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

WHITE_SPACE: Final = " \t\n\r"

_ILLEGAL = "\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff"
ILLEGAL: Final = re.compile(f"[{_ILLEGAL}]")
"""Characters that XML 1.0 does not have."""

_TO_ESCAPE = re.compile(rf"[{_ILLEGAL}]|\\(?=u\{{)")
_TO_ESCAPE_IN_ITEM = re.compile(rf"[{_ILLEGAL}{WHITE_SPACE}]|\\(?=u\{{)")
_ESCAPED = re.compile(r"\\u\{([0-9A-F]{0,6})\}")

_LIST_ITEM = re.compile(rf"[^{WHITE_SPACE}]+")
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def escape(text: str) -> str:
    r"""Text as the content of a leaf, or an attribute, holds it.

    >>> escape(r" F:\u{x}" + chr(1))
    '\\u{20}F:\\u{5C}u{x}\\u{1}'
    """
    escaped = _TO_ESCAPE.sub(_code, text)
    if escaped and escaped[0] in WHITE_SPACE:
        escaped = f"\\u{{{ord(escaped[0]):X}}}{escaped[1:]}"
    if escaped and escaped[-1] in WHITE_SPACE:
        escaped = f"{escaped[:-1]}\\u{{{ord(escaped[-1]):X}}}"
    return escaped


def unescape(text: str) -> str:
    r"""The inverse of `escape`; does not change invalid escapes and halves of surrogate pairs.

    >>> unescape(r"\u{20}a\u{zz}\n")
    ' a\\u{zz}\\n'
    """
    return _ESCAPED.sub(_character, text) if "\\u{" in text else text


def join_list(items: Iterable[str]) -> str:
    r"""Items as one attribute value.

    >>> join_list(["FileType", "a b", ""])
    'FileType a\\u{20}b \\u{}'
    """
    return " ".join(_TO_ESCAPE_IN_ITEM.sub(_code, item) or "\\u{}" for item in items)


def split_list(text: str) -> tuple[str, ...]:
    """The inverse of `join_list`."""
    # Not str.split(): that would also split at white space of Unicode, which names may hold.
    return tuple(unescape(item) for item in _LIST_ITEM.findall(text))


def is_decimal(text: str) -> bool:
    """Whether the text is a finite decimal number such as `-1.5`, `.5`, `+1` or `4.4e-011`, without white space."""
    return _DECIMAL.fullmatch(text) is not None and abs(float(text)) != float("inf")


def _code(match: re.Match[str]) -> str:
    return f"\\u{{{ord(match.group()):X}}}"


def _character(match: re.Match[str]) -> str:
    digits = match.group(1)
    if not digits:
        return ""
    # Half of a surrogate pair is no text that a store or an answer could hold.
    code = int(digits, 16)
    return match.group() if code > 0x10FFFF or 0xD800 <= code <= 0xDFFF else chr(code)
