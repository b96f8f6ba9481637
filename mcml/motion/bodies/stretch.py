"""Consecutive frames of a document, with cached values of the body that are needed often: vectors, sides, the trunk.

The neighbours of a frame are those in the document, also if they come from different takes. Numbers are steps of the
rounded positions until they become metres at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np

from mcml.motion.bodies.calibration import Calibration
from mcml.motion.bodies.positions import UNSEEN, Steps
from mcml.motion.pictures.figures import axis_of
from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, divided, dot, length, unit

P = ParamSpec("P")
Found = TypeVar("Found")

HIPS = ("left_up_leg", "right_up_leg")
SHOULDERS = ("left_up_arm", "right_up_arm")
NECK = "neck2|neck1|Head"
"""Where the trunk ends: the lowest joint of the neck."""

LEVEL = 0.1
"""Cosine of the angle to the vertical below which the line through the hips does not tell where a body faces."""


def once_a_stretch(
    method: Callable[Concatenate[Stretch, P], Found],
) -> Callable[Concatenate[Stretch, P], Found]:
    """Cache a method's result with its stretch, because many quantities share their first steps. Read-only."""

    @wraps(method)
    def found(stretch: Stretch, /, *args: P.args, **kwargs: P.kwargs) -> Found:
        key = (method.__name__, args, *kwargs.items())
        if key not in stretch.kept:
            stretch.kept[key] = method(stretch, *args, **kwargs)
        result: Found = stretch.kept[key]
        return result

    return found


@dataclass(frozen=True, eq=False)
class Stretch:
    """places: (frames, 3) rounded positions by MCML's names of joints. frame_time: seconds, None where unknown.

    first: the place of its first frame in the document, from 0. A calibration may leave out frames at the start.
    """

    places: Mapping[str, Steps]
    frames: int
    frame_time: float | None
    calibration: Calibration
    first: int = 0

    @cached_property
    def kept(self) -> dict[Hashable, Any]:
        """Cached results of `once_a_stretch`."""
        return {}

    def hold(self, method: Callable[[Stretch], Found], result: Found) -> None:
        """Keep the result of a function under `once_a_stretch` that is known from before."""
        self.kept[method.__name__, ()] = result

    @once_a_stretch
    def of_person(self, person: str) -> Stretch:
        """The same frames with the joints, lines and zeros of one of several people, without the prefix of the person.

        person: the prefix; "" for all names as they are.
        """
        if not person:
            return self
        begin = f"{person}:"
        own = {name.removeprefix(begin): steps for name, steps in self.places.items() if name.startswith(begin)}
        return replace(self, places=own, calibration=self.calibration.of_person(person))

    @property
    def skipped(self) -> int:
        """How many of its frames at the start are no part of the motion."""
        return max(0, self.calibration.skipped - self.first)

    @cached_property
    def up(self) -> Array:
        """(3,) unit vector."""
        return axis_of(self.calibration.up)

    @once_a_stretch
    def at(self, joint: str) -> Array:
        """(n, 3) steps, NaN where unknown. joint: a name, or several with `|` of which the first one known counts."""
        name = known(joint, self.places)
        if name is None:
            return np.full((self.frames, 3), np.nan)
        found = self.places[name].astype(np.float64)
        unseen = self.places[name][:, 0] == UNSEEN
        unseen[: self.skipped] = True
        if unseen.any():
            found[unseen] = np.nan
        return found

    def stacked(self, joints: Sequence[str]) -> Array:
        """(joints, n, 3) steps, NaN where unknown."""
        found = np.full((len(joints), self.frames, 3), np.nan)
        known = [place for place, name in enumerate(joints) if name in self.places]
        if known:
            steps = np.stack([self.places[joints[place]] for place in known])
            found[known] = steps
            unseen = steps[:, :, 0] == UNSEEN
            if unseen.any():
                found[np.array(known)[:, None], np.arange(self.frames)] = np.where(unseen[:, :, None], np.nan, steps)
        found[:, : self.skipped] = np.nan
        return found

    def between(self, start: str, end: str) -> Array:
        """(n, 3) steps from one joint to another."""
        return self.at(end) - self.at(start)

    @once_a_stretch
    def middle(self, joints: tuple[str, str]) -> Array:
        """(n, 3) steps, the middle of two joints."""
        middle: Array = (self.at(joints[0]) + self.at(joints[1])) / 2
        return middle

    @once_a_stretch
    def level_left(self) -> Array:
        """(n, 3) level unit vectors to the body's left, along the line through its hips; NaN where that is upright."""
        across = self.between(HIPS[1], HIPS[0])
        level = across - (across @ self.up)[:, None] * self.up
        return divided(level, length(level), LEVEL * length(across))

    @once_a_stretch
    def trunk_axes(self, sides: tuple[str, str]) -> tuple[Array, Array, Array]:
        """Unit vectors (n, 3) to the left, up and on of the trunk: up from between the hips to the neck, left along
        the line through two joints (left, right), perpendicular to up.
        """
        up = unit(self.at(NECK) - self.middle(HIPS))
        across = self.between(sides[1], sides[0])
        left = across - dot(across, up)[:, None] * up
        left = divided(left, length(left), LEVEL * length(across))
        return left, up, cross(left, up)


def known(joint: str, names: Collection[str]) -> str | None:
    """The first of names with `|` between them that is among others."""
    return next((name for name in joint.split("|") if name in names), None)
