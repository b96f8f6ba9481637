"""Numbers as the text that the head of a clip holds."""

from __future__ import annotations

import math

from mcml.errors import ConversionError
from mcml.motion.skeleton import Array, Triple


def lexeme(value: float) -> str:
    """The shortest text of a double, whole numbers without a point: `0`, `1.5`, `1e-05`.

    Raises ConversionError for one that is not finite.
    """
    if value == 0:
        return "0"
    if not math.isfinite(value):
        raise ConversionError(
            "A number of the skeleton is beyond the largest that a file can hold.",
            remedy="Check the numbers of the source: they are near 1e308.",
        )
    text = repr(float(value))
    return text.removesuffix(".0")


def triple(values: Array) -> Triple:
    """The lexemes of a vector (3,)."""
    return lexeme(float(values[0])), lexeme(float(values[1])), lexeme(float(values[2]))
