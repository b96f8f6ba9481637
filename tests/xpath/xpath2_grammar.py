"""Seeded expressions of XPath 2.0 about nodes that exist: what version 1.0 has, and around it what came later."""

from __future__ import annotations

from collections.abc import Iterator

from elementpath.tdop import Parser
from elementpath.xpath31 import XPath31Parser

from mcml_service.xpath.language.xpath31.written import spell_for_elementpath
from tests.xpath.grammar import Grammar
from tests.xpath.on_frames import CHANNELS, later_of_frame_bones
from tests.xpath.witness import Witness, element

LATER_FUNCTIONS = (
    "distinct-values", "min", "max", "avg", "abs", "round", "floor", "ceiling", "string-join", "matches", "replace",
    "lower-case", "upper-case", "ends-with", "exists", "empty", "index-of", "sort", "tokenize",
)  # fmt: skip
LATER_OPERATORS = (
    "to", "for", "some", "every", "if", "eq", "ne", "lt", "le", "gt", "ge", "=", "!=", "<", "<=", ">", ">=", ",",
    "union", "intersect", "except", "let", "!", "||",
)  # fmt: skip
LATEST = {
    "let": (
        "let $a := {p} return count($a)",
        "let $a := {p} return ($a[1], count($a))",
        "let $n := count({p}) return 2 * $n",
        "let $n := count({p}) return //frame[position() = $n]",
        "for $x in {p} return let $c := count($x/@*) return $c * 2",
        "//frame[let $n := count(frame_bone) return $n > 1]/@id",
        "let $a := {p}, $b := {q} return count($a | $b)",
        "let $t := {k} return //frame[motion_name = $t or @id = $t]",
        "let $a := {p}/@* return //*[@* = $a]",
    ),
    "!": (
        "{p} ! name(.)",
        "({p}) ! (position() * 2)",
        "({p}, {q}) ! string(.)",
        "count({p} ! @*)",
        "(1 to 4) ! (. * 2)[. > 3]",
        "{p} ! (@* | *)",
        "(for $x in {p} return $x/..) ! name(.)",
        "{p}/string-join(@*, '-')",
        "{p}/(@* | *)",
        "distinct-values({p}/count(*))",
        "({p} ! string(.))[. = {k}]",
        "{p}/count(preceding-sibling::*) => sum()",
    ),
    "||": (
        "name(({p})[1]) || '-' || count({q})",
        "{k} || {k}",
        "//bone[name || 'x' = {k} || 'x']/name",
        "({p} ! (name(.) || '.'))[2]",
        "for $x in {p}, $i in 1 to 2 return name($x) || $i",
        "'' || count({p}) div 2",
        "'' || max((1, count({p})))",
    ),
    "sort": (
        "sort({p}/name())",
        "sort({p}, (), function($x) {{ count($x/*) }})",
        "sort({p}/@*)[position() < 4]",
        "reverse({p})",
        "sort(distinct-values({p}/string(.)))",
        "sort((3, 1, count({p})), (), function($x) {{ -$x }})",
        "head(sort({p}/@*))",
        "tail(sort({p}/count(*)))",
        "subsequence({p}, 2, 3)",
        "remove(reverse({p}), 2)",
        "sort({p}, (), function($x) {{ name($x) }})/..",
    ),
    "tokenize": (
        "tokenize(string(({p})[1]), '[aeiou]')",
        "{p} ! tokenize(string(.), 'a')[2]",
        "count({p}/tokenize(name(.), '_'))",
        "//bone[tokenize(name, '_') = 'left']/name",
        "tokenize(' a b  c ')",
        "for $t in tokenize({k}, '-') return upper-case($t)",
        "//frame[tokenize(string(@id), '0') = '1']/@id",
    ),
}
"""What came with XPath 3.1, and beside it what else gives sequences. p, q: paths. k: a text that occurs."""
XPATH2_FEATURES = (*LATER_FUNCTIONS, *LATER_OPERATORS)


def xpath2_features(text: str) -> set[str]:
    """What of XPath 2.0 an expression uses."""
    return {token.symbol for token in Parser.parse(XPath31Parser(), spell_for_elementpath(text)).iter()}


class Xpath2Grammar(Grammar):
    """Expressions of XPath 2.0."""

    def expressions(self) -> Iterator[tuple[str, str]]:
        while True:
            name = self.random.choice(list(self.trees))
            self._size = self._sizes[name]
            self._budget = self.random.choice([1, 2, 2, 3, 4, 6, 9])
            document = Witness("document", self.trees[name].getroot())
            text = ""
            while not xpath2_features(text or "a") & set(XPATH2_FEATURES):
                text = self.whole(document)
            yield name, text

    def chained(self, comparison: str, node: Witness) -> str:
        """Comparisons of comparisons are XPath 1.0 alone."""
        return comparison

    def whole(self, document: Witness) -> str:
        kind = self.random.choices(["sequence", "filtered", "single", "truth"], [40, 31, 14, 15])[0]
        return str(getattr(self, kind)(document))

    def start(self, document: Witness) -> str:
        """A path from the document."""
        return self.absolute(document)[0]

    # -- parts -----------------------------------------------------------------------------------------------------

    def sequence(self, document: Witness) -> str:
        """Nodes or values, in their own order."""
        kind = self.pick(
            [
                "for",
                "if",
                ",",
                "union",
                "intersect",
                "except",
                "to",
                "distinct-values",
                "index-of",
                "let",
                "!",
                "||",
                "sort",
                "tokenize",
            ]
        )
        first = self.start(document)
        second = self.start(document) if self.chance(0.7) else first
        if kind == "for":
            return self.loop(document)
        if kind == "if":
            other = self.random.choice([self.start, self.single])(document)
            return f"if ({self.truth(document)}) then {first} else {other}"
        if kind == ",":
            other = self.sequence(document) if self.spend() else self.single(document)
            return f"({first}, {other})"
        if kind in ("union", "intersect", "except"):
            other = f"{first}[{self.position_test()}]" if self.chance(0.6) else second
            return f"{first} {kind} {other}"
        if kind == "to":
            number = self.random.choice([1, 2, 5])
            return self.random.choice([
                f"{first}[position() = {number} to {number + 3}]", f"for $i in 1 to {number} return ({first})[$i]",
                f"{number} to count({second})", f"({number} to {number + 9})[. mod 2 = 1]",
            ])  # fmt: skip
        if kind == "distinct-values":
            return f"distinct-values({first})"
        if kind in LATEST:
            return self.random.choice(LATEST[kind]).format(p=first, q=second, k=self.known(document))
        texts = self.random.choice(["//frame/@id", "//bone/name", "//frame_bone/@name"])
        return f"index-of({texts}, {self.known(document)})"

    def known(self, document: Witness) -> str:
        """A text that occurs."""
        found = document.element.xpath("//bone/name/text() | //frame/@id | //motion_name/text()") or ["1"]
        return self.quoted(str(self.random.choice(found)))

    def loop(self, document: Witness) -> str:
        outer = self.random.choice(["//frame", "//bone", "//frame_bone", self.start(document)])
        inner = self.random.choice([
            "string($x)", "count($x/*)", "$x/@*", "replace(string($x), '[aeiou]', '-')", "upper-case(name($x))",
            "if (exists($x/*)) then $x/*[1] else $x", "round(number($x/@Rx))", "abs(number($x/@Ry))", "$x/..",
            "floor(number($x/@Tx))", "string-join($x/@*, '/')", "max($x//@Rx)", "ceiling(sum($x//@Rz))",
            "($x/@name, count($x/preceding-sibling::*))", "string-length(string($x)) eq 0",
        ])  # fmt: skip
        text = f"for $x in {outer} return {inner}"
        wrapped = ["{}", "{}", "count({})", "string-join(for $y in ({}) return string($y), ' ')", "({})[2]"]
        return self.random.choice([*wrapped, "distinct-values({})", "exists({})"]).format(text)

    def filtered(self, document: Witness) -> str:
        """Nodes of a condition that came later."""
        root = document.element
        frames, bone = root.findall("motion/frame"), root.find("skeleton//bone")
        if frames and self.chance(0.7):
            node = self.some(frames)
            text, conditions = "//frame", self.on_frame(node)
            bones = node.element.findall("frame_bone")
            if bones and self.chance(0.6):
                node = self.some(bones)
                text, conditions = "//frame_bone", self.on_bone(node)
        elif bone is not None:
            node = element(bone)
            text, conditions = "//bone", self.on_name("name", str(bone.findtext("name")))
        else:
            node = self.some(list(root.find("header")) or [root])
            text, conditions = "//header/*", [*self.on_name(".", "bvh"), "empty(*)", "exists(text())"]
        for _ in range(self.random.choice([1, 1, 2])):
            condition = self.prefer(conditions)
            if self.chance(0.25):
                condition = f"({condition}) {self.random.choice(['and', 'or'])} ({self.condition(node)})"
            text += f"[{condition}]"
        if self.chance(0.3):
            text = self.further(text, node)[0]
        return self.random.choice(["{}", "{}", "{}", "count({})", "exists({})", "empty({})"]).format(text)

    def prefer(self, conditions: list[str]) -> str:
        """One of several, rather one that uses what is rare."""
        lacking = [self.counts[name] < 0.05 * self.made for name in XPATH2_FEATURES]
        rare = {name for name, few in zip(XPATH2_FEATURES, lacking, strict=True) if few}
        uses = [10.0 if xpath2_features(each) & rare else 1.0 for each in conditions]
        return self.random.choices(conditions, uses)[0]

    def on_bone(self, bone: Witness) -> list[str]:
        held = [channel for channel in CHANNELS if channel in bone.element.attrib] or ["Rx"]
        channel, other = self.random.choice(held), self.random.choice(held)
        value = abs(float(bone.element.get(channel, "1")))
        near = self.number_text(value + self.random.choice([-1, 0, 0.5, 2]))
        return [
            f"abs(@{channel}) <= {near}", f"abs(@{channel}) > {near}", f"round(@{channel}) = {round(value)}",
            f"floor(@{channel}) < @{other}", f"ceiling(@{channel}) >= @{other}", f"number(@{channel}) lt {near}",
            f"number(@{channel}) ge number(@{other})", f"max((@*[name() != 'name'])) > {near}",
            f"min((@Rx | @Ry | @Rz)) <= {near}", f"avg((@Rx | @Ry)) != {near}", f"exists(@{channel})",
            f"empty(@SF) and abs(@{channel} - @{other}) < {near}", f"number(@{channel}) le {near}",
            *self.on_name("@name", bone.element.get("name")),
        ]  # fmt: skip

    def on_frame(self, frame: Witness) -> list[str]:
        names = [found.text for found in frame.element.findall("motion_name")] or ["walk"]
        return [
            f"some $n in motion_name satisfies $n = {self.quoted(names[0])}",
            "every $b in frame_bone satisfies exists($b/@name)", "every $v in frame_bone/@Rx satisfies $v > -50",
            f"exists(motion_name[.={self.quoted(names[-1])}])", "empty(motion_name)", "exists(frame_bone)",
            "max(frame_bone/@Rx) > 1", "min(frame_bone/@Rx) <= 10", "avg(frame_bone/@Ry) >= -20",
            *self.random.sample(later_of_frame_bones(self.random, frame.element), 3),
            "position() = 2 to 5",
            f"string-join(motion_name, '+') = {self.quoted('+'.join(names))}",
            "count(distinct-values(motion_name)) ge 1",
            f"@id = ({self.quoted(frame.element.get('id'))}, '3')", "string(@id) ne '1'", "count(frame_bone) eq 2",
            "if (motion_name) then @id > 1 else true()", f"index-of(motion_name, {self.quoted(names[-1])}) = 1",
        ]  # fmt: skip

    def on_name(self, path: str, text: str) -> list[str]:
        start, end = self.quoted(f"^{text[:2]}"), self.quoted(text[-2:])
        return [
            f"matches({path}, {start}, 'i')", f"matches({path}, '[a-z]+_[a-z]+')", f"ends-with({path}, {end})",
            f"lower-case({path}) = {self.quoted(text.lower())}", f"upper-case({path}) = {self.quoted(text.upper())}",
            f"replace({path}, '_', '-') != {path}", f"string({path}) eq {self.quoted(text)}",
            f"string({path}) ge {self.quoted(text)}", f"replace({path}, '(.)_(.)', '$2_$1') != ''",
            f"string({path}) gt 'M'", f"lower-case(string({path})) lt 'm'", f"ends-with(upper-case({path}), 'G')",
        ]  # fmt: skip

    def single(self, document: Witness) -> str:
        kind = self.pick(
            ["min", "max", "avg", "abs", "round", "floor", "ceiling", "string-join", "replace", "lower-case",
             "upper-case"]
        )  # fmt: skip
        channel = f"@{self.random.choice(CHANNELS)}"
        samples = self.random.choice([f"//{channel}", f"//frame/frame_bone/{channel}", f"//frame[2]//{channel}"])
        if kind in ("min", "max", "avg"):
            inner = self.random.choice([samples, samples, f"for $v in {samples} return number($v) * 2", "(3, 1, 2)"])
            return f"{kind}({inner})"
        if kind in ("abs", "round", "floor", "ceiling"):
            inner = self.random.choice([f"sum({samples})", f"({samples})[1]", f"min({samples})", "-2.5", "//frametime"])
            return f"{kind}({inner})"
        path = self.random.choice(["//bone/name", "//motion_name", self.start(document)])
        if kind == "string-join":
            return self.random.choice(["string-join({}, ',')", "string-join(distinct-values({}), ' ')"]).format(path)
        if kind == "replace":
            return f"replace(string(({path})[1]), '[^a-z]+', '.')"
        return f"{kind}({self.random.choice([f'string({path})', f'string-join({path}, ``)'.replace('``', repr('-'))])})"

    def truth(self, document: Witness) -> str:
        kind = self.pick(
            ["exists", "empty", "some", "every", "eq", "ne", "lt", "le", "gt", "ge", "matches", "ends-with"]
        )
        path = self.start(document)
        if kind in ("exists", "empty"):
            return f"{kind}({path})"
        if kind == "some":
            return f"some $x in {path} satisfies count($x/*) >= {self.random.choice([0, 1, 2])}"
        if kind == "every":
            return f"every $x in {path}, $y in //frame[1] satisfies exists($x/ancestor-or-self::*) and $y"
        if kind in ("matches", "ends-with"):
            return f"{kind}(string(({path})[1]), {self.random.choice([repr('a'), repr('t')])})"
        one, other = self.random.choice([
            (f"count({path})", "2"), (f"string(({path})[1])", "'m'"), (f"name(({path})[1])", self.known(document)),
            ("number((//@Rx)[1])", "1.5"), (f"string-length(string(({path})[1]))", f"count({path})"),
        ])  # fmt: skip
        return f"{one} {kind} {other}"
