"""Postures that a body keeps: it stands, sits, crouches, lies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.motion.bodies.activities.activity import Activity
from mcml.motion.bodies.activities.signals import SIDES, BodySignals, confidence_of
from mcml.motion.vectors import angle_between, length
from mcml.numerics.runs import find_true

_STILL, _CALM = 0.15, 0.4
"""Speeds in leg lengths a second below which a body stands, and keeps another posture."""
_STRAIGHT, _BENT, _LOW = 0.85, 0.75, 0.25
"""Heights of the hips over an ankle in leg lengths: above which a leg is straight; below which it is bent; below which
a body sits on the ground."""
_LEVEL = 50.0
"""Degrees between a thigh and the axis down from which on a body may sit."""
_BESIDE = 0.3
"""Level distance in leg lengths of the hips from the ankles: a crouching body has them above its feet, else it would
fall; a sitting body is carried by something else."""
_LEANS, _LIES = 45.0, 60.0
"""Degrees of the trunk from the axis up: below which a body stands, and above which it lies."""
_STANDS, _KEEPS = 1.0, 0.6
"""Seconds of standing and of other postures at least."""


def find_postures(signals: BodySignals) -> Iterator[Activity]:
    """Times in which a body stands, sits, crouches or lies."""
    down = -signals.stretch.up
    extents, thighs = [], []
    for side in SIDES:
        hip, knee, ankle = (signals.at(f"{side}_{part}") for part in ("up_leg", "low_leg", "foot"))
        extents.append(signals.height(hip - ankle))
        thighs.append(angle_between(knee - hip, np.broadcast_to(down, hip.shape)))
    ankles = (signals.at("left_foot") + signals.at("right_foot")) / 2
    extent, thigh = np.fmax(*extents), np.fmin(*thighs)
    beside = length(signals.level(signals.hips - ankles))
    upright = ~(signals.lean > _LIES)
    bent = (extent < _BENT) & upright & (signals.speed < _CALM)
    sits = bent & (((thigh > _LEVEL) & (beside > _BESIDE)) | (extent < _LOW))
    poses = {
        "stand": ((extent > _STRAIGHT) & ~(signals.lean > _LEANS) & (signals.speed < _STILL), _STANDS),
        "sit": (sits, _KEEPS),
        "crouch": (bent & ~sits & (extent > _LOW) & (thigh > _LEVEL), _KEEPS),
        "lie": ((signals.lean > _LIES) & (extent < _STRAIGHT / 2) & (signals.speed < _CALM), _KEEPS),
    }
    for name, (flags, least) in poses.items():
        for first, end in find_true(flags).tolist():
            seconds = (end - first) * signals.frame_time
            if seconds >= least:
                yield Activity(name, first, end - 1, confidence_of(seconds, least / 2, 2 * least))
