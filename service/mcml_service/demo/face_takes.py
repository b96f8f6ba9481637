"""Facial marker takes in the shape of the founding paper's set: neutral, an expression, neutral again.

The law that makes them is written in docs/analyses/expression.md, with every constant. Millimetres, Y up, X to the
face's left, Z ahead.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, Shape, full_shape
from mcml.motion.markers import marker_skeleton
from mcml.motion.rotations import from_euler, rotate
from mcml.motion.skeleton import Array

RATE = 60
SECONDS = 4.0
HEAD = np.array([0.0, 1600.0, 0.0])

_ROWS: tuple[tuple[str, float, tuple[float, ...]], ...] = (
    # region, y, |x| of the markers of a row; 0 is one marker, others are pairs
    ("forehead", 72.0, (0.0, 18.0, 36.0, 52.0)),
    ("forehead", 56.0, (12.0, 30.0, 48.0)),
    ("brow", 40.0, (10.0, 22.0, 34.0, 46.0)),
    ("lid", 26.0, (22.0, 32.0, 42.0)),
    ("lid", 14.0, (22.0, 32.0, 42.0)),
    ("temple", 22.0, (58.0,)),
    ("temple", 4.0, (60.0,)),
    ("nose", 18.0, (0.0,)),
    ("nose", 4.0, (0.0,)),
    ("nose", -10.0, (0.0,)),
    ("nose", -12.0, (11.0,)),
    ("cheek", 0.0, (24.0, 38.0, 50.0)),
    ("cheek", -14.0, (26.0, 40.0, 54.0)),
    ("cheek", -28.0, (34.0, 46.0, 57.0)),
    ("lip", -32.0, (0.0, 8.0, 16.0)),
    ("lip", -38.0, (0.0, 6.0, 13.0)),
    ("lip", -41.0, (25.0,)),
    ("lip", -44.0, (0.0, 6.0, 13.0)),
    ("lip", -50.0, (0.0, 8.0, 16.0)),
    ("chin", -64.0, (0.0, 10.0, 20.0)),
    ("chin", -78.0, (0.0, 10.0, 20.0)),
    ("jaw", -54.0, (30.0, 42.0)),
    ("jaw", -68.0, (34.0, 46.0)),
)

_UNITS: dict[str, tuple[tuple[float, float], tuple[float, float], tuple[float, float, float]]] = {
    # centre (|x|, y), widths, move of a marker there (outwards, up, ahead)
    "inner_brow_up": ((12, 44), (10, 14), (0, 9, 0)),
    "outer_brow_up": ((40, 42), (12, 14), (0, 8, -1)),
    "brow_down": ((14, 42), (12, 10), (-5, -7, 2)),
    "lid_up": ((32, 26), (9, 4), (0, 3, 0)),
    "lid_down": ((32, 26), (9, 4), (0, -9, 0)),
    "lid_tight": ((32, 14), (9, 4), (0, 4, 1)),
    "cheek_up": ((40, -6), (12, 10), (1, 6, 4)),
    "nose_wrinkle": ((7, -2), (8, 10), (0, 5, 2)),
    "upper_lip_up": ((12, -34), (9, 5), (0, 7, 1)),
    "corner_up": ((25, -40), (12, 11), (9, 9, -6)),
    "corner_down": ((25, -42), (10, 11), (3, -9, -2)),
    "pucker": ((18, -41), (10, 10), (-10, 0, 9)),
    "stretch": ((25, -42), (11, 12), (11, -2, -4)),
    "puff": ((42, -22), (14, 14), (5, 0, 10)),
    "chin_up": ((8, -62), (12, 9), (0, 6, 3)),
}
JAW = "jaw"
UNITS = (*_UNITS, JAW)

_EXPRESSIONS: dict[str, dict[str, float]] = {
    "joy": {"corner_up": 1, "cheek_up": 1, "lid_tight": 0.7, JAW: 0.15},
    "surprise": {"inner_brow_up": 1, "outer_brow_up": 1, "lid_up": 1, JAW: 0.6},
    "anger": {"brow_down": 1, "lid_tight": 0.8, "chin_up": 0.5, "pucker": 0.25},
    "sadness": {"inner_brow_up": 0.9, "corner_down": 1, "chin_up": 0.7, "lid_down": 0.3},
    "fear": {"inner_brow_up": 1, "outer_brow_up": 0.5, "brow_down": 0.4, "lid_up": 1, "stretch": 1, JAW: 0.25},
    "disgust": {"nose_wrinkle": 1, "upper_lip_up": 1, "brow_down": 0.5, "cheek_up": 0.5, "corner_down": 0.4},
    "shout": {JAW: 1, "upper_lip_up": 0.4, "brow_down": 0.3},
    "kiss": {"pucker": 1, "chin_up": 0.3, "lid_down": 0.4},
    "wink": {"lid_down": 1, "cheek_up": 0.9, "corner_up": 0.5},
    "puff": {"puff": 1, "pucker": 0.3, "lid_up": 0.3},
}
EXPRESSIONS = tuple(_EXPRESSIONS)
_LEFT_ONLY = ("wink",)


@dataclass(frozen=True)
class FaceTake:
    """A generated take and the truth about it.

    amounts: (F, U) of the units `UNITS`. still: (F, M, 3) markers before head motion, noise and gaps, mm.
    rotations: (F, 4) of the head. positions: (F, 3) of the head, mm. present: (F, M) False in gaps.
    """

    clip: ClipStream
    name: str
    expression: str
    amounts: Array
    still: Array
    rotations: Array
    positions: Array
    present: NDArray[np.bool_]


def face_markers() -> tuple[tuple[str, ...], Array]:
    """Names of the 100 markers and their places (100, 3) in the neutral face."""
    names, places = [], []
    rows: dict[str, int] = {}
    for region, y, xs in _ROWS:
        rows[region] = rows.get(region, 0) + 1
        for place, x in enumerate(xs, 1):
            for side, sign in (("l", 1.0), ("r", -1.0)) if x else (("c", 0.0),):
                names.append(f"{region}_{rows[region]}_{place}_{side}")
                places.append((sign * x, y))
    x, y = np.array(places).T
    z = 85 * np.sqrt(1 - (x / 85) ** 2 - (y / 125) ** 2) + 22 * np.exp(-((x / 9) ** 2) - ((y + 5) / 18) ** 2)
    return tuple(names), np.stack([x, y, z], axis=1)


def face_takes(
    seed: int = 1,
    *,
    expressions: Sequence[str] = EXPRESSIONS,
    repeats: int = 1,
    fps: float = RATE,
    every_marker: int = 1,
    head: bool = False,
    noise: float = 0.0,
    gaps: float = 0.0,
) -> list[FaceTake]:
    """Ten takes of about 240 frames, or `repeats` times as many.

    fps: the same seed gives the same movements at any rate. every_marker: 2 keeps every second marker, and so on.
    head: whether it moves. noise: deviation of every coordinate, mm. gaps: share of the samples that is missing.
    """
    labels, neutral = face_markers()
    labels, neutral = labels[::every_marker], neutral[::every_marker]
    takes = []
    for number, random in enumerate(np.random.SeedSequence(seed).spawn(repeats * len(expressions)), 1):
        # Measurement has a separate random stream, so that noise and gaps do not change the movement.
        movement, heads, measurement = (np.random.default_rng(part) for part in random.spawn(3))
        expression = expressions[(number - 1) % len(expressions)]
        amounts = _amounts(movement, expression, fps)
        still = _move(neutral, amounts, left_only=expression in _LEFT_ONLY)
        rotations, positions = _head(heads, np.arange(len(still)) / fps, head)
        values = rotate(rotations[:, None], still) + positions[:, None]
        if noise:
            values = values + measurement.normal(0.0, noise, values.shape)
        present = _present(measurement, values.shape[:2], gaps)
        name = f"face_{number:03d}_{expression}"
        properties = (("take", str(number), ""), ("expression", expression, ""))
        clip = _clip(name, labels, np.round(values, 6) + 0.0, present, fps, properties)
        takes.append(FaceTake(clip, name, expression, amounts, still, rotations, positions, present))
    return takes


def _smooth_step(share: Array) -> Array:
    s = np.clip(share, 0.0, 1.0)
    step: Array = s**3 * (10 - 15 * s + 6 * s**2)
    return step


def _amounts(rng: np.random.Generator, expression: str, fps: float) -> Array:
    """(F, U) amounts of the units over a take."""
    length = SECONDS * rng.uniform(0.9, 1.1)
    rise, fall = 0.3 * length * rng.uniform(0.9, 1.1), 0.35 * length * rng.uniform(0.9, 1.1)
    rise_late, fall_late = rng.uniform(0, 0.2, len(UNITS)), rng.uniform(0, 0.3, len(UNITS))
    strength = np.exp(rng.normal(0, 0.08) + rng.normal(0, 0.08, len(UNITS)))
    offset = rng.normal(0, 0.015, len(UNITS))
    periods, phases = rng.uniform(1, 4, (3, len(UNITS))), rng.uniform(0, 2 * np.pi, (3, len(UNITS)))
    full = np.array([_EXPRESSIONS[expression].get(unit, 0.0) for unit in UNITS]) * strength
    time = (np.arange(round(length * fps)) / fps)[:, None]
    up = _smooth_step((time - 0.1 * length - rise_late * rise) / ((1 - rise_late) * rise))
    down = _smooth_step((time - (0.9 * length - fall) - fall_late * fall) / ((1 - fall_late) * fall))
    sway = np.sin(2 * np.pi * time[:, None] / periods + phases).sum(axis=1) * 0.01 / np.sqrt(3)
    amounts: Array = full * up * (1 - down) + offset + sway
    return amounts


def _move(neutral: Array, amounts: Array, *, left_only: bool) -> Array:
    """(F, M, 3) markers of the face at rest, moved by the units."""
    side, y = np.sign(neutral[:, 0]), neutral[:, 1]
    fields = np.empty((len(_UNITS), len(neutral), 3))
    for place, ((cx, cy), (sx, sy), move) in enumerate(_UNITS.values()):
        weight = np.exp(-0.5 * (((np.abs(neutral[:, 0]) - cx) / sx) ** 2 + ((y - cy) / sy) ** 2))
        if left_only:
            weight = weight * (side > 0)
        fields[place] = weight[:, None] * np.stack([side * move[0], *(np.full_like(y, part) for part in move[1:])], 1)
    moved = neutral + np.tensordot(amounts[:, :-1], fields, axes=1)
    angle = np.radians(22.0) * amounts[:, -1, None] / (1 + np.exp((y + 41.0) / 3.0))
    cos, sin, hinge = np.cos(angle), np.sin(angle), np.array([5.0, -10.0])
    up, ahead = moved[..., 1] - hinge[0], moved[..., 2] - hinge[1]
    turned: Array = np.stack([moved[..., 0], hinge[0] + cos * up - sin * ahead, hinge[1] + sin * up + cos * ahead], -1)
    return turned


def _head(rng: np.random.Generator, time: Array, moves: bool) -> tuple[Array, Array]:
    """(F, 4) rotations and (F, 3) positions of the head."""
    turn, place = rng.normal(0, (10, 6, 4)), rng.normal(0, 40, 3)
    waves = np.sin(2 * np.pi * time[:, None] / rng.uniform(3, 6, 6) + rng.uniform(0, 2 * np.pi, 6))
    if not moves:
        return np.tile([0.0, 0.0, 0.0, 1.0], (len(time), 1)), np.tile(HEAD, (len(time), 1))
    return from_euler(np.radians(turn + waves[:, :3] * (8, 5, 3)), "YXZ"), HEAD + place + 15 * waves[:, 3:]


def _present(rng: np.random.Generator, shape: tuple[int, ...], gaps: float) -> NDArray[np.bool_]:
    """Return (F, M) the mask of existing samples: runs of 2 to 12 frames are missing, and one of 20 to 40."""
    present = np.ones(shape, dtype=bool)
    if gaps <= 0:
        return present
    frames, markers = shape
    runs = round(gaps * frames * markers / 7)
    first, length = rng.integers(0, frames, runs), rng.integers(2, 13, runs)
    for start, count, marker in zip(first, length, rng.integers(0, markers, runs), strict=True):
        present[start : start + count, marker] = False
    start = int(rng.integers(0, max(1, frames - 40)))
    present[start : start + int(rng.integers(20, 41)), int(rng.integers(0, markers))] = False
    return present


def _clip(
    name: str,
    labels: Sequence[str],
    values: Array,
    present: NDArray[np.bool_],
    fps: float,
    properties: tuple[tuple[str, str, str], ...],
) -> ClipStream:
    skeleton = marker_skeleton(labels)
    columns = skeleton.columns()
    fields = {"filename": f"{name}.trc", "calibration_unit": "mm", "global_axis_of_gravity": "Y"}
    head = ClipHead("trc", skeleton, fields, frame_time=repr(1.0 / fps), number_style="fixed:6", properties=properties)
    whole = full_shape(columns)
    rows, shape_of = np.unique(present, axis=0, return_inverse=True)
    # A marker without sample stays in the frame by its name alone.
    shapes: tuple[Shape, ...] = tuple(
        tuple((marker, bits if row[marker] else 0) for marker, bits in whole) for row in rows
    )
    table = np.where(present[..., None], values, np.nan).reshape(len(values), -1)

    def blocks() -> Iterator[FrameBlock]:
        yield FrameBlock(table, columns, shapes, np.arange(1, len(table) + 1), shape_of.reshape(-1))

    return ClipStream(head, blocks, len(table))
