"""MT1: a moving skeleton in at most 4 KB, to be drawn without anything else known of the clip.

    bytes          what
    3              "MT1"
    1              flags: 1 a face, 2 markers (points without bones)
    4              J points, B bones, L poses of the loop, S poses of the whole clip: one byte each
    4              seconds that the loop lasts, from its first pose to its last: f32
    4              aspect: width of the picture over its height: f32
    4              ground step: see below, in heights of the picture: f32
    B x 3          bones in the order in which they are drawn, the farthest first: place of the one end, of the other,
                   and side + 4 * depth; side: 0 centre, 1 left, 2 right; depth: 0 farthest to 63 nearest
    L x J x 2      the loop: x, y of every point in every pose
    S x J x 2      the whole clip, from its first frame to its last, for scrubbing: likewise
    L + S          the way along the ground since the first pose of the loop, and of the whole clip, to the right: in
                   ground steps, modulo 256

Numbers are little-endian. x is 0 at the left edge of the picture and 255 at the right, y is 0 at the top and 255 at the
bottom, which is the ground where a clip touches it. A point's pixels are (x / 255 * aspect * height, y / 255 * height).
The place over the ground where the body stands is taken out, so the figure walks on the spot: let ticks on the floor
slide by the way; at one every 64 steps they fit together where the way begins again at 0. Poses are evenly spaced;
between them Catmull-Rom splines are within a pixel at 160 pixels height. Markers have no bones: each point is a dot,
and its side follows from nothing; L is 20 and S is 12 at most, with bodies 32 and 16.

The loop is the busiest 2.6 s of the clip, or all of a shorter one. The poster is the pose of the loop farthest from its
mean. The head is the end of the bone whose point is highest on average; nothing says so.
"""

from __future__ import annotations

import struct

import numpy as np

from mcml.motion.pictures.figures import Figure
from mcml.motion.skeleton import Array

MAGIC = b"MT1"
FACE, MARKERS = 1, 2
LOOP_SECONDS = 31 / 12
BODY_POSES, MARKER_POSES = (32, 16), (20, 12)
"""Of the loop, and of the whole clip."""
GROUND_STEP = 1 / 128
"""Two ways that a walker makes from pose to pose must not look alike: 128 steps are one height of the picture."""
_HEAD = struct.Struct("<3s5B3f")


def busiest(moved: Array, spacing: float) -> tuple[float, float]:
    """Return (start, end) of the loop in seconds: the LOOP_SECONDS with the most movement, or all of a shorter clip.

    moved: (n, P, 3) positions, without the travel over the ground. spacing: seconds between them.
    """
    whole = (len(moved) - 1) * spacing
    if whole <= LOOP_SECONDS:
        return 0.0, max(whole, 0.0)
    window = max(1, round(LOOP_SECONDS / spacing))
    speeds = np.linalg.norm(np.diff(moved, axis=0), axis=2).mean(axis=1)
    sums = np.concatenate([[0.0], np.cumsum(speeds)])
    start = int((sums[window:] - sums[:-window]).argmax()) * spacing if len(sums) > window else 0.0
    start = min(start, whole - LOOP_SECONDS)
    return start, start + LOOP_SECONDS


def loop_times(figure: Figure, start: float, end: float) -> Array:
    """(L,) when the poses of the loop are."""
    most = _poses(figure)[0]
    count = round((end - start) * (most - 1) / LOOP_SECONDS) + 1
    return np.linspace(start, end, min(most, max(count, 1 if end <= start else 2)))


def scrub_times(figure: Figure, frames: int, whole: float) -> Array:
    """(S,) when the poses of the whole clip are."""
    return np.linspace(0.0, whole, min(_poses(figure)[1], max(frames, 1)))


def _poses(figure: Figure) -> tuple[int, int]:
    return MARKER_POSES if figure.markers else BODY_POSES


def poses_at(positions: Array, spacing: float, times: Array) -> Array:
    """(k, P, 3) positions at times, by linear interpolation between the given ones, `spacing` seconds apart."""
    if spacing <= 0 or len(positions) < 2:
        return positions[np.zeros(len(times), dtype=np.intp)]
    at = np.clip(times / spacing, 0, len(positions) - 1)
    before = np.minimum(at.astype(np.intp), len(positions) - 2)
    share = (at - before)[:, None, None]
    found: Array = positions[before] * (1 - share) + positions[before + 1] * share
    return found


def carried(figure: Figure, positions: Array) -> Array:
    """(n, 3) what carries the figure: its root, or the middle of its points."""
    found: Array = np.median(positions, axis=1) if figure.root is None else positions[:, figure.root]
    return found


def draw(figure: Figure, loop: Array, scrub: Array, seconds: float, view: Array) -> bytes:
    """The picture. loop (L, P, 3), scrub (S, P, 3): positions of the figure's points. seconds: that the loop lasts.

    view: (3, 3) unit vectors to the right, up and towards who looks.
    """
    poses = np.concatenate([loop, scrub])
    flat = poses @ view.T
    way = carried(figure, poses) @ view[0]
    flat[..., 0] -= way[:, None]
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    extent = np.maximum(high - low, 0.02 * max(float((high - low)[:2].max()), 1e-30))
    across = np.rint((flat[..., 0] - low[0]) / extent[0] * 255)
    down = np.rint((high[1] - flat[..., 1]) / extent[1] * 255)
    places = np.stack([across, down], axis=-1).astype(np.uint8)
    count = len(loop)
    since = way - np.where(np.arange(len(way)) < count, way[0], way[count])
    ground = np.mod(np.rint(since / extent[1] / GROUND_STEP), 256).astype(np.uint8)
    bones = _bones(figure, flat[:count, :, 2].mean(axis=0))
    flags = FACE * figure.face + MARKERS * figure.markers
    sizes = (len(figure.points), len(figure.bones), count, len(scrub))
    aspect = float(extent[0] / extent[1])
    head = _HEAD.pack(MAGIC, flags, *sizes, min(seconds, 1e9), aspect, GROUND_STEP)
    return b"".join([head, bones.tobytes(), places.tobytes(), ground.tobytes()])


def _bones(figure: Figure, depths: Array) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return (B, 3) the bones in drawing order, the farthest first. depths: (P,) of the points, nearer is larger."""
    if not figure.bones:
        return np.empty((0, 3), np.uint8)
    pairs = np.array(figure.bones)
    middle = depths[pairs].mean(axis=1)
    order = np.argsort(middle, kind="stable")
    extent = float(np.ptp(middle)) or 1.0
    near = np.rint((middle - middle.min()) / extent * 63).astype(int)
    sides = np.array(figure.sides)[pairs[:, 1]]
    return np.column_stack([pairs, sides + 4 * near])[order].astype(np.uint8)
