"""A body of sticks that moves as functions of time say: positions of its joints, in leg lengths, Y up, facing Z."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.bodies.clip_body import ClipBody, body_at
from mcml.motion.clip import ClipHead
from mcml.motion.markers import marker_skeleton
from mcml.motion.skeleton import Array

THIGH = SHANK = 0.5
UPPER = FORE = 0.32
ANKLE, HALF_HIPS, TRUNK, HALF_SHOULDERS = 0.08, 0.1, 0.6, 0.2
NAMES = ("Root", *JOINTS)

Course = Callable[[Array], Array]
"""Of times (n,): values (n, 3), such as places."""


def still(*place: float) -> Course:
    return lambda times: np.tile(np.array(place, np.float64), (len(times), 1))


@dataclass(frozen=True)
class Puppet:
    """Courses of the middle of the hips, of the ankles, and of the hands from their shoulders. turn: radians of the
    body to the left. lean: radians of the trunk forwards."""

    hips: Course = field(default_factory=lambda: still(0, ANKLE + 0.99, 0))
    ankles: dict[str, Course] = field(
        default_factory=lambda: {"left": still(HALF_HIPS, ANKLE, 0), "right": still(-HALF_HIPS, ANKLE, 0)}
    )
    hands: dict[str, Course] = field(
        default_factory=lambda: {"left": still(0.02, -0.63, 0.02), "right": still(-0.02, -0.63, 0.02)}
    )
    turn: Callable[[Array], Array] = np.zeros_like
    lean: Callable[[Array], Array] = np.zeros_like

    def positions(self, times: Array) -> dict[str, Array]:
        """(n, 3) of each joint. Ankles are places in the world; all else turns with the body."""
        turn, lean = self.turn(times), self.lean(times)
        left = np.stack([np.cos(turn), 0 * turn, -np.sin(turn)], axis=1)
        ahead = np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=1)
        up = np.array([0.0, 1.0, 0.0])
        axis = np.cos(lean)[:, None] * up + np.sin(lean)[:, None] * ahead
        front = np.cos(lean)[:, None] * ahead - np.sin(lean)[:, None] * up
        hips = self.hips(times)
        neck = hips + TRUNK * axis
        found = {"Root": hips, "neck1": neck, "neck2": neck + 0.05 * axis, "Head": neck + 0.15 * axis}
        for side, sign in (("left", 1.0), ("right", -1.0)):
            hip = hips + sign * HALF_HIPS * left
            ankle = self.ankles[side](times)
            toes = ankle + 0.2 * ahead - (ANKLE - 0.02) * up
            shoulder = neck - 0.05 * axis + sign * HALF_SHOULDERS * left
            own = self.hands[side](times)
            hand = shoulder + own[:, :1] * left + own[:, 1:2] * axis + own[:, 2:] * front
            knee = bend(hip, ankle, THIGH, SHANK, ahead)
            elbow = bend(shoulder, hand, UPPER, FORE, -axis - 0.3 * front)
            parts = {"up_leg": hip, "low_leg": knee, "foot": ankle, "toes": toes}
            parts |= {"up_arm": shoulder, "low_arm": elbow, "hand": hand}
            found |= {f"{side}_{part}": places for part, places in parts.items()}
        return found

    def body(self, seconds: float, rate: float = 60.0, size: float = 85.0, heading: float = 0.0) -> ClipBody:
        """size: of a leg in source units. heading: radians by which all is turned about the axis up."""
        times = np.arange(round(seconds * rate)) / rate
        places = self.positions(times)
        points = np.stack([places[name] for name in NAMES], axis=1) * size
        cos, sin = np.cos(heading), np.sin(heading)
        turned = points @ np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
        head = ClipHead("trc", marker_skeleton(NAMES), {"global_axis_of_gravity": "Y"}, repr(1 / rate))
        return body_at(head, turned)


def bend(start: Array, end: Array, first: float, second: float, towards: Array) -> Array:
    """The middle joint of two bones from start to end, bent towards a direction; stretched where they are too short."""
    line = end - start
    far = np.linalg.norm(line, axis=1, keepdims=True)
    along = line / np.maximum(far, 1e-9)
    reach = np.clip(far, 0.05, 0.999 * (first + second))
    part = (first**2 - second**2 + reach**2) / (2 * reach)
    aside = towards - (towards * along).sum(axis=1, keepdims=True) * along
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-9)
    middle: Array = start + part * along + np.sqrt(np.maximum(first**2 - part**2, 0)) * aside
    return middle


def walking(speed: float = 1.4, step: float = 0.7, in_place: bool = False, curve: float = 0.0) -> Puppet:
    """speed: leg lengths a second; step: leg lengths; curve: radians a second to the left."""
    period = 2 * step / speed

    def ahead(distance: Array, aside: float, turn: Array) -> Array:
        if curve:
            radius = speed / curve
            centre = np.array([radius, 0.0, 0.0])
            spot = np.stack([-(radius - aside) * np.cos(turn), 0 * turn, (radius - aside) * np.sin(turn)], axis=1)
            return centre + spot
        return np.stack([np.full_like(distance, aside), 0 * distance, distance], axis=1)

    def foot(sign: float) -> Course:
        def course(times: Array) -> Array:
            phase = times / period + (0.0 if sign > 0 else 0.5)
            cycle, part = np.floor(phase), phase % 1.0
            # Planted for the first 0.6 of the cycle, then it swings.
            swing = np.clip((part - 0.6) / 0.4, 0, 1)
            smooth = swing * swing * (3 - 2 * swing)
            distance = (cycle + smooth - (0.0 if sign > 0 else 0.5) + 0.3) * 2 * step
            places = ahead(distance, sign * HALF_HIPS, distance / speed * curve)
            places[:, 1] = ANKLE + 0.12 * np.sin(np.pi * swing)
            if in_place:
                places[:, 2] -= speed * times
            return places

        return course

    def hips(times: Array) -> Array:
        places = ahead(speed * times, 0.0, times * curve)
        # Lowest when the feet are farthest apart: twice a cycle, at contact.
        places[:, 1] = ANKLE + 0.93 - 0.02 * np.cos(4 * np.pi * times / period)
        if in_place:
            places[:, 2] -= speed * times
        return places

    return Puppet(hips, {"left": foot(1.0), "right": foot(-1.0)}, turn=lambda times: times * curve)


def with_hand(puppet: Puppet, side: str, course: Course) -> Puppet:
    return replace(puppet, hands={**puppet.hands, side: course})
