"""Walks of one generated person, straight on and on curves to both sides."""

from __future__ import annotations

import numpy as np

from mcml.motion.clip import ClipStream
from mcml_service.demo import body

HEIGHT = 174.0
TURNS = (0.0, 25.0, -25.0, 50.0, -50.0, 90.0, -90.0)
"""Degrees a second to the left."""


def walks() -> list[ClipStream]:
    """A walk of six seconds for each of the turns."""
    names = {0.0: "straight"} | {turn: f"{'left' if turn > 0 else 'right'}_{abs(turn):.0f}" for turn in TURNS if turn}
    return [turning_walk(f"walk_{names[turn]}", HEIGHT, turn, 6.0) for turn in TURNS]


def turning_walk(
    name: str, height: float, degrees: float, seconds: float, *, heading: float = 0.0, away: float = 0.0
) -> ClipStream:
    """A walk that turns by so many degrees a second to the left. height, away (to the left): cm. heading: degrees."""
    root, angles = body.walk(height, seconds, 1.0, 6.0)
    time = np.arange(len(root)) / body.RATE
    yaw = np.radians(heading + degrees * time)
    side, forward = root[:, 0], np.diff(root[:, 2], prepend=root[0, 2])
    ways = np.cumsum(forward[:, None] * np.stack([np.sin(yaw), np.cos(yaw)], axis=1), axis=0)
    turned = np.stack([away + ways[:, 0] + side * np.cos(yaw), root[:, 1], ways[:, 1] - side * np.sin(yaw)], axis=1)
    zero = np.zeros_like(time)
    return body.clip(name, height, turned, {**angles, "Hips": np.stack([zero, zero, np.degrees(yaw)], axis=1)})
