"""A motion that stays where it is: the way of the body over the ground taken out, steps and jumps kept."""

from __future__ import annotations

import numpy as np

from mcml.motion.carriers import carriers
from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Edited, in_columns, present, remade
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import HubWriter, Known
from mcml.motion.rotations import inverse, rotate
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading


def ground_path(skeleton: Skeleton, block: FrameBlock, up: str = "Y", reading: Reading = DEGREES) -> Array:
    """Return the way (n, 3) of a body over the ground since the first frame, in the clip's unit; 0 along `up`.

    It is that of the joint that carries the body; of markers, and of several bodies, the mean of the steps of all that
    are known in both of two successive frames.
    """
    hub = HubReader(skeleton, reading).read(block)
    positions, _ = walked(skeleton, hub.translations, hub.rotations)
    return _path(skeleton, block, positions, carriers(skeleton, hub.translations), up)


def stay_in_place(
    skeleton: Skeleton, block: FrameBlock, first: int, last: int, up: str = "Y", reading: Reading = DEGREES
) -> Edited:
    """Keep the body over the place where it is in a frame, for the frames first to last, from 0, both included.

    Heights, turns and the poses of all joints below the one that carries the body do not change. Later frames go on
    from there. block: the frames of the clip. up: the axis "X", "Y" or "Z" that points up.
    """
    hub = HubReader(skeleton, reading).read(block)
    positions, turned = walked(skeleton, hub.translations, hub.rotations)
    carry = carriers(skeleton, hub.translations)
    path = _path(skeleton, block, positions, carry, up)
    shift = path[first] - path[np.clip(np.arange(len(block)), first, last)]
    translations = hub.translations.copy()
    for joint in carry:
        parent = skeleton.joints[joint].parent
        translations[:, joint] += shift if parent < 0 else rotate(inverse(turned[:, parent]), shift)
    changed = np.zeros((len(block), len(skeleton)), dtype=bool)
    changed[np.ix_(shift.any(axis=1), list(carry))] = True
    writer = HubWriter(skeleton, reading)
    values = writer.write(translations, hub.rotations, hub.scales, Known(hub.values, ~changed, near=True))
    values[np.isnan(in_columns(block, skeleton.columns()))] = np.nan
    rows = np.arange(len(block), dtype=np.intp)
    return Edited(remade(block, skeleton.columns(), values, rows, block.ids), writer.shortfall)


def _path(skeleton: Skeleton, block: FrameBlock, positions: Array, carry: tuple[int, ...], up: str) -> Array:
    columns = skeleton.columns()
    seen = present(in_columns(block, columns), columns, len(skeleton))[:, list(carry)]
    ground = np.where("XYZ".index(up.upper()) == np.arange(3), 0.0, positions[:, list(carry)])
    known = seen[1:] & seen[:-1]
    steps = np.where(known[..., None], np.diff(ground, axis=0), 0.0).sum(axis=1)
    steps /= np.maximum(known.sum(axis=1), 1)[:, None]
    path: Array = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return path
