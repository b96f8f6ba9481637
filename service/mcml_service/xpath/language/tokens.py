"""The tokens of an expression, each with its place. XPath 1.0 §3.7."""

from __future__ import annotations

import re
from dataclasses import dataclass

from mcml.errors import Place, QueryError

_START = (
    "A-Z_a-z\u00c0-\u00d6\u00d8-\u00f6\u00f8-\u02ff\u0370-\u037d\u037f-\u1fff\u200c\u200d\u2070-\u218f\u2c00-\u2fef"
)
_START += "\u3001-\ud7ff\uf900-\ufdcf\ufdf0-\ufffd\U00010000-\U000effff"
_NAME = f"[{_START}][{_START}0-9.\u00b7\u0300-\u036f\u203f\u2040-]*"
_TOKEN = re.compile(
    # An exponent is of XPath 2.0 and of libxml2.
    rf"""[ \t\r\n]*(?:
        (?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
      | (?P<string>'[^']*'|"[^"]*")
      | (?P<name>{_NAME})
      | (?P<symbol>::|:=|//|!=|<=|>=|=>|\|\||\.\.|[/@\[\]().,*|+=<>$:!{{}}-])
      | (?P<end>\Z)
    )""",
    re.VERBOSE,
)


@dataclass(frozen=True, slots=True)
class Token:
    """kind: "number", "string", "name", "symbol" or "end". start, end: its place in the text."""

    kind: str
    text: str
    start: int
    end: int


def tokens(text: str) -> list[Token]:
    """Return all tokens, the last one of kind "end". Raises QueryError for invalid text."""
    found: list[Token] = []
    place = 0
    while True:
        match = _TOKEN.match(text, place)
        if match is None:
            start = len(text) - len(text[place:].lstrip(" \t\r\n"))
            what = "a text is not closed" if text[start] in "'\"" else f"{text[start]!r} is no part of XPath"
            raise QueryError(what, at=Place(column=start + 1))
        kind = match.lastgroup or "end"
        found.append(Token(kind, match[kind], match.start(kind), match.end(kind)))
        if kind == "end":
            return found
        place = match.end()
