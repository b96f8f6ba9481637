"""Reasons why clips have no value of a quantity, and warnings that name them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.motion.bodies.quantities import AskedQuantity
from mcml_service.clips.bodies import Body
from mcml_service.xpath.language.motion_functions import PREFIX
from mcml_service.xpath.language.tree import Call, Literal
from mcml_service.xpath.library.motion_notes import (
    OF_LENGTHS,
    OF_TIMES,
    WITH_FLOOR,
    WITH_TIMES,
    named,
    rested_on,
)

_WORDS = {"metres": "unit", "up": "up axis", "floor": "floor"}


def _call_of(asked: AskedQuantity) -> Call:
    return Call(PREFIX + asked.name, tuple(Literal(argument) for argument in asked.arguments))


def find_reason(asked: AskedQuantity, body: Body) -> str:
    """Tell why a body has no known sample of a quantity."""
    function = PREFIX + asked.name
    if asked.unit in OF_LENGTHS and not asked.of_file and body.calibration.metres is None:
        return "the unit of length is not known; set it with mcml set --unit"
    if (asked.unit in OF_TIMES or function in WITH_TIMES) and body.frame_time is None:
        return "the frame time is not known; set it with mcml set --frame-time"
    if function in WITH_FLOOR and not asked.of_gait and body.calibration.floor is None:
        return "the floor is not known; PATCH /documents/{id}/calibration sets it"
    return "no sample in the frame ranges is known"


def find_guesses(asked: AskedQuantity, body: Body) -> list[str]:
    """Return the words of guesses about a body that a quantity depends on."""
    origins = body.calibration.origins
    found = [] if asked.of_file else sorted(rested_on([_call_of(asked)]))
    guesses = [_WORDS[name] for name in found if origins[name].kind == "guessed"]
    if not set(body.doubtful).isdisjoint(asked.joints(body.names)):
        guesses.append("joint name")
    return guesses


class LeftOut:
    """Names of clips by the reason why they, or some of their values, are left out, in order of appearance."""

    def __init__(self) -> None:
        self._names: dict[str, list[str]] = {}

    def add(self, why: str, name: str) -> None:
        """Note a clip once for each reason."""
        names = self._names.setdefault(why, [])
        if not names or names[-1] != name:
            names.append(name)

    def warnings(self, documents: int) -> Iterator[str]:
        """Yield a sentence for each reason. documents: number of all clips."""
        for why, names in self._names.items():
            some = named(names, np.ones(len(names), np.bool_))
            yield f"{why} ({len(names):,} of {documents:,} clips: {some})."
