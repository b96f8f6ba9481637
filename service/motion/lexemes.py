"""Numbers as the text that the head of a clip holds."""

from __future__ import annotations

from service.motion.skeleton import Array, Triple


def lexeme(value: float) -> str:
    """The shortest text of a finite double, whole numbers without a point: `0`, `1.5`, `1e-05`."""
    if value == 0:
        return "0"
    text = repr(float(value))
    return text.removesuffix(".0")


def triple(values: Array) -> Triple:
    """The lexemes of a vector (3,)."""
    return lexeme(float(values[0])), lexeme(float(values[1])), lexeme(float(values[2]))
