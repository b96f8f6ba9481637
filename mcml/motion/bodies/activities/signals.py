"""Signals of a body over time, from which activities are recognised. Lengths are leg lengths, times seconds.

In leg lengths, bodies of any size and clips of any unit can be compared (dynamic similarity: Alexander, "Optimization
and gaits in the locomotion of vertebrates", 1989).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.bodies.local_fit import slopes
from mcml.motion.bodies.stretch import HIPS, NECK, Stretch
from mcml.motion.feet.contacts import standing, standing_height
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, length

Flags = NDArray[np.bool_]
Side: TypeAlias = Literal["left", "right"]

SIDES: Final[tuple[Side, Side]] = ("left", "right")
JOINTS: Final = (
    *NECK.split("|"),
    *(f"{side}_{part}" for side in SIDES
      for part in ("up_leg", "low_leg", "foot", "toes", "up_arm", "low_arm", "hand")),
)  # fmt: skip
"""The joints that are looked at."""
SETTLED: Final = 0.25
"""Standard deviation in seconds of the Gaussian over speeds: the sway of single steps is gone."""


@dataclass(frozen=True, eq=False)
class BodySignals:
    """Signals of n frames, NaN where unknown.

    stretch: the body, with JOINTS. scale: leg lengths of a step of its rounded positions. frame_time: seconds.
    """

    stretch: Stretch
    scale: float
    frame_time: float

    @classmethod
    def of(cls, stretch: Stretch) -> BodySignals | None:
        """None if the length of the leg or the frame time is unknown, or the clip has fewer than 3 frames."""
        leg = stretch.calibration.leg
        if leg is None or stretch.frame_time is None or stretch.frames < 3:
            return None
        return cls(stretch, stretch.calibration.step / leg, stretch.frame_time)

    def frames_in(self, seconds: float) -> int:
        """The number of frames of a duration, 1 at least."""
        return max(1, round(seconds / self.frame_time))

    def at(self, joint: str) -> Array:
        """(n, 3) positions of a joint."""
        return self.stretch.at(joint) * self.scale

    def height(self, places: Array) -> Array:
        """(n,) of positions (n, 3), from the origin."""
        heights: Array = places @ self.stretch.up
        return heights

    def level(self, vectors: Array) -> Array:
        """Vectors (n, 3) without their part upwards."""
        flat: Array = vectors - (vectors @ self.stretch.up)[:, None] * self.stretch.up
        return flat

    def velocity(self, values: Array, settled: float = SETTLED) -> Array:
        """(n, k) slopes of values (n, k) per second, through a Gaussian of a standard deviation in seconds."""
        return smooth(slopes(values, self.frame_time), settled / self.frame_time)

    @cached_property
    def hips(self) -> Array:
        """(n, 3) positions of the middle of the hips."""
        return self.stretch.middle(HIPS) * self.scale

    @cached_property
    def lifts(self) -> Array:
        """(2, n) heights of the left and the right foot above their standing height: of the ankle or the toes, which
        is lower."""
        found = []
        for side in SIDES:
            parts = [self.at(f"{side}_{part}") for part in ("foot", "toes")]
            heights = [self.height(part) - _standing_height(part, self.stretch.up) for part in parts]
            found.append(np.fmin(*heights))
        return np.stack(found)

    @cached_property
    def stands(self) -> Flags:
        """(2, n) whether the left and the right foot are planted."""
        found = np.zeros((2, self.stretch.frames), dtype=np.bool_)
        for flags, side in zip(found, SIDES, strict=True):
            for part in ("foot", "toes"):
                places = self.at(f"{side}_{part}")
                heights = self.height(places) - _standing_height(places, self.stretch.up)
                speeds = length(slopes(places, self.frame_time))
                for first, end in standing(heights, speeds, self.frame_time):
                    flags[first:end] = True
        return found

    @cached_property
    def apart(self) -> Array:
        """(n,) level distance of the ankles."""
        return length(self.level(self.at("left_foot") - self.at("right_foot")))

    @cached_property
    def speed(self) -> Array:
        """(n,) of the hips over the ground, or over the lower foot, the larger of both: a body on a treadmill, or
        whose root stays in place, travels as well."""
        over_ground = self.velocity(self.level(self.hips))
        feet = [self.level(self.hips - self.at(f"{side}_foot")) for side in SIDES]
        over = np.stack([slopes(foot, self.frame_time) for foot in feet])
        lower = np.argmin(np.where(np.isnan(self.lifts), np.inf, self.lifts), axis=0)
        over_foot = smooth(over[lower, np.arange(len(lower))], SETTLED / self.frame_time)
        return np.fmax(length(over_ground), length(over_foot))

    @cached_property
    def turning(self) -> Array:
        """(n,) degrees a second of the line through the hips about the axis up, to the left."""
        return self.velocity(self.directions(self.stretch.level_left())[:, None])[:, 0]

    def directions(self, vectors: Array) -> Array:
        """(n,) degrees of vectors (n, 3) about the axis up, to the left, without leaps of 360."""
        ahead = np.roll(np.abs(self.stretch.up), 1)
        beside = np.cross(self.stretch.up, ahead)
        angles: Array = np.degrees(np.arctan2(vectors @ beside, vectors @ ahead))
        seen = np.isfinite(angles)
        angles[seen] = np.unwrap(angles[seen], period=360.0)
        return angles

    @cached_property
    def lean(self) -> Array:
        """(n,) degrees between the trunk and the axis up."""
        trunk = self.at(NECK) - self.hips
        return angle_between(trunk, np.broadcast_to(self.stretch.up, trunk.shape))


def smooth(values: Array, deviation: float) -> Array:
    """Values (n, k) through a Gaussian of a standard deviation in frames. Unknown rows stay NaN; for the rows around
    them they are interpolated."""
    seen = np.isfinite(values).all(axis=1)
    if not seen.any():
        return np.full_like(values, np.nan)
    rows = np.arange(len(values))
    filled = values
    if not seen.all():
        filled = np.stack([np.interp(rows, rows[seen], column[seen]) for column in values.T], axis=1)
    smoothed: Array = scipy.ndimage.gaussian_filter1d(filled, deviation, axis=0, mode="nearest")
    smoothed[~seen] = np.nan
    return smoothed


def confidence_of(value: float, least: float, sure: float) -> float:
    """0.5 at the least value that counts, 1 from the sure one on, linear between them.

    >>> confidence_of(45, least=40, sure=60), confidence_of(90, least=40, sure=60)
    (0.625, 1.0)
    """
    return float(np.clip(0.5 + 0.5 * (value - least) / (sure - least), 0.5, 1.0))


def _standing_height(places: Array, up: Array) -> float:
    seen = places[np.isfinite(places).all(axis=1)]
    return standing_height(seen, up) if len(seen) else float("nan")
