"""The program that reads the meshes of an FBX file that has skinned ones, with the joints that move them.

The answer is a line of JSON, as in `mcml.processes.scene_answer`, with `meshes`, `pictures` (lengths in bytes) and
`notices` too, then numbers: of each mesh, as its counts say, points (float64, x y z), corners (int64, their vertices),
sizes (int64, corners of each face), surfaces (int64, the material of each face), uv (float64, u v of each corner), and
of each vertex that follows joints first (int64, vertex, joint of the mesh) and then (float64) the weight. Then the
bytes of the pictures. With `count` the answer is the number of vertices of skinned meshes alone.
"""

from __future__ import annotations

import io
import json
import os
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any, BinaryIO

from mcml.processes.fbx_scene import AXES, FbxScene, hold, list_once, rows_of
from mcml.processes.scene_answer import UnreadableError, run_program


def main() -> None:
    """Read the standard input."""
    run_program(_read)


def _read(options: Mapping[str, Any], source: BinaryIO, target: BinaryIO) -> None:
    data = source.read()
    # The joints are at rest as `evaluate_fbx` has them: without geometry ufbx reads no skins of the oldest files.
    plain, read = (FbxScene(io.BytesIO(data), geometry=geometry) for geometry in (False, True))
    reader = _MeshReader(read, plain.joints, options)
    if options["count"]:
        target.write(json.dumps({"vertices": reader.skinned}).encode() + b"\n")
        return
    found = list(reader.meshes()) if reader.skinned else []
    head = {
        "rigs": [asdict(plain.rig([]))],
        "up": AXES[int(read.scene.settings.axes.up)],
        "meshes": [facts for facts, _ in found],
        "pictures": [len(picture) for picture in reader.pictures],
        "notices": reader.notices,
    }
    target.write(json.dumps(head).encode() + b"\n")
    for _, numbers in found:
        for each in numbers:
            target.write(each.tobytes())
    for picture in reader.pictures:
        target.write(picture)
    target.flush()
    # Elements that were given twice would be released twice.
    os._exit(0)


class _MeshReader:
    """skinned: vertices of skinned meshes. pictures: bytes of textures, notices: sentences, as far as it has read."""

    def __init__(self, read: FbxScene, joints: Sequence[int], options: Mapping[str, Any]) -> None:
        self._read, self._options = read, options
        self._place = {node: joint for joint, node in enumerate(joints)}
        self._all = list_once(read.scene.meshes)
        self._skins = [list_once(mesh.skin_deformers) for mesh in self._all]
        self.skinned = sum(mesh.num_vertices for mesh, skins in zip(self._all, self._skins, strict=True) if skins)
        self.pictures: list[bytes] = []
        self.notices: list[str] = []
        self._vertices = self._triangles = 0

    def meshes(self) -> Iterator[tuple[dict[str, Any], list[array[Any]]]]:
        """Yield the counts and the numbers of each mesh that follows joints, once for each of its instances."""
        for mesh, skins in zip(self._all, self._skins, strict=True):
            if not mesh.num_triangles:
                continue
            if skins:
                if len(skins) > 1:
                    self._note("meshes with several skins follow the first")
                yield self._read_mesh(mesh, *self._skin(skins[0]))
                continue
            for node in hold(list_once(mesh.instances)):
                hung = self._hung(node)
                if hung is None:
                    self._note("meshes that hang from no joint are left out")
                else:
                    yield self._read_mesh(mesh, *hung)

    def _skin(self, skin: Any) -> tuple[list[int], list[list[float]], list[tuple[int, int, float]]]:
        """Joints of the rig, matrices from the mesh to each, and (vertex, place among them, weight)."""
        if int(skin.skinning_method) > 1:
            self._note("the skin is not a linear one: its vertices are blended linearly")
        joints: list[int] = []
        matrices: list[list[float]] = []
        places: dict[int, int] = {}
        for number, cluster in enumerate(hold(list_once(skin.clusters))):
            bone = hold(cluster.bone_node)
            if bone is not None and bone.typed_id in self._place:
                places[number] = len(joints)
                joints.append(self._place[bone.typed_id])
                matrices.append(rows_of(cluster.geometry_to_bone))
        found = list_once(skin.weights)
        weights = []
        for vertex, each in enumerate(list_once(skin.vertices)):
            for weight in found[each.weight_begin : each.weight_begin + each.num_weights]:
                if weight.cluster_index in places and weight.weight > 0:
                    weights.append((vertex, places[weight.cluster_index], weight.weight))
        return joints, matrices, weights

    def _hung(self, node: Any) -> tuple[list[int], list[list[float]], list[tuple[int, int, float]]] | None:
        """The nearest joint at a node or above it, and the transform of the mesh to the world at rest."""
        above = node.typed_id
        while above >= 0 and above not in self._place:
            above = self._read.parents[above]
        return None if above < 0 else ([self._place[above]], [rows_of(node.geometry_to_world)], [])

    def _read_mesh(
        self, mesh: Any, joints: list[int], matrices: list[list[float]], weights: list[tuple[int, int, float]]
    ) -> tuple[dict[str, Any], list[array[Any]]]:
        self._vertices = self._check(self._vertices + mesh.num_vertices, "vertices")
        self._triangles = self._check(self._triangles + mesh.num_triangles, "triangles")
        if len(mesh.blend_deformers):
            self._note("blend shapes of the mesh are left out")
        points = array("d", [number for vertex in list_once(mesh.vertices) for number in vertex])
        corners = array("q", list_once(mesh.vertex_indices))
        faces = list_once(mesh.faces)
        # Faces lie one after the other; those of one or two corners have no surface.
        sizes = array("q", [face.num_indices for face in faces])
        uv = array("d")
        if mesh.vertex_uv.exists:
            values = list_once(mesh.vertex_uv.values)
            uv = array("d", [number for index in list_once(mesh.vertex_uv.indices) for number in values[index]])
        materials = [self._material(each) for each in hold(list_once(mesh.materials))]
        surfaces = array("q", list_once(mesh.face_material) if materials else [])
        facts = {
            "points": mesh.num_vertices,
            "corners": len(corners),
            "faces": len(sizes),
            "surfaces": len(surfaces),
            "uv": len(uv) // 2,
            "weights": len(weights),
            "joints": joints,
            "matrices": matrices,
            "skinned": bool(weights),
            "materials": materials,
        }
        pairs = array("q", [number for vertex, place, _ in weights for number in (vertex, place)])
        return facts, [points, corners, sizes, surfaces, uv, pairs, array("d", [weight for *_, weight in weights])]

    def _material(self, material: Any) -> dict[str, Any]:
        """Its colour, and the number of its picture, or null."""
        colour = material.fbx.diffuse_color
        value = colour.value_vec4
        picture = None
        texture = hold(colour.texture)
        if texture is not None and colour.texture_enabled:
            content = texture.content
            if content:
                picture = len(self.pictures)
                self.pictures.append(bytes(content))
            else:
                self._note("textures are left out: they are in files that are not sent along")
        return {"colour": [value.x, value.y, value.z], "picture": picture}

    def _check(self, count: int, what: str) -> int:
        most = self._options[what]
        if count > most:
            raise UnreadableError(
                f"the meshes of the file have {count} {what}, the limit is {most}",
                "Save the character with fewer triangles.",
                "limit",
            )
        return count

    def _note(self, sentence: str) -> None:
        if sentence not in self.notices:
            self.notices.append(sentence)
