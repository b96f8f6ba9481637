"""The shared part of programs that read FBX files with ufbx: the scene, its joints, and numbers of its transforms.

The Python layer of ufbx 0.0.5 gives the elements of a list without taking a reference, and a scene that is released
without `free` leaves its elements dangling. So each list is read once, by index, with a reference for each element
(`list_once`), scenes of frames are freed, elements that are given again are held (`hold`), and one process reads one
file.
"""

from __future__ import annotations

import ctypes
from typing import Any, BinaryIO

import ufbx

from mcml.motion.nodes import choose_joints, parents_among
from mcml.processes.scene_answer import SEND, UnreadableError, WrittenRig

AXES = ("X", "-X", "Y", "-Y", "Z", "-Z", "")
"""Axes in the order of ufbx; "" for none."""


class FbxScene:
    """A scene of ufbx. nodes, clusters, stacks: its elements. joints: numbers of nodes. parents: of nodes.

    Without bones, joints are the nodes of meshes with blend shapes.
    """

    def __init__(self, source: BinaryIO, *, geometry: bool) -> None:
        """Raises UnreadableError for damaged files, and for those without bones and without blend shapes.

        geometry: of characters, which need bones.
        """
        try:
            scene: Any = ufbx.load_memory(source.read(), ignore_geometry=not geometry, ignore_embedded=not geometry)
        except ufbx.UfbxError as error:
            raise UnreadableError(
                f"the FBX file is damaged or cut off: {error}", "Send it whole, or save it again."
            ) from None
        self.nodes, self.clusters, self.stacks = (
            list_once(each) for each in (scene.nodes, scene.skin_clusters, scene.anim_stacks)
        )
        self.bones = [cluster.bone_node for cluster in self.clusters]
        self._bound: dict[int, list[float]] = {}
        for cluster, bone in zip(self.clusters, self.bones, strict=True):
            if bone is not None:
                self._bound.setdefault(bone.typed_id, rows_of(cluster.bind_to_world))
        self.parents = [-1 if node.parent is None else node.parent.typed_id for node in self.nodes]
        bones = {number for number, node in enumerate(self.nodes) if node.bone is not None} | set(self._bound)
        self.joints = choose_joints(self.parents, bones)
        self._has_bones = bool(self.joints)
        if not self.joints and self.stacks and not geometry and len(scene.blend_channels):
            self.joints = choose_joints(self.parents, self._find_faces())
        if not self.joints:
            raise UnreadableError(f"the file has no skeleton: {len(self.nodes)} nodes, none is a bone", SEND)
        # The last one, so that it is released after its elements.
        self.scene = scene

    def _find_faces(self) -> set[int]:
        """The nodes of meshes with blend shapes."""
        meshes = [(number, hold(node.mesh)) for number, node in enumerate(self.nodes) if node.mesh is not None]
        return {number for number, mesh in meshes if len(mesh.blend_deformers)}

    def rig(self, shapes: list[str]) -> WrittenRig:
        """The joints at rest, with these blend shapes."""
        return WrittenRig(
            [self.nodes[node].name or f"node_{node}" for node in self.joints],
            parents_among(self.joints, self.parents),
            [rows_of(self.nodes[node].node_to_world) for node in self.joints],
            [self._bound.get(node) for node in self.joints],
            shapes,
            face=not self._has_bones,
        )


_HELD: list[Any] = []


def hold(element: Any) -> Any:
    """An element that may have been given before, held until the process ends, which `os._exit` must do."""
    _HELD.append(element)
    return element


def list_once(elements: Any) -> list[Any]:
    """The elements or values of a list of ufbx, each read once."""
    items = [elements[index] for index in range(len(elements))]
    for item in items:
        if isinstance(item, ufbx.Element):
            _take_reference(item)
    return items


_take_reference = ctypes.pythonapi.Py_IncRef
_take_reference.argtypes, _take_reference.restype = [ctypes.py_object], None


def rows_of(matrix: Any) -> list[float]:
    """The 12 numbers of a transform, row by row, of ufbx' columns."""
    return [column[axis] for axis in range(3) for column in matrix]
