"""Random but legal clips of every convention, for property tests. A seed is the whole of a clip."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.skeleton import CHANNEL_INDEX, Convention, EndSite, Joint, Skeleton, Triple

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
FORMAT_OF = {Convention.LISTED: "bvh", Convention.FIXED: "asf-amc", Convention.BASE: "htr"}


def random_clip(
    convention: Convention, seed: int, *, moving: bool = False, partial: bool = True, radians: bool = False
) -> ClipStream:
    """A tree of up to 12 joints and 20 frames in three blocks.

    moving: joints other than the root may move in their parents. partial: joints may have fewer than three angles.
    Every fifth middle angle is a quarter turn.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 12))
    file_order = str(rng.choice(ORDERS))
    joints: list[Joint] = []
    parents = _pre_order(rng, count)
    for index, parent in enumerate(parents):
        order = file_order if convention is Convention.BASE else str(rng.choice(ORDERS))
        letters = order
        if partial and convention is not Convention.BASE and parent >= 0:
            letters = "".join(letter for letter in order if rng.random() < 0.8)
        moves = parent < 0 or convention is Convention.BASE or (moving and rng.random() < 0.3)
        channels = (("Tx", "Ty", "Tz") if moves else ()) + tuple(f"R{letter.lower()}" for letter in letters)
        joint = Joint(f"j{index}", parent, f"j{index}", convention, channels, letters)
        joints.append(_placed(joint, order, index not in parents, rng, radians))
    skeleton = Skeleton(tuple(joints))
    fields = {"units_angle": "rad" if radians else "deg"}
    if convention is Convention.BASE:
        fields |= {"bone_length_axis": str(rng.choice(list("XYZ"))), "euler_rotation_order": file_order}
    values = _values(skeleton, rng, moving, radians)
    head = ClipHead(FORMAT_OF[convention], skeleton, fields, frame_time="0.01")
    return ClipStream(head, lambda: _blocks(skeleton, values), len(values))


def _pre_order(rng: np.random.Generator, count: int) -> list[int]:
    parents, path = [-1], [0]
    for index in range(1, count):
        path = path[: int(rng.integers(1, len(path) + 1))]
        parents.append(path[-1])
        path.append(index)
    return parents


def _triple(values: np.ndarray) -> Triple:
    x, y, z = (repr(float(value)) for value in np.round(values, 4))
    return x, y, z


def _placed(joint: Joint, order: str, leaf: bool, rng: np.random.Generator, radians: bool) -> Joint:
    turn = rng.uniform(-3, 3, 3) if radians else rng.uniform(-180, 180, 3)
    if joint.convention is Convention.LISTED:
        sites = (EndSite(_triple(rng.normal(size=3))),) if leaf else ()
        mode = "" if "Tx" not in joint.channels else str(rng.choice(["absolute", "relative"]))
        return replace(joint, offset=_triple(rng.normal(size=3) * 5), end_sites=sites, translation=mode)
    if joint.convention is Convention.FIXED:
        if joint.parent < 0:
            return replace(joint, offset=_triple(rng.normal(size=3)), axis=("0", "0", "0"), axis_order="XYZ")
        axis = _triple(turn) if rng.random() < 0.7 else ("0", "0", "0")
        length = repr(round(float(rng.uniform(0, 8)), 4))
        return replace(
            joint, direction=_triple(rng.normal(size=3)), length=length, axis=axis, axis_order=str(rng.choice(ORDERS))
        )
    return replace(
        joint,
        offset=_triple(rng.normal(size=3) * 5),
        axis=_triple(turn),
        axis_order=order,
        length=repr(round(float(rng.uniform(0, 8)), 4)),
        channels=(*joint.channels, "SF"),
    )


def _values(skeleton: Skeleton, rng: np.random.Generator, moving: bool, radians: bool) -> np.ndarray:
    columns = skeleton.columns()
    frames = 20
    values = np.empty((frames, len(columns)))
    for index, (joint, channel) in enumerate(columns):
        item = skeleton.joints[joint]
        if channel == CHANNEL_INDEX["SF"]:
            values[:, index] = 1.0
        elif channel < 3:
            walk = np.cumsum(rng.normal(size=frames))
            still = item.parent >= 0 and not moving
            values[:, index] = 0.0 if still else walk
        else:
            walk = np.cumsum(rng.normal(0, 20, frames)) + rng.uniform(-180, 180)
            if item.rotation_order[1:2] == "XYZ"[channel - 3]:
                walk[::5] = 90.0
            values[:, index] = np.radians(walk) if radians else walk
    return values.round(6)


def _blocks(skeleton: Skeleton, values: np.ndarray) -> Iterator[FrameBlock]:
    columns = skeleton.columns()
    for start, end in ((0, 7), (7, 8), (8, len(values))):
        ids = np.arange(start + 1, end + 1, dtype=np.int64)
        yield FrameBlock(values[start:end], columns, (full_shape(columns),), ids)
