"""Text to tree: equivalent spellings, errors with columns and hints, limits."""

from __future__ import annotations

import sys
from types import FrameType

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcml.errors import LimitError, QueryError
from mcml_service.xpath.engine.scan_plan import plan_scan
from mcml_service.xpath.engine.starts import start_of
from mcml_service.xpath.language.functions import FUNCTIONS
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.rules import normal
from mcml_service.xpath.language.tree import Operation, Path, Step, Written, walk
from mcml_service.xpath.language.types import type_of


def test_abbreviations_are_written_out() -> None:
    tree = parse("//a/@b/..").tree
    assert isinstance(tree, Path)
    assert tree.absolute
    assert [(step.axis, step.name) for step in tree.steps] == [
        ("descendant-or-self", "node()"),
        ("child", "a"),
        ("attribute", "b"),
        ("parent", "node()"),
    ]


def test_parentheses_and_predicates() -> None:
    assert parse("((//a))").tree.__class__ is Path
    tree = parse("(//a)[1]/b[2][c]").tree
    assert isinstance(tree, Path)
    assert tree.start is not None
    assert len(tree.steps[0].predicates) == 2
    assert isinstance(tree.steps[0], Step)


def test_operators_that_associate_are_one_node() -> None:
    tree = parse("+".join("1" * 3000)).tree
    assert isinstance(tree, Operation)
    assert len(tree.operands) == 3000
    assert sum(1 for _ in walk(tree)) == 3001


@pytest.mark.parametrize(
    ("text", "column", "hint"),
    [
        ("//frame[", 8, "do not match"),
        ("//frame[motion_name='X'", 21, "do not match"),
        ("foo(1)", 1, "Did you mean"),
        ("a == b", 4, "single ="),
        ("//x:frame", 4, "no namespaces"),
        ("for $x in a return foo(1)", 20, "Did you mean"),
        ("for $x in a return $y", 20, "bind it"),
        ("for $x in a", 11, ""),
        ("matches('a', doc('b'))", 14, "docs/xpath.md"),
        ("for $x in y:a return 1", 12, "no namespaces"),
        ("$x", 1, "in the request"),
        ("sort(//bone/name, function($n) { $n })", 19, "third argument"),
        ("math:squrt(2)", 6, "math:sqrt"),
        ("'abc", 1, "not closed"),
        ("a && b", 3, "`and`"),
        ("count('x')", 7, "Use a path"),
        ("1[2]", 1, "Use a path"),
        ("a | 'x'", 5, "Use a path"),
        ("\n\n//frame]", 10, "do not match"),
        ("a\x00", 2, ""),
        ("", 1, ""),
    ],
)
def test_errors_have_a_column_and_a_hint(text: str, column: int, hint: str) -> None:
    with pytest.raises(QueryError) as caught:
        parse(text)
    assert caught.value.at is not None
    assert caught.value.at.column == column
    assert hint in (caught.value.remedy or "")


HOSTILE = [
    "(" * 5000 + ")" * 4000,
    "a[" * 4000,
    "-" * 9000 + "1",
    "- " * 4000 + "1",
    "1" + "+1-1" * 2000,
    "a" * 10_001,
    "a" + "/a" * 4999,
    "//*" * 3000,
    "not(" * 2000,
    "'" + "x" * 9998 + "'",
    "a or " * 1900 + "a",
    "1=1" + "=1!=1" * 1500,
    "[" * 9999,
    "9" * 9999,
    "1" + "0" * 400,
    "0." + "3" * 5000,
    '"' * 9999,
    "//frame" + "[frame_bone" * 60 + "]" * 60,
    "a" + "[b[c]/d" * 50 + "]" * 50,
    "not(" * 90 + "a" + ")" * 90,
    "(" * 100 + "a" + ")" * 100 + "[1]" * 3000,
    "a[1 = " * 90 + "1" + "]" * 90,
    "for $x in a[" + "b[" * 90 + "1" + "]" * 91 + " return $x",
]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_texts_take_steps_by_their_length(text: str) -> None:
    """Calls are counted, not seconds: the same on every machine."""
    calls = 0

    def count(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    sys.setprofile(count)
    try:
        tree = parse(text).tree
        start_of(normal(tree))
        type_of(tree)
    except (QueryError, LimitError):
        pass
    finally:
        sys.setprofile(None)
    assert calls < 100 * len(text)


@given(st.text(alphabet="/@[]()|*.:='\"$-+<>!,ab1 \n", max_size=40))
def test_any_text_is_parsed_or_refused(text: str) -> None:
    try:
        query = parse(text)
    except (QueryError, LimitError):
        return
    plan_scan(normal(query.tree))
    assert parse(query.text).text == query.text


@pytest.mark.parametrize(
    ("text", "stored"),
    [
        ("//frame[motion_name='left-arm-front']", "//frame[motion_name='left-arm-flexion']"),
        ('count(//motion_name[. = "left-arm_abduction"])', 'count(//motion_name[. = "left-arm-abduction"])'),
        ("//frame['back-bend'=motion_name/text()]", "//frame['trunk-flexion'=motion_name/text()]"),
    ],
)
def test_synonyms_are_asked_in_the_form_in_which_they_are_stored(text: str, stored: str) -> None:
    query = parse(text)
    assert query.text == parse(stored).text
    assert len(query.warnings) == 1
    assert "is stored as" in query.warnings[0]


@pytest.mark.parametrize(
    "text", ["//frame[motion_name='walk']", "//bone[name='left-arm-front']", "//frame[@id='back-bend']"]
)
def test_other_texts_stay(text: str) -> None:
    literal = text.split("'")[1]
    assert f"'{literal}'" in parse(text).text
    assert parse(text).warnings == ()


def test_impossible_names_are_asked_with_a_warning() -> None:
    (warning,) = parse("//frame[motion_name='left-shoulder-abduction']").warnings
    assert "left-arm-abduction" in warning


@pytest.mark.parametrize(
    ("text", "type"),
    [
        ("//a", "nodes"), ("a|b", "nodes"), ("(a)[1]", "nodes"), ("id('x')", "nodes"), ("1", "number"),
        ("-a", "number"), ("count(a)", "number"), ("a+1", "number"), ("'x'", "string"), ("name()", "string"),
        ("a=b", "boolean"), ("not(a)", "boolean"), ("a and b", "boolean"), ("contains('a', 'b')", "boolean"),
    ],
)  # fmt: skip
def test_types(text: str, type: str) -> None:
    assert type_of(parse(text).tree) == type


@pytest.mark.parametrize(
    ("text", "rooted"),
    [
        ("mcml/motion", "/mcml/motion"),
        (".", "/."),
        ("..", "/.."),
        ("@id", "/@id"),
        ("*[a]/b", "/*[a]/b"),
        ("child::mcml", "/child::mcml"),
        ("count( mcml [1] )", "count( /mcml [1] )"),
        ("(mcml | //frame)[last()]", "(/mcml | //frame)[last()]"),
        ("(mcml)[1]/motion", "(/mcml)[1]/motion"),
        ("mcml * mcml", "/mcml * /mcml"),
        ("string( )", "string(/ )"),
        ("//frame[string()]", "//frame[string()]"),
        ("- name()", "- name(/)"),
    ],
)
def test_paths_start_at_the_document(text: str, rooted: str) -> None:
    assert parse(text).text == parse(rooted).text


def test_a_minus_sign_binds_less_tightly_than_a_union() -> None:
    tree = parse("- //a | //b").tree
    assert isinstance(tree, Operation)
    assert tree.operator == "negate"
    assert type_of(tree) == "number"


@pytest.mark.parametrize(
    "text",
    ["for $x in //a return 1", "let $x := 1 return $x", "some $x in //a satisfies $x > 1", "every $x in . satisfies $x",
     "if (//a) then //b else ()", "(1, 'a', //b)", "()", "1 to 3", "//a[@id = 1 to 3]", "'a' || 'b'", "//a ! string(.)",
     "//a/string(b)", "//a/(b | c)/@d", "//a except //b intersect //c", "//a[@b eq 'c']", "7 idiv 2", "-(//a | //b)",
     "sort(//a, (), function($x) { $x/@b })", "math:sqrt(2)", "(//a, //b)[2]/c", "(1 to 3)[. > 1]", "$n + 1",
     "for $x in //a, $y in $x/b return ($x, $y)", "(for $x in //a return $x/b)/c", "(1, 2) ! (. + 1)", "1 = (2, 3)"],
)  # fmt: skip
def test_what_came_after_1_0_has_a_tree_that_is_written_out_as_it_was(text: str) -> None:
    query = parse(text, {"n": 1.0})
    assert parse(query.text).tree == query.tree
    assert query.is_later or text == "$n + 1" or text.startswith("-")
    assert not any(isinstance(part, Written) for part in walk(query.tree))


@pytest.mark.parametrize(
    "text", ["a/xs:double(.)", "a is b", "a << b", "1 instance of xs:integer", "'1' cast as xs:integer", "a/element()"]
)
def test_what_has_no_columns_is_kept_as_it_is_written(text: str) -> None:
    query = parse(text)
    assert isinstance(query.tree, Written)
    assert query.text == text
    assert query.is_later


def test_an_arrow_is_a_call() -> None:
    assert (
        parse("//bone/name => string-join('-') => upper-case()").tree
        == parse("upper-case(string-join(//bone/name, '-'))").tree
    )


def test_comparisons_associate_from_the_left() -> None:
    tree = parse("1 = 2 != 3").tree
    assert isinstance(tree, Operation)
    assert tree == parse("(1 = 2) != 3").tree
    assert tree != parse("1 = (2 != 3)").tree


LATER_ARITIES = {
    ("data", 0), *((name, 2) for name in ("distinct-values", "id", "lang", "max", "min", "round", "sum")),
    *((name, 3) for name in
      ("contains", "ends-with", "index-of", "starts-with", "substring-after", "substring-before", "compare")),
}  # fmt: skip
"""What has no columns with so many arguments, and is XPath 3.1."""


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS) - set(MOTION_FUNCTIONS)))
@pytest.mark.parametrize("count", range(5))
def test_calls_with_a_wrong_number_of_arguments_are_refused(name: str, count: int) -> None:
    """As libxml2 refuses them, where it has the function."""
    signature = FUNCTIONS[name]
    arguments = ["'left-knee-flexion'" if name == "mo:angle" else "'a'", *["1"] * 4]
    if signature.takes_items or signature.of_node:
        arguments[signature.place] = "//a"
    text = f"{name}({', '.join(arguments[:count])})"
    if not signature.is_later and name not in MOTION_FUNCTIONS:
        try:
            etree.fromstring("<a/>").xpath(f"//a[{text}]")
        except etree.XPathEvalError:
            assert not signature.takes(count)
        else:
            assert signature.takes(count)
    if signature.takes(count):
        parse(text)
        return
    if (name, count) in LATER_ARITIES:
        assert isinstance(parse(text).tree, Written)
        return
    for whole in (text, f"//frame[@id < 3]/a[{text}]"):
        with pytest.raises(QueryError, match=r"takes .* given") as caught:
            parse(whole)
        assert caught.value.at is not None
        assert caught.value.at.column == whole.index(f"{name}(") + 1
    with pytest.raises(QueryError, match=r"argument|comma"):
        parse(f"for $x in //frame return {text}")


LIBXML2 = """node() + 1|node()*2|text() = 'a'|a + .|a * .|a[node()+.]|* + *|a -b|a-b|a mod b|mod mod mod|and and and|div
@div div @mod|a[1]/..|/.|/*|/ = 'a'|(/) = a|-(-1)|--1|1--1|a[.5]|5. + .5|child :: a|a//.|a//..|.//.|lang('en')|true()
id('a')/b[1]|(a)/c|text()[1]|a[last()-1]|child::mod/and|a/div|1 div 2 div 3|@*|ancestor::node()[1]|a or(b)|1 div(2)
a[b]and c|'a'='b'or'c'|if|for|a/if|@for|some|to|union|item|element|map|every|a/element/item|a[-1]|- a = 1|- a/b
@node()|//a[@ node()=1]|1 = 1 = 1|3 > 2 > 1|//frame[@id > 3 = true()]|1div 2|//a[@id=1and @id<5]|1 != 2 = (3 = 4)
1=1 or 2=2 and 3<4<5|//a[b]/c[d]or e|2*-3|--a|//a[.='x'][..]|'a'='b'='c'|a[b=c=d]|processing-instruction('a b')
""".replace("\n", "|").split("|")[:-1]


@pytest.mark.parametrize("text", LIBXML2)
def test_whatever_libxml2_takes_is_parsed(text: str) -> None:
    assert etree.XPath(parse(text).text)


@pytest.mark.parametrize("name", MOTION_FUNCTIONS)
@pytest.mark.parametrize("count", range(5))
def test_functions_of_bodies_with_a_wrong_number_of_arguments_are_refused(name: str, count: int) -> None:
    if FUNCTIONS[name].takes(count):
        return
    with pytest.raises(QueryError, match=r"takes .* given") as caught:
        parse(f"//frame[{name}({', '.join(['1'] * count)}) = 1]")
    assert caught.value.at is not None
    assert caught.value.at.column == 9
