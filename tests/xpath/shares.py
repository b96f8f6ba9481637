"""What of the language expressions use, and how often: a campaign judges itself by it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from mcml_service.xpath.language.tree import (
    AXES,
    Call,
    Expression,
    Operation,
    Path,
    walk,
)

NODE_TESTS = ("name", "*", "node()", "text()", "comment()", "processing-instruction()", "processing-instruction('…')")
FUNCTIONS = (
    "last", "position", "count", "id", "local-name", "namespace-uri", "name", "string", "concat", "starts-with",
    "contains", "substring-before", "substring-after", "substring", "string-length", "normalize-space", "translate",
    "boolean", "not", "true", "false", "lang", "number", "sum", "floor", "ceiling", "round",
)  # fmt: skip
OPERATORS = ("or", "and", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "div", "mod", "|", "negate")
LEAST_SHARE = 0.02
LEAST_FILLED = 0.6
FEATURES = (
    *(f"{axis}::" for axis in AXES),
    *(f"test {test}" for test in NODE_TESTS),
    *(f"{function}()" for function in FUNCTIONS),
    *(f"operator {operator}" for operator in OPERATORS),
)


def features(tree: Expression) -> set[str]:
    """What of the language an expression uses."""
    found: set[str] = set()
    for part in walk(tree):
        if isinstance(part, Call):
            found.add(f"{part.function}()")
        elif isinstance(part, Operation):
            found.add(f"operator {part.operator}")
        elif isinstance(part, Path):
            for step in part.steps:
                test = step.name if step.name in NODE_TESTS else "name"
                if step.name.startswith("processing-instruction('"):
                    test = NODE_TESTS[-1]
                found |= {f"{step.axis}::", f"test {test}"}
    return found


@dataclass
class Tally:
    """What a campaign asked, and how it was answered.

    wanted: features that must have their share. refused: expressions that the oracle takes for none. filled: answers
    that are not empty. excused: differences that only the last places of numbers decide.
    """

    wanted: Sequence[str] = FEATURES
    asked: int = 0
    refused: int = 0
    filled: int = 0
    excused: int = 0
    features: Counter[str] = field(default_factory=Counter)
    ways: Counter[str] = field(default_factory=Counter)

    def __str__(self) -> str:
        rarest = ", ".join(f"{name} {count / self.asked:.1%}" for name, count in self.shares()[:4])
        return (
            f"{self.asked} expressions, {self.refused} refused, {self.filled / self.asked:.1%} not empty, "
            f"{self.on_columns:.1%} without projection, {self.excused} decided by last places; rarest: {rarest}"
        )

    @property
    def on_columns(self) -> float:
        """Share of the expressions answered without projection."""
        return 1 - self.ways["projection"] / self.asked

    def shares(self) -> list[tuple[str, int]]:
        """How often each feature was used, the rarest first."""
        return sorted(((name, self.features[name]) for name in self.wanted), key=lambda pair: pair[1])

    def judge(self) -> None:
        """Asserts that the expressions were worth asking."""
        assert self.refused <= max(2, 0.01 * self.asked)
        assert self.filled >= LEAST_FILLED * self.asked
        assert self.shares()[0][1] >= LEAST_SHARE * self.asked, self.shares()[:5]
