"""Places of several dancers: where they start, the room that is left for a path, and their distances.

Points of the floor are complex numbers x + i z, metres, as in `stage`.
"""

from __future__ import annotations

import numpy as np

from mcml_service.analysis.dance.stage import Points, Stage

LINE = 3
"""Most dancers in one line; more of them form two."""


def form_lines(count: int, spacing: float, facing: float) -> Points:
    """(N,) places about 0: up to three dancers in a line across the direction they face, more in two lines.

    The lines are staggered, the fuller one behind, so that neighbours of both are a spacing apart. facing: radians to
    the left of +Z.

    >>> form_lines(3, 1.0, 0.0).real.tolist()
    [-1.0, 0.0, 1.0]
    """
    front = count if count <= LINE else count // 2
    back = count - front
    across = np.concatenate([np.arange(front) - (front - 1) / 2, np.arange(back) - (back - 1) / 2])
    if back and front == back:
        across[:front] -= 0.25
        across[front:] += 0.25
    along = np.repeat([0.0, -np.sqrt(0.75)], [front, back])
    places = spacing * (across + 1j * along) * np.exp(-1j * facing)
    centred: Points = places - places.mean()
    return centred


def find_room(stage: Stage, places: Points) -> Stage | None:
    """The part of a stage in which a path keeps dancers at places (N,) on the stage; None without any."""
    if stage.radius is not None:
        radius = stage.radius - float(np.abs(places).max())
        return Stage(radius) if radius > 0 else None
    width = stage.width - 2 * float(np.abs(places.real).max())
    depth = stage.depth - 2 * float(np.abs(places.imag).max())
    return Stage(None, width, depth) if min(width, depth) > 0 else None


def find_nearest(ways: Points) -> tuple[float, int, tuple[int, int]]:
    """The least distance of two roots, metres; its frame; and the two. ways: (N, F), N of at least 2."""
    found = [
        (float(distances.min()), int(distances.argmin()), (one, other))
        for one in range(len(ways))
        for other in range(one + 1, len(ways))
        for distances in [np.abs(ways[one] - ways[other])]
    ]
    return min(found)
