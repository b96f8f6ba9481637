"""Corners of force plates that a document keeps, and the up axis and the floor of the laboratory by them.

The section `FORCE_PLATFORM:CORNERS` of a source has a line for each plate: x, y and z of its four corners, in the unit
and the axes of the clip.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from mcml.motion.clip import ClipHead
from mcml.motion.lexemes import lexeme
from mcml.motion.skeleton import Array

SECTION: Final = "FORCE_PLATFORM:CORNERS"
MOST_PLATES: Final = 255
"""The dimensions of a parameter of C3D are bytes."""

_ALONG: Final = 0.9
"""Of a normal, along an axis that it points along."""
_LARGEST: Final = float(np.finfo(np.float32).max)
_SAME_PLACE: Final = 1e-3
"""Of the longest side of a plate: more than rounding moves a corner."""
_LEAST_AREA: Final = 1e-6
"""Of the area of a square whose side is the longest edge."""


def usable_plates(corners: Array) -> Array:
    """Return those of plates (P, 4, 3) that have finite corners and an area."""
    finite = np.isfinite(corners).all(axis=(1, 2))
    with np.errstate(invalid="ignore", over="ignore"):
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1, initial=0.0)
        areas = np.linalg.norm(_normals(corners), axis=1)
        chosen: Array = corners[finite & (areas > _LEAST_AREA * edges**2)]
    return chosen


def section_of_plates(plates: Array) -> tuple[str, str]:
    """(name, text) of the section that keeps plates (P, 4, 3)."""
    return SECTION, "\n".join(" ".join(map(_short, plate)) for plate in plates.reshape(-1, 12).tolist())


def _short(value: float) -> str:
    """The fewest digits that are the same number, in the precision that it has: files have single precision."""
    single = np.float32(value if abs(value) <= _LARGEST else 0)
    return str(single).removesuffix(".0") if float(single) == value else lexeme(value)


def kept_plates(head: ClipHead) -> Array:
    """(P, 4, 3) corners of the usable plates that a clip keeps; lines of another form are passed over."""
    texts = [text for source in head.sources for name, text in source.sections if name == SECTION]
    rows = [line.split() for text in texts for line in text.split("\n", MOST_PLATES)[:MOST_PLATES]]
    return usable_plates(np.array(list(_numbers(rows)), dtype=np.float64).reshape(-1, 4, 3))


def _numbers(rows: Iterable[list[str]]) -> Iterable[list[float]]:
    for row in rows:
        try:
            numbers = [float(word) for word in row]
        except ValueError:
            continue
        if len(numbers) == 12:
            yield numbers


def match_plates(plates: Array, corners: Mapping[str, Array]) -> list[str | None]:
    """Name each of plates (P, 4, 3) by its corners: (4, 3) by name, in the same unit and axes.

    None for a plate that is elsewhere. Each name is given once.
    """
    free = dict(corners)
    names: list[str | None] = []
    with np.errstate(invalid="ignore", over="ignore"):
        for plate in plates:
            most = _SAME_PLACE * np.ptp(plate, axis=0).max()
            name = next((name for name, own in free.items() if np.abs(own - plate).max() <= most), None)
            free.pop(name or "", None)
            names.append(name)
    return names


def replace_plates(head: ClipHead, plates: Array) -> ClipHead:
    """Return a head with other plates (P, 4, 3) in place of its own; without any if there are none."""
    new = section_of_plates(plates)
    sources = []
    for source in head.sources:
        kept = [new if name == SECTION else (name, text) for name, text in source.sections]
        sources.append(replace(source, sections=tuple(part for part in kept if part[0] != SECTION or len(plates))))
    return replace(head, sources=tuple(sources))


def normal_axis(plates: Array, positions: Array) -> str | None:
    """Return the axis along the normals of plates (P, 4, 3), on the side where most points are, such as "Z" or "-Z".

    positions: (n, J, 3), NaN where unknown; without any the side is the one that the order of the corners states. None
    without plates, and where normals are oblique or along several axes.
    """
    if not len(plates):
        return None
    normals = _normals(plates)
    shares = np.abs(normals) / np.linalg.norm(normals, axis=1, keepdims=True)
    axes = shares.argmax(axis=1)
    axis = int(axes[0])
    if (axes != axis).any() or (shares.max(axis=1) < _ALONG).any():
        return None
    # Halves, because differences and means of the largest numbers overflow.
    heights = positions[..., axis].ravel() / 2 - np.median(plates[:, :, axis]) / 2
    heights = heights[np.isfinite(heights)] / 2
    # By the standard z of a plate, x cross y, points down.
    side = float(np.median(heights)) if len(heights) else 0.0
    return ("-" if (side or -float(normals[0, axis])) < 0 else "") + "XYZ"[axis]


def floor_of_plates(plates: Array, up: Array) -> tuple[float, float] | None:
    """Return (height of the lowest plate's middle, height of the highest one's) along up, (3,).

    None without plates whose normal is along up.
    """
    normals = _normals(plates)
    with np.errstate(invalid="ignore", divide="ignore"):
        level = np.abs(normals @ up) >= _ALONG * np.linalg.norm(normals, axis=1)
    heights = plates[level].mean(axis=1) @ up
    return (float(heights.min()), float(heights.max())) if len(heights) else None


def _normals(plates: Array) -> Array:
    """(P, 3) x cross y of plates, of any length."""
    x, y = plates[:, 0] - plates[:, 1], plates[:, 0] - plates[:, 3]
    normals: Array = np.cross(x, y)
    return normals
