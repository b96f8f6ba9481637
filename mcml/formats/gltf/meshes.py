"""The meshes of a glTF file as one that follows the joints of its rig, by linear blend skinning.

A vertex is at the sum of w G I v over the joints that it follows: G from a joint to the world, I the inverse bind
matrix (glTF 2.0 specification, section 3.7.3, Khronos Group 2021). The rotation and the place of G move, its scale at
rest is taken into the mesh. The joints are then in the pose in which most of the mesh was bound. Other skins of the
file, bound in another pose, are brought there. Meshes without a skin that hang from a joint follow it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, LimitError, McmlError, Notice, UnsupportedError
from mcml.formats.colours import to_srgb
from mcml.formats.gltf.colours import Colours
from mcml.formats.gltf.document import DAMAGED, Document, as_number
from mcml.formats.gltf.reading import SceneReading, has_skinned_mesh, rest_matrix
from mcml.formats.scenes.local_poses import find_rotations
from mcml.motion.characters.rigged import MOST_TRIANGLES, MOST_VERTICES, RiggedCharacter
from mcml.motion.characters.surfaces import vertex_normals
from mcml.motion.rotations import from_matrix
from mcml.motion.skeleton import Array
from mcml.motion.skin import Character

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_SLOTS = 4
MOST_COUNTED = (1 << 31) - 1
_LOST, _APART = 0.02, 1e-3
"""Weight of a vertex beyond four joints, and parts of the size of the body, from which there is a notice."""


@dataclass(frozen=True, eq=False)
class _Part:
    """A primitive, of which each vertex has a place in each joint.

    joints: (k,) of the rig. into: (k, 3, 4) from the mesh to each, with the joint's scale at rest. slots: (V, s) places
    in `joints`, weights: (V, s). normals: (V, 3) or None.
    """

    points: Array
    normals: Array | None
    faces: NDArray[np.int64]
    colours: Array
    joints: NDArray[np.intp]
    into: Array
    slots: NDArray[np.intp]
    weights: Array


def read_character(reading: SceneReading) -> RiggedCharacter | None:
    """Read the meshes of a file that has a skinned one; None if it has none.

    Raises FormatError for damaged ones, UnsupportedError for compressed ones, LimitError for more than `MOST_VERTICES`.
    """
    if not has_skinned_mesh(reading.document):
        return None
    return _MeshReader(reading).read()


def count_vertices(data: bytes) -> int:
    """The number of vertices of the skinned meshes of a GLB or glTF file, by its text alone; 0 for damaged ones."""
    try:
        document = Document(data, lambda name: None)
        skinned = [node for node in document.items("nodes") if "mesh" in node and "skin" in node]
        primitives = [each for node in skinned for each in _primitives(document.item("meshes", node["mesh"]))]
        accessors = [document.item("accessors", each["attributes"]["POSITION"]) for each in primitives]
        return min(sum(as_number(each.get("count"), "count") for each in accessors), MOST_COUNTED)
    except (McmlError, KeyError, TypeError):
        return 0


class _MeshReader:
    def __init__(self, reading: SceneReading) -> None:
        self.reading, self.document = reading, reading.document
        self.colours = Colours(reading.document)
        self.place = {node: joint for joint, node in enumerate(reading.joints)}
        linear = reading.rig.rest[:, :, :3]
        rotations, _ = find_rotations(linear[None], np.broadcast_to(np.eye(3), linear.shape))
        self.rotations = rotations[0]
        self.scales = np.swapaxes(self.rotations, -1, -2) @ linear
        self.notices: list[str] = []
        self.vertices = self.triangles = 0

    def read(self) -> RiggedCharacter:
        parts = [part for node, facts in enumerate(self.reading.nodes) if "mesh" in facts for part in self._parts(node)]
        if not any(len(part.faces) for part in parts):
            raise FormatError("the meshes of the file have no triangles", remedy="Save it with its triangles.")
        bound = self._bind(parts)
        whole = self._join(parts, bound)
        if self.colours.left_out:
            self.notices.append(f"textures are left out: {', '.join(sorted(self.colours.left_out))}")
        if any("targets" in each for mesh in self.document.items("meshes") for each in _primitives(mesh)):
            self.notices.append("blend shapes of the mesh are left out")
        notices = tuple(Notice("note", what) for what in dict.fromkeys(self.notices))
        return RiggedCharacter(whole, self.reading.rig.names, self.reading.rig.rest[:, :, 3], notices)

    def _parts(self, node: int) -> list[_Part]:
        facts = self.reading.nodes[node]
        mesh = self.document.item("meshes", facts["mesh"])
        if "skin" in facts:
            joints, into = self._skin(facts["skin"])
        else:
            hung = self._hung(node)
            if hung is None:
                self.notices.append("meshes that hang from no joint are left out")
                return []
            joints, into = hung
        return [part for each in _primitives(mesh) if (part := self._part(each, joints, into)) is not None]

    def _skin(self, number: object) -> tuple[NDArray[np.intp], Array]:
        """The joints of a skin in the rig, and the transforms (k, 3, 4) from its meshes to them."""
        skin = self.document.item("skins", number)
        nodes = [as_number(node, "joint") for node in skin.get("joints", [])]
        joints = np.array([self.place[node] for node in nodes], np.intp)
        matrices = np.tile(np.eye(4)[:3], (len(joints), 1, 1))
        if "inverseBindMatrices" in skin:
            found = _read(self.document, skin["inverseBindMatrices"], (16,), None, len(joints))
            if len(found) < len(joints):
                raise FormatError(f"skin {number} has {len(joints)} joints and {len(found)} matrices", remedy=DAMAGED)
            # Columns one after the other.
            matrices = found[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)[:, :3]
        return joints, self.scales[joints] @ matrices

    def _hung(self, node: int) -> tuple[NDArray[np.intp], Array] | None:
        """The joint that a node hangs from, and the transform (1, 3, 4) to it; None where there is none."""
        matrix = np.eye(4)
        while node >= 0 and node not in self.place:
            local = np.vstack([rest_matrix(self.reading.nodes[node], node), [0, 0, 0, 1]])
            matrix = local @ matrix
            node = self.reading.parents[node]
        if node < 0:
            return None
        joint = self.place[node]
        return np.array([joint]), (self.scales[joint] @ matrix[:3])[None]

    def _part(self, primitive: dict[str, Any], joints: NDArray[np.intp], into: Array) -> _Part | None:
        mode = primitive.get("mode", _TRIANGLES)
        if mode not in (_TRIANGLES, _STRIP, _FAN):
            self.notices.append("points and lines of meshes are left out")
            return None
        if "KHR_draco_mesh_compression" in (primitive.get("extensions") or {}):
            raise UnsupportedError("the mesh is compressed (KHR_draco)", remedy="Save it without compression.")
        attributes = primitive.get("attributes")
        if not isinstance(attributes, dict) or "POSITION" not in attributes:
            self.notices.append("meshes without places of vertices are left out")
            return None
        count = as_number(self.document.item("accessors", attributes["POSITION"]).get("count"), "count")
        self.vertices = _check_limit(self.vertices + count, MOST_VERTICES, "vertices")
        points = _read(self.document, attributes["POSITION"], (3,), count)
        if not np.isfinite(points).all():
            raise FormatError("a vertex of the mesh has no place", remedy=DAMAGED)
        normals = _read(self.document, attributes["NORMAL"], (3,), count) if "NORMAL" in attributes else None
        slots, weights = self._weights(attributes, count, len(joints))
        faces = self._faces(primitive, mode, count)
        return _Part(points, normals, faces, self._colours(primitive, attributes, count), joints, into, slots, weights)

    def _weights(self, attributes: dict[str, Any], count: int, joints: int) -> tuple[NDArray[np.intp], Array]:
        """Places (V, 4) in the joints of the skin, and weights (V, 4) with the sum 1, the largest first."""
        sets = [number for number in range(4) if f"JOINTS_{number}" in attributes]
        if not sets or joints == 1:
            return np.zeros((count, 1), np.intp), np.ones((count, 1))
        slots = np.concatenate(
            [_read(self.document, attributes[f"JOINTS_{each}"], (4,), count) for each in sets], axis=1
        ).astype(np.intp)
        weights = np.concatenate(
            [_read(self.document, attributes.get(f"WEIGHTS_{each}"), (4,), count) for each in sets], axis=1
        )
        weights = np.where(np.isfinite(weights) & (weights > 0), weights, 0.0)
        if count and ((slots >= joints) & (weights > 0)).any():
            raise FormatError(f"a vertex follows joint {int(slots.max())} of a skin of {joints}", remedy=DAMAGED)
        slots = np.where(weights > 0, slots, 0)
        order = np.argsort(-weights, axis=1, kind="stable")[:, :_SLOTS]
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

    def _faces(self, primitive: dict[str, Any], mode: int, count: int) -> NDArray[np.int64]:
        if "indices" in primitive:
            most = 3 * MOST_TRIANGLES
            corners = _read(self.document, primitive["indices"], (1,), None, most)[:, 0].astype(np.int64)
            if len(corners) and not 0 <= corners.min() <= corners.max() < count:
                raise FormatError(f"a triangle names vertex {int(corners.max())} of {count}", remedy=DAMAGED)
        else:
            corners = np.arange(count)
        if mode == _TRIANGLES:
            faces = corners[: len(corners) // 3 * 3].reshape(-1, 3)
        else:
            steps = np.arange(max(0, len(corners) - 2))
            places = np.stack([steps, steps + 1 + steps % 2, steps + 2 - steps % 2], axis=1)
            places = places if mode == _STRIP else np.stack([steps + 1, steps + 2, 0 * steps], axis=1)
            faces = corners[places]
        self.triangles = _check_limit(self.triangles + len(faces), MOST_TRIANGLES, "triangles")
        return np.asarray(faces, np.int64)

    def _colours(self, primitive: dict[str, Any], attributes: dict[str, Any], count: int) -> Array:
        uv = {
            number: _read(self.document, attributes[f"TEXCOORD_{number}"], (2,), count)
            for number in range(4)
            if f"TEXCOORD_{number}" in attributes
        }
        colours = self.colours.of(primitive.get("material"), count, uv)
        if "COLOR_0" in attributes:
            colours = colours * _read(self.document, attributes["COLOR_0"], (3, 4), count)[:, :3]
        return colours

    def _bind(self, parts: list[_Part]) -> Array:
        """(J, 3, 4) the joints, without scale, in the pose in which most of the mesh was bound.

        It is placed so that the joint that most vertices follow is where it is at rest.
        """
        rest = np.concatenate([self.rotations, self.reading.rig.rest[:, :, 3:]], axis=2)
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
        for joint, parent in enumerate(self.reading.rig.parents):
            if np.isnan(bound[joint, 0, 0]):
                local = rest[joint] if parent < 0 else _product(_rigid_inverse(rest[parent]), rest[joint])
                bound[joint] = local if parent < 0 else _product(bound[parent], local)
        return bound

    def _join(self, parts: list[_Part], bound: Array) -> Character:
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
            wide = ((0, 0), (0, _SLOTS - part.slots.shape[1]))
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


def _primitives(mesh: dict[str, Any]) -> list[dict[str, Any]]:
    found = mesh.get("primitives", [])
    if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
        raise FormatError("the primitives of a mesh are no list of objects", remedy=DAMAGED)
    return found


def _read(document: Document, number: object, widths: tuple[int, ...], count: int | None, most: int = 0) -> Array:
    """(count, width) the numbers of an accessor. count: None for any up to `most`. FormatError, LimitError."""
    accessor = document.item("accessors", number)
    found = as_number(accessor.get("count"), "count")
    if count is not None and found != count:
        raise FormatError(f"accessor {number} has {found} elements for {count} vertices", remedy=DAMAGED)
    if count is None:
        _check_limit(found, most, "numbers of triangles" if widths == (1,) else "joints")
    kinds = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
    width = kinds.get(str(accessor.get("type")), 0)
    return document.read(number, width if width in widths else widths[0])


def _check_limit(count: int, most: int, what: str) -> int:
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
