"""Generated dance clips with known beats, bars and tempo, as full-body clips. Law: docs/analyses/dance.md.

A dance is a function of time, which a frame rate only samples. Deterministic in its arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import ClipStream
from mcml.motion.skeleton import Array
from mcml_service.demo import body

Style = Literal["groove", "hit", "step", "accent", "wave", "preparation"]

FIGURES, HOMES = 6, 2
PREPARATION = 2.0
"""Seconds of standing and shifting before, and again after, the dance of style `preparation`."""

_RANGES = np.array(
    [
        # low, high: degrees, except the shift of the weight (part of the height)
        (-25.0, 25.0),  # 0 turn of the trunk
        (-12.0, 12.0),  # 1 side bend
        (-5.0, 20.0),  # 2 forward bend
        (-12.0, 12.0),  # 3 nod of the head
        (-70.0, 50.0),  # 4 left arm: raise
        (-45.0, 45.0),  # 5 swing
        (5.0, 110.0),  # 6 bend
        (-70.0, 50.0),  # 7 right arm
        (-45.0, 45.0),
        (5.0, 110.0),
        (-0.09, 0.09),  # 10 weight
        (4.0, 40.0),  # 11 knees
    ]
)
_LOW, _SPAN = _RANGES[:, 0], _RANGES[:, 1] - _RANGES[:, 0]
_STANDING = np.array([0.0, 0, 0, 0, -72, 0, 8, -72, 0, 8, 0, 5])
_LEFT_ARM, _RIGHT_ARM, _WEIGHT = slice(4, 7), slice(7, 10), 10
_LAG = 0.025


@dataclass(frozen=True)
class Truth:
    """The true beats and bars of a clip. beats: (4n,) seconds from the first frame. bars: (n, 4) of them.

    period: seconds a beat, 60 / tempo. figures: (n,) the figure of each bar.
    """

    style: Style
    tempo: float
    period: float
    beats: Array
    bars: Array
    figures: NDArray[np.int64]


@dataclass(frozen=True)
class DanceClip:
    clip: ClipStream
    truth: Truth


@dataclass(frozen=True)
class _Keys:
    """Poses on beats, a bar before and a bar after the dance among them.

    times: (k,). poses: (k, 12). places: (k, 3) x, z, heading.
    """

    times: Array
    poses: Array
    places: Array


def dance_clip(
    style: Style,
    *,
    tempo: float = 112.0,
    bars: int = 8,
    fps: float = 60.0,
    seed: int = 0,
    dancer: int = 0,
    height: float = 170.0,
    jitter: float = 0.006,
    name: str = "dance",
) -> DanceClip:
    """Generate a clip and its truth.

    seed: selects the danced figures and their variations. dancer: seed of the dancer's figures.

    tempo: beats a minute. height: cm. jitter: standard deviation of a beat's time, seconds.
    """
    period = 60.0 / tempo
    start = PREPARATION if style == "preparation" else 0.0
    figures = np.array([_rng(seed, 1, bar).integers(FIGURES) for bar in range(bars + 2)])
    keys = _keys(style, period, start, figures, seed, dancer, jitter)
    seconds = 2 * start + 4 * bars * period
    time = np.arange(round(seconds * fps)) / fps
    if style == "wave":
        poses, places = _wave(time - start, period), np.zeros((len(time), 3))
    else:
        poses, places = _dance(style, keys, time)
    if style == "preparation":
        poses = _prepare(poses, keys, time, seconds)
    if style != "wave":
        poses = poses + _tremor(time, seed)
    counted = np.array([start + period * (beat + 0.5) for beat in range(4 * bars)])
    beats = counted if style == "wave" else keys.times[4:-4]
    root, angles = _pose(poses, places, height)
    made = body.clip(name, height, root, angles)
    made = made.with_head(replace(made.head, frame_time=f"{1 / fps:.9f}"))
    return DanceClip(made, Truth(style, tempo, period, beats, beats.reshape(-1, 4), figures[1:-1]))


def _rng(*key: int) -> np.random.Generator:
    return np.random.default_rng(list(key))


def _vocabulary(dancer: int) -> Array:
    """(FIGURES, 4, 12) poses of a dancer's figures; the fourth ones are homes, taken in turn."""
    rng = _rng(dancer, 0)
    homes = [_apart(rng, [])]
    while len(homes) < HOMES:
        homes.append(_apart(rng, homes))
    figures = []
    for number in range(FIGURES):
        home = homes[number % HOMES]
        first = _apart(rng, homes)
        second = _apart(rng, [first])
        figures.append([first, second, _apart(rng, [second, home]), home])
    return np.array(figures)


def _apart(rng: np.random.Generator, others: list[Array]) -> Array:
    """A pose at least a third of the range away from others, as a root of the mean square."""
    while True:
        pose: Array = _LOW + _SPAN * rng.random(len(_SPAN))
        if all(np.sqrt(np.mean(((pose - other) / _SPAN) ** 2)) >= 1 / 3 for other in others):
            return pose


def _keys(
    style: Style, period: float, start: float, figures: NDArray[np.int64], seed: int, dancer: int, jitter: float
) -> _Keys:
    """Keys of all bars danced, one bar before and one after among them."""
    vocabulary = _vocabulary(dancer)
    times: list[float] = []
    poses: list[Array] = []
    places: list[Array] = []
    place = np.zeros(3)
    for bar, figure in enumerate(figures, start=-1):
        rng = _rng(seed, 2, bar + 1)
        error = np.clip(rng.normal(0, 1, 4), -2, 2) * jitter
        varied = vocabulary[figure] + 0.04 * _SPAN * rng.normal(0, 1, (4, len(_SPAN)))
        way, turn, length = rng.uniform(0, 2 * np.pi), rng.uniform(-90, 90), rng.uniform(0, 1 / 3)
        travel = np.array([length * np.cos(way), length * np.sin(way), turn]) / 4
        for beat in range(4):
            times.append(start + period * (4 * bar + beat + 0.5) + error[beat])
            full = style != "accent" or beat % 2 == 0 or not poses
            poses.append(varied[beat] if full else poses[-1] + 0.6 * (varied[beat] - poses[-1]))
            place = place + travel * (style in ("step", "preparation"))
            places.append(place)
    return _Keys(np.array(times), np.array(poses), np.array(places) - places[3])


def _dance(style: Style, keys: _Keys, time: Array) -> tuple[Array, Array]:
    """Poses (F, 12) and places (F, 3) at times (F,)."""
    ease = _hold_jerk if style == "hit" else _cosine
    poses = _between(keys.times, keys.poses, time, ease)
    if style == "groove":
        poses[:, _LEFT_ARM] = _between(keys.times, keys.poses[:, _LEFT_ARM], time + _LAG, ease)
        poses[:, _RIGHT_ARM] = _between(keys.times, keys.poses[:, _RIGHT_ARM], time - _LAG, ease)
    return poses, _between(keys.times, keys.places, time, ease)


def _between(times: Array, values: Array, time: Array, ease: Callable[[Array], Array]) -> Array:
    last = np.clip(np.searchsorted(times, time, side="right"), 1, len(times) - 1)
    u = np.clip((time - times[last - 1]) / (times[last] - times[last - 1]), 0, 1)
    poses: Array = values[last - 1] + (values[last] - values[last - 1]) * ease(u)[:, None]
    return poses


def _cosine(u: Array) -> Array:
    eased: Array = (1 - np.cos(np.pi * u)) / 2
    return eased


def _hold_jerk(u: Array) -> Array:
    return _jerk(np.clip((u - 0.1) / 0.8, 0, 1))


def _jerk(u: Array) -> Array:
    eased: Array = u**3 * (10 - 15 * u + 6 * u**2)
    return eased


def _wave(time: Array, period: float) -> Array:
    """(F, 12): every value swings, one after the other, so that they never rest together."""
    phases = 2 * np.pi * np.arange(len(_SPAN)) / len(_SPAN)
    swing = np.cos(np.pi * (time[:, None] / period - 0.5) - phases)
    poses: Array = _LOW + _SPAN / 2 + 0.35 * _SPAN * swing
    return poses


def _prepare(poses: Array, keys: _Keys, time: Array, seconds: float) -> Array:
    """The dance with standing, slow shifting and lifting of the arms before and after it."""
    first, last = keys.times[3], keys.times[-4]
    sway = np.zeros_like(poses)
    sway[:, _WEIGHT] = 0.02 * np.sin(2 * np.pi * 0.3 * time)
    standing = _STANDING + sway
    before = _jerk(np.clip((time - 0.4) / (first - 0.4), 0, 1))[:, None]
    after = _jerk(np.clip((seconds - 0.4 - time) / (seconds - 0.4 - last), 0, 1))[:, None]
    early = standing + (keys.poses[3] - standing) * before
    late = standing + (keys.poses[-4] - standing) * after
    return np.where(time[:, None] < first, early, np.where(time[:, None] > last, late, poses))


def _tremor(time: Array, seed: int) -> Array:
    """(F, 12) three sine waves per value between 5 and 9 Hz, 0.05 degrees each; none on the weight."""
    rng = _rng(seed, 3)
    rates, phases = rng.uniform(5, 9, (3, len(_SPAN))), rng.uniform(0, 2 * np.pi, (3, len(_SPAN)))
    angles = 2 * np.pi * rates * time[:, None, None] + phases
    shaken: Array = 0.05 * np.sin(angles).sum(axis=1)
    shaken[:, _WEIGHT] = 0.0
    return shaken


def _pose(poses: Array, places: Array, height: float) -> tuple[Array, dict[str, Array]]:
    """(root, angles) of poses; hips and legs such that the ankles stay at the place and heading."""
    turn, side, forward, nod = poses[:, :4].T
    shift, bend = poses[:, _WEIGHT], np.maximum(poses[:, 11], 0.0)
    knee = np.radians(bend)
    leg = 0.491 * np.cos(knee)
    lean = np.arcsin(np.clip(shift / leg, -0.9, 0.9))
    heading = np.radians(places[:, 2])
    root = height * np.stack(
        [
            places[:, 0] + shift * np.cos(heading),
            0.059 + leg * np.cos(lean),
            places[:, 1] - shift * np.sin(heading),
        ],
        axis=1,
    )
    zero = np.zeros(len(poses))
    angles = {
        "Hips": _angles(zero, zero, places[:, 2]),
        "Spine": _angles(side, zero, turn),
        "Spine1": _angles(zero, forward, 0.4 * turn),
        "Head": _angles(-0.5 * side, nod - 0.5 * forward, -0.8 * turn),
    }
    for name, sign, arm in (("Left", 1.0, poses[:, _LEFT_ARM]), ("Right", -1.0, poses[:, _RIGHT_ARM])):
        angles[f"{name}UpLeg"] = _angles(-np.degrees(lean), -bend, zero)
        angles[f"{name}Leg"] = _angles(zero, 2 * bend, zero)
        angles[f"{name}Foot"] = _angles(zero, -bend, zero)
        angles[f"{name}Arm"] = _angles(sign * arm[:, 0], zero, -sign * arm[:, 1])
        angles[f"{name}ForeArm"] = _angles(zero, zero, -sign * arm[:, 2])
    return root, angles


def _angles(z: Array, x: Array, y: Array) -> Array:
    return np.stack([z, x, y], axis=1)
