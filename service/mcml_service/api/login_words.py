"""The words of the sign-in pages: English, and Korean and Japanese by the English sentence.

The studio has its own words; before the sign-in a browser states its languages in `Accept-Language` (RFC 9110, 12.5.4).
"""

from __future__ import annotations

import json
import re
from functools import cache

from mcml_service.resources import login_words_path

ENGLISH = "en"


def choose_language(accepted: str) -> str:
    """The language of a page for the value of an `Accept-Language` header: the known one with the greatest weight."""
    best, weight = ENGLISH, 0.0
    for part in accepted.split(",")[:20]:
        tag, _, parameter = part.partition(";")
        known = tag.strip().lower().split("-")[0]
        found = re.fullmatch(r"\s*q\s*=\s*([01](?:\.\d{0,3})?)\s*", parameter)
        stated = float(found[1]) if found else 0.0 if parameter else 1.0
        if stated > weight and (known == ENGLISH or known in _tables()):
            best, weight = known, stated
    return best


def translate(language: str, sentence: str) -> str:
    """An English sentence in the language; sentences without a translation stay English."""
    if sentence in (whole := _tables().get(language, {})):
        return whole[sentence]
    for pattern, translated in _patterns(language):
        if filled := pattern.fullmatch(sentence):
            return translated.format(**filled.groupdict())
    return sentence


@cache
def _patterns(language: str) -> list[tuple[re.Pattern[str], str]]:
    """The sentences with values of a language as patterns, a group for each {value}, and their translation."""
    return [
        (re.compile(re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>.+)", re.escape(english))), translated)
        for english, translated in _tables().get(language, {}).items()
        if "{" in english
    ]


@cache
def _tables() -> dict[str, dict[str, str]]:
    tables: dict[str, dict[str, str]] = json.loads(login_words_path().read_text(encoding="utf-8"))
    return tables
