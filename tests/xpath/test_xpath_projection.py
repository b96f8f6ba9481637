"""Projected documents give the same answers as whole ones."""

from __future__ import annotations

import math
from itertools import islice
from random import Random

import pytest

from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.reach import Projection, projection
from mcml_service.xpath.trees.evaluate import Found, Tree
from tests import fuzz
from tests.xpath.grammar import Grammar
from tests.xpath.small import DOCUMENT, answer, projected, tree


@pytest.mark.slow
@pytest.mark.parametrize("asked", fuzz.lengths(700, 10_000))
def test_projected_documents_give_the_same_answers(asked: int) -> None:
    random = Random(3)
    whole = tree()
    small = {level: projected(level) for level in Projection}
    used = dict.fromkeys(Projection, 0)
    for _, text in islice(Grammar(random, {"small": whole}).expressions(), asked):
        query = parse(text)
        try:
            expected = answer(whole, query.text)
        except Exception:  # libxml2 refuses a type that only shows while it runs
            continue
        level = projection(query.tree)
        used[level] += 1
        found = answer(small[level], query.text)
        both_nan = isinstance(found, float) and math.isnan(found) and math.isnan(expected)
        assert both_nan or found == expected, (text, level)
    assert min(used.values()) > asked / 15


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("//bone[@mapped='true']/name", Projection.HEAD),
        ("count(//frame)", Projection.FRAMES),
        ("count(//frame[motion_name='walk'])", Projection.FRAMES),
        ("//motion_name", Projection.FRAMES),
        ("//frame[2]/@id", Projection.FRAMES),
        ("//property[@name='age']/@value", Projection.HEAD),
        ("/mcml/motion/frametime", Projection.HEAD),
        ("string(/mcml)", Projection.FRAMES),
        ("//frame", Projection.WHOLE),
        ("/", Projection.WHOLE),
        ("count(//*)", Projection.WHOLE),
        ("count(//namespace::*)", Projection.WHOLE),
    ],
)
def test_levels(text: str, level: Projection) -> None:
    assert projection(parse(text).tree) is level


@pytest.mark.parametrize("text", ["/", "//..", "/.", "(/)[1]", "//frame | /", "//frame/ancestor-or-self::node()"])
def test_the_document_node_is_counted(text: str) -> None:
    found = Tree([DOCUMENT.encode()]).items(text, variables={}, offset=0, limit=1000)
    first = found.items[0]
    assert isinstance(first, Found)
    assert (first.kind, first.address) == ("document", "/")
    assert found.total == tree().xpath(f"count({text})")
