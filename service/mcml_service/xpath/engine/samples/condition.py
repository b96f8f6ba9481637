"""A condition on samples, and facts derived from its form: the samples that it reads, those that it requires, and the
verdict of zone maps. It has the meaning of its tree in `columns`: nothing here evaluates it for a frame. Arithmetic on
the ends of zone maps (`intervals`) decides beforehand in which tracks no frame fulfils it, and in which every frame
does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from mcml_service.xpath.engine.functions import arithmetic
from mcml_service.xpath.language.conditions import Sample, samples_of
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.tree import TURNED, Call, Expression, Literal, Operation, with_children
from mcml_service.xpath.library import intervals
from mcml_service.xpath.library.intervals import Interval, Verdict
from mcml_service.xpath.nodes.numbering import Floats

Ends: TypeAlias = Mapping[Sample, Interval]
"""Of each sample, by the zone maps of some tracks."""


@dataclass(frozen=True)
class Condition:
    """tree: of logic, comparisons and arithmetic of samples and of literals."""

    tree: Expression

    @classmethod
    def of(cls, tree: Expression) -> Condition:
        """Make a condition from the output of `conditions`, with constants as numbers."""
        return cls(_folded(tree))

    @cached_property
    def samples(self) -> frozenset[Sample]:
        """All that it reads."""
        return samples_of(self.tree)

    @cached_property
    def strict(self) -> frozenset[Sample]:
        """Samples without which no frame fulfils it."""
        return _strict(self.tree)

    @cached_property
    def bounds(self) -> tuple[tuple[Sample, str, float], ...]:
        """(sample, operator, number): no frame fulfils it otherwise."""
        if isinstance(self.tree, Operation) and self.tree.operator == "and":
            return tuple(bound for operand in self.tree.operands for bound in Condition(operand).bounds)
        bound = _bound(self.tree)
        return () if bound is None else (bound,)

    @cached_property
    def bound(self) -> tuple[Sample, str, float] | None:
        """The one bound that it is, no more and no less."""
        return _bound(self.tree)

    @property
    def is_presence(self) -> bool:
        """Whether it only requires that a frame has a sample."""
        return isinstance(self.tree, Call) and isinstance(self.tree.arguments[0], Sample)

    @cached_property
    def leaves(self) -> dict[Expression, Condition]:
        """The comparisons and the like that it combines."""
        found: dict[Expression, Condition] = {}

        def noted(leaf: Expression) -> Expression:
            found[leaf] = Condition(leaf)
            return leaf

        self.combining(noted)
        return found

    def combining(self, function: Callable[[Expression], Expression]) -> Expression:
        """Return its tree with its leaves replaced."""
        return _with_leaves(self.tree, function)

    def judge(self, ends: Ends) -> Verdict:
        """Return the verdict of zone maps."""
        return _judged(self.tree, ends)


def _is_combination(tree: Expression) -> bool:
    operator = tree.operator if isinstance(tree, Operation) else tree.function if isinstance(tree, Call) else ""
    return operator in ("and", "or", "not")


def _with_leaves(tree: Expression, function: Callable[[Expression], Expression]) -> Expression:
    if not _is_combination(tree):
        return function(tree)
    return with_children(tree, lambda part: _with_leaves(part, function))


def _strict(tree: Expression) -> frozenset[Sample]:
    if isinstance(tree, Call):
        # A negation is also true without samples: other conditions must require them.
        return frozenset() if tree.function == "not" else samples_of(tree)
    if not isinstance(tree, Operation):
        return frozenset()
    if tree.operator == "and":
        return frozenset[Sample]().union(*map(_strict, tree.operands))
    if tree.operator == "or":
        return frozenset.intersection(*map(_strict, tree.operands))
    if tree.operator == "!=":
        return frozenset(operand for operand in tree.operands if isinstance(operand, Sample))
    return samples_of(tree)


def _bound(tree: Expression) -> tuple[Sample, str, float] | None:
    if not isinstance(tree, Operation) or tree.operator == "!=" or tree.operator not in TURNED:
        return None
    left, right = tree.operands
    for operator, one, other in ((tree.operator, left, right), (TURNED[tree.operator], right, left)):
        if isinstance(one, Sample) and isinstance(other, Literal) and not math.isnan(float(other.value)):
            return one, operator, float(other.value)
    return None


def _constant(tree: Expression) -> float:
    """The number that an expression without samples is."""
    if isinstance(tree, Literal):
        return float(tree.value)
    if isinstance(tree, Call):
        function = SAFE_FUNCTIONS[tree.function].of_numbers or np.asarray
        return float(function(np.asarray(_constant(tree.arguments[0]))))
    if not isinstance(tree, Operation):
        raise TypeError("not a constant")
    first, *others = map(_constant, tree.operands)
    if tree.operator == "negate":
        return -first
    result = np.asarray(first)
    for other in others:
        result = arithmetic(tree.operator, result, np.asarray(other))
    return float(result)


def _folded(tree: Expression) -> Expression:
    if isinstance(tree, Sample | Literal):
        return tree
    return with_children(tree, _folded) if samples_of(tree) else Literal(_constant(tree))


def _judged(tree: Expression, ends: Ends) -> Verdict:
    if isinstance(tree, Call):
        inner = tree.arguments[0]
        if isinstance(inner, Sample):
            return intervals.present(ends[inner])
        verdict = _judged(inner, ends)
        return Verdict(~verdict.must, ~verdict.may)
    if not isinstance(tree, Operation):
        raise TypeError("not a condition")
    if tree.operator in ("and", "or"):
        combine = intervals.all_of if tree.operator == "and" else intervals.any_of
        return combine([_judged(operand, ends) for operand in tree.operands])
    left, right = (_between(operand, ends) for operand in tree.operands)
    if tree.operator == "!=":
        return intervals.unknown(next(ends[operand] for operand in tree.operands if isinstance(operand, Sample)))
    return intervals.compared(tree.operator, left, right)


def _between(tree: Expression, ends: Ends) -> Interval:
    """Return the range of a number."""
    if isinstance(tree, Sample):
        return ends[tree]
    if isinstance(tree, Literal):
        return intervals.exactly(float(tree.value))
    if isinstance(tree, Call):
        inner = _between(tree.arguments[0], ends)
        if tree.function == "abs":
            return intervals.magnitude(inner)
        function: Callable[[Floats], Floats] = SAFE_FUNCTIONS[tree.function].of_numbers or np.asarray
        return intervals.monotonic(function, inner)
    if not isinstance(tree, Operation):
        raise TypeError("not a number")
    first, *others = (_between(operand, ends) for operand in tree.operands)
    if tree.operator == "negate":
        return intervals.negative(first)
    for other in others:
        first = intervals.computed(tree.operator, first, other)
    return first
