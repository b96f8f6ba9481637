"""Move hands, feet, head and hips of a body over a range of frames, on top of its motion.

Hips move the body; the trunk bends towards the head by damped least squares, arms and legs by two-bone inverse
kinematics (`mcml.motion.feet.limbs`). Ends keep their orientation in the world unless they are turned.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError
from mcml.motion.carriers import carriers
from mcml.motion.clip import FrameBlock
from mcml.motion.feet.legs import is_below
from mcml.motion.feet.limbs import Limb, bend_limb, limb_hinge
from mcml.motion.frames import Edited, in_columns, remade
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import HubWriter, Known
from mcml.motion.rotation_vectors import from_vector
from mcml.motion.rotations import IDENTITY, inverse, multiply, rotate
from mcml.motion.skeleton import TRANSLATIONS, Array, Skeleton
from mcml.motion.solving.chains import solve_chain
from mcml.motion.units import DEGREES, Reading

Handle = Literal["hips", "head", "left_hand", "right_hand", "left_foot", "right_foot"]
HANDLES: Final[tuple[Handle, ...]] = get_args(Handle)

_JOINTS: Final[Mapping[Handle, tuple[str, ...]]] = {
    "hips": ("Root",),
    "head": ("Root", "Head"),
    "left_hand": ("left_up_arm", "left_low_arm", "left_hand"),
    "right_hand": ("right_up_arm", "right_low_arm", "right_hand"),
    "left_foot": ("left_up_leg", "left_low_leg", "left_foot"),
    "right_foot": ("right_up_leg", "right_low_leg", "right_foot"),
}
"""MCML's names of the joints that move a handle, from the trunk outwards; the last one is moved."""


@dataclass(frozen=True)
class HandleMove:
    """way: (3,) by which a handle is moved, in the clip's unit and axes. turn: (3,) vector by which it is turned about
    these axes, in radians."""

    way: Array = field(default_factory=lambda: np.zeros(3))
    turn: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Posed:
    """edited: the frames. missed: of each moved or held handle the farthest that it is from its goal in any frame, in
    the clip's unit. size: of the body in the first posed frame, its longest side along an axis.
    """

    edited: Edited
    missed: Mapping[Handle, float]
    size: float


def handles_of(skeleton: Skeleton) -> tuple[Handle, ...]:
    """The handles that a skeleton has: those whose joints it has, each below the one before."""
    return tuple(handle for handle in HANDLES if _joints_of(skeleton, handle) is not None)


def pose_frames(
    skeleton: Skeleton,
    block: FrameBlock,
    moves: Mapping[Handle, HandleMove],
    strength: Array,
    hold: Sequence[Handle] = ("left_foot", "right_foot"),
    reading: Reading = DEGREES,
) -> Posed:
    """Move handles by a part of their ways and turns in each frame, the rest of the motion below it.

    strength: (n,) parts, 0 for frames that keep their bits, see `mcml.motion.frames.eased`. hold: handles that stay
    where they are in the frame while others move. Handles that are neither moved nor held go along with the joints
    above them. A limb that does not reach its goal is stretched towards it. Missing samples stay missing. Raises
    ConversionError for a handle that the skeleton lacks, and for hips whose position has no channels.
    """
    lacking = [handle for handle in moves if _joints_of(skeleton, handle) is None]
    if lacking:
        there = ", ".join(handles_of(skeleton)) or "none: map its joints to MCML's names first"
        raise ConversionError(f"the skeleton has no handle {lacking[0]}", remedy=f"Handles that it has: {there}.")
    rows = np.flatnonzero(strength)
    hub = HubReader(skeleton, reading).read(block)
    writer = HubWriter(skeleton, reading)
    layer = _Layer(skeleton, hub.translations, hub.rotations, rows, strength[rows], moves, writer)
    layer.move([handle for handle in hold if _joints_of(skeleton, handle) is not None])
    translations, rotations = hub.translations.copy(), hub.rotations.copy()
    translations[rows], rotations[rows] = layer.translations, layer.rotations
    changed = (rotations != hub.rotations).any(axis=2) | (translations != hub.translations).any(axis=2)
    values = writer.write(translations, rotations, hub.scales, Known(hub.values, ~changed, near=True))
    values[np.isnan(in_columns(block, skeleton.columns()))] = np.nan
    frames = np.arange(len(block), dtype=np.intp)
    return Posed(
        Edited(remade(block, skeleton.columns(), values, frames, block.ids), writer.shortfall),
        layer.find_misses(),
        layer.size,
    )


def _joints_of(skeleton: Skeleton, handle: Handle) -> tuple[int, ...] | None:
    names = skeleton.names
    if not all(name in names for name in _JOINTS[handle]):
        return None
    joints = tuple(names.index(name) for name in _JOINTS[handle])
    return joints if all(is_below(skeleton, joint, above) for above, joint in pairwise(joints)) else None


class _Layer:
    """Frames that are posed, in the hub form: translations (m, J, 3), rotations (m, J, 4)."""

    def __init__(
        self,
        skeleton: Skeleton,
        translations: Array,
        rotations: Array,
        rows: NDArray[np.intp],
        strength: Array,
        moves: Mapping[Handle, HandleMove],
        writer: HubWriter,
    ) -> None:
        self.skeleton, self.writer, self.moves = skeleton, writer, moves
        self.translations, self.rotations = translations[rows], rotations[rows]
        self._whole = walked(skeleton, translations, rotations)
        self._carriers = carriers(skeleton, translations)
        self._strength = strength[:, None]
        self._places, self._world = (part[rows] for part in self._whole)
        self._goals: dict[Handle, Array] = {}

    def move(self, hold: Sequence[Handle]) -> None:
        """Move the handles, from the trunk outwards."""
        moves = self.moves
        if "hips" in moves:
            self._move_hips(moves["hips"])
        if "head" in moves or ("head" in hold and "hips" in moves):
            self._bend_trunk()
        for handle in HANDLES[2:]:
            above = {"hips", "head"} if handle.endswith("hand") else {"hips"}
            if handle in moves or (handle in hold and above & moves.keys()):
                self._bend(handle)

    @property
    def size(self) -> float:
        """The longest side of the body along an axis, in the first frame."""
        return float(np.ptp(self._places[:1], axis=1).max(initial=0.0))

    def find_misses(self) -> dict[Handle, float]:
        """Of each handle the farthest distance from its goal."""
        places = walked(self.skeleton, self.translations, self.rotations)[0]
        ends = {handle: (_joints_of(self.skeleton, handle) or (0,))[-1] for handle in self._goals}
        return {
            handle: float(np.linalg.norm(places[:, ends[handle]] - goal, axis=1).max(initial=0.0))
            for handle, goal in self._goals.items()
        }

    def _aim(self, handle: Handle, joint: int) -> tuple[Array, Array]:
        """Goals (m, 3) of a handle, and its rotations (m, 4) in the world there."""
        move = self.moves.get(handle, HandleMove())
        self._goals[handle] = self._places[:, joint] + self._strength * move.way
        return self._goals[handle], multiply(from_vector(self._strength * move.turn), self._world[:, joint])

    def _move_hips(self, move: HandleMove) -> None:
        (hips,) = _joints_of(self.skeleton, "hips") or (0,)
        goals, faces = self._aim("hips", hips)
        if move.turn.any():
            above = self._world_above(hips, self._world)
            self.rotations[:, hips] = self.writer.nearest(hips, multiply(inverse(above), faces))
        if not move.way.any():
            return
        bearers = [joint for joint in self._carriers if joint == hips or is_below(self.skeleton, hips, joint)]
        bearer = bearers[0] if bearers else hips
        if not set(TRANSLATIONS) <= set(self.skeleton.joints[bearer].channels):
            raise ConversionError(
                f"the hips cannot be moved: {self.skeleton.joints[bearer].name} has no position channels",
                remedy="Move hands, feet or the head, or turn the hips.",
            )
        way = goals - self._places[:, hips]
        self.translations[:, bearer] += rotate(inverse(self._world_above(bearer, self._world)), way)

    def _bend_trunk(self) -> None:
        skeleton = self.skeleton
        hips, head = _joints_of(skeleton, "head") or (0, 0)
        chain = [head]
        while chain[0] != hips:
            chain.insert(0, skeleton.joints[chain[0]].parent)
        goals, faces = self._aim("head", head)
        places, world = walked(skeleton, self.translations, self.rotations)
        local = self.rotations[:, chain]
        local[:, 0] = world[:, hips]
        shares = np.array([0.0, *(float(self.writer.is_free(joint)) for joint in chain[1:-1]), 0.0])
        offsets = self.translations[:, chain].swapaxes(0, 1)
        length = float(np.linalg.norm(offsets[1:], axis=2).sum(axis=0).mean()) if len(offsets[0]) else 0.0
        if length > 0 and shares.any():
            solved = solve_chain(places[:, hips], local, offsets, goals, shares, length)
            self.rotations[:, chain[1:-1]] = solved[:, 1:-1]
        above = self._world_above(head, walked(skeleton, self.translations, self.rotations)[1])
        self.rotations[:, head] = self.writer.nearest(head, multiply(inverse(above), faces))

    def _bend(self, handle: Handle) -> None:
        upper, lower, end = _joints_of(self.skeleton, handle) or (0, 0, 0)
        limb: Limb = (upper, lower, end, end)
        goals, faces = self._aim(handle, end)
        hinge = limb_hinge(*self._whole, limb)
        self.rotations = bend_limb(
            self.skeleton, limb, self.translations, self.rotations, goals, faces, hinge, self.writer
        )

    def _world_above(self, joint: int, world: Array) -> Array:
        parent = self.skeleton.joints[joint].parent
        above: Array = world[:, parent] if parent >= 0 else np.broadcast_to(IDENTITY, world[:, joint].shape)
        return above
