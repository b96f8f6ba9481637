"""Example queries about the motion of a library, each of which finds frames in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from mcml.motion.bodies.activities.recognition import recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.skeleton import Array
from mcml_schemas.querying.examples import QueryExample
from mcml_service.actions.suggesting.sample_motion import MotionSample
from mcml_service.xpath.language.tree import Literal
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.limits import Limits

MOST = 8
MOST_OF_BODIES = 6
_HANDS = ("left_hand", "right_hand", "left_foot", "right_foot", "Head", "Root")
_FEET = ("right_toes", "left_toes", "right_foot", "left_foot")
_HIGH = ("right_hand", "left_hand", "left_toes", "right_toes", "Head")
_BENDS = ("left-knee-flexion", "right-knee-flexion", "left-elbow-flexion", "trunk-flexion")
_COMMON = ("stand", "lie", "step")
"""Activities that are examples only if no other is found."""


@dataclass(frozen=True)
class ExampleMaker:
    """Makes examples of the motion of a sample.

    labels: of the library, the most frequent first. limits: no example is made after their time is up.
    """

    sample: MotionSample
    labels: list[str]
    limits: Limits

    def of_bodies(self) -> Iterator[QueryExample]:
        """Examples with functions of bodies."""
        yield from self._activities()
        yield from self._speed_on_foot()
        yield from self._above_head()
        yield from self._bend()
        yield from self._one_after_the_other()
        yield from self._near_hands()
        yield from self._fastest()
        yield from self._height()
        yield from self._speed()

    def of_elements(self) -> Iterator[QueryExample]:
        """Examples with elements of MCML."""
        for name in self.labels[:1]:
            yield _example("label", f"//frame[motion_name = {_text(name)}]", f"Frames with the label {name}", name=name)
            about = f"Frames without the label {name}"
            yield _example("no-label", f"//frame[not(motion_name = {_text(name)})]", about, name=name)
        yield _example("begin", "//frame[position() <= 30]", "The first 30 frames of each clip")
        yield _example("every", "//frame[position() mod 10 = 1]", "Every tenth frame")

    def _activities(self) -> Iterator[QueryExample]:
        found: Counter[str] = Counter()
        for _, body in self.sample.clips:
            if self.limits.over:
                break
            found.update({each.name for each in recognize_activities(body.stretch(JOINTS))})
        for name in sorted(found, key=lambda name: (name in _COMMON, -found[name], name)):
            about = f"Frames of the activity {name}"
            yield _example("activity", f"//frame[mo:activity('{name}')]", about, name=name)

    def _speed_on_foot(self) -> Iterator[QueryExample]:
        for joint, value in self._at_share("speed", _HANDS, 0.8):
            for foot, _ in self._at_share("contact", _FEET, 0.5):
                q = f"//frame[mo:speed('{joint}') > {value:g} and mo:contact('{foot}')]"
                about = f"{_words(joint)} faster than {value:g} m/s while the {_lower(foot)} are on the ground"
                yield _example("speed-contact", q, about, joint=joint, other=foot, value=value)
                return

    def _speed(self) -> Iterator[QueryExample]:
        for joint, value in self._at_share("speed", _HANDS, 0.9):
            about = f"{_words(joint)} faster than {value:g} m/s"
            yield _example("speed", f"//frame[mo:speed('{joint}') > {value:g}]", about, joint=joint, value=value)
            return

    def _height(self) -> Iterator[QueryExample]:
        for joint, value in self._at_share("height", _HIGH, 0.9):
            about = f"{_words(joint)} higher than {value:g} m"
            yield _example("height", f"//frame[mo:height('{joint}') > {value:g}]", about, joint=joint, value=value)
            return

    def _above_head(self) -> Iterator[QueryExample]:
        for joint, _ in self._at_share("height", ("right_hand", "left_hand"), 1.0):
            q = f"//frame[mo:height('{joint}') > mo:height('Head')]"
            yield _example("above-head", q, f"{_words(joint)} above the head", joint=joint)

    def _bend(self) -> Iterator[QueryExample]:
        for angle, value in self._at_share("angle", _BENDS, 0.8):
            about = f"{_words(angle.replace('-', '_'))} over {value:g}°"
            yield _example("angle", f"//frame[mo:angle('{angle}') > {value:g}]", about, angle=angle, value=value)
            return

    def _one_after_the_other(self) -> Iterator[QueryExample]:
        fast = dict(self._at_share("speed", ("left_hand", "right_hand"), 0.8))
        if len(fast) == 2:
            (one, first), (other, second) = fast.items()
            q = f"//frame[mo:speed('{one}') > {first:g} and mo:window(0, 1)[mo:speed('{other}') > {second:g}]]"
            about = (
                f"{_words(one)} faster than {first:g} m/s, then {_lower(other)} faster than {second:g} m/s within 1 s"
            )
            yield _example("then", q, about, joint=one, value=first, other=other, limit=second)

    def _near_hands(self) -> Iterator[QueryExample]:
        for _, value in self._at_share("distance", ("left_hand,right_hand",), 0.2):
            q = f"//frame[mo:distance('left_hand', 'right_hand') < {value:g}]"
            about = f"Hands nearer to each other than {value:g} m"
            yield _example("distance", q, about, joint="left_hand", other="right_hand", value=value)

    def _fastest(self) -> Iterator[QueryExample]:
        for joint, _ in self._at_share("speed", _HANDS, 0.9):
            for name in self.labels[:1]:
                q = f"mo:top(3, //frame[motion_name = {_text(name)}], mo:speed('{joint}'))"
                about = f"The three ranges labelled {name} in which the {_lower(joint)} is fastest"
                yield _example("fastest", q, about, joint=joint, name=name)
            return

    def _at_share(self, name: str, arguments: tuple[str, ...], share: float) -> Iterator[tuple[str, float]]:
        """Yield each argument with known values, and the round value that this share of frames is below."""
        for argument in arguments:
            if self.limits.over:
                return
            values = self.sample.values(name, tuple(argument.split(",")))
            if values:
                yield argument, _round_quantile(np.concatenate(values), share, name)


def find_examples(maker: ExampleMaker, finds: Callable[[QueryExample], bool]) -> list[QueryExample]:
    """Return at most eight examples that find frames, six of them about bodies if there are enough.

    finds: whether an example finds frames in the library.
    """
    limits = maker.limits
    elements = list(islice(_check(maker.of_elements(), finds, limits), MOST - MOST_OF_BODIES))
    return [*islice(_check(maker.of_bodies(), finds, limits), MOST - len(elements)), *elements]


def _check(
    examples: Iterator[QueryExample], finds: Callable[[QueryExample], bool], limits: Limits
) -> Iterator[QueryExample]:
    """Examples that find frames, one of a kind."""
    kinds: set[str] = set()
    for each in examples:
        if not limits.over and each.kind not in kinds and finds(each):
            kinds.add(each.kind)
            yield each


def _round_quantile(values: Array, share: float, name: str) -> float:
    """A quantile, rounded to a number that people would write."""
    value = float(np.quantile(values, share))
    if name == "angle":
        return float(5 * np.floor(value / 5))
    return float(f"{value:.1g}" if name == "speed" else f"{value:.2f}")


def _text(name: str) -> str:
    return unparse(Literal(name))


def _words(joint: str) -> str:
    return _lower(joint).capitalize()


def _lower(joint: str) -> str:
    return joint.replace("_", " ").lower()


def _example(kind: str, q: str, about: str, **values: str | float) -> QueryExample:
    return QueryExample.model_validate({"kind": kind, "q": q, "about": about, "values": values})
