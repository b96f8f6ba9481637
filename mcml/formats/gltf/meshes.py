"""The meshes of a glTF file as one that follows the joints of its rig (`mcml.formats.scenes.skinning`).

Skins have inverse bind matrices from the mesh to each joint (glTF 2.0 specification, section 3.7.3, Khronos Group
2021). Meshes without a skin that hang from a joint follow it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, McmlError, Notice, UnsupportedError
from mcml.formats.gltf.colours import Colours
from mcml.formats.gltf.document import DAMAGED, Document, as_number
from mcml.formats.gltf.reading import SceneReading, has_skinned_mesh, rest_matrix
from mcml.formats.scenes.skinning import MeshPart, Skinning, check_limit
from mcml.motion.characters.rigged import MOST_TRIANGLES, MOST_VERTICES, RiggedCharacter
from mcml.motion.skeleton import Array

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
MOST_COUNTED = (1 << 31) - 1


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
        self.skinning = Skinning(reading.rig)
        self.notices = self.skinning.notices
        self.vertices = self.triangles = 0

    def read(self) -> RiggedCharacter:
        parts = [part for node, facts in enumerate(self.reading.nodes) if "mesh" in facts for part in self._parts(node)]
        if not any(len(part.faces) for part in parts):
            raise FormatError("the meshes of the file have no triangles", remedy="Save it with its triangles.")
        whole = self.skinning.join(parts)
        if self.colours.left_out:
            self.notices.append(f"textures are left out: {', '.join(sorted(self.colours.left_out))}")
        if any("targets" in each for mesh in self.document.items("meshes") for each in _primitives(mesh)):
            self.notices.append("blend shapes of the mesh are left out")
        notices = tuple(Notice("note", what) for what in dict.fromkeys(self.notices))
        return RiggedCharacter(whole, self.reading.rig.names, self.reading.rig.rest[:, :, 3], notices)

    def _parts(self, node: int) -> list[MeshPart]:
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
        return joints, self.skinning.scales[joints] @ matrices

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
        return np.array([joint]), (self.skinning.scales[joint] @ matrix[:3])[None]

    def _part(self, primitive: dict[str, Any], joints: NDArray[np.intp], into: Array) -> MeshPart | None:
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
        self.vertices = check_limit(self.vertices + count, MOST_VERTICES, "vertices")
        points = _read(self.document, attributes["POSITION"], (3,), count)
        if not np.isfinite(points).all():
            raise FormatError("a vertex of the mesh has no place", remedy=DAMAGED)
        normals = _read(self.document, attributes["NORMAL"], (3,), count) if "NORMAL" in attributes else None
        slots, weights = self._weights(attributes, count, len(joints))
        faces = self._faces(primitive, mode, count)
        return MeshPart(
            points, normals, faces, self._colours(primitive, attributes, count), joints, into, slots, weights
        )

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
        return self.skinning.choose_weights(slots, weights)

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
        self.triangles = check_limit(self.triangles + len(faces), MOST_TRIANGLES, "triangles")
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
        check_limit(found, most, "numbers of triangles" if widths == (1,) else "joints")
    kinds = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
    width = kinds.get(str(accessor.get("type")), 0)
    return document.read(number, width if width in widths else widths[0])
