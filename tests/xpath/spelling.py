"""Parts of expressions that are about no node: positions, and the white space between tokens."""

from __future__ import annotations

from itertools import pairwise
from random import Random

from mcml_service.xpath.language.tokens import Token, tokens

BEYOND = (
    "99999999999999999999", "1000000000000", "-1", "0", "-0", "0.5", "1.5", "1 div 0", "-1 div 0", "0 div 0",
    "position() = 99999999999999999999", "position() < 1000000000000", "position() > -1000000000000",
    "position() != -1", "last() + 1", "position() <= 9223372036854775808", "last() - 1e18", "2147483648",
)  # fmt: skip
"""Positions that no list has, or all lists."""


def position_test(random: Random) -> str:
    """A condition on the position that some node of most lists meets."""
    number = random.choice([1, 1, 1, 2, 3, 5, 10])
    if random.random() < 0.06:
        return random.choice(BEYOND)
    return random.choice([
        "1", str(number), "last()", f"position() <= {number}", f"position() mod {number + 1} = 1",
        "position()=last()", f"position() >= {number} and position() <= {number + 5}", f"last() - {number - 1}",
        f"position() < {number + 1}", f"not(position() > {number})", f"round(last() div {number})",
        f"ceiling(last() * 0.{number})", "floor(last() div 2) + 1",
    ])  # fmt: skip


def nested(random: Random, condition: str) -> str:
    """The condition in predicates of predicates."""
    depth = random.choice([2, 3, 8, 20])
    return "self::node()[" * depth + condition + "]" * depth


def without_space(text: str) -> str:
    """The expression with the white space alone that it cannot do without."""
    parts = tokens(text)
    result = ""
    for before, token in pairwise([Token("end", "", 0, 0), *parts]):
        grows = before.kind == "name" and token.text[:1] not in "<>=!+*/|()[],@$'\":"
        grows |= before.kind == "number" and (token.kind == "number" or token.text[:1] in (".", "e", "E"))
        result += " " * (grows and token.kind != "end") + token.text
    return result
