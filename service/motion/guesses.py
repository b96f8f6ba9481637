"""What a clip that does not say its unit or its up axis is likely to mean. Guesses are told, and never written."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from service.motion.carriers import chain
from service.motion.clip import ClipHead
from service.motion.skeleton import Array, Skeleton
from service.motion.units import metres_of, metres_per_unit

HEIGHTS = (("m", 0.8, 3.0), ("ft", 3.5, 8.0), ("inch", 40.0, 95.0), ("cm", 95.0, 260.0), ("mm", 800.0, 2600.0))
"""Units, and between what heights a person is in them."""


def likely_units(height: float) -> list[str]:
    """Units in which a body of this height would be a person; several where they overlap."""
    return [name for name, low, high in HEIGHTS if low <= height <= high]


def likely_unit(head: ClipHead, pose: Array) -> tuple[str | None, float | None]:
    """The stated unit, else one in which a body of this size would be a person, and its metres; None for unknown.

    pose: (J, 3) positions, NaN where unknown. ASF states a factor: its values over it are inches in Vicon's files.
    """
    if stated := head.fields.get("calibration_unit"):
        return stated, metres_of(head)
    # A root that only stands in the world, away from the body, is no part of its height.
    aside = [joint for root in head.skeleton.roots for joint in chain(head.skeleton, root)[:-1]]
    pose = np.delete(pose, aside, axis=0)
    seen = pose[np.isfinite(pose).all(axis=1)]
    extent = float(np.ptp(seen, axis=0).max()) if len(seen) > 1 else 0.0
    factor = 0.0
    with suppress(ValueError):
        factor = float(head.fields.get("units_length", 0))
    if factor > 0:
        return (f"inch/{factor:g}", 0.0254 / factor) if "inch" in likely_units(extent / factor) else (None, None)
    units = likely_units(extent)
    return (units[0], metres_per_unit(units[0])) if units else (None, None)


def likely_up(skeleton: Skeleton, positions: Array) -> str:
    """The axis along which a body stands in a pose: "X", "Y", "Z", or with a minus where the head is below.

    positions: (J, 3) of one frame, NaN where a point was not seen. From the root, or the feet, to the head; bodies
    without such names, and points, stand along the axis along which they are longest. "Y" where nothing extends.
    """
    places = {joint.name: index for index, joint in enumerate(skeleton.joints)}
    feet = [places[name] for name in ("left_foot", "right_foot") if name in places] or [places.get("Root", 0)]
    if "Head" in places and len(skeleton) > 1:
        towards = positions[places["Head"]] - positions[feet].mean(axis=0)
        if np.isfinite(towards).all() and np.abs(towards).max() > 0:
            axis = int(np.abs(towards).argmax())
            return ("-" if towards[axis] < 0 else "") + "XYZ"[axis]
    seen = positions[np.isfinite(positions).all(axis=1)]
    if len(seen) < 2 or not np.ptp(seen, axis=0).any():
        return "Y"
    return "XYZ"[int(np.ptp(seen, axis=0).argmax())]
