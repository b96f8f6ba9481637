"""Regular expressions of XPath (Functions and Operators 3.1 §5.6), in linear time and bounded memory.

elementpath validates a pattern and translates its character classes. RE2 runs the result. RE2 has no back-references,
so they are refused. With the flag `m`, `^` also matches after a line feed that ends the text.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import accumulate
from typing import Any

import re2
from elementpath.regex import RegexError, translate_pattern

from mcml.errors import LimitError, QueryError

MOST_REPETITIONS = 1000
"""The limit of RE2. It reads larger counts as literal text."""
MAX_LENGTH = 10_000
FEW_HITS = 32
"""Texts that match, from which on texts are searched one by one if most of them match."""
MEMORY = 16 << 20
"""Bytes that one expression may take, compiled and while it runs."""

_FLAGS = {"s": re.DOTALL, "m": re.MULTILINE}
_SPACES = str.maketrans("\t\r\n", "   ")
_SIGNS = frozenset("\\|.?*+(){}[]^$-")
"""Metacharacters."""
_COUNT = re.compile(r"\{(\d+)(?:,(\d*))?\}")
_ENDS = (r"(?!\n\Z)", r"(?<!\n\Z)")
"""Anchors that make Python match as XPath does; RE2 needs none."""
_CLASSES = {"d": r"\p{Nd}", "s": r" \t\n\r", "w": r"\p{L}\p{M}\p{N}\p{S}"}
"""Character classes that RE2 limits to ASCII."""
_REFUSED = r"Write a backslash before a sign that means itself, such as \( or \., or the flag 'q' for all."


def matches(text: str, pattern: str, flags: str = "") -> bool:
    """`matches()`.

    Raises QueryError for an invalid regular expression, LimitError for one that takes too much memory.
    """
    return compiled(pattern, flags).search(_sound(text)) is not None


def match_all(texts: Sequence[str], pattern: str, flags: str = "") -> list[bool]:
    """`matches()` of each text. Raises as it does.

    All texts are searched as the lines of one, which passes over texts without a match: the first match anywhere begins
    in the first text that has one, as long as lines begin and end as texts do. Only such texts are searched alone.
    """
    if not texts:
        return []
    alone = compiled(pattern, flags)
    found = [False] * len(texts)
    lines = [_sound(text).encode() for text in texts]
    if any(b"\n" in line for line in lines):
        return [alone.search(text) is not None for text in texts]
    together = compiled(pattern, flags if "m" in flags else f"{flags}m")
    whole = b"\n".join(lines)
    starts = [0, *accumulate(len(line) + 1 for line in lines)]
    place = hits = 0
    while place < len(texts):
        if hits < FEW_HITS or 2 * hits < place:
            match = together.search(whole, starts[place])
            if match is None:
                break
            place = bisect_right(starts, match.start()) - 1
        found[place] = alone.search(texts[place]) is not None
        hits += found[place]
        place += 1
    return found


def replace(text: str, pattern: str, replacement: str, flags: str = "") -> str:
    """`replace()`, with `$1` for the first group. Raises as `matches`."""
    found, groups = _that_takes_something(pattern, flags)
    make = _template(replacement, groups, literal="q" in flags)
    parts: list[str] = []
    place = 0
    for match in found.finditer(_sound(text)):
        parts += (text[place : match.start()], *make(match))
        place = match.end()
    return "".join([*parts, text[place:]])


def tokenize(text: str, pattern: str | None = None, flags: str = "") -> list[str]:
    """`tokenize()`: the parts between what matches, or words between white space. Raises as `matches`."""
    if pattern is None:
        return [word for word in text.translate(_SPACES).split(" ") if word]
    if pattern and not flags and not _SIGNS.intersection(pattern):
        return text.split(pattern) if text else []
    found, _ = _that_takes_something(pattern, flags)
    if not text:
        return []
    ends = [match.span() for match in found.finditer(_sound(text))]
    starts = [0, *(stop for _, stop in ends)]
    return [text[start:stop] for start, stop in zip(starts, [*(start for start, _ in ends), len(text)], strict=True)]


@lru_cache(maxsize=256)
def compiled(pattern: str, flags: str = "") -> Any:
    """A regular expression as RE2 has it. Raises as `matches`."""
    wrong = next((flag for flag in flags if flag not in "smixq"), None)
    if wrong is not None:
        raise QueryError(f"{wrong!r} is no flag of a regular expression", remedy="There are s, m, i, x and q.")
    if len(pattern) > MAX_LENGTH:
        raise _too_large(f"it is longer than {MAX_LENGTH:,} letters")
    options = re2.Options()
    options.log_errors = False
    options.max_mem = MEMORY
    options.case_sensitive = "i" not in flags
    options.dot_nl = "s" in flags
    options.literal = "q" in flags
    try:
        text = pattern if options.literal else _as_re2(pattern, flags)
        return re2.compile(text, options)
    except (RegexError, UnicodeEncodeError) as error:
        raise QueryError(f"{pattern!r} is no regular expression: {error}", remedy=_REFUSED) from None
    except AttributeError:
        # elementpath takes every sign that Python calls a digit for a back-reference.
        raise QueryError(f"{pattern!r} is no regular expression: a digit follows a backslash") from None
    except re2.error as error:
        said = error.args[0].decode(errors="replace") if error.args and isinstance(error.args[0], bytes) else str(error)
        if "too large" in said or "repetition" in said or "too deep" in said:
            raise _too_large(said) from None
        raise QueryError(f"{pattern!r} is no regular expression: {said}", remedy=_REFUSED) from None


def _as_re2(pattern: str, flags: str) -> str:
    """Translate a pattern to RE2."""
    if "x" in flags:
        pattern = _without_spaces(pattern)
    chosen = 0
    for flag in flags:
        chosen |= _FLAGS.get(flag, 0)
    try:
        text = translate_pattern(pattern, chosen)
    except (OverflowError, RecursionError, MemoryError) as error:
        raise _too_large(str(error) or "it is nested too deeply") from None
    for end in _ENDS:
        text = text.replace(end, "")
    return ("(?m)" if "m" in flags else "") + "".join(_parts(text))


def _parts(text: str) -> Iterator[str]:
    """Translate a pattern of Python to RE2, part by part."""
    in_class, place = False, 0
    while place < len(text):
        sign = text[place]
        size = 1
        if sign == "\\":
            size = 2
            if place + 1 == len(text):
                raise RegexError("it ends with a backslash")
            yield _escape(text[place + 1], in_class=in_class)
        elif in_class:
            in_class = sign != "]"
            yield r"\[" if sign == "[" else sign
        elif sign == "[":
            in_class = True
            size = 2 if text[place + 1 : place + 2] == "^" else 1
            yield text[place : place + size]
        else:
            count = _COUNT.match(text, place) if sign == "{" else None
            if count is not None:
                size = len(count[0])
                if any(number and (len(number) > 4 or int(number) > MOST_REPETITIONS) for number in count.groups()):
                    raise _too_large(f"{count[0]} repeats more than {MOST_REPETITIONS:,} times")
            yield text[place : place + size]
        place += size


def _escape(letter: str, *, in_class: bool) -> str:
    """Translate an escape sequence."""
    if letter.isdigit() and letter != "0":
        raise QueryError(
            f"a regular expression has a back-reference (\\{letter}), which takes unbounded time",
            remedy="Write without \\1, such as (aa|bb) for (a|b)\\1.",
        )
    letters = _CLASSES.get(letter.lower())
    if letters is None:
        return f"\\{letter}"
    if not in_class:
        return f"[{'^' if letter.isupper() else ''}{letters}]"
    if letter.islower():
        return letters
    # RE2 has no class within a class; among the letters of XML these are the same.
    return {"D": r"\P{Nd}", "S": r"\S", "W": r"\p{P}\p{Z}\p{C}"}[letter]


def _without_spaces(pattern: str) -> str:
    """A pattern without the white space outside of its classes (flag x)."""
    kept, depth, place = [], 0, 0
    while place < len(pattern):
        sign = pattern[place]
        if sign == "\\":
            kept.append(pattern[place : place + 2])
            place += 2
            continue
        depth += (sign == "[") - (sign == "]" and depth > 0)
        if depth or sign not in " \t\n\r":
            kept.append(sign)
        place += 1
    return "".join(kept)


def _sound(text: str) -> str:
    """A text, refused where it holds half of a letter, as a JSON string can and no XML does."""
    if text.isascii():
        return text
    try:
        text.encode()
    except UnicodeEncodeError:
        raise QueryError("a text holds half of a letter (a surrogate without its other half)") from None
    return text


def _too_large(why: str) -> LimitError:
    return LimitError(
        f"The regular expression is too large: {why}.",
        remedy=f"Repeat at most {MOST_REPETITIONS:,} times, and write no repetition inside of a repetition.",
        code="query-too-large",
    )


@lru_cache(maxsize=256)
def _that_takes_something(pattern: str, flags: str) -> tuple[Any, int]:
    """A regular expression that matches no empty text, and how many groups it has."""
    found = compiled(pattern, flags)
    if found.search("") is not None:
        raise QueryError(
            f"the regular expression {pattern!r} matches the empty text, of which there is no end",
            remedy="Match at least one character: + instead of *.",
        )
    return found, found.groups


@lru_cache(maxsize=256)
def _template(replacement: str, groups: int, *, literal: bool) -> Callable[[Any], list[str]]:
    """Return a function that makes the parts of a replacement for a match.

    `$12` is group 12 if there are that many, else group 1 and a 2.
    """
    parts: list[str | int] = [replacement] if literal else []
    place = len(replacement) if literal else 0
    while place < len(replacement):
        letter = replacement[place]
        place += 1
        if letter == "\\":
            if replacement[place : place + 1] not in ("\\", "$") or place == len(replacement):
                raise QueryError(f"in {replacement!r} a backslash is followed by neither $ nor a backslash")
            parts.append(replacement[place])
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
            if number <= groups:
                parts.append(number)
            place = end
        else:
            parts.append(letter)

    def made(match: Any) -> list[str]:
        return [(match.group(part) or "") if isinstance(part, int) else part for part in parts]

    return made
