"""Matches one after the other: where they end, of any length of text."""

from __future__ import annotations

import re

import pytest

from mcml.language.prologue import has_doctype
from mcml.patterns import end_of_matches


@pytest.mark.parametrize(
    ("text", "end"), [(b"", 0), (b"aab", 2), (b"b", 0), (b"ab" * 3, 1), (b"a" * 2_000_000, 2_000_000)]
)
def test_they_end_where_no_other_follows(text: bytes, end: int) -> None:
    assert end_of_matches(re.compile(rb"a"), text) == end


@pytest.mark.parametrize(
    "before", [b"", b" \n", b"<!-- <a> -->", b"<?xml version='1.0'?>\n<!--x--><?y?>", b" " * 2_000_000]
)
def test_a_doctype_is_seen_behind_comments_and_instructions(before: bytes) -> None:
    assert has_doctype(before + b"<!DOCTYPE evil>")
    assert not has_doctype(before + b"<mcml/><!DOCTYPE evil>")
    assert not has_doctype(before + b"<!-- <!DOCTYPE evil> ")
