"""A take of a scene as a clip: joints in the convention of a base pose, with the frames streamed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, Notice
from mcml.formats.format import Limits
from mcml.formats.scenes.local_poses import find_rotations, make_local
from mcml.formats.scenes.scene import Rig, Scene, Take
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, Shape, SourcePart, full_shape
from mcml.motion.lexemes import lexeme, triple
from mcml.motion.rotations import from_euler, from_matrix, to_euler, to_matrix
from mcml.motion.skeleton import ROTATIONS, TRANSLATIONS, Array, Convention, EndSite, Joint, Skeleton, unique_names

ORDER = "ZYX"
"""The order of all rotations: FBX' own default, and one that every format of the catalogue takes."""
ANGLE_DECIMALS = 11
"""Of degrees; rounding loses 1e-13 radians."""
STILL = 3e-7
"""The share of the body's size below which a joint counts as not moving in its parent."""
_VALUES_AT_ONCE = 1 << 18
_SCALED = 1e-3
_TURNS = {"X": ((0, 0, 1), np.pi), "Y": ((1, 0, 0), np.pi), "Z": ((1, 0, 0), np.pi)}


@dataclass(frozen=True)
class Rest:
    """A rig at rest, in the numbers that the document states.

    offsets: (J, 3) in the parent. axes: (J, 3) degrees about x, y, z. rotations: (J, 3, 3) in the parent, of `axes`.
    moving: (J,) which joints have translation channels. decimals: of translations. scaled: joints whose scale changes,
    with the least and the greatest.
    """

    offsets: Array
    axes: Array
    rotations: Array
    moving: NDArray[np.bool_]
    decimals: int
    scaled: tuple[int, float, float]


_RESTS: WeakKeyDictionary[Rig, Rest] = WeakKeyDictionary()
"""Found once for the takes that share a rig."""


def make_clip(scene: Scene, take: Take, format_name: str, source: SourcePart, limits: Limits) -> ClipStream:
    """The clip of a take. Raises FormatError where more than half of its samples are missing, LimitError for its size.

    Joints whose place in their parent changes in any take of the same rig have translation channels in all of them,
    so that the takes of a file share one skeleton.
    """
    rig = take.rig
    limits.check_size(take.frames, 6 * len(rig) + len(rig.shapes))
    turn = turn_up(scene.up)
    if rig not in _RESTS:
        _RESTS[rig] = _find_rest(rig, [other for other in scene.takes if other.rig is rig], turn)
    rest = _RESTS[rig]
    notices = [*scene.notices, *take.notices]
    if scene.up.startswith("-"):
        notices.append(Notice("note", f"{scene.up} is up in the file: roots are turned by half a turn"))
    if rest.scaled[0]:
        notices.append(
            Notice(
                "note",
                f"the scale of {rest.scaled[0]} joints changes ({rest.scaled[1]:.3g} to {rest.scaled[2]:.3g}): "
                "lengths of bones change as translations",
            )
        )
    if take.frames == 1:
        notices.append(Notice("note", "the take has a single frame"))
    skeleton = _make_skeleton(rig, rest)
    fields = {"dataframe_rate": lexeme(take.rate), "euler_rotation_order": ORDER}
    if scene.unit:
        fields["calibration_unit"] = scene.unit
    if scene.up:
        fields["global_axis_of_gravity"] = scene.up.removeprefix("-")
    head = ClipHead(format_name, skeleton, fields, sources=(source,), properties=take.properties)

    def blocks() -> Iterator[FrameBlock]:
        return _read_blocks(take, skeleton, rest, turn, notices)

    return ClipStream(head, blocks, take.frames, notices)


def turn_up(up: str) -> Array | None:
    """(3, 3) half a turn that brings an axis that points down to where it points up; None where it does."""
    if not up.startswith("-"):
        return None
    axis, angle = _TURNS[up[-1]]
    return to_matrix(np.array([*np.array(axis) * np.sin(angle / 2), np.cos(angle / 2)]))


def _apart(poses: Array, turn: Array | None) -> tuple[Array, Array]:
    """Places (n, J, 3) and linear transforms (n, J, 3, 3) of poses (n, J, 3, 4)."""
    lost: NDArray[np.bool_] = np.logical_not(np.isfinite(poses).all(axis=(-1, -2)))
    if lost.any():
        poses = np.where(lost[..., None, None], np.nan, poses)
    poses = poses if turn is None else turn @ poses
    return poses[..., 3], poses[..., :3]


def _find_rest(rig: Rig, takes: list[Take], turn: Array | None) -> Rest:
    places, linear = _apart(rig.rest[None], turn)
    still = np.broadcast_to(np.eye(3), linear.shape[1:])
    rotations, _ = find_rotations(linear, still)
    offsets, turned = make_local(places, rotations, rig.parents)
    size = float(np.ptp(places[0], axis=0).max(initial=0.0))
    size = size if size > 0 else float(np.abs(offsets).max(initial=0.0)) or 1.0
    decimals = int(np.clip(12 - np.floor(np.log10(size)), 0, 300))
    offsets = np.round(offsets[0], decimals) + 0.0
    angles = np.array([to_euler(from_matrix(one)[None], ORDER)[0] for one in turned[0]])
    axes = np.round(np.degrees(angles[:, ::-1]), ANGLE_DECIMALS) + 0.0
    stated = to_matrix(from_euler(np.radians(axes[:, ::-1]), ORDER))
    away, least, greatest = np.zeros(len(rig)), np.full(len(rig), np.inf), np.zeros(len(rig))
    for take in takes:
        for places, rotations, scales in _read_world(take, turn):
            moved, _ = make_local(places, rotations, rig.parents)
            away = np.fmax(away, np.fmax.reduce(np.abs(moved - offsets).max(axis=-1), axis=0, initial=0.0))
            ratio = scales / scales[:, _roots_of(rig.parents)]
            least = np.fmin(least, np.fmin.reduce(ratio.min(axis=-1), axis=0, initial=np.inf))
            greatest = np.fmax(greatest, np.fmax.reduce(ratio.max(axis=-1), axis=0, initial=0.0))
    moving = (away > STILL * size) | (rig.parents < 0)
    scaled = (greatest - 1 > _SCALED) | (1 - least > _SCALED)
    scaled &= np.isfinite(least)
    facts = (int(scaled.sum()), float(least[scaled].min(initial=1)), float(greatest[scaled].max(initial=1)))
    return Rest(offsets, axes, stated, moving, decimals, facts)


def _roots_of(parents: NDArray[np.intp]) -> NDArray[np.intp]:
    """(J,) the root above each joint."""
    roots = np.arange(len(parents))
    for joint, parent in enumerate(parents):
        if parent >= 0:
            roots[joint] = roots[parent]
    return roots


def _read_world(take: Take, turn: Array | None) -> Iterator[tuple[Array, Array, Array]]:
    """Places (n, J, 3), rotations (n, J, 3, 3) and scales (n, J, 3) of joints in the world, block by block."""
    count = max(1, _VALUES_AT_ONCE // (12 * len(take.rig)))
    before = np.broadcast_to(np.eye(3), (len(take.rig), 3, 3))
    for first in range(0, take.frames, count):
        places, linear = _apart(take.poses(first, min(first + count, take.frames)), turn)
        rotations, scales = find_rotations(linear, before)
        before = rotations[-1]
        yield places, rotations, scales


def _make_skeleton(rig: Rig, rest: Rest) -> Skeleton:
    names = unique_names([*(name.rpartition("/")[2] or name for name in rig.names), *rig.shapes])
    tips: dict[int, list[EndSite]] = {}
    for index, tip in rig.tips:
        tips.setdefault(index, []).append(EndSite(triple(_turn_tip(rig, index, tip, rest.decimals))))
    joints = [
        Joint(
            name=names[index],
            parent=int(rig.parents[index]),
            source_name=rig.names[index],
            convention=Convention.BASE,
            channels=(TRANSLATIONS if rest.moving[index] else ()) + ROTATIONS,
            rotation_order=ORDER,
            offset=triple(rest.offsets[index]),
            axis=triple(rest.axes[index]),
            axis_order=ORDER,
            end_sites=tuple(tips.get(index, ())),
        )
        for index in range(len(rig))
    ]
    # Below the last root, so that they follow all joints, which keep their numbers.
    root = int(np.flatnonzero(rig.parents < 0)[-1])
    joints += [
        Joint(name, root, source, Convention.BLEND_SHAPE, ("weight",))
        for name, source in zip(names[len(rig) :], rig.shapes, strict=True)
    ]
    return Skeleton(tuple(joints))


def _turn_tip(rig: Rig, joint: int, tip: Array, decimals: int) -> Array:
    """(3,) a tip in the joint's own axes, which have no scale."""
    linear = rig.rest[None, joint : joint + 1, :, :3]
    rotations, _ = find_rotations(linear, np.eye(3)[None])
    own: Array = np.round(rotations[0, 0].T @ linear[0, 0] @ tip, decimals) + 0.0
    return own


def _read_blocks(
    take: Take, skeleton: Skeleton, rest: Rest, turn: Array | None, notices: list[Notice]
) -> Iterator[FrameBlock]:
    columns = skeleton.columns()
    rig = take.rig
    angles_of: list[Array | None] = [None] * len(rig)
    done = missing = 0
    for places, rotations, _ in _read_world(take, turn):
        translations, turned = make_local(places, rotations, take.rig.parents)
        away = np.round(translations - rest.offsets, rest.decimals)
        quaternions = from_matrix(np.swapaxes(rest.rotations, -1, -2) @ turned)
        angles = np.empty((len(places), len(rig), 3))
        for joint in range(len(rig)):
            angles[:, joint] = unroll(quaternions[:, joint], angles_of, joint)
        values = np.empty((len(places), len(columns)))
        degrees = np.round(np.degrees(angles), ANGLE_DECIMALS)
        weights = None if take.weights is None else take.weights(done, done + len(places))
        for place, (joint, channel) in enumerate(columns):
            if weights is not None and joint >= len(rig):
                values[:, place] = weights[:, joint - len(rig)]
            else:
                values[:, place] = away[:, joint, channel] if channel < 3 else degrees[:, joint, 5 - channel]
        values += 0.0
        ids = np.arange(done + 1, done + len(values) + 1, dtype=np.int64)
        block = without_gaps(values, columns, ids)
        if take.labels is not None:
            block = replace(block, motion_names=take.labels(done, done + len(values)))
        done += len(values)
        missing += int(np.isnan(block.values).sum())
        yield block
    if missing:
        if 2 * missing > done * len(columns):
            raise FormatError(
                f"{missing} of {done * len(columns)} numbers of the motion are missing or not finite",
                remedy="Save the file with another program.",
            )
        notice = Notice("warning", f"{missing} numbers are missing or not finite; these joints have no samples there")
        if notice not in notices:
            notices.append(notice)


def unroll(quaternions: Array, angles_of: list[Array | None], joint: int, order: str = ORDER) -> Array:
    """Angles (n, 3) of one joint in radians, continuing those of the block before; NaN without a sample."""
    there = ~np.isnan(quaternions[:, 0])
    found = to_euler(quaternions[there], order, angles_of[joint])
    if len(found):
        angles_of[joint] = found[-1]
    if there.all():
        return found
    angles = np.full((len(quaternions), 3), np.nan)
    angles[there] = found
    return angles


def without_gaps(values: Array, columns: tuple[tuple[int, int], ...], ids: NDArray[np.int64]) -> FrameBlock:
    """The block of these values; where a number of a joint is missing, that frame has no sample of the joint."""
    gaps = np.isnan(values)
    if not gaps.any():
        return FrameBlock(values, columns, (full_shape(columns),), ids)
    joints = np.array([joint for joint, _ in columns])
    lost = np.zeros((len(values), joints.max() + 1), bool)
    for place, joint in enumerate(joints):
        lost[:, joint] |= gaps[:, place]
    values[lost[:, joints]] = np.nan
    patterns, shape_of = np.unique(lost, axis=0, return_inverse=True)
    full = full_shape(columns)
    shapes: list[Shape] = [tuple((joint, 0 if gone[joint] else bits) for joint, bits in full) for gone in patterns]
    return FrameBlock(values, columns, tuple(shapes), ids, shape_of.reshape(-1).astype(np.intp))
