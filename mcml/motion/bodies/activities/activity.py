"""An activity of a body, with its frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from mcml.errors import RequestError

_TWO_SIDED = {
    "turn": "turn {}",
    "kick": "{} kick",
    "wave": "{} wave",
    "reach": "{} reach",
    "raise hand": "raise {} hand",
}
_NAMES = ("walk", "run", "step", "jump", "stand", "sit", "crouch", "lie")
ACTIVITIES: Final = (*_NAMES, *(form.format(side) for form in _TWO_SIDED.values() for side in ("left", "right")))
"""The names of activities."""
ANY_ACTIVITY: Final = (*ACTIVITIES, *_TWO_SIDED)
"""These names, and those that mean either side."""
OF_ARMS: Final = ("wave", "reach", "raise hand")
"""Those of one arm."""


@dataclass(frozen=True)
class Activity:
    """name: one of ACTIVITIES. first, last: frames from 0. confidence: 0.5 to 1.

    degrees: of a turn. steps: of a walk, a run or steps.
    """

    name: str
    first: int
    last: int
    confidence: float
    degrees: float | None = None
    steps: int | None = None


def name_of(kind: str, side: str) -> str:
    """The name of an activity of one side.

    >>> name_of("raise hand", "left")
    'raise left hand'
    """
    return _TWO_SIDED[kind].format(side)


def names_meant(text: str) -> frozenset[str]:
    """The names that a text means: one activity, or one to both sides. Raises RequestError for others.

    >>> sorted(names_meant("turn"))
    ['turn left', 'turn right']
    """
    if text in ACTIVITIES:
        return frozenset({text})
    if text in _TWO_SIDED:
        return frozenset(name_of(text, side) for side in ("left", "right"))
    known = ", ".join(ANY_ACTIVITY)
    raise RequestError(f"{text!r} is no activity that is recognised", remedy=f"Take one of: {known}.")
