"""A condition on samples over many frames at once: the evaluator of all expressions (`columns`), given the samples
themselves instead of frames to look for them in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from mcml_service.xpath.engine.context import Bound, Context, Value
from mcml_service.xpath.language.conditions import Sample
from mcml_service.xpath.language.tree import Expression, Variable
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import Bools, Floats
from mcml_service.xpath.nodes.samples import Samples


class Columns(Protocol):
    """The evaluator of expressions over the documents of a forest. check: raises when time is up."""

    forest: Forest

    @property
    def check(self) -> Callable[[], None]: ...

    def truth(self, expression: Expression, context: Context) -> Bools: ...


def fulfilled(columns: Columns, condition: Expression, block: Mapping[Variable, Floats | Bools]) -> Bools:
    """In which frames a condition holds. block: its variables, arrays of one shape, which the answer has, too; of a
    `Sample` NaN where a frame has none."""
    shape = next(iter(block.values())).shape
    variables = {variable.name: Bound(_value(variable, column.reshape(-1))) for variable, column in block.items()}
    nowhere = np.broadcast_to(np.int64(0), int(np.prod(shape)))
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        return columns.truth(condition, Context(nowhere, variables=variables)).reshape(shape)


def _value(variable: Variable, column: Floats | Bools) -> Value:
    return Samples(column.astype(np.float64, copy=False)) if isinstance(variable, Sample) else column
