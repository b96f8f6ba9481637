"""All activities of a clip."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from mcml.motion.bodies.activities.activity import OF_ARMS, Activity, name_of, names_meant
from mcml.motion.bodies.activities.gestures import find_hand_gestures, find_kicks
from mcml.motion.bodies.activities.postures import find_postures
from mcml.motion.bodies.activities.signals import SIDES, BodySignals
from mcml.motion.bodies.activities.travel import find_jumps, find_travel, find_turns
from mcml.motion.bodies.stretch import HIPS, NECK, Stretch, known, once_a_stretch
from mcml.motion.skeleton import Array

LEGS: Final = tuple(f"{side}_{part}" for side in SIDES for part in ("up_leg", "low_leg", "foot"))
"""The joints without which nothing is recognised."""
_ARM = ("up_arm", "low_arm", "hand")


@lru_cache(maxsize=64)
def joints_needed(text: str) -> tuple[str, ...]:
    """The joints that an activity needs; any of those with `|` between them. Raises RequestError for unknown names."""
    names = names_meant(text)
    arms = [
        f"{side}_{part}" for side in SIDES for part in _ARM if any(name_of(kind, side) in names for kind in OF_ARMS)
    ]
    return (*LEGS, *arms, *([NECK] if arms else []))


@once_a_stretch
def recognize_activities(stretch: Stretch) -> tuple[Activity, ...]:
    """Activities by their first frames; several at a time may overlap.

    stretch: the whole clip, with `signals.JOINTS`. None where `find_unknown` says that nothing is recognised, and of
    limbs that it says are unknown.
    """
    signals = BodySignals.of(stretch)
    if signals is None or not all(joint in stretch.places for joint in LEGS):
        return ()
    travel = list(find_travel(signals))
    travels = np.zeros(stretch.frames, dtype=np.bool_)
    for one in travel:
        travels[one.first : one.last + 1] |= one.name in ("walk", "run")
    found = [
        *travel,
        *find_turns(signals),
        *find_jumps(signals, [one for one in travel if one.name == "run"]),
        *find_postures(signals),
        *find_kicks(signals),
        *find_hand_gestures(signals, travels),
    ]
    return tuple(sorted(found, key=lambda one: (one.first, one.last, one.name)))


def find_frames(stretch: Stretch, text: str) -> Array:
    """(n,) 1 in the frames of an activity (see `names_meant`), else 0; NaN where it cannot be recognised."""
    is_known = stretch.frame_time is not None and stretch.calibration.leg is not None
    if not is_known or any(known(joint, stretch.places) is None for joint in joints_needed(text)):
        return np.full(stretch.frames, np.nan)
    names = names_meant(text)
    flags = np.where(np.isfinite(stretch.middle(HIPS)[:, 0]), 0.0, np.nan)
    for activity in recognize_activities(stretch):
        if activity.name in names:
            flags[activity.first : activity.last + 1] = 1.0
    return flags


def find_unknown(stretch: Stretch) -> list[str]:
    """Sentences about unknown values of a clip that prevent the recognition of all or some activities."""
    if stretch.frame_time is None:
        return ["No activities are recognised, as the frame time is unknown."]
    lacking = [joint for joint in LEGS if joint not in stretch.places]
    if lacking:
        return [f"No activities are recognised, as the body has no {', '.join(lacking)}."]
    if stretch.calibration.leg is None:
        return ["No activities are recognised, as the length of the leg is unknown."]
    lacking = [joint.split("|")[0] for joint in joints_needed("reach") if known(joint, stretch.places) is None]
    if lacking:
        return [f"No movements of arms are recognised, as the body has no {', '.join(lacking)}."]
    return []
