"""Projected documents give the same answers as whole ones, and hostile expressions end in time."""

from __future__ import annotations

import math
from itertools import islice
from random import Random

import pytest

from mcml.errors import LimitError, StoreError
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.reach import Projection, may_select_document, projection
from mcml_service.xpath.xml.evaluate import Evaluator, Nodes, Scalar
from tests.xpath.grammar import Grammar
from tests.xpath.small import DOCUMENT, answer, projected, tree


def test_projected_documents_give_the_same_answers() -> None:
    random = Random(3)
    whole = tree()
    small = {level: projected(level) for level in Projection}
    used = dict.fromkeys(Projection, 0)
    for _, text in islice(Grammar(random, {"small": whole}).expressions(), 3500):
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
    assert min(used.values()) > 300


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
    assert may_select_document(parse(text).tree)
    pool = Evaluator(processes=1)
    try:
        found = pool.evaluate(parse(text), [DOCUMENT.encode()])
    finally:
        pool.close()
    assert isinstance(found, Nodes)
    assert (found.items[0].kind, found.items[0].address) == ("document", "/")
    assert found.total == tree().xpath(f"count({text})")


MANY = "<mcml>" + "<frame/>" * 30_000 + "</mcml>"


@pytest.mark.parametrize(
    "text",
    [
        "count(//*[count(//*) > count(.//*)])",
        "//*[preceding::*[following::*[preceding::*]]][count(preceding::*) = 0]",
        "count(//frame[count(preceding-sibling::frame[count(following-sibling::frame) > 1]) > 1])",
    ],
)
@pytest.mark.timeout(60)
def test_expressions_that_take_too_long_are_ended(text: str) -> None:
    pool = Evaluator(seconds=1.0, processes=1)
    try:
        with pytest.raises(LimitError) as caught:
            pool.evaluate(parse(text), [MANY.encode()])
        assert caught.value.details["code"] == "query-timeout"
        assert pool.evaluate(parse("count(//frame)"), [MANY.encode()]) == Scalar(30_000.0)
    finally:
        pool.close()


def test_expressions_that_take_too_much_memory_are_ended() -> None:
    pool = Evaluator(memory_bytes=150 << 20, processes=1)
    pieces = [b"<mcml>", *[b"<frame><frame_bone name='a' Tx='1'/></frame>" * 1000] * 1000, b"</mcml>"]
    try:
        with pytest.raises(LimitError) as caught:
            pool.evaluate(parse("count(//frame)"), pieces)
        assert caught.value.details["code"] == "query-memory"
        assert pool.evaluate(parse("count(//frame)"), [MANY.encode()]) == Scalar(30_000.0)
    finally:
        pool.close()


def test_a_document_that_is_no_xml_is_the_store_s_fault() -> None:
    pool = Evaluator(processes=1)
    try:
        with pytest.raises(StoreError, match="not well-formed"):
            pool.evaluate(parse("1"), [b"<mcml>", b"<", b"</x>" * 100_000])
        assert pool.evaluate(parse("1 + 1"), [b"<mcml/>"]) == Scalar(2.0)
    finally:
        pool.close()
