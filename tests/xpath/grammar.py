"""Seeded expressions of XPath 1.0 over MCML, of the kinds that people ask, and nested as deep as they never do.

Every expression is about nodes that exist (`witness.py`): a path goes where a node is, a comparison is with a value
near the node's, a condition that does not hold is negated. Expressions are legal by construction, for each part knows
its type. What has been used least is preferred, so that every axis, node test, function and operator has its share.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from random import Random
from typing import Any

from mcml_service.xpath.language.tree import AXES
from tests.xpath.on_frames import CHANNELS, of_frame_bones, of_id
from tests.xpath.spelling import nested, position_test, without_space
from tests.xpath.witness import Witness, child, element, move

WANTED = 0.05
"""Share of the expressions below which a feature is preferred."""
MOST_WORK = 200_000
"""Nodes that libxml2 may look at, about, when a witness is asked."""


class Grammar:
    """trees: the documents, by name. Expressions come in an order that the seed alone decides."""

    def __init__(self, random: Random, trees: Mapping[str, Any]) -> None:
        self.random = random
        self.trees = trees
        self.counts: Counter[str] = Counter()
        self.made = 0
        self._budget = 0
        self._sizes = {name: sum(1 for _ in tree.iter()) for name, tree in trees.items()}
        self._size = 0

    def expressions(self) -> Iterator[tuple[str, str]]:
        """(document that the expression is about, expression), without end. Tell `used` what each consists of."""
        while True:
            name = self.random.choice(list(self.trees))
            self._size = self._sizes[name]
            self._budget = self.random.choice([2, 4, 4, 6, 6, 8, 10, 14, 25, 40])
            text = self.top(Witness("document", self.trees[name].getroot()))
            yield name, without_space(text) if self.chance(0.15) else text

    def used(self, found: set[str]) -> None:
        self.made += 1
        self.counts.update(found)

    def evaluate(self, node: Witness, text: str) -> Any:
        """What libxml2 makes of an expression at the node; None where that is unknown, or would take it long."""
        wide = sum(map(text.count, ("//", "descendant", "following", "preceding", "/mcml", "/node()", "/*")))
        return None if self._size**wide > MOST_WORK else node.evaluate(text)

    # -- choices ---------------------------------------------------------------------------------------------------

    def pick(self, options: Sequence[str], weights: Sequence[float] | None = None, form: str = "{}") -> str:
        """One of several features; those that stand in few expressions so far are more likely."""
        bases = weights or [1.0] * len(options)
        wanted = WANTED * self.made + 1
        needs = [min(20.0, max(1.0, wanted / (self.counts[form.format(option)] + 1))) for option in options]
        return self.random.choices(options, [base * need for base, need in zip(bases, needs, strict=True)])[0]

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def spend(self) -> bool:
        """Whether another part may be made."""
        self._budget -= 1
        return self._budget >= 0

    # -- whole expressions -----------------------------------------------------------------------------------------

    def top(self, document: Witness) -> str:
        kind = self.random.choices(["nodes", "number", "string", "boolean"], [64, 13, 13, 10])[0]
        if kind != "nodes":
            return str(getattr(self, kind)(document))
        text, _ = self.absolute(document)
        if self.chance(0.08):
            text = f"{text} | {self.absolute(document)[0]}"
        # As in `step`: where namespace nodes stand among others, libxml2 does not know.
        if self.chance(0.12) and "namespace::" not in text:
            text = f"({text})[{self.position_test()}]"
        return text

    def absolute(self, document: Witness) -> tuple[str, Witness]:
        """A path from the document: mostly one that begins as people's do."""
        root = document.element
        choice = self.random.choices(["frame", "bone", "header", "walk"], [50, 22, 10, 18])[0]
        node: Witness | None = None
        if choice == "frame" and root.find("motion/frame") is not None:
            node = self.some(root.find("motion").findall("frame"))
            text = self.random.choice(["//frame", "/mcml/motion/frame", "//motion/frame", "/descendant::frame"])
        elif choice == "bone" and root.find("skeleton//bone") is not None:
            node = self.some(root.findall("skeleton//bone"))
            text = self.random.choice(["//bone", "//bone", "/mcml/skeleton//bone", "/mcml/skeleton/descendant::bone"])
        elif choice == "header":
            node = self.some(list(root.find("header")) or [root])
            text = f"//{node.element.tag}"
        if node is None:
            text, node = self.step(document)
            text = "/" + text
        else:
            text += self.predicates(node)
        return self.further(text, node)

    def some(self, found: Sequence[Any]) -> Witness:
        return element(self.random.choice(found))

    def further(self, text: str, node: Witness) -> tuple[str, Witness]:
        """The path and more steps from a node that it selects."""
        while self.chance(0.6) and self.spend():
            if node.kind == "element" and node.element.tag == "frame" and self.chance(0.5):
                found = self.bone_of(node)
                if found is None:
                    continue
                step, node = found
            else:
                step, node = self.step(node)
            text += ("/" if text != "/" else "") + step
        return text, node

    def bone_of(self, frame: Witness) -> tuple[str, Witness] | None:
        """A bone of a frame, by name or place."""
        bone = child(frame, self.random, "frame_bone")
        if bone is None:
            return None
        name = bone.element.get("name")
        place = self.random.choice([f"[@name={self.quoted(name)}]", f"[{self.quoted(name)}=@name]", "[2]", ""])
        return f"frame_bone{place}{self.predicates(bone)}", bone

    # -- paths -----------------------------------------------------------------------------------------------------

    def nodes(self, node: Witness) -> tuple[str, Witness]:
        """A path from a node, or from the document."""
        root = node.element.getroottree().getroot()
        if node.kind == "document" or self.chance(0.08):
            return self.absolute(Witness("document", root))
        if node.kind == "element" and node.element.tag == "frame" and self.chance(0.5):
            found = self.bone_of(node)
            if found is not None:
                return self.further(*found)
        text, node = self.step(node)
        text, node = self.further(text, node)
        return self.grouped(text, node) if self.chance(0.15) and node.kind != "namespace" else (text, node)

    def grouped(self, text: str, node: Witness) -> tuple[str, Witness]:
        """A union, or a list with a position of its own."""
        if self.chance(0.5):
            return f"({text})[{self.position_test()}]", node
        other = self.pick(["id('a')", "comment()", "processing-instruction()", "@*", "*", "."])
        return f"({text} | {other})", node

    def step(self, node: Witness) -> tuple[str, Witness]:
        """A step to a node that exists, with its test and predicates."""
        weights = [3.0 if axis in ("child", "descendant", "attribute", "parent") else 1.0 for axis in AXES]
        for _ in range(20):
            axis = self.pick(AXES, weights, "{}::")
            if node.kind == "namespace" and axis not in ("parent", "ancestor"):
                # XPath leaves the order of namespace nodes open, and libxml2 loses it: positions would tell nothing.
                continue
            found = move(node, axis, self.random)
            if found is None or (found.kind == "text" and self.chance(0.5)):
                continue
            return self.written(axis, self.test(axis, found)) + self.predicates(found), found
        return ".", node

    def test(self, axis: str, node: Witness) -> str:
        if node.kind in ("attribute", "namespace"):
            name = "node()" if axis not in ("attribute", "namespace") else node.name
            return name if self.chance(0.6) else self.pick([name, "*" if name != "node()" else name, "node()"])
        if node.kind == "document":
            return "node()"
        if node.kind == "text":
            return self.pick(["text()", "text()", "node()"])
        return self.random.choices([str(node.element.tag), "*", "node()"], [70, 18, 12])[0]

    def written(self, axis: str, test: str) -> str:
        """A step, abbreviated or in full."""
        short = {("parent", "node()"): "..", ("self", "node()"): "."}.get((axis, test))
        if short and self.chance(0.7):
            # A step that is abbreviated takes no predicates.
            return f"{short}/self::node()"
        if axis == "child" and self.chance(0.9):
            return test
        return f"@{test}" if axis == "attribute" and self.chance(0.9) else f"{axis}::{test}"

    def predicates(self, node: Witness) -> str:
        text = ""
        while self.chance(0.45) and self.spend():
            text += f"[{self.position_test() if self.chance(0.25) else self.condition(node)}]"
        return text

    def position_test(self) -> str:
        return position_test(self.random)

    # -- conditions ------------------------------------------------------------------------------------------------

    def condition(self, node: Witness) -> str:
        """A boolean expression that holds for the node, where that is known."""
        if node.kind == "element" and self.chance(0.45):
            known = self.usual(node)
            if known is not None:
                return known
        text = f"{self.string(node)} != 'no-such'" if self.chance(0.12) else self.boolean(node)
        if self.chance(0.05):
            text = nested(self.random, text)
        held = self.evaluate(node, f"boolean({text})")
        return f"not({text})" if held is False and self.chance(0.9) else text

    def usual(self, node: Witness) -> str | None:
        """What animators ask of a frame, a bone or a sample."""
        tag, random = node.element.tag, self.random
        if tag == "frame":
            names = [found.text for found in node.element.findall("motion_name")]
            if names and self.chance(0.6):
                name, other = self.quoted(random.choice(names)), self.quoted(random.choice(names))
                return random.choice([
                    f"motion_name={name}", f"{name}=./motion_name", f"motion_name={name} and motion_name={other}",
                    f"motion_name={name} or motion_name='run'", f"motion_name[.={name}]", f"motion_name/text()={name}",
                    f"child::motion_name!={name} or motion_name={other}",
                    f"not(motion_name='nothing') and {name}=motion_name",
                ])  # fmt: skip
            if self.chance(0.3):
                return of_id(random, node.element, self.quoted)
            if self.chance(0.4):
                return of_frame_bones(random, node.element)
            bone = child(node, random, "frame_bone")
            if bone is None:
                return "not(frame_bone)"
            return f"frame_bone[@name={self.quoted(bone.element.get('name'))}]/{self.compared(bone)}"
        if tag == "frame_bone":
            return self.compared(node)
        if tag == "bone":
            name = self.quoted(node.element.findtext("name"))
            return random.choice([f"name={name}", f"{name}=name", "name", ".//bone or name", "not(bone) or bone"])
        return None

    def compared(self, bone: Witness) -> str:
        """A channel of a bone against a number near its value, or against another channel."""
        held = [channel for channel in CHANNELS if channel in bone.element.attrib]
        if not held:
            return "@name"
        channel, other = self.random.choice(held), self.random.choice(held)
        value = float(bone.element.get(channel))
        near = self.number_text(value + self.random.choice([-2, -0.5, 0, 0, 0.25, 3]))
        operator = self.pick(["<", "<=", ">", ">=", "=", "!="], form="operator {}")
        if self.chance(0.25):
            return f"@{channel} {operator} {near}"
        held_here = self.evaluate(bone, f"@{channel} {operator} {near}")
        if not held_here:
            operator = {"<": ">=", ">=": "<", "<=": ">", ">": "<=", "=": "!=", "!=": "="}[operator]
        return f"@{channel} {operator} {near}" if self.chance(0.7) else f"@{channel} + @{other} != {near}"

    # -- values ----------------------------------------------------------------------------------------------------

    def boolean(self, node: Witness) -> str:
        if not self.spend():
            return self.random.choice([self.path(node), "true()"])
        kind = self.pick(
            ["operator <", "operator =", "operator and", "not()", "boolean()", "true()", "false()", "contains()",
             "starts-with()", "lang()", "test comment()", "test processing-instruction()", "id()", "path"],
            [5, 5, 3, 1, 1, 0.8, 1.5, 1.3, 1.5, 1.2, 1.2, 1.6, 1, 2],
        )  # fmt: skip
        if kind in ("operator <", "operator ="):
            text = self.relation(node) if kind == "operator <" else self.equality(node)
            return self.chained(text, node) if self.chance(0.12) else text
        if kind == "operator and":
            operator = self.random.choice(["and", "or"])
            operands = [self.condition(node) for _ in range(self.random.choice([2, 2, 3]))]
            return "(" + f" {operator} ".join(f"({each})" if " or " in each else each for each in operands) + ")"
        if kind in ("not()", "boolean()"):
            inner = self.random.choice([self.boolean, self.path, self.string, self.number])(node)
            return f"{kind[:-2]}({inner})"
        if kind in ("contains()", "starts-with()"):
            text, value = self.string_value(node)
            part = value[:3] if kind == "starts-with()" else value[1:4]
            return f"{kind[:-2]}({text}, {self.quoted(part)})"
        if kind == "path":
            return self.path(node)
        target = self.random.choice(["'walk'", "'no-such'"])
        dead = {"test comment()": "comment()", "id()": f"id({self.path(node) if self.chance(0.4) else target})"}
        target = self.random.choice(["", "'a'", "'a'"])
        dead["test processing-instruction()"] = f"processing-instruction({target})"
        if kind in dead:
            return self.random.choice(["not({})", "count({}) = 0", "{}"]).format(dead[kind])
        return "lang('en')" if kind == "lang()" else kind

    def path(self, node: Witness) -> str:
        return self.nodes(node)[0]

    def chained(self, comparison: str, node: Witness) -> str:
        """The truth of a comparison compared again, as `1 < 2 = true()` and `3 > 2 > 1` do."""
        for _ in range(self.random.choice([1, 1, 2, 4])):
            other = self.random.choice(["true()", "false()", "1", "0", self.number(node), self.string(node)])
            comparison = f"{comparison} {self.random.choice(['=', '!=', '<', '<=', '>', '>='])} {other}"
        return f"({comparison})"

    def relation(self, node: Witness) -> str:
        operator = self.pick(["<", "<=", ">", ">="], form="operator {}")
        text = self.operand(node)
        value = self.evaluate(node, f"number({text})")
        if self.chance(0.3) or not isinstance(value, float) or value != value or abs(value) > 1e9:
            other = self.random.choice([self.operand, self.number, self.path])(node)
        else:
            other = self.number_text(value + self.random.choice([-1, -0.5, 0, 0.5, 1, 10]))
        return f"{text} {operator} {other}" if self.chance(0.8) else f"{other} {operator} {text}"

    def operand(self, node: Witness) -> str:
        return self.number(node) if self.chance(0.6) else self.path(node)

    def equality(self, node: Witness) -> str:
        operator = self.pick(["=", "!="], form="operator {}")
        kind = self.random.choices(["value", "strings", "paths", "boolean"], [5, 2, 2, 1])[0]
        if kind == "value":
            text, value = self.string_value(node)
            return f"{text} {operator} {self.quoted(value)}"
        if kind == "strings":
            return f"{self.string(node)} {operator} {self.random.choice([self.string, self.path])(node)}"
        if kind == "paths":
            return f"{self.path(node)} {operator} {self.random.choice([self.path, self.number])(node)}"
        other = self.random.choice(["true()", "false()"])
        return f"({self.random.choice([self.condition, self.path])(node)}) {operator} {other}"

    def string_value(self, node: Witness) -> tuple[str, str]:
        """A string expression or path, and its value at the node, or something like it."""
        text, end = (self.string(node), None) if self.chance(0.5) else self.nodes(node)
        value = self.evaluate(node, f"string({text})")
        if isinstance(value, str) and len(value) < 60:
            return text, value
        return text, end.value[:40] if end is not None else "1"

    def number(self, node: Witness) -> str:
        if not self.spend():
            return self.random.choice([f"count({self.path(node)})", str(self.random.choice([1, 2, 3, 0.5, 10]))])
        kinds = ["count", "sum", "number", "string-length", "floor", "ceiling", "round", "position", "last"]
        kind = self.pick(
            [
                *(f"{kind}()" for kind in kinds),
                *(f"operator {sign}" for sign in ("+", "-", "*", "div", "mod", "negate")),
            ],
            [6, 2, 2, 2, 1, 1, 1, 1, 1, 2, 2, 2, 1, 1, 1],
        )
        if kind in ("count()", "sum()"):
            text, end = self.nodes(node)
            if kind == "sum()" and end.kind == "element" and end.element.tag == "frame_bone":
                text += "/@" + self.random.choice(CHANNELS)
            return f"{kind[:-2]}({text})"
        if kind in ("position()", "last()"):
            # Around the whole expression libxml2, as lxml calls it, has no position.
            return kind if node.kind != "document" else f"count({self.path(node)}[{kind}])"
        if kind in ("number()", "string-length()"):
            inner = self.random.choice([self.path, self.string, lambda at: "" if at.kind != "document" else "/"])(node)
            return f"{kind[:-2]}({inner})"
        if kind == "operator negate":
            return f"-{self.operand(node)}" if self.chance(0.7) else f"- -{self.path(node)}"
        if kind.startswith("operator"):
            operands = [self.operand(node) for _ in range(self.random.choice([2, 2, 3]))]
            return "(" + f" {kind[9:]} ".join(operands) + ")"
        return f"{kind[:-2]}({self.operand(node)})"

    def string(self, node: Witness) -> str:
        if not self.spend():
            return self.random.choice([f"string({self.path(node)})", "'walk'", f"name({self.path(node)})"])
        kind = self.pick(
            ["string()", "concat()", "substring-before()", "substring-after()", "substring()", "normalize-space()",
             "translate()", "name()", "local-name()", "namespace-uri()"],
            [3, 1, 1, 1, 1, 1, 1, 2, 1, 1],
        )  # fmt: skip
        name = kind[:-2]
        if name == "concat":
            return f"concat({', '.join(self.text(node) for _ in range(self.random.choice([2, 2, 3, 5])))})"
        if name in ("substring-before", "substring-after"):
            text, value = self.string_value(node)
            return f"{name}({text}, {self.quoted(value[1:3] or 'a')})"
        if name == "substring":
            last = self.random.choice(["", ", 3", ", 2.5", f", {self.operand(node)}"])
            return f"substring({self.text(node)}, {self.random.choice(['1', '2', '1.5', '-1', '0'])}{last})"
        if name == "translate":
            old, new = self.random.choice(["a-", "abc", ".", "etl"]), self.random.choice(["", "A", "XYZ"])
            return f"translate({self.text(node)}, '{old}', '{new}')"
        inner = "" if node.kind != "document" and self.chance(0.3) else self.path(node)
        if name in ("string", "normalize-space") and self.chance(0.3):
            inner = self.random.choice([self.number, self.boolean, self.string])(node)
        return f"{name}({inner})"

    def text(self, node: Witness) -> str:
        return self.random.choice([self.string, self.path, self.path, lambda at: self.quoted("left-arm")])(node)

    def quoted(self, text: str) -> str:
        mark = '"' if "'" in text or ('"' not in text and self.chance(0.3)) else "'"
        return f"{mark}{text.replace(mark, ' ')}{mark}"

    def number_text(self, value: float) -> str:
        digits = self.random.choice([0, 1, 2, 6])
        return f"{value:.{digits}f}" if self.chance(0.8) else str(round(value))
