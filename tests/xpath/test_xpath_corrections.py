"""What elementpath gets wrong and is corrected, on trees alone: each pair of values by each operator, against Saxon."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import pytest
from saxonche import PySaxonApiError, PySaxonProcessor

from mcml.errors import QueryError
from mcml_service.xpath.trees.evaluate import Found, Tree
from tests.xpath.oracle import same_value
from tests.xpath.saxon import evaluate
from tests.xpath.small import DOCUMENT, tree

OPERATORS = ("+", "-", "*", "div", "mod", "idiv")
NUMBERS = ("3", "-7", "2.5", "-2.5", "0", "1e0", "-0e0", "7.0", "xs:double('INF')", "xs:double('NaN')")
NODES = ("//@Tx[. = '1.5']", "//@Rx[. = '-3.25']", "//filename", "(//frames)[1]")
OTHERS = ("'4'", "'x'", "true()", "xs:date('2020-01-02')", "xs:yearMonthDuration('P1Y')", "xs:anyURI('3')", "(5, 6)")
NOTHING = ("()", "//nothing")
DURATIONS = ("xs:yearMonthDuration('P1Y')",)

COLLATION = "http://www.w3.org/2005/xpath-functions/collation/html-ascii-case-insensitive"
EXPRESSIONS = [
    "sort(//frame_bone/@*)", "head(sort(//frame/following::node()/@*))", "sort((3, 1, number('x'), 2.5e0))",
    "sort(//frame_bone/@Rx, (), function($x) {number($x)})", "sort(//frame_bone/@Rx, (), function($x) {-$x})",
    "sort(//bone, (), function($bone) {($bone/name, 2)})", f"sort(//bone/name, '{COLLATION}')",
    "sort((xs:date('2020-02-01'), xs:date('2020-01-01')))", "sort((true(), false()))", "sort(//frame/count(*))",
    "sort((//frame_bone/@name, 'hips', 'Tail'))",
    "distinct-values((//frame_bone/@Rx, 3, 10.0, //frame_bone/number(@Rx)))",
    f"distinct-values(('a', 'A', //name/string()), '{COLLATION}')",
    "//node()[lang('en')]", "(//@*[lang('en')], 2)", "(//comment)[lang('')]",
    "//bone[(ancestor::node() + (count(descendant::text()) * 2) + 10) != 2]/name", "//frame[1]/node() * 2",
    "//frame/node() instance of node()*", "(//frame[1]/node()) instance of node()+", "(//x) instance of node()?",
    "(function($x as node()*) as item()* {count($x)})(//frame)", "//name[. instance of node()]",
    "(//bone/node()) ! (. treat as node())/string(.)", "[1, 2] instance of array(item()*)",
    "//frame[motion_name != false()]", "//frame[motion_name = true()]", "//frame[nothing = false()]",
    "//frame[false() < motion_name]", "//frame[(nothing, frame_bone) != false()]",
    "(abs(()), abs(//nothing), ceiling(()), floor(//nothing), round(()))",
]  # fmt: skip


@pytest.fixture(scope="module")
def processor() -> PySaxonProcessor:
    return PySaxonProcessor(license=False)


@pytest.fixture(scope="module")
def document() -> Tree:
    return Tree([[DOCUMENT.encode()]])


def wanted(processor: Any, text: str, *, compatible: bool) -> list[Any] | None:
    """Saxon's items, nodes by their addresses; None where it refuses."""
    try:
        items = evaluate(processor, tree().getroot(), text, {}, 1000, 0, compatible=compatible)["items"]
    except PySaxonApiError:
        return None
    return [item[2] if item[0] == "node" else item[1] for item in items]


def found(document: Tree, text: str, *, compatible: bool) -> list[Any] | None:
    """Our items in the same form; None where they are refused."""
    try:
        items = document.items(text, variables={}, offset=0, limit=1000, compatible=compatible).items
    except QueryError:
        return None
    return [item.address if isinstance(item, Found) else _spelled(item) for item in items]


def _spelled(value: Any) -> Any:
    """Numbers without digits as the wire has them."""
    if not isinstance(value, float) or math.isfinite(value):
        return value
    return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"


def assert_same(processor: Any, document: Tree, text: str, *, compatible: bool) -> None:
    expected, got = (
        wanted(processor, text, compatible=compatible),
        found(document, text, compatible=compatible),
    )
    assert (got is None) == (expected is None), f"{text}: {got} instead of {expected}"
    if got is None or expected is None:
        return
    assert len(got) == len(expected), f"{text}: {got} instead of {expected}"
    for one, other in zip(got, expected, strict=True):
        same_value(one, other, text)


@pytest.mark.parametrize("compatible", [True, False])
@pytest.mark.parametrize("operator", OPERATORS)
def test_operands_of_each_type(processor: Any, document: Tree, operator: str, compatible: bool) -> None:
    for one, other in product((*NUMBERS, *NODES, *OTHERS), repeat=2):
        if one in DURATIONS and operator == "div":
            continue  # Saxon divides by doubles and keeps their last digits.
        assert_same(processor, document, f"({one}) {operator} ({other})", compatible=compatible)


@pytest.mark.parametrize("operator", OPERATORS)
def test_nothing_is_no_number_in_the_compatible_mode_and_else_nothing(document: Tree, operator: str) -> None:
    """XPath 3.1 §3.5; Saxon raises errors for some of these, others it decides before it knows their values."""
    for nothing, other in product(NOTHING, (*NUMBERS, *NODES, *DURATIONS)):
        for text in (f"({nothing}) {operator} ({other})", f"({other}) {operator} ({nothing})"):
            assert found(document, text, compatible=True) == ["NaN"], text
            if other != "//filename":
                assert found(document, text, compatible=False) == [], text


@pytest.mark.parametrize("compatible", [True, False])
def test_signs(processor: Any, document: Tree, compatible: bool) -> None:
    for sign, value in product("+-", (*NUMBERS, *NODES, "'4'", "'x'", "true()", "(5, 6)", *NOTHING)):
        assert_same(processor, document, f"{sign}({value})", compatible=compatible)


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_expressions(processor: Any, document: Tree, text: str) -> None:
    assert wanted(processor, text, compatible=True) is not None
    assert_same(processor, document, text, compatible=True)


@pytest.mark.parametrize("text", ["sort(('a', 1))", "//frame[(1, 2) = true()]", "sort((1, true()))", "-xs:anyURI('3')"])
def test_refusals(document: Tree, text: str) -> None:
    assert found(document, text, compatible=True) is None


def test_an_end_of_a_range_may_be_the_double_that_compatible_arithmetic_gives(document: Tree) -> None:
    assert found(document, "1 to 2 + 1", compatible=True) == [1, 2, 3]
    assert found(document, "1 to 2 + 1", compatible=False) == [1, 2, 3]
    assert found(document, "1 to 2.5", compatible=True) is None
