"""Expressions that chance makes to hurt: patterns, numbers, values that double, depth, and loops in loops."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

PATHS = ("//frame", "//*", "//frame_bone", "//frame_bone/@Rx", "/mcml", "//bone", "(//frame, //frame_bone)")
NUMBERS = (
    "2147483647",
    "2147483648",
    "1e300",
    "99999999999999999999",
    "9007199254740993",
    "1 div 0",
    "-1e9",
    "1000000",
)


def hostile_expression(chance: Random) -> str:
    """One of them."""
    make = chance.choice(KINDS)
    return make(chance)[:10_000]


def _pattern(chance: Random) -> str:
    atom = chance.choice(("a", ".", r"\w", r"\p{L}", "[a-z]", "(a|aa)", "(a*)", "(a|b|ab)", r"[\s\S]"))
    for _ in range(chance.randint(1, 6)):
        bound = chance.choice(("+", "*", "{1,999}", "{1000}", "{2147483647}", "{0,100000}", "{3}{4}", "?", "{50}"))
        atom = f"({atom}{bound})" if chance.random() < 0.8 else f"{atom}{bound}{atom}"
    text = f"string-join(for $i in 1 to {chance.choice((10, 1000, 100000))} return 'a', '')"
    call = chance.choice(("matches({0}, '{1}')", "count(tokenize({0}, '{1}'))", "replace({0}, '{1}', 'aaaa')"))
    return call.format(chance.choice((text, "'aaaaaaaaaaaaaaaaaaaaaaaaaaaaa!'", "//frame/@id")), atom)


def _grown(chance: Random) -> str:
    first = chance.choice(("//frame", "'abcdefghij'", "1", "(1 to 1000)", "//@*", "'a'"))
    by = chance.choice(
        (
            *("($a, $a)", "concat($a[1], $a[1])", "string-join(($a, $a), ',')", "replace(string($a[1]), 'a', 'aaaa')"),
            *("($a, $a, $a)", "for $i in $a return ($i, $i)", "($a ! (., .))", "concat(string($a[1]), $a[1], $a[1])"),
        )
    )
    end = chance.choice(("count($a)", "string-length(string($a[1]))", "$a", "sum($a)", "distinct-values($a)"))
    return f"let $a := {first} return " + f"let $a := {by} return " * chance.randint(5, 60) + end


def _number(chance: Random) -> str:
    one, other = chance.choice(NUMBERS), chance.choice(NUMBERS)
    shapes = (
        *("count({0} to {1})", "sum(1 to {0})", "reverse(1 to {0})[1]", "//frame[{0}]", "//frame[@id = ({0}, {1})]"),
        *(
            "subsequence(//frame, {0}, {1})",
            "substring('abc', {0}, {1})",
            "mo:top({0}, //frame)",
            "(1 to {0})[. = {1}]",
        ),
        *("mo:runs(//frame, {0}, {1})", "count(//frame[mo:window({0}, {1})])", "sort(1 to {0})[1]"),
        *("distinct-values(1 to {0})", "string-join(1 to {0}, ',')", "index-of(1 to {0}, {1})", "{0} idiv {1}"),
        "avg(for $i in 1 to {0} return $i * $i)",
    )
    return chance.choice(shapes).format(one, other)


def _deep(chance: Random) -> str:
    depth = chance.randint(10, 400)
    shapes: tuple[Callable[[], str], ...] = (
        lambda: "(" * depth + "1" + ")" * depth,
        lambda: "//frame[" * depth + "1" + "]" * depth,
        lambda: "not(" * depth + "//frame" + ")" * depth,
        lambda: "-" * depth + "1",
        lambda: "//*" * min(depth, 150),
        lambda: "count(" * depth + "//frame" + ")" * depth,
        lambda: "if (//frame) then " * depth + "1" + " else 2" * depth,
        lambda: "for $i in //frame return " * min(depth, 80) + "$i",
        lambda: "//frame/following-sibling::*" * 1 + "/preceding::*/following::*" * min(depth, 30),
        lambda: " or ".join(["//frame[@id = 1]"] * depth),
        lambda: "1" + "+1" * 10 * depth,
        lambda: "|".join([chance.choice(PATHS)] * depth),
    )
    return chance.choice(shapes)()


def _loops(chance: Random) -> str:
    names = "abcdef"[: chance.randint(2, 5)]
    sources = [chance.choice((*PATHS, "1 to 5000", "1 to 100000")) for _ in names]
    loops = " ".join(f"for ${name} in {source} return" for name, source in zip(names, sources, strict=True))
    body = chance.choice(("1", "concat($a, $b)", "$a", "($a, $b)", "$a | $b", "//frame[@id = $a]", "string($b)"))
    around = chance.choice(("count({0})", "{0}", "string-join({0}, ',')", "distinct-values({0})", "sum({0})"))
    return around.format(f"{loops} {body}")


def _selected(chance: Random) -> str:
    text = chance.choice(PATHS)
    for _ in range(chance.randint(1, 4)):
        inner = chance.choice(PATHS)
        predicate = chance.choice(
            ("count({0}) > 1", "{0} = {0}", "{0} != {0}", ". << {0}", "some $x in {0} satisfies $x = .", "{0}[{0}]")
        )
        text = f"{text}[{predicate.format(inner)}]"
    end = chance.choice(("count({0})", "{0}", "({0})[last()]", "sort({0})", "{0} => reverse()", "xs:double(({0})[1])"))
    return end.format(text)


KINDS = (_pattern, _grown, _number, _deep, _loops, _selected)
