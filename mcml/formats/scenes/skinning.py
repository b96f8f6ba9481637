"""The meshes of a scene as one that follows the joints of its rig, by linear blend skinning.

A vertex is at the sum of w G I v over the joints that it follows: G from a joint to the world, I from the mesh to the
joint as it was bound (Magnenat-Thalmann et al. 1988). The rotation and the place of G move, its scale at rest is taken
into the mesh. The joints are then in the pose in which most of the mesh was bound; other meshes, bound in another pose,
are brought there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.errors import LimitError
from mcml.formats.colours import to_srgb
from mcml.formats.scenes.local_poses import find_rotations
from mcml.formats.scenes.scene import Rig
from mcml.motion.characters.surfaces import vertex_normals
from mcml.motion.rotations import from_matrix
from mcml.motion.skeleton import Array
from mcml.motion.skin import Character

SLOTS = 4
"""Joints that a vertex follows at most."""
_LOST, _APART = 0.02, 1e-3
"""Weight of a vertex beyond four joints, and parts of the size of the body, from which there is a notice."""


@dataclass(frozen=True, eq=False)
class MeshPart:
    """A mesh, of which each vertex has a place in each joint that it follows.

    points: (V, 3), normals: (V, 3) or None. faces: (T, 3), counterclockwise from outside. colours: (V, 3), linear.
    joints: (k,) of the rig. into: (k, 3, 4) from the mesh to each, with the joint's scale at rest (`Skinning.scales`).
    slots: (V, s) places in `joints`, weights: (V, s) with the sum 1.
    """

    points: Array
    normals: Array | None
    faces: NDArray[np.int64]
    colours: Array
    joints: NDArray[np.intp]
    into: Array
    slots: NDArray[np.intp]
    weights: Array


class Skinning:
    """Binds meshes to a rig. scales: (J, 3, 3) of the joints at rest. notices: approximations, as sentences."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        linear = rig.rest[:, :, :3]
        rotations, _ = find_rotations(linear[None], np.broadcast_to(np.eye(3), linear.shape))
        self.rotations = rotations[0]
        self.scales = np.swapaxes(self.rotations, -1, -2) @ linear
        self.notices: list[str] = []

    def choose_weights(self, slots: NDArray[np.intp], weights: Array) -> tuple[NDArray[np.intp], Array]:
        """Return the four largest weights (V, 4) of each vertex, with the sum 1, and their slots.

        slots: (V, s) places among the joints of a mesh, weights: (V, s), 0 where there is none.
        """
        slots = np.where(weights > 0, slots, 0)
        order = np.argsort(-weights, axis=1, kind="stable")[:, :SLOTS]
        whole = weights.sum(axis=1)
        if (uneven := int((np.abs(whole - 1) > _LOST).sum())) > 0:
            self.notices.append(f"weights of {uneven} vertices do not add up to 1: they are scaled")
        slots, weights = np.take_along_axis(slots, order, 1), np.take_along_axis(weights, order, 1)
        kept = weights.sum(axis=1)
        if (kept < (1 - _LOST) * whole).any():
            self.notices.append("vertices that follow more than four joints follow the four nearest")
        if (kept == 0).any():
            self.notices.append(f"{int((kept == 0).sum())} vertices follow no joint: they follow the first of the skin")
            weights[kept == 0, 0] = 1.0
        return slots, weights / weights.sum(axis=1, keepdims=True)

    def join(self, parts: Sequence[MeshPart]) -> Character:
        """Return the parts as one mesh, bound to the rig."""
        return self._join(parts, self._bind(parts))

    def _bind(self, parts: Sequence[MeshPart]) -> Array:
        """(J, 3, 4) the joints, without scale, in the pose in which most of the mesh was bound.

        It is placed so that the joint that most vertices follow is where it is at rest.
        """
        rest = np.concatenate([self.rotations, self.rig.rest[:, :, 3:]], axis=2)
        bound: Array = np.full(rest.shape, np.nan)
        for part in sorted(parts, key=lambda each: -len(each.points)):
            carried = np.zeros(len(part.joints))
            np.add.at(carried, part.slots, part.weights)
            backs = _rigid_inverse(part.into)
            known = ~np.isnan(bound[part.joints, 0, 0])
            lead = int(np.argmax(np.where(known, carried, 0) if (known & (carried > 0)).any() else carried))
            goal = bound[part.joints[lead]] if known[lead] else rest[part.joints[lead]]
            moved = _product(_product(goal, _rigid_inverse(backs[lead])), backs)
            fresh = ~known & (carried > 0)
            bound[part.joints[fresh]] = moved[fresh]
        for joint, parent in enumerate(self.rig.parents):
            if np.isnan(bound[joint, 0, 0]):
                local = rest[joint] if parent < 0 else _product(_rigid_inverse(rest[parent]), rest[joint])
                bound[joint] = local if parent < 0 else _product(bound[parent], local)
        return bound

    def _join(self, parts: Sequence[MeshPart], bound: Array) -> Character:
        points, normals, apart, start = [], [], 0.0, 0
        faces, joints, weights = [], [], []
        for part in parts:
            moves = _product(bound[part.joints], part.into)
            blended = np.einsum("vs,vsij->vij", part.weights, moves[part.slots])
            moved = blended[..., 3] + np.einsum("vij,vj->vi", blended[..., :3], part.points)
            for slot in range(part.slots.shape[1]):
                chosen = moves[part.slots[:, slot]]
                one = chosen[..., 3] + np.einsum("vij,vj->vi", chosen[..., :3], part.points)
                away = part.weights[:, slot] * np.linalg.norm(one - moved, axis=1)
                apart = max(apart, float(away.max(initial=0.0)))
            points.append(moved)
            own = vertex_normals(part.points, part.faces) if part.normals is None else part.normals
            normals.append(_turn_normals(blended[..., :3], own))
            flipped = np.linalg.det(blended[:, :, :3]).mean() < 0 if len(blended) else False
            faces.append((part.faces[:, ::-1] if flipped else part.faces) + start)
            wide = ((0, 0), (0, SLOTS - part.slots.shape[1]))
            joints.append(np.pad(part.joints[part.slots], wide, mode="edge").astype(np.int64))
            weights.append(np.pad(part.weights, wide))
            start += len(moved)
        placed = np.concatenate(points)
        if apart > _APART * float(np.ptp(placed, axis=0).max()):
            self.notices.append("parts of the mesh were bound in different poses: they are approximated near joints")
        turns = from_matrix(bound[:, :, :3] @ np.swapaxes(self.rotations, -1, -2))
        return Character(
            placed, np.concatenate(normals), np.concatenate(faces), np.concatenate(joints), np.concatenate(weights),
            bound[:, :, 3], turns, to_srgb(np.concatenate([part.colours for part in parts])),
        )  # fmt: skip


def check_limit(count: int, most: int, what: str) -> int:
    """Return a number of vertices or triangles. Raises LimitError for more than the limit."""
    if count > most:
        raise LimitError(
            f"the meshes of the file have {count} {what}, the limit is {most}",
            remedy="Save the character with fewer triangles.",
        )
    return count


def _rigid_inverse(matrices: Array) -> Array:
    """(…, 3, 4) R, -R t of transforms (…, 3, 4) L, t, with R the inverse of the rotation of L."""
    linear = matrices[..., :3].reshape(1, -1, 3, 3)
    rotations, _ = find_rotations(linear, np.broadcast_to(np.eye(3), linear.shape[1:]))
    back = np.swapaxes(rotations[0], -1, -2).reshape(matrices[..., :3].shape)
    return np.concatenate([back, -back @ matrices[..., 3:]], axis=-1)


def _product(first: Array, second: Array) -> Array:
    """The products of affine transforms (…, 3, 4)."""
    made = first[..., :3] @ second
    made[..., 3] += first[..., 3]
    return np.asarray(made)


def _turn_normals(linear: Array, normals: Array) -> Array:
    """(V, 3) normals turned by linear transforms (V, 3, 3): by their cofactors, which keep them square to the mesh."""
    x, y, z = linear[..., 0], linear[..., 1], linear[..., 2]
    turned = normals[:, :1] * np.cross(y, z) + normals[:, 1:2] * np.cross(z, x) + normals[:, 2:] * np.cross(x, y)
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(np.where(length > 0, turned / np.where(length > 0, length, 1.0), (0.0, 1.0, 0.0)))
