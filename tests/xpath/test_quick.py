"""Which expressions are quick: a server answers them beside heavy ones, of the same client too."""

from __future__ import annotations

from random import Random

import pytest

from mcml_service.xpath.quick import is_quick
from tests.hostile.hostile_expressions import hostile_expression
from tests.hostile.test_hostile_questions import BOMBS

QUICK = [
    "count(//frame)",
    "//frame[17]",
    "//frame[motion_name = 'walk'][frame_bone[@name='left_hand']/@Rx > 60]",
    "max(//frame_bone[@name='left_up_leg']/@Rx) - 2 * 3",
    "count(/mcml[contains(header/filename, 'walk')])",
    "distinct-values(//motion_name)",
    "//frame[not(motion_name)] | //bone",
    "(//frame)[3]/@id",
]
HEAVY = [
    "count(//*[count(//*) > 1])",
    "//frame[frame_bone[@Rx > 3 and ../frame_bone[@name = 'a'][@Ry > 1]]]",
    "//frame[mo:height('Head') > 1]",
    "//frame[@id = 1 to 90]",
    "count(//filename[matches(., 'walk')])",
    "//frame[following-sibling::frame]",
    "for $m in /mcml return count($m//frame)",
    "count(//frame[@id = (1, 2)])",
    "concat('a', 'b')",
    "//frame[",
    "$a",
    "'" + "x" * 400 + "'",
    "+".join(["1"] * 61),
]


@pytest.mark.parametrize("text", QUICK)
def test_simple_conditions_are_quick(text: str) -> None:
    assert is_quick(text)


@pytest.mark.parametrize("text", [*HEAVY, *BOMBS.values()])
def test_what_may_grow_is_not_quick(text: str) -> None:
    assert not is_quick(text)


@pytest.mark.parametrize("seed", range(20))
def test_hostile_expressions_that_are_quick_are_small(seed: int) -> None:
    chance = Random(seed)
    quick = [text for text in (hostile_expression(chance) for _ in range(100)) if is_quick(text)]
    assert not [text for text in quick if len(text) > 400 or "$" in text or text.count("//") > 2]
