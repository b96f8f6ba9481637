"""Which anatomical movements a motion is made of: spans of frames with part, side and movement, as suggestions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from mcml.errors import ConversionError
from mcml.motion.anatomy.angles import Rate, anatomical_rates, spins
from mcml.motion.anatomy.axes import Segment, Stance, relative_turns, segments_of, stance_of
from mcml.motion.feet.contacts import hysteresis
from mcml.motion.hub import Rest, in_every_frame, walked
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array, Skeleton
from mcml.numerics.runs import find_true

CIRCLING = ("head", "neck", "trunk", "shoulder", "arm", "wrist", "fingers", "thumb", "finger-two", "finger-three",
            "finger-four", "finger-five", "leg", "foot")  # fmt: skip
"""Parts that circumduct: their bone goes round a cone."""
_ROUND = np.radians(330)
"""How much of a circle is one."""
_HARDLY, _STEADY = 0.2, 0.9
"""Of the median step: smaller ones have no heading. Of all turns of the heading: how many must go one way."""
_NARROWEST = np.radians(8)
"""Half the opening of a cone."""


@dataclass(frozen=True)
class Thresholds:
    """When a part moves. begin, end: degrees a second at which a span begins, and below which it ends. least: degrees
    that a span must cover. smooth: seconds, the deviation of the Gaussian over speeds. share: of all that the part
    does, the least that a movement must be on the mean."""

    begin: float = 30.0
    end: float = 12.0
    least: float = 12.0
    smooth: float = 0.05
    share: float = 0.45


@dataclass(frozen=True)
class Suggestion:
    """part, side ("left", "right", "" for parts without sides) and movement of the vocabulary of motion names.

    first, last: frames from 0. degrees: covered. confidence: 0 to 1.
    """

    part: str
    side: str
    movement: str
    first: int
    last: int
    degrees: float
    confidence: float


def suggest_movements(
    skeleton: Skeleton,
    rest: Rest,
    translations: Array,
    rotations: Array,
    frame_time: float,
    up: str = "Y",
    facing: str | None = None,
    thresholds: Thresholds | None = None,
) -> list[Suggestion]:
    """Anatomical movements of a clip, by their first frames.

    rest: of the skeleton. translations: (n, J, 3), rotations: (n, J, 4) local, of the hub form (`HubReader`).
    frame_time: seconds. facing: the axis along which the body faces when it is upright, such as "Z" or "-X", for rigs
    without sides in their names. Joints are found by MCML's names. Raises ConversionError for a frame time that is not
    positive, and if left and right are unknown.
    """
    if not (np.isfinite(frame_time) and frame_time > 0):
        raise ConversionError(f"{frame_time} seconds a frame are no frame rate", remedy="Give a positive number.")
    limits = thresholds or Thresholds()
    if len(rotations) < 2:
        return []
    ahead = None if facing is None else direction(facing)
    stance = stance_of(skeleton, rest, translations, rotations, direction(up), ahead)
    world = walked(skeleton, in_every_frame(rest.offsets, len(rotations)), rotations)[1]
    found = []
    for segment in segments_of(skeleton, rest, stance):
        circles = _circles(skeleton, segment, world, stance, frame_time, limits)
        busy = np.zeros(len(rotations), dtype=bool)
        for circle in circles:
            busy[circle.first : circle.last + 1] = True
        found += circles
        for rate in anatomical_rates(skeleton, segment, world, stance, frame_time):
            found += _spans(rate, busy, frame_time, limits)
    return sorted(found, key=lambda one: (one.first, one.last, one.part, one.side, one.movement))


def direction(axis: str) -> Array:
    """(3,) unit vector of an axis such as "Z" or "-X"."""
    unit: Array = np.eye(3)["XYZ".index(axis[-1].upper())]
    return -unit if axis.startswith("-") else unit


def _smoothed(values: Array, frame_time: float, limits: Thresholds) -> Array:
    smooth: Array = scipy.ndimage.gaussian_filter1d(values, limits.smooth / frame_time, axis=0, mode="nearest")
    return smooth


def _spans(
    rate: Rate, busy: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], frame_time: float, limits: Thresholds
) -> list[Suggestion]:
    smooth = np.degrees(_smoothed(rate.rate, frame_time, limits))
    speed = np.degrees(_smoothed(rate.speed, frame_time, limits))
    found = []
    for sign, movement in ((1.0, rate.movement), (-1.0, rate.opposite)):
        moves = sign * smooth
        moving = hysteresis((moves > limits.begin) & ~busy, (moves > limits.end) & ~busy)
        for first, end in find_true(moving).tolist():
            span = slice(first, end)
            degrees = float(moves[span].sum() * frame_time)
            share = float(moves[span].sum() / max(float(speed[span].sum()), 1e-12))
            if degrees >= limits.least and share >= limits.share:
                confidence = min(share, 1.0) * degrees / (degrees + limits.least)
                found.append(Suggestion(rate.part, rate.side, movement, first, end - 1, degrees, confidence))
    return found


def _circles(
    skeleton: Skeleton, segment: Segment, world: Array, stance: Stance, frame_time: float, limits: Thresholds
) -> list[Suggestion]:
    """Spans in which the end of a bone goes round."""
    if segment.part.name not in CIRCLING:
        return []
    turns = relative_turns(skeleton, world, stance, segment)
    bone = rotate(turns, segment.bone)
    swing = np.cross(rotate(turns, spins(turns, frame_time)), bone)
    speed = np.degrees(np.linalg.norm(_smoothed(swing, frame_time, limits), axis=1))
    found = []
    for first, end in find_true(hysteresis(speed > limits.begin, speed > limits.end)).tolist():
        found += _turns_round(segment, bone[first:end], first)
    return found


def _turns_round(segment: Segment, bone: Array, start: int) -> list[Suggestion]:
    """Return the longest frame range that goes around one axis at least once, if there is one."""
    axis = bone.mean(axis=0)
    length = float(np.linalg.norm(axis))
    if len(bone) < 8 or length < 0.1:
        return []
    axis /= length
    one = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    one /= np.linalg.norm(one)
    two = np.cross(axis, one)
    flat = np.stack([bone @ one, bone @ two], axis=1)
    steps = np.diff(flat, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    # Where the bone hardly moves it goes nowhere.
    heading = steps[lengths > _HARDLY * float(np.median(lengths))]
    turning = np.diff(np.unwrap(np.arctan2(heading[:, 1], heading[:, 0])))
    total = float(abs(turning.sum()))
    apart = float(np.arcsin(min(1.0, np.linalg.norm(flat - flat.mean(axis=0), axis=1).min())))
    if total < _ROUND or apart < _NARROWEST / 2:
        return []
    share = min(1.0, total / float(np.abs(turning).sum()))
    if share < _STEADY:
        return []
    side = segment.side
    degrees = float(np.degrees(total))
    return [Suggestion(segment.part.name, side, "circumduction", start, start + len(bone) - 1, degrees, share)]
