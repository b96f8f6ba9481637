"""The table of the security standard is whole, and what it says is met has a test or a page."""

from __future__ import annotations

import re
from collections import Counter

import pytest

from tests.docs.generate import DOCS

PAGE = (DOCS / "security.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\d+\.\d+\.\d+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", PAGE, re.MULTILINE)
A_CHAPTER = {1: 8, 2: 4, 3: 8, 4: 2, 5: 4, 6: 13, 7: 6, 8: 4, 9: 4, 10: 5, 11: 3, 12: 3, 13: 1, 14: 2, 15: 3}
"""Requirements of level 1 in each chapter of ASVS 5.0.0; 16 and 17 have none."""


def test_every_requirement_has_its_line_once() -> None:
    numbers = [tuple(map(int, number.split("."))) for number, *_ in ROWS]
    assert numbers == sorted(set(numbers))
    assert Counter(number[0] for number in numbers) == A_CHAPTER
    counted = Counter(state for _, _, state, _ in ROWS)
    told = re.search(r"Of (\d+): (\d+) met, (\d+) partly, (\d+) not, (\d+) with nothing", PAGE)
    assert told is not None
    assert [int(number) for number in told.groups()] == [
        len(ROWS), counted["met"], counted["partly"], counted["no"], counted["none here"],
    ]  # fmt: skip


@pytest.mark.parametrize(("number", "state", "why"), [(number, state, why) for number, _, state, why in ROWS])
def test_what_is_met_is_shown(number: str, state: str, why: str) -> None:
    """That the tests exist is asked of all guides, in tests/architecture."""
    assert state in ("met", "partly", "no", "none here")
    if state in ("met", "partly"):
        assert re.search(r"`tests/[\w/]+\.py: test_\w+`|\]\([\w./-]+\.md\)|`SECURITY\.md`", why), number
    else:
        assert len(why) > 10 or re.fullmatch(r"as \d+\.\d+\.\d+", why), number
