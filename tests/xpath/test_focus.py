"""The focus of an operand is not that of another: `.`, `@id` and `position()` mean the same in every place."""

from __future__ import annotations

from itertools import product

import pytest

from mcml.errors import QueryError
from mcml_service.xpath.trees.evaluate import Tree

DOCUMENT = b"""<mcml><skeleton><bone><name>waist</name><bone><name>neck</name></bone></bone>
<bone><name>leg</name></bone></skeleton>
<motion><frame id='1'><motion_name>walk</motion_name></frame><frame id='2'/></motion></mcml>"""
PATHS = ("//bone", "//bone[last()]", "(//bone/name)", "ancestor::*", "//bone except //bone[1]", "motion_name")
SHAPES = (
    "string-join({}, '-')", "count({})", "string(({})[1])", "head({} ! name())", "exists({})", "sort({} ! name())[1]",
)  # fmt: skip
OUTER = (
    "concat({a}, '|', {d})", "({a}, {d})", "(if ({a}) then {d} else {d})", "map{{'x': {a}, 'y': {d}}}?y",
    "array{{{a}, {d}}}?*", "(let $q := {a} return {d})", "(function($u, $v) {{ $v }})({a}, {d})", "({a} = {d})",
    "string({a}) || {d}", "({a} => string() => concat({d}))", "insert-before({a}, 1, {d})", "deep-equal({a}, {d})",
    "for-each-pair(({a})[1], {d}, function($x, $y) {{ $y }})", "apply(function($x, $y) {{ $y }}, [{a}, {d}])",
    "fold-left({a}, {d}, function($x, $y) {{ $x }})", "index-of(({a} ! string(.), {d}), {d})", "({d}, {a})",
    "subsequence(({d}, {a}), 1, 1)", "contains(string({a}), {d})", "substring({d}, 1, string-length(string({a})))",
)  # fmt: skip
OF_FOCUS = {
    "name(.)": "name($node)", "string(@id)": "string($node/@id)", "string(position())": "string($place)",
    "name(..)": "name($node/..)",
}  # fmt: skip


@pytest.fixture(scope="module")
def tree() -> Tree:
    return Tree([[DOCUMENT]])


def ask(tree: Tree, text: str, compatible: bool) -> list[object]:
    try:
        return list(tree.items(text, variables={}, offset=0, limit=99, compatible=compatible).items)
    except QueryError as error:
        return [error.what]


@pytest.mark.parametrize("compatible", [False, True])
@pytest.mark.parametrize("outer", OUTER)
def test_an_operand_after_another_has_the_focus_of_both(tree: Tree, outer: str, compatible: bool) -> None:
    answered = 0
    for path, shape, (own, bound) in product(PATHS, SHAPES, OF_FOCUS.items()):
        operand = shape.format(path)
        found = ask(tree, f"//frame/({outer.format(a=operand, d=own)})", compatible)
        wanted = ask(
            tree,
            f"for $place in 1 to 2, $node in (//frame)[$place] return $node/({outer.format(a=operand, d=bound)})",
            compatible,
        )
        assert found == wanted, (operand, own)
        answered += len(found) > 1
    assert answered


@pytest.mark.parametrize("function", ["fold-left", "fold-right", "array:fold-left", "array:fold-right"])
@pytest.mark.parametrize(("members", "zero"), [((), ()), ((), (5, 6)), ((1, 2), ()), ((1, 2), (5, 6)), ((1,), (5,))])
def test_folds_begin_with_any_sequence(
    tree: Tree, function: str, members: tuple[int, ...], zero: tuple[int, ...]
) -> None:
    given = ", ".join(map(str, members))
    given = f"[{given}]" if function.startswith("array") else f"({given})"
    start = ", ".join(map(str, zero))
    found = ask(tree, f"{function}({given}, ({start}), function($a, $b) {{ ($a, $b) }})", False)
    assert found == [*zero, *members] if function.endswith("left") else found == [*members, *zero]
