"""Find the points in a C3D file, from its header, its parameters and its size.

Points and analog samples alternate, frame by frame, so that a wrong number of analog words moves every point but the
first ones. Header and parameters state most facts at least twice; if they disagree, the layout that fits the size of
the file is used. No single statement is always right: each is wrong in some real files.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from mcml.errors import FormatError, Notice
from mcml.formats.c3d.parameters import BLOCK, Statements
from mcml.formats.format import note

_CAPPED: Final = 0xFFFF
"""The greatest count of frames in a word: longer files have it in parameters."""


_SHOWN: Final[dict[str, Callable[[int], str]]] = {
    "start": lambda value: f"data from block {value}",
    "points": lambda value: f"{value} points",
    "real": lambda value: "floats" if value else "integers",
    "analog": lambda value: f"{value} analog values a frame",
    "frames": lambda value: f"{value} frames",
}


@dataclass(frozen=True, slots=True)
class Layout:
    """start: first byte of the data. points, analog: in a frame, words for the latter. real: floats, not integers."""

    start: int
    frames: int
    points: int
    analog: int
    real: bool

    @property
    def frame_bytes(self) -> int:
        return (4 * self.points + self.analog) * (4 if self.real else 2)

    @property
    def end(self) -> int:
        return self.start + self.frames * self.frame_bytes


@dataclass(frozen=True)
class _Fact:
    """The statements about one fact, the most trusted first. said: (value, source), each value once."""

    name: str
    said: list[tuple[int, str]]

    @staticmethod
    def of(name: str, said: Sequence[tuple[float | None, str]]) -> _Fact:
        values: dict[int, str] = {}
        for value, who in said:
            if value is not None and value >= 0:
                values.setdefault(round(value), who)
        return _Fact(name, list(values.items()))


def find_layout(
    said: Statements,
    size: int,
    is_zero: Callable[[int, int], bool],
    notices: list[Notice],
    analog_alone: bool = False,
) -> Layout:
    """Find the layout of a file of `size` bytes, with its actual number of frames.

    is_zero(first, behind): whether these bytes of the file are all zero. analog_alone: accept analog channels without
    points. Raises FormatError without points, or if frames are announced but missing.
    """
    facts = _facts(said)
    names = [fact.name for fact in facts]
    has_points = any(value for value, _ in facts[names.index("points")].said)
    if any(not fact.said for fact in facts) or not (has_points or analog_alone):
        raise FormatError("the file has no points", remedy="Files with analog channels alone are not read.")
    layouts = [_layout(dict(zip(names, values, strict=True))) for values in _combinations(facts)]
    layouts = [
        layout for layout in layouts if (layout.points if has_points else layout.frame_bytes) and layout.start >= BLOCK
    ]
    if not layouts:
        raise FormatError("the header does not say where the points begin", remedy="Send the C3D file itself.")
    ends = {layout: _limit(said, layout.start, size) for layout in layouts}
    fitting = [layout for layout in layouts if 0 <= ends[layout] - layout.end < BLOCK]
    chosen = _tightest(fitting, ends, is_zero) if fitting else layouts[0]
    _tell(facts, chosen, bool(fitting), notices)
    return chosen if fitting else _as_many_as_there_are(chosen, ends[chosen], is_zero, notices)


def _facts(said: Statements) -> list[_Fact]:
    """Return all statements about the layout. Words 2 to 10 of the header, and the parameters that repeat them."""
    words, number = said.words, said.number
    # Some older files say that a frame has 0 samples, and have one.
    samples = float(words[9]) or 1.0
    points = [(float(words[1]), "the header"), (number("POINT:USED"), "POINT:USED")]
    starts = [(float(words[8]) or None, "the header"), (number("POINT:DATA_START") or None, "POINT:DATA_START")]
    if not any(start for start, _ in starts):
        starts = [(said.section[1] // BLOCK + 1, "the length of the parameters")]
    used = number("ANALOG:USED")
    analog: list[tuple[float | None, str]] = [(float(words[2]), "the header")]
    if used is not None:
        analog.append((used * samples, "ANALOG:USED and the header's samples"))
        rates = number("ANALOG:RATE"), number("POINT:RATE") or said.rate
        if rates[0] and rates[1] and rates[0] > 0 and rates[1] > 0:
            analog.append((used * round(min(rates[0] / rates[1], 1e4)), "ANALOG:USED and ANALOG:RATE"))
    real = [(float(scale < 0), who) for scale, who in scales_said(said)]
    return [
        _Fact.of("start", starts),
        _Fact.of("points", points),
        _Fact.of("real", real),
        _Fact.of("analog", analog),
        _Fact.of("frames", _frame_counts(said)),
    ]


def scales_said(said: Statements) -> list[tuple[float, str]]:
    """Return the scale from the parameter and from the header, if they are numbers; 1 if neither is.

    Its sign tells whether points are floats (negative) or integers, which it multiplies.
    """
    scales = [(said.number("POINT:SCALE"), "POINT:SCALE"), (said.scale, "the header")]
    return [(scale, who) for scale, who in scales if scale and math.isfinite(scale)] or [(-1.0, "nobody")]


def _frame_counts(said: Statements) -> list[tuple[float | None, str]]:
    """Every program writes the two words of the header. Their maximum is 65,535; larger counts are in parameters."""
    words, number = said.words, said.number
    first, last = said.long("TRIAL:ACTUAL_START_FIELD"), said.long("TRIAL:ACTUAL_END_FIELD")
    fields = last - first + 1 if first is not None and last is not None and last >= first else None
    counts: list[tuple[float | None, str]] = [
        (max(0.0, float(words[4] - words[3] + 1)), "the header"),
        (fields, "TRIAL:ACTUAL_END_FIELD"),
        (number("POINT:LONG_FRAMES") or None, "POINT:LONG_FRAMES"),
        (number("POINT:FRAMES") or None, "POINT:FRAMES"),
    ]
    if any((count or 0) > _CAPPED for count, _ in counts):
        capped = (_CAPPED, float(_CAPPED - words[3] + 1))
        counts = [count for count in counts if count[0] not in capped]
    return sorted(counts, key=lambda count: (count[0] or 0) <= _CAPPED)


def _combinations(facts: list[_Fact]) -> list[tuple[int, ...]]:
    """List all combinations of the statements, those closest to the most trusted statements first."""
    choices = itertools.product(*(range(len(fact.said)) for fact in facts))
    return [
        tuple(fact.said[place][0] for fact, place in zip(facts, chosen, strict=True))
        for chosen in sorted(choices, key=lambda chosen: (sum(map(bool, chosen)), sum(chosen)))
    ]


def _layout(values: dict[str, int]) -> Layout:
    start = (values["start"] - 1) * BLOCK
    return Layout(start, values["frames"], values["points"], values["analog"], bool(values["real"]))


def _limit(said: Statements, start: int, size: int) -> int:
    """Where data that begin there must end: at the end of the file, or where parameters behind them begin."""
    return min(said.section[0], size) if said.section[0] > start else size


def _tightest(fitting: list[Layout], ends: dict[Layout, int], is_zero: Callable[[int, int], bool]) -> Layout:
    """Of several that fit within the last block, the shortest with nothing but zeros behind it, or else the first.

    A layout that is too short leaves data behind it; one that is too long takes padding for data.
    """
    if len({(layout.start, layout.end) for layout in fitting}) == 1:
        return fitting[0]
    clean = [layout for layout in fitting if is_zero(layout.end, ends[layout])]
    return min(clean, key=lambda layout: layout.end) if clean else fitting[0]


def _tell(facts: list[_Fact], chosen: Layout, fits: bool, notices: list[Notice]) -> None:
    """Add contradicting statements about the layout to the receipt."""
    for fact in facts:
        if len(fact.said) > 1:
            said = " and ".join(f"{_SHOWN[fact.name](value)} by {who}" for value, who in fact.said)
            value = _SHOWN[fact.name](_stated(chosen)[fact.name])
            why = "fit the size of the file and count" if fits else "count; nothing fits the size of the file"
            note(notices, "warning", f"header and parameters disagree ({said}): {value} {why}")


def _stated(layout: Layout) -> dict[str, int]:
    """The values of a layout as files state them."""
    return {
        "start": layout.start // BLOCK + 1,
        "points": layout.points,
        "real": int(layout.real),
        "analog": layout.analog,
        "frames": layout.frames,
    }


def _as_many_as_there_are(
    layout: Layout, end: int, is_zero: Callable[[int, int], bool], notices: list[Notice]
) -> Layout:
    """Return the number of frames in the bytes, if it is less or more than stated."""
    declared, held = layout.frames, max(0, end - layout.start) // layout.frame_bytes
    if held < declared:
        if held == 0:
            raise FormatError(
                f"the file says it has {declared} frames, and its data hold none",
                remedy="Send the whole file, or save it again with another program.",
            )
        note(notices, "warning", f"the file says it has {declared} frames, {held} follow: these count")
    elif is_zero(layout.end, end):
        return layout
    else:
        behind = layout.start + held * layout.frame_bytes
        while end - behind + layout.frame_bytes < BLOCK and is_zero(behind - layout.frame_bytes, end):
            held, behind = held - 1, behind - layout.frame_bytes
        if end - behind >= BLOCK or not is_zero(behind, end):
            note(
                notices,
                "warning",
                f"{end - layout.end} bytes follow the {declared} frames that the file says it has: they were not read",
            )
            return layout
        note(notices, "warning", f"the file says it has {declared} frames, its bytes hold {held}: these count")
    return Layout(layout.start, held, layout.points, layout.analog, layout.real)
