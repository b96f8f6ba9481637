"""Expressions with arguments that nobody expects: each is answered, or refused in words."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from contextlib import suppress
from random import Random

import pytest

from mcml.errors import McmlError, QueryError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, one_kind, store

ODD = [
    *("''", "()", "'a'", "0", "-1", "1.5", "1 div 0", "0 div 0", "2147483648", "1e308", "9223372036854775808"),
    *("//frame", "//frame/@id", "//nothing", "@id", ".", "(1,2)", "('a','b')", "(1,'a')", "(//frame[1], 3)", "true()"),
    *("'2147483648'", "1 to 3", "//frame_bone/@Rx", "string(@id)", "'\U0001f600'", "1 to 2147483648"),
]
SHAPES = [
    *("//frame[@id = ({0}, {1})]", "//frame[position() = ({0}, {1})]", "({0}, {1})[. > {0}]", "(//frame)[{0}]"),
    *("//frame[{0}][{1}]", "subsequence(//frame, {0}, {1})", "//frame[@id = {0} to {1}]", "count({0} to {1})"),
    *("({0} to {1})[2]", "substring('abc', {0}, {1})", "mo:runs(//frame, {0}, {1})", "//frame[mo:window({0}, {1})]"),
    *("for $x at $i in ({0}, {1}) order by {0} return $x", "for $x in {0}, $y in {1} group by $k := $x return $k"),
    *("for $x in {0} count $n where $n = {1} return $n", "for $x in {0}, $y in {1} stable order by $y, $x return $x"),
    *("(//frame)[position() = {0}]", "array{{({0}, {1})}}?*", "fold-left(({0}, {1}), {0}, concat#2)"),
    *("for $x allowing empty in {0} return count(({1}, $x))", "//bone except head(({0}, {1}))"),
    *("mo:top({0}, //frame)", "{0} idiv {1}", "for $i in ({0}, {1}) return //frame[$i]", "{0} to {1} to {0}"),
]


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    store(database, {"a.bvh": bvh(5), "empty.bvh": bvh(0)})
    queries = Queries(database, Settings(cache_dir="none"))
    yield queries
    queries.close()


def ask(engine: Queries, text: str) -> None:
    with suppress(McmlError):
        engine.answer(QueryRequest(q=text, limit=3))


@pytest.mark.slow
@one_kind
def test_every_function_takes_or_refuses_what_is_odd(engine: Queries) -> None:
    chance = Random(5)
    for name, signature in SAFE_FUNCTIONS.items():
        for count in range(4):
            if signature.takes(count):
                for arguments in chance.sample(list(itertools.product(ODD[:25], repeat=count)), min(4, 25**count)):
                    call = f"{name}({', '.join(arguments)})"
                    for text in (call, f"//frame[{call}]"):
                        ask(engine, text)


@one_kind
@pytest.mark.parametrize("shape", SHAPES)
def test_numbers_of_any_size(engine: Queries, shape: str) -> None:
    numbers = ["-1", "0", "3", "2147483648", "-2147483649", "9007199254740993", "9223372036854775808", "1e300"]
    for pair in itertools.product(numbers, repeat=2):
        ask(engine, shape.format(*pair))


@one_kind
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("count(1 to 2000000000)", 2000000000),
        ("count(1 to 30)", 30),
        ("substring-before('abc', '')", ""),
        ("substring-before('abc', ())", ""),
        ("substring-after('abc', '')", "abc"),
        ("count(//*:frame)", 5),
        ("count(//Q{}frame/@Q{}id)", 5),
        ("count(//*:frame[1]/Q{}*)", 3),
        ("count(//frame[math:sqrt(number(@id)) > 1][xs:double(@id) > 1])", 4),
        ("let $a := 3 return xs:double($a) + 1", 4),
        ("count(//frame ! xs:double(@id))", 5),
        ("'a' || xs:string(3)", "a3"),
        ("count(//*:frame[xs:double(@*:id) > 3])", 2),
    ],
)
def test_values(engine: Queries, text: str, value: object) -> None:
    assert engine.answer(QueryRequest(q=text)).value == value


@pytest.mark.parametrize(
    "text",
    [
        *("//Q{x}frame", "1 to 2 to 3", "'x' => doc()", "doc('x') + xs:double(1)", "doc#1('x')"),
        "Q{http://www.w3.org/2005/xpath-functions}doc('x') or xs:boolean(1)",
        "sort(//frame, (), function($f) { doc('x') + xs:double($f/@id) })",
        "for $f in (function() { doc('x') }) return xs:double($f())",
        "map { 'a': doc('x') }('a') + xs:double(1)",
        "array { doc('x') }(1) + xs:double(1)",
        "xs:double(1) => (function($a) { doc('x') })()",
    ],
)
def test_refused(text: str) -> None:
    with pytest.raises(QueryError):
        parse(text)


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("for m in /mcml return $m", "begin with \\$"),
        ("for $m in /mcml order $m return $m", "order by"),
        ("for $m in /mcml sort by $m return $m", "order by"),
        ("for $m in /mcml group by $m/header/filename return count($m)", "group by \\$k :="),
        ("for $x as xs:string in ('a', 'b') return $x", "no types"),
        ("for tumbling window $w in //frame start when true() return $w", "Windows are not supported"),
        ("for $m in /mcml order by $m/header/filename desc return $m", "descending"),
        ("for $m in /mcml order by count($m//frame)", "End the loop with return"),
        ("let $x = 5 return $x", "let \\$n :="),
        ("for $m in /mcml count n return n", "begin with \\$"),
        ("select count(//frame) from /mcml", "not SQL"),
    ],
)
def test_mistakes_in_loops_have_a_remedy(text: str, remedy: str) -> None:
    with pytest.raises(QueryError) as caught:
        parse(text)
    assert re.search(remedy, str(caught.value.remedy))
