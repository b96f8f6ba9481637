"""Regular expressions that are matched again and again."""

from __future__ import annotations

import re


def end_of_matches(pattern: re.Pattern[bytes], text: bytes) -> int:
    """Where matches of a pattern, one after the other from the beginning of a text, end.

    Not one pattern that repeats: it would have to be possessive, or a long run of white space would take for ever, and
    Python 3.11 has possessive repetitions of groups right from 3.11.5 on (https://github.com/python/cpython/issues/106052).
    """
    end = 0
    while found := pattern.match(text, end):
        end = found.end()
    return end
