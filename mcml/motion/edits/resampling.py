"""Resample a clip to another frame rate.

Rotations go along the shorter arc (slerp), translations in straight lines: between two frames nothing rotates further
or faster than from one frame to the other, so limits are not exceeded and a hinge stays a hinge. A squad would also
have smooth velocities, but overshoots where a motion stops. For a smoother result, smooth afterwards. Times that exist
at both rates keep their values bit by bit.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Edited, in_columns, remade
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import HubWriter, Known, Shortfall
from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading

_LARGEST_RATIO = 1000
_MOST_FRAMES = 50_000_000
_DRIFT = 0.01
"""Frames by which the stated frame times (`0.0333333`) may leave a ratio of whole numbers over a whole clip."""


def frame_places(frames: int, frame_time: float, new_frame_time: float) -> Array:
    """Return the positions of the frames of another rate among n frames, from 0 (m,), exact where the rates agree.

    frame_time, new_frame_time: seconds. The last one is at or before the last old frame. Raises ConversionError for
    times that are not positive.

    >>> frame_places(5, 1 / 120, 1 / 80).tolist()
    [0.0, 1.5, 3.0]
    """
    if not (frame_time > 0 and new_frame_time > 0 and np.isfinite(frame_time) and np.isfinite(new_frame_time)):
        raise ConversionError(
            f"{frame_time} and {new_frame_time} seconds a frame are no frame rates", remedy="Give positive numbers."
        )
    ratio = new_frame_time / frame_time
    whole = Fraction(ratio).limit_denominator(_LARGEST_RATIO)
    if whole and abs(float(whole) - ratio) / ratio * frames < _DRIFT:
        count = (frames - 1) * whole.denominator // whole.numerator + 1
        return np.arange(count, dtype=np.float64) * whole.numerator / whole.denominator
    count = np.floor((frames - 1) / ratio) + 1
    if not count <= _MOST_FRAMES:
        raise ConversionError(
            f"{frames} frames of {frame_time:g} seconds would become {count:.3g} of {new_frame_time:g} seconds",
            remedy="Check the frame time.",
        )
    return np.arange(count, dtype=np.float64) * ratio


def resampled(
    skeleton: Skeleton, block: FrameBlock, frame_time: float, new_frame_time: float, reading: Reading = DEGREES
) -> Edited:
    """All frames of a clip at another rate, numbered from 1; motion names from the frame at or before.

    A sample is missing where either of its two neighbours is.
    """
    places = frame_places(len(block), frame_time, new_frame_time)
    return sampled(skeleton, block, places, reading)


def sampled(skeleton: Skeleton, block: FrameBlock, places: Array, reading: Reading = DEGREES) -> Edited:
    """A clip at places (m,) between its first frame, 0, and its last, n - 1; see `resampled`."""
    columns = skeleton.columns()
    raw = in_columns(block, columns)
    before = np.clip(np.floor(places).astype(np.intp), 0, max(len(block) - 1, 0))
    part = places - before
    if not part.any():
        nothing = Shortfall(np.zeros(len(skeleton)), np.zeros(len(skeleton)))
        return Edited(remade(block, columns, raw[before], before), nothing)
    after = np.minimum(before + 1, len(block) - 1)
    hub = HubReader(skeleton, reading).read(block)
    share = part[:, None]
    turned = slerp(hub.rotations[before], hub.rotations[after], np.broadcast_to(share, (len(part), len(skeleton))))
    moved = hub.translations[before] + share[..., None] * (hub.translations[after] - hub.translations[before])
    scales = hub.scales[before] + share * (hub.scales[after] - hub.scales[before])
    between = hub.values[before] + share * (hub.values[after] - hub.values[before])
    exact = part == 0.0
    between[exact] = hub.values[before[exact]]
    # A joint that does not move between two frames keeps its numbers too.
    same = np.ones((len(part), len(skeleton)), dtype=bool)
    for index, (joint, _) in enumerate(columns):
        same[:, joint] &= hub.values[before, index] == hub.values[after, index]
    writer = HubWriter(skeleton, reading)
    known = Known(between, exact[:, None] | same, near=True)
    values = writer.write(moved, turned, scales, known)
    gaps = np.isnan(raw[before]) | (np.isnan(raw[after]) & ~exact[:, None])
    values[gaps] = np.nan
    return Edited(remade(block, columns, values, before), writer.shortfall)
