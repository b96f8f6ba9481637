"""Regular expressions of XPath against those of Python, translated by elementpath, where both mean the same."""

from __future__ import annotations

import re
from contextlib import suppress

import pytest
from elementpath.regex import translate_pattern
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcml.errors import LimitError, McmlError, QueryError
from mcml_service.xpath.language import regular

ATOMS = [
    *("a", "b", "é", "1", " ", ".", r"\d", r"\s", r"\D", r"\S", r"\i", r"\c", r"\.", r"\-", "(a|b)", "(b)", "(?:ab)"),
    *("[a-c]", "[^a]", "[a-z-[b]]", r"[\s\d]", r"[^\s]", r"\p{L}", r"\P{L}", r"\p{IsGreek}", "[-a]", r"[\[\]]"),
]
COUNTS = ["", "", "*", "+", "?", "{2}", "{1,3}", "{1,}", "*?", "{0,2}?"]
PATTERNS = st.lists(st.tuples(st.sampled_from(ATOMS), st.sampled_from(COUNTS)), min_size=1, max_size=4).map(
    lambda parts: "".join(atom + count for atom, count in parts)
)
FLAGS = {"s": re.DOTALL, "i": re.IGNORECASE}


@given(pattern=PATTERNS, text=st.text("ab é1 .-[]\tZ٣β\n", max_size=8), flags=st.sampled_from(["", "s", "i", "si"]))
def test_matches_as_python_does(pattern: str, text: str, flags: str) -> None:
    chosen = 0
    for flag in flags:
        chosen |= FLAGS[flag]
    theirs = re.compile(translate_pattern(pattern, chosen), chosen)
    assert regular.matches(text, pattern, flags) == (theirs.search(text) is not None)


@pytest.mark.parametrize(
    ("text", "pattern", "flags", "expected"),
    [
        ("a_b", r"^\w+$", "", False),  # an underscore is punctuation
        ("a\nb", "^b$", "m", True),
        ("a\nb", "^b$", "", False),
        ("ab\n", "b$", "", False),
        ("a.b", "a.b", "q", True),
        ("axb", "a.b", "q", False),
        ("ab", "a b", "x", True),
        ("a b", "a[ ]b", "x", True),
        ("a b", "a\\ b", "x", True),
        ("A", "a", "i", True),
        ("\r", ".", "", False),
        ("٣", r"\d", "", True),
        ("x" * 1000, "^x{1000}$", "", True),
    ],
)
def test_says_what_the_specification_says(text: str, pattern: str, flags: str, expected: bool) -> None:
    assert regular.matches(text, pattern, flags) is expected


@pytest.mark.parametrize(
    "pattern",
    [
        "a{2147483647}",
        "a{1001}",
        "a{1001,}",
        "a{0,99999999999999999999}",
        "(a{5000}){2}",
        "((a{900}){900}){900}",
        "x" * 20_000,
        "(a|b){999}" * 2000,
    ],
)
def test_what_is_too_large_is_refused_at_once(pattern: str) -> None:
    with pytest.raises(LimitError, match="too large"):
        regular.matches("aaa", pattern)


@pytest.mark.parametrize("pattern", [r"(a)\1", r"(a|b)c\1", r"(?:x)(y)[z]\1+"])
def test_back_references_are_refused_with_the_reason(pattern: str) -> None:
    with pytest.raises(QueryError, match="back-reference"):
        regular.matches("aa", pattern)


@pytest.mark.parametrize("pattern", ["(a+)+$", "(a|a)*b", "(.*)*x", "a*a*a*a*a*a*b"])
def test_repetitions_of_repetitions_take_linear_time(pattern: str) -> None:
    # An engine that tries one way after the other would not end before the world does.
    regular.matches("a" * 100_000, pattern)


@given(pattern=st.text(max_size=12), text=st.text(max_size=8), flags=st.text("smixq", max_size=2))
def test_any_text_is_a_pattern_or_refused(pattern: str, text: str, flags: str) -> None:
    for call in (regular.matches, regular.tokenize):
        # Another error would end the test.
        with suppress(McmlError):
            call(text, pattern, flags)


@pytest.mark.parametrize(("pattern", "flags"), [("\\", "x"), ("\\²", ""), ("(a)\\²", "i")])
def test_a_backslash_before_nothing_or_another_digit_is_refused(pattern: str, flags: str) -> None:
    with pytest.raises(QueryError, match="is no regular expression"):
        regular.matches("a", pattern, flags)


def test_half_of_a_letter_is_refused() -> None:
    with pytest.raises(QueryError):
        regular.matches("a", "\ud800")
    with pytest.raises(QueryError):
        regular.matches("\ud800", "a")


@pytest.mark.parametrize(
    ("text", "pattern", "replacement", "flags", "expected"),
    [
        ("walk_12", "([a-z]+)_([0-9]+)", "$2-$1", "", "12-walk"),
        ("abc", "(b)", "$1$1$2", "", "abbc"),
        ("abc", "b", r"\$\\", "", r"a$\c"),
        ("a.c", ".", "$1", "q", "a$1c"),
        ("abab", "(a)|b", "[$1]", "", "[a][][a][]"),
        ("abc", "(a)(b)(c)", "$12", "", "a2"),
    ],
)
def test_replaces(text: str, pattern: str, replacement: str, flags: str, expected: str) -> None:
    assert regular.replace(text, pattern, replacement, flags) == expected


SIGNS = st.sampled_from(["a", "b", "_", ".", " ", "\n", "\r", "é", "٣", "", "ab"])
PARTS = st.sampled_from(
    ["a", "b", "ab", ".", "^", "$", "a*", "b+", "[^a]", r"\s", r"\S", r"\W", r"\n", "(a|b)", "_?", "\n", "a|b", "^$"]
)


@given(
    st.lists(st.lists(SIGNS, max_size=5).map("".join), max_size=80),
    st.lists(PARTS, min_size=1, max_size=4).map("".join),
    st.sampled_from(["", "s", "m", "i", "sm", "q", "x"]),
)
@settings(max_examples=400, deadline=None)
def test_many_texts_match_as_each_alone(texts: list[str], pattern: str, flags: str) -> None:
    try:
        regular.compiled(pattern, flags)
    except McmlError:
        assume(False)
    assert regular.match_all(texts, pattern, flags) == [regular.matches(text, pattern, flags) for text in texts]


def test_half_of_a_letter_is_refused_among_many_texts() -> None:
    with pytest.raises(QueryError, match="half of a letter"):
        regular.match_all(["a", "\ud800"], "a")
