"""Texts that users read are plain English."""

from __future__ import annotations

import pytest

from tests.docs.english import BUDGETS, check_areas, check_text


@pytest.mark.slow
def test_no_area_breaks_the_rules_more_often_than_its_budget_allows() -> None:
    for area, faults in check_areas().items():
        assert len(faults) <= BUDGETS[area], [(fault.place, fault.words) for fault in faults[:20]]


@pytest.mark.parametrize(
    "text",
    [
        "What is larger than 2 GiB is refused.",
        "The list shows what was found.",
        "Ask whoever made the link.",
        "Nothing is called so.",
        "It is told of by a webhook.",
        "Such as are stored already are skipped.",
        "Take the clip, and who may edit it.",
        "They shall have a name.",
    ],
)
def test_odd_texts_are_found(text: str) -> None:
    assert list(check_text("here", text))


@pytest.mark.parametrize(
    "text",
    [
        "The server refuses uploads over 2 GiB.",
        "People who have an account see it.",
        "What to do next?",
        "Run `mcml what is` in a shell.",
        "No matches.",
        "Editors can delete clips that they have imported.",
    ],
)
def test_plain_texts_are_not(text: str) -> None:
    assert not list(check_text("here", text))
