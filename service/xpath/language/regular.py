"""Regular expressions of XPath (Functions and Operators 3.1 §5.6), within a limit of time.

elementpath translates their syntax to that of Python; they run in `regex`, which lets other threads run and stops when
time is up: an expression such as `(a+)+$` would else hold up the whole process.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TypeVar

import regex
from elementpath.regex import RegexError, translate_pattern

from service.errors import LimitError, QueryError

SECONDS = 2.0
"""For one text. Texts of documents are short."""
_FLAGS = {"s": regex.DOTALL, "m": regex.MULTILINE, "i": regex.IGNORECASE, "x": regex.VERBOSE}
_SPACES = str.maketrans("\t\r\n", "   ")
_SIGNS = frozenset("\\|.?*+(){}[]^$-")
"""Letters that mean more than themselves."""
_Found = TypeVar("_Found")


def matches(text: str, pattern: str, flags: str = "") -> bool:
    """`matches()`. QueryError for what is no regular expression, LimitError for one that takes too long."""
    return _within_time(
        pattern, lambda: _compiled(pattern, flags).search(text, timeout=SECONDS, concurrent=True) is not None
    )


def replace(text: str, pattern: str, replacement: str, flags: str = "") -> str:
    """`replace()`, with `$1` for what the first parenthesis found. Raises as `matches`."""
    found = _that_takes_something(pattern, flags)
    template = _template(replacement, found.groups, literal="q" in flags)
    return _within_time(pattern, lambda: found.sub(template, text, timeout=SECONDS, concurrent=True))


def tokenize(text: str, pattern: str | None = None, flags: str = "") -> list[str]:
    """`tokenize()`: the parts between what matches, or words between white space. Raises as `matches`."""
    if pattern is None:
        return [word for word in text.translate(_SPACES).split(" ") if word]
    if pattern and not flags and not _SIGNS.intersection(pattern):
        return text.split(pattern) if text else []
    found = _that_takes_something(pattern, flags)
    if not text:
        return []
    ends = _within_time(pattern, lambda: [m.span() for m in found.finditer(text, timeout=SECONDS, concurrent=True)])
    starts = [0, *(stop for _, stop in ends)]
    return [text[start:stop] for start, stop in zip(starts, [*(start for start, _ in ends), len(text)], strict=True)]


def _within_time(pattern: str, call: Callable[[], _Found]) -> _Found:
    try:
        return call()
    except TimeoutError:
        raise LimitError(
            f"The regular expression {pattern!r} takes too long.",
            remedy="Write it without a repetition inside of a repetition.",
            code="query-too-large",
        ) from None


@lru_cache(maxsize=256)
def _compiled(pattern: str, flags: str) -> regex.Pattern[str]:
    wrong = next((flag for flag in flags if flag not in "smixq"), None)
    if wrong is not None:
        raise QueryError(f"{wrong!r} is no flag of a regular expression", remedy="There are s, m, i, x and q.")
    chosen = 0
    for flag in flags.replace("q", ""):
        chosen |= _FLAGS[flag]
    if "q" in flags:
        return regex.compile(regex.escape(pattern), chosen & regex.IGNORECASE)
    try:
        return regex.compile(translate_pattern(pattern, chosen), chosen)
    except (RegexError, regex.error, OverflowError) as error:
        raise QueryError(
            f"{pattern!r} is no regular expression: {error}",
            remedy=r"Write a backslash before a sign that means itself, such as \( or \., or the flag 'q' for all.",
        ) from None


def _that_takes_something(pattern: str, flags: str) -> regex.Pattern[str]:
    found = _compiled(pattern, flags)
    if _within_time(pattern, lambda: found.search("", timeout=SECONDS)):
        raise QueryError(
            f"the regular expression {pattern!r} matches the empty text, of which there is no end",
            remedy="Let it match at least one letter: + instead of *.",
        )
    return found


@lru_cache(maxsize=256)
def _template(replacement: str, groups: int, *, literal: bool) -> str:
    """The replacement as `regex` writes it. `$12` is group 12 where there are as many, else group 1 and a 2."""
    if literal:
        return replacement.replace("\\", r"\\")
    result, place = "", 0
    while place < len(replacement):
        letter = replacement[place]
        place += 1
        if letter == "\\":
            if replacement[place : place + 1] not in ("\\", "$") or place == len(replacement):
                raise QueryError(f"in {replacement!r} a backslash stands before something else than $ or a backslash")
            result += r"\\" if replacement[place] == "\\" else "$"
            place += 1
        elif letter == "$":
            end = place
            while (
                end < len(replacement)
                and replacement[end] in "0123456789"
                and (end == place or int(replacement[place : end + 1]) <= groups)
            ):
                end += 1
            if end == place:
                raise QueryError(f"in {replacement!r} no number follows $", remedy=r"Write \$ for the sign itself.")
            number = int(replacement[place:end])
            result += rf"\g<{number}>" if number <= groups else ""
            place = end
        else:
            result += letter
    return result
