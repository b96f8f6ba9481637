"""Projected documents give the same answers as whole ones."""

from __future__ import annotations

import math
from itertools import islice
from random import Random

import pytest
from lxml import etree

from mcml.errors import QueryError
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.reach import Projection, projection
from mcml_service.xpath.language.xpath31.written import find_projection, spell_for_elementpath
from mcml_service.xpath.trees.evaluate import Found, Tree
from tests import fuzz
from tests.xpath.grammar import Grammar
from tests.xpath.small import DOCUMENT, answer, projected, tree
from tests.xpath.xpath2_grammar import Xpath2Grammar


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


@pytest.mark.slow
@pytest.mark.parametrize("asked", fuzz.lengths(700, 10_000))
def test_projected_documents_give_the_same_answers_to_tokens(asked: int) -> None:
    """Of XPath 3.1 as it is written: generated expressions, alone and as parts of others."""
    random = Random(4)
    documents = {level: Tree([[etree.tostring(projected(level))]]) for level in Projection}
    used = dict.fromkeys(Projection, 0)
    expressions = [kind(random, {"small": tree()}).expressions() for kind in (Grammar, Xpath2Grammar)]
    for _ in range(asked):
        _, inner = next(random.choice(expressions))
        text = random.choice(WRITTEN).replace("@@", spell_for_elementpath(inner))
        try:
            expected = _items(documents[Projection.WHOLE], text)
            level = find_projection(text, compatible=True)
        except QueryError:
            continue
        used[level] += 1
        assert _items(documents[level], text) == expected, (text, level)
    assert min(used.values()) > asked / 30


def _items(document: Tree, text: str) -> list[str]:
    return [repr(item) for item in document.items(text, variables={}, offset=0, limit=1000).items]


WRITTEN = [
    "@@", "count(@@)", "xs:string(@@)", "for $v in (@@) order by string($v) return $v", "array{@@}?*",
    "(@@) ! string(.)", "let $v := (@@) return $v[1]", "map{'a': (@@)}?a",
    "sort((@@), (), function($v) { -count($v) })",
    "for $v in (@@) group by $k := string($v) return concat($k, count($v))", "deep-equal((@@), (@@))",
    "fold-left((@@), '', function($a, $v) { concat($a, $v) })", "for $v at $i in (@@) count $n return $i + $n",
    "(@@) => count()", "exists((@@)[. instance of element()])", "for-each((@@), string#1)", "(//frame, @@)[1]/@id",
    "some $v in (@@) satisfies $v is (//frame)[1]", "let $f := function($x) { $x } return $f((@@))", "(@@) ! name()",
]  # fmt: skip
"""Expressions around others."""


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
    found = Tree([[DOCUMENT.encode()]]).items(text, variables={}, offset=0, limit=1000)
    first = found.items[0]
    assert isinstance(first, Found)
    assert (first.kind, first.address) == ("document", "/")
    assert found.total == tree().xpath(f"count({text})")
