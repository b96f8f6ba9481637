"""The meshes of an FBX file as one that follows the joints of its rig (`mcml.formats.scenes.skinning`).

A program of its own reads them (`mcml.processes.read_fbx_meshes`). Faces of more than three corners are cut into
triangles as fans. A vertex is split where its corners have several places in a texture or several materials.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, McmlError, Notice
from mcml.formats.colours import Pictures, sample_picture
from mcml.formats.format import Limits, ReadOptions, SourceFile
from mcml.formats.scenes.apart import invert_affine, make_rig, multiply_affine, read_head
from mcml.formats.scenes.make_clip import turn_up
from mcml.formats.scenes.scene import Rig
from mcml.formats.scenes.skinning import MeshPart, Skinning
from mcml.motion.characters.rigged import MOST_TRIANGLES, MOST_VERTICES, RiggedCharacter
from mcml.motion.characters.surfaces import vertex_normals
from mcml.motion.nodes import sort_by_tree
from mcml.motion.rotations import from_matrix, rotate
from mcml.motion.skeleton import Array
from mcml.processes.programs import run_reader
from mcml.processes.scene_answer import MEMORY, SECONDS

_PROGRAM = "mcml.processes.read_fbx_meshes"
_SIGN = b"Cluster"
"""Bytes that every file with a skin has."""
_DAMAGED = "Save the file again."
_NUMBERS = (("points", "<f8", 3), ("corners", "<i8", 1), ("faces", "<i8", 1), ("surfaces", "<i8", 1), ("uv", "<f8", 2))


def read_character(file: SourceFile, options: ReadOptions) -> RiggedCharacter | None:
    """Read the meshes of a file that has a skinned one; None if it has none.

    Raises FormatError for damaged files, LimitError for more than `MOST_VERTICES`.
    """
    with _run(file.stream, count=False) as answer:
        head = read_head(answer)
        if not head["meshes"]:
            return None
        meshes = [_Numbers.read(answer, facts) for facts in head["meshes"]]
        pictures = [answer.read(length) for length in head["pictures"]]
    return _MeshReader(head, meshes, pictures, options.limits).read()


def count_vertices(stream: BinaryIO) -> int:
    """Return the number of vertices of the skinned meshes of a file; 0 for damaged ones."""
    stream.seek(0)
    before = b""
    while block := stream.read(1 << 20):
        if _SIGN in before + block:
            break
        before = block[-len(_SIGN) :]
    else:
        return 0
    try:
        with _run(stream, count=True) as answer:
            return int(read_head(answer)["vertices"])
    except McmlError:
        return 0
    finally:
        stream.seek(0)


def _run(stream: BinaryIO, *, count: bool) -> BinaryIO:
    facts = {"count": count, "vertices": MOST_VERTICES, "triangles": MOST_TRIANGLES}
    return run_reader(_PROGRAM, json.dumps(facts), stream=stream, seconds=SECONDS, memory=MEMORY)


@dataclass(frozen=True, eq=False)
class _Numbers:
    """A mesh as the program gives it. corners: (C,) vertices. sizes: (F,) corners of each face. surfaces: (F,)
    materials, or none. uv: (C, 2) or none. pairs: (W, 2) a vertex and a place among the joints of the mesh, with
    weights (W,).
    """

    facts: dict[str, Any]
    points: Array
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    surfaces: NDArray[np.int64]
    uv: Array
    pairs: NDArray[np.int64]
    weights: Array

    @classmethod
    def read(cls, answer: BinaryIO, facts: dict[str, Any]) -> _Numbers:
        parts = [_take(answer, facts[name], width, kind) for name, kind, width in _NUMBERS]
        points, corners, sizes, surfaces, uv = parts
        pairs = _take(answer, facts["weights"], 2, "<i8")
        weights = _take(answer, facts["weights"], 1, "<f8")
        return cls(facts, points, corners[:, 0], sizes[:, 0], surfaces[:, 0], uv, pairs, weights[:, 0])


def _take(answer: BinaryIO, count: int, width: int, kind: str) -> NDArray[Any]:
    data = answer.read(8 * count * width)
    if len(data) != 8 * count * width:
        raise FormatError("the file is damaged: its reader ended early", remedy=_DAMAGED)
    return np.frombuffer(data, kind).reshape(count, width)


class _MeshReader:
    def __init__(self, head: dict[str, Any], meshes: list[_Numbers], pictures: list[bytes], limits: Limits) -> None:
        facts = head["rigs"][0]
        order = sort_by_tree(facts["parents"], limits.depth)
        self.rig: Rig = make_rig(facts, order, np.empty(0, np.intp), limits)
        self.place = {joint: index for index, joint in enumerate(order)}
        self.default = np.array(facts["rest"], np.float64).reshape(-1, 3, 4)
        self.skinning = Skinning(self.rig)
        self.skinning.notices += head["notices"]
        self.up = head["up"]
        self.meshes = meshes
        decoder = Pictures()
        self.pictures = [decoder.read(data) for data in pictures]
        self.skinning.notices += [f"textures are left out: {why}" for why in sorted(decoder.left_out)]

    def read(self) -> RiggedCharacter:
        parts = [part for mesh in self.meshes if (part := self._part(mesh)) is not None]
        if not parts:
            raise FormatError("the meshes of the file have no triangles", remedy="Save it with its triangles.")
        whole, rest = self.skinning.join(parts), self.rig.rest[:, :, 3]
        turn = turn_up(self.up)
        if turn is not None:
            rotation = from_matrix(turn)
            whole, rest = whole.turn(rotation), rotate(rotation, rest)
        notices = tuple(Notice("note", what) for what in dict.fromkeys(self.skinning.notices))
        return RiggedCharacter(whole, self.rig.names, rest, notices)

    def _part(self, mesh: _Numbers) -> MeshPart | None:
        triangles = _triangulate(mesh.sizes)
        if not len(triangles):
            return None
        if not np.isfinite(mesh.points).all():
            raise FormatError("a vertex of the mesh has no place", remedy=_DAMAGED)
        surfaces = np.zeros(len(mesh.corners), np.int64)
        if len(mesh.surfaces):
            surfaces = np.repeat(mesh.surfaces, mesh.sizes)
        uv = mesh.uv if len(mesh.uv) else np.zeros((len(mesh.corners), 2))
        # Corners of one vertex that look alike are one vertex again.
        keys = np.column_stack([mesh.corners, surfaces, uv])
        _, first, vertex = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        own = mesh.corners[first]
        normals = vertex_normals(mesh.points, mesh.corners[triangles])
        joints = np.array([self.place[joint] for joint in mesh.facts["joints"]], np.intp)
        slots, weights = self._weights(mesh)
        return MeshPart(
            mesh.points[own],
            normals[own],
            vertex.reshape(-1)[triangles].astype(np.int64),
            self._colours(mesh, surfaces[first], uv[first]),
            joints,
            self._into(mesh, joints),
            slots[own],
            weights[own],
        )

    def _into(self, mesh: _Numbers, joints: NDArray[np.intp]) -> Array:
        """(k, 3, 4) from the mesh to its joints."""
        matrices = np.array(mesh.facts["matrices"], np.float64).reshape(-1, 3, 4)
        if not mesh.facts["skinned"]:
            # The place in the world at rest.
            (joint,) = mesh.facts["joints"]
            matrices = multiply_affine(invert_affine(self.default[joint]), matrices[0])[None]
        return np.asarray(self.skinning.scales[joints] @ matrices)

    def _weights(self, mesh: _Numbers) -> tuple[NDArray[np.intp], Array]:
        """Places among the joints of the mesh, and weights, (V, s) with the sum 1."""
        count = len(mesh.points)
        if not mesh.facts["skinned"]:
            return np.zeros((count, 1), np.intp), np.ones((count, 1))
        order = np.lexsort((-mesh.weights, mesh.pairs[:, 0]))
        vertices, places = mesh.pairs[order].T
        starts = np.searchsorted(vertices, np.arange(count))
        rank = np.arange(len(vertices)) - starts[vertices]
        width = int(rank.max(initial=0)) + 1
        slots, weights = np.zeros((count, width), np.intp), np.zeros((count, width))
        slots[vertices, rank], weights[vertices, rank] = places, mesh.weights[order]
        return self.skinning.choose_weights(slots, weights)

    def _colours(self, mesh: _Numbers, surfaces: NDArray[np.int64], uv: Array) -> Array:
        """(V, 3) linear colours of vertices with these materials and places in their pictures."""
        colours = np.ones((len(surfaces), 3))
        for number, material in enumerate(mesh.facts["materials"]):
            chosen = surfaces == number
            picture = None if material["picture"] is None else self.pictures[material["picture"]]
            if picture is None:
                colours[chosen] = np.clip(material["colour"], 0.0, 1.0)
            else:
                # The origin of FBX is the lower left corner; a picture takes the place of the colour.
                colours[chosen] = sample_picture(picture, uv[chosen] * [1, -1] + [0, 1])
        return colours


def _triangulate(sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """(T, 3) corners of triangles that fan out from the first corner of each face."""
    counts = np.maximum(sizes - 2, 0)
    faces = np.repeat(np.arange(len(sizes)), counts)
    starts = (np.cumsum(sizes) - sizes)[faces]
    steps = np.arange(len(faces)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.column_stack([starts, starts + steps + 1, starts + steps + 2])
