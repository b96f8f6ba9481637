"""Questions about motion that chance writes, and what they mean, frame after frame."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

from tests.xpath.motion_twin import TURNED, Asked, Document, Node, best_runs

JOINTS = ("Root", "Head", "left_hand", "right_hand", "left_toes", "left_foot", "left_low_leg", "left_up_leg", "nobody")
ANGLES = (
    "right-elbow-flexion", "left-arm-abduction", "trunk-flexion", "left-hip-flexion", "right-hip-adduction",
    "left-leg-flexion", "left-knee-flexion", "right-hip-internal-rotation", *TURNED,
)  # fmt: skip
NAMES = ("walk", "jump", "left-leg-flexion")
AXES = ("x", "y", "z", "up", "front", "left")
RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "=": operator.eq,
}  # fmt: skip
SCALES = {
    "time": (0.0, 0.5), "unit": (0.001, 0.02), "leg": (0.7, 0.95), "height": (-0.1, 1.8), "position": (-0.6, 0.6),
    "distance": (0.1, 1.5), "angle": (0.0, 120.0), "tilt": (0.0, 120.0), "speed": (0.2, 6.0),
    "acceleration": (1.0, 90.0), "heading": (-180.0, 180.0), "rate": (-3.0, 3.0), "pose": (0.1, 0.8),
    "motion": (0.2, 0.8), "channel": (-20.0, 20.0),
}  # fmt: skip
"""Numbers that they are compared with."""


@dataclass(frozen=True)
class Question:
    """of: its nodes over documents, or the number that it is."""

    text: str
    of: Callable[[Sequence[Document]], list[Node] | float]


class Chance:
    """documents: those whose poses may be asked for."""

    def __init__(self, random: Random, documents: Sequence[Document]) -> None:
        self.random = random
        self.documents = [one for one in documents if one.frames]

    # -- numbers of a frame ----------------------------------------------------------------------------------------

    def quantity(self) -> tuple[str, Asked]:
        """One function, and which kind of number it is."""
        kind = self.random.choice([kind for kind in SCALES if self.documents or kind not in ("pose", "motion")])
        pick = self.random.choice
        if kind == "channel":
            name, channel = pick(("Root", "left_low_leg", "left_up_leg")), pick(("Rx", "Ry", "Tz"))
            return kind, Asked(
                f"number(frame_bone[@name='{name}'][1]/@{channel})", lambda d, i: _channel(d, i, name, channel)
            )
        if kind in ("pose", "motion"):
            return kind, self.unlike(kind)
        if kind == "rate":
            _, inner = self.quantity()
            return kind, Asked(f"mo:rate({inner.text})", lambda d, i: d.rates(inner)[i])
        arguments: tuple[str, ...] = ()
        if kind in ("height", "position", "speed", "acceleration"):
            arguments = (pick(JOINTS),)
            arguments += (pick(AXES),) if kind == "position" else ()
            arguments += (pick(JOINTS),) if kind != "height" and pick((True, False)) else ()
        elif kind in ("distance", "tilt"):
            arguments = (pick(JOINTS), pick(JOINTS))
        elif kind == "angle":
            arguments = (pick(ANGLES),) if pick((True, True, False)) else (pick(JOINTS), pick(JOINTS), pick(JOINTS))
        texts = []
        for place, text in enumerate(arguments):
            is_joint = not (kind == "position" and place == 1) and not (kind == "angle" and len(arguments) == 1)
            texts.append(f"frame_bone[@name='{text}']" if is_joint and self.random.random() < 0.2 else f"'{text}'")
        inside = any(text.startswith("frame_bone") for text in texts)

        def of(document: Document, frame: int) -> float:
            told = list(arguments)
            if inside:
                # A frame_bone that is not there names nothing.
                there = {name for name, _ in document.frames[frame].bones}
                told = [t if x.startswith("'") or t in there else "" for t, x in zip(told, texts, strict=True)]
            return document.quantity(kind, *told)[frame]

        return kind, Asked(f"mo:{kind}({', '.join(texts)})", of)

    def unlike(self, kind: str) -> Asked:
        """From a pose, or a stretch."""
        other = self.random.choice(self.documents)
        name = self.random.choice((other.name, other.uuid))
        name = other.uuid if sum(one.name == name for one in self.documents) > 1 else name
        first = self.random.randint(1, len(other.frames))
        if kind == "pose":
            return Asked(f"mo:pose-distance('{name}', {first})", lambda d, i: d.pose_distances(other, first)[i])
        last = min(len(other.frames), first + self.random.randint(0, 9))
        return Asked(
            f"mo:motion-distance('{name}', {first}, {last})", lambda d, i: d.motion_distances(other, first, last)[i]
        )

    def number(self) -> tuple[str, Asked]:
        """A quantity, or what is made of several or of a window."""
        kind, one = self.quantity()
        choice = self.random.random()
        if choice < 0.55:
            return kind, one
        if choice < 0.7:
            _, other = self.quantity()
            sign = self.random.choice("+-*")
            found = {"+": operator.add, "-": operator.sub, "*": operator.mul}[sign]
            return kind, Asked(f"({one.text} {sign} {other.text})", lambda d, i: found(one.of(d, i), other.of(d, i)))
        function = self.random.choice(("min", "max", "sum", "avg"))
        text, frames = self.window()
        return kind, Asked(
            f"{function}({text}/{one.text})",
            lambda d, i: _of_many(function, [d.all(one)[other] for other in frames(d, i)]),
        )

    def key(self) -> Asked | None:
        """What runs are better by: often how near they are, for which there is an index."""
        choice = self.random.random()
        if choice < 0.3:
            return None
        if choice < 0.6 or not self.documents:
            return self.number()[1]
        near = self.unlike(self.random.choice(("pose", "motion")))
        return Asked(f"-{near.text}", lambda d, i: -near.of(d, i))

    def window(self) -> tuple[str, Callable[[Document, int], list[int]]]:
        """Neighbours, some of which may be left out."""
        low, high = sorted(self.random.choice((-0.2, -0.1, -1 / 60, 0.0, 1 / 30, 0.05, 0.1)) for _ in range(2))
        by_frames = self.random.random() < 0.4
        if by_frames:
            low, high = sorted(self.random.randint(-7, 7) for _ in range(2))
        text = f"mo:window({low!r}, {high!r}{', ' + repr('frames') if by_frames else ''})"
        if self.random.random() < 0.8:
            return text, lambda d, i: d.window(i, low, high, by_frames=by_frames)
        kept = self.plain()
        return f"{text}[{kept.text}]", lambda d, i: [
            other for other in d.window(i, low, high, by_frames=by_frames) if d.all(kept)[other] is True
        ]

    # -- what holds in a frame -------------------------------------------------------------------------------------

    def plain(self) -> Asked:
        kind, number = self.number() if self.random.random() < 0.2 else self.quantity()
        sign = self.random.choice(("<", ">", ">=", "<="))
        bound = round(self.random.uniform(*SCALES[kind]), 3)
        return Asked(f"{number.text} {sign} {bound}", lambda d, i: _compared(number, number.of(d, i), sign, bound))

    def condition(self, depth: int = 2) -> Asked:
        choice = self.random.random()
        pick = self.random.choice
        if depth and choice < 0.2:
            one, other = self.condition(depth - 1), self.condition(depth - 1)
            if pick((True, False)):
                return Asked(f"({one.text} and {other.text})", lambda d, i: both(one.of(d, i), other.of(d, i)))
            return Asked(f"({one.text} or {other.text})", lambda d, i: either(one.of(d, i), other.of(d, i)))
        if depth and choice < 0.3:
            inner = self.condition(depth - 1)
            return Asked(f"not({inner.text})", lambda d, i: opposite(inner.of(d, i)))
        if choice < 0.38:
            joint, other_joint = pick(JOINTS), pick(JOINTS)
            touches = Asked(f"mo:contact('{joint}')", lambda d, i: truth(d.quantity("contact", joint)[i]))
            if pick((True, False)):
                return touches
            return Asked(
                f"{touches.text} != mo:contact('{other_joint}')",
                lambda d, i: differ(touches.of(d, i), truth(d.quantity("contact", other_joint)[i])),
            )
        if choice < 0.44:
            name = pick(NAMES)
            return Asked(f"motion_name = '{name}'", lambda d, i: name in d.frames[i].names)
        if choice < 0.72:
            return self.around()
        kind, number = self.number()
        sign = pick(("<", ">", ">=", "<="))
        bound = round(self.random.uniform(*SCALES[kind]), 3)
        return Asked(f"{number.text} {sign} {bound}", lambda d, i: _compared(number, number.of(d, i), sign, bound))

    def around(self) -> Asked:
        """What a window says."""
        text, frames = self.window()
        choice = self.random.randrange(7)
        if choice == 0:
            name = self.random.choice(NAMES)
            return Asked(
                f"{text}/motion_name = '{name}'", lambda d, i: any(name in d.frames[o].names for o in frames(d, i))
            )
        if choice == 1:
            count = self.random.randint(0, 8)
            return Asked(f"count({text}) > {count}", lambda d, i: len(frames(d, i)) > count)
        if choice == 2:
            return Asked(f"exists({text})", lambda d, i: bool(frames(d, i)))
        if choice == 3:
            bone, low = "left_low_leg", round(self.random.uniform(-10, 10), 2)
            return Asked(
                f"{text}/frame_bone[@name='{bone}']/@Rx > {low}",
                lambda d, i: any(_channel(d, o, bone, "Rx") > low for o in frames(d, i)),
            )
        if choice == 4:
            held = self.plain()
            return Asked(
                f"(every $w in {text} satisfies $w[{held.text}])",
                lambda d, i: all(d.all(held)[o] is True for o in frames(d, i)),
            )
        kind, number = self.quantity()
        sign = self.random.choice(("<", ">"))
        bound = round(self.random.uniform(*SCALES[kind]), 3)
        if choice == 5:
            return Asked(
                f"{number.text} {sign} {text}/{number.text}",
                lambda d, i: some(
                    [_compared(number, number.of(d, i), sign, d.all(number)[o]) for o in frames(d, i)]
                    + [None] * (_compared(number, number.of(d, i), sign, 0.0) is None)
                ),
            )
        return Asked(
            f"{text}/{number.text} {sign} {bound}",
            lambda d, i: some([_compared(number, d.all(number)[o], sign, bound) for o in frames(d, i)]),
        )

    # -- questions -------------------------------------------------------------------------------------------------

    def question(self) -> Question:
        held = self.condition()
        choice = self.random.random()
        if choice < 0.4:
            return Question(f"//frame[{held.text}]", lambda ds: _frames(ds, lambda d: _where(d, held)))
        if choice < 0.55:
            least, gap = (self.random.choice((0.0, 0.02, 0.05, 1 / 30, 0.1, 0.2)) for _ in range(2))
            after = f", {gap!r}" if self.random.random() < 0.6 else ""
            gap = gap if after else 0.0
            return Question(
                f"mo:runs(//frame[{held.text}], {least!r}{after})",
                lambda ds: _frames(ds, lambda d: d.long_runs(_where(d, held), least, gap)),
            )
        if choice < 0.7:
            count = self.random.choice((0, 1, 2, 5))
            key = self.key()
            after = "" if key is None else f", {key.text}"
            return Question(
                f"mo:top({count}, //frame[{held.text}]{after})",
                lambda ds: best_runs(ds, held, count, key),
            )
        if choice < 0.82:
            kind, number = self.bone()
            low = round(self.random.uniform(*SCALES[kind]), 3)
            return Question(
                f"//frame[{held.text}]/frame_bone[{number.text} > {low}]", lambda ds: bones(ds, held, number, low)
            )
        if choice < 0.92:
            return Question(f"count(//frame[{held.text}])", lambda ds: float(sum(len(_where(d, held)) for d in ds)))
        _, number = self.quantity()
        function = self.random.choice(("max", "sum", "avg"))
        return Question(
            f"{function}(//frame[{held.text}][{number.text} = {number.text}]/{number.text})",
            lambda ds: _of_all(function, [v for d in ds for i in _where(d, held) if (v := number.of(d, i)) == v]),
        )

    def bone(self) -> tuple[str, Asked]:
        """A number of a frame_bone: `of` takes its place among those of the document, (frame, bone)."""
        kind = self.random.choice(("height", "speed", "distance"))
        more = ("Root",) if kind == "distance" else ()

        def of(document: Document, place: Any) -> float:
            frame, bone = place
            found: float = document.quantity(kind, document.frames[frame].bones[bone][0], *more)[frame]
            return found

        return kind, Asked(f"mo:{kind}({', '.join(('.', *map(repr, more)))})", of)


def _where(document: Document, held: Asked) -> list[int]:
    if document.lacks(held.text):
        return []
    return [frame for frame, holds in enumerate(document.all(held)) if holds is True]


def _frames(documents: Sequence[Document], of: Callable[[Document], list[int]]) -> list[Node]:
    return [document.address(frame) for document in documents for frame in of(document)]


def bones(documents: Sequence[Document], held: Asked, number: Asked, low: float) -> list[Node]:
    return [
        document.address(frame, bone)
        for document in documents
        for frame in _where(document, held)
        for bone in range(len(document.frames[frame].bones))
        if float(number.of(document, (frame, bone))) > low  # type: ignore[arg-type]  # a place
    ]


def _channel(document: Document, frame: int, bone: str, channel: str) -> float:
    found = [values for name, values in document.frames[frame].bones if name == bone]
    return found[0].get(channel, math.nan) if found else math.nan


def _of_many(function: str, values: list[Any]) -> Any:
    """None for nothing, as XPath says; NaN where one of them is NaN."""
    total = 0.0
    for value in values:
        total += value
    if function == "sum":
        return total
    if not values:
        return None
    if function == "avg":
        return total / len(values)
    return math.nan if any(value != value for value in values) else (min if function == "min" else max)(values)


def _of_all(function: str, values: list[float]) -> float:
    if function == "sum":
        return math.fsum(values)
    if not values:
        return math.nan
    return max(values) if function == "max" else math.fsum(values) / len(values)


def _compared(number: Asked, value: Any, sign: str, other: Any) -> bool | None:
    """None where a number about a body is not known."""
    if "mo:" in number.text and (value != value or other != other):
        return None
    return value is not None and other is not None and RELATIONS[sign](value, other)


def truth(number: float) -> bool | None:
    return None if number != number else number == 1


def opposite(one: bool | None) -> bool | None:
    return None if one is None else not one


def both(one: bool | None, other: bool | None) -> bool | None:
    if one is False or other is False:
        return False
    return None if one is None or other is None else True


def either(one: bool | None, other: bool | None) -> bool | None:
    return opposite(both(opposite(one), opposite(other)))


def differ(one: bool | None, other: bool | None) -> bool | None:
    return None if one is None or other is None else one != other


def some(found: Sequence[bool | None]) -> bool | None:
    if any(one is True for one in found):
        return True
    return None if None in found else False
