"""Calls of functions of bodies in motion (`mo:height('Head')`) in an expression that columns cannot evaluate."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mcml.errors import QueryError
from mcml_service.xpath.language.grammar import read
from mcml_service.xpath.language.meaning import bind
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS
from mcml_service.xpath.language.tree import Call, Expression, Span, Written

MOTION_CALL = re.compile(rf"""'[^']*'|"[^"]*"|(?<![\w.$-])({"|".join(sorted(MOTION_FUNCTIONS))})(?=\s*\()""")
"""A text between quotation marks, or (group 1) the name of such a function."""
_NEXT_BINDING = re.compile(r",\s*\$[^\s,]+\s+in\s")
"""A comma of `for $a in …, $b in …`, which no argument can begin with."""


@dataclass(frozen=True, slots=True)
class WrittenCall:
    """call: arguments that columns cannot evaluate, or with variables of loops, are `Written`.

    span: its place in the text. arguments: their texts.
    """

    call: Call
    span: Span
    arguments: tuple[str, ...]


def written_calls(text: str, variables: Mapping[str, str | float | bool]) -> Iterator[WrittenCall]:
    """The calls in an expression that can be parsed, without those in arguments of others. variables: the values of
    those that the request binds."""
    end = 0
    for match in MOTION_CALL.finditer(text):
        if not match.group(1) or match.start() < end:
            continue
        spans, end = argument_spans(text, text.index("(", match.end()) + 1)
        arguments = tuple(_tree(text, span, variables) for span in spans)
        place = match.start(), end
        yield WrittenCall(Call(match.group(1), arguments, place), place, tuple(text[slice(*span)] for span in spans))


def _tree(text: str, span: Span, variables: Mapping[str, str | float | bool]) -> Expression:
    start, end = span
    try:
        # Errors and warnings name columns of the whole text.
        return bind(read(" " * start + text[start:end]), variables)
    except QueryError:
        inner = text[start:end]
        return Written(inner, motion=tuple(each.call for each in written_calls(inner, variables)), span=span)


def argument_spans(text: str, start: int) -> tuple[list[Span], int]:
    """(where the arguments of a call stand, the place after it). start: the place after its opening bracket."""
    spans: list[Span] = []
    depth, quote, begin = 1, "", start
    for place, letter in enumerate(text[start:], start):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in "([{":
            depth += 1
        elif letter in ")]}":
            depth -= 1
        ends = not quote and (depth == 0 or (depth == 1 and letter == "," and not _NEXT_BINDING.match(text, place)))
        if ends and text[begin:place].strip():
            lead = len(text[begin:place]) - len(text[begin:place].lstrip())
            spans.append((begin + lead, begin + len(text[begin:place].rstrip())))
        begin = place + 1 if ends else begin
        if depth == 0:
            return spans, place + 1
    return spans, len(text)
