"""glTF files with skinned meshes, made for tests, and where the specification puts their vertices."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pygltflib
from scipy.spatial.transform import Rotation, Slerp

from mcml.motion.skeleton import Array
from tests.formats.readers.test_gltf import gltf

KINDS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Builder:
    """A glTF file in the making."""

    def __init__(self) -> None:
        self.binary = b""
        self.model: dict[str, Any] = {"bufferViews": [], "accessors": [], "nodes": [], "meshes": [], "skins": []}

    def add(self, values: Any, kind: int = 5126, **facts: Any) -> int:
        """Add an accessor with these numbers; its number."""
        array = np.asarray(values, KINDS[kind])
        array = array.reshape(len(array), -1)
        data = array.tobytes()
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        self.binary += data + b"\0" * (-len(data) % 4)
        self.model["bufferViews"].append(view)
        place = {"bufferView": len(self.model["bufferViews"]) - 1, "componentType": kind, **facts}
        self.model["accessors"].append({**place, "count": len(array), "type": TYPES[array.shape[1]]})
        return len(self.model["accessors"]) - 1

    def primitive(self, points: Array, joints: Array, weights: Array, faces: Array, **more: Any) -> dict[str, Any]:
        """A primitive whose vertices follow any number of joints."""
        attributes = {"POSITION": self.add(points)}
        for number in range(0, joints.shape[1], 4):
            attributes[f"JOINTS_{number // 4}"] = self.add(joints[:, number : number + 4], 5123)
            attributes[f"WEIGHTS_{number // 4}"] = self.add(weights[:, number : number + 4])
        return {"attributes": attributes, "indices": self.add(np.ravel(faces)[:, None], 5125), **more}

    def data(self) -> bytes:
        model = {name: value for name, value in self.model.items() if value}
        return gltf(model, self.binary)


def tube(joints: int = 3, seed: int = 0, *, still: bool = False) -> Builder:
    """A chain of joints under a scaled armature, bound in another pose than it rests in, around which is a mesh."""
    chance = np.random.default_rng(seed)
    made = Builder()
    scale, back = 0.01, []
    made.model["nodes"].append({"name": "Armature", "scale": [scale] * 3, "children": [1]})
    world = np.eye(4)
    for joint in range(joints):
        node = {
            "name": f"joint{joint}",
            "translation": (100 * chance.normal(size=3)).tolist(),
            "rotation": Rotation.random(random_state=seed + joint).as_quat().tolist(),
        }
        if joint + 1 < joints:
            node["children"] = [joint + 2]
        made.model["nodes"].append(node)
        local = np.eye(4)
        local[:3, :3] = Rotation.random(random_state=100 + seed + joint).as_matrix()
        local[:3, 3] = node["translation"]
        world = world @ local
        back.append(np.linalg.inv(world))
    count = 40
    places = np.linalg.inv(back[0])[:3, 3] + 80 * chance.normal(size=(count, 3))
    carriers = chance.integers(0, joints, (count, 4))
    weights = chance.random((count, 4)) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    faces = chance.integers(0, count, (30, 3))
    made.model["skins"].append(
        {"joints": list(range(1, joints + 1)), "inverseBindMatrices": made.add([m.T.ravel() for m in back])}
    )
    made.model["meshes"].append({"primitives": [made.primitive(places, carriers, weights, faces)]})
    made.model["nodes"].append({"name": "body", "mesh": 0, "skin": 0})
    if not still:
        times = np.arange(6) / 30
        samplers, channels = [], []
        for joint in range(joints):
            turns = Rotation.random(6, random_state=200 + seed + joint).as_quat()
            samplers.append({"input": made.add(times[:, None]), "output": made.add(turns)})
            channels.append({"sampler": joint, "target": {"node": joint + 1, "path": "rotation"}})
        made.model["animations"] = [{"name": "Move", "samplers": samplers, "channels": channels}]
    return made


def read_numbers(model: pygltflib.GLTF2, number: int) -> Array:
    """The numbers of an accessor, by pygltflib's reading of the file."""
    accessor = model.accessors[number]
    view = model.bufferViews[accessor.bufferView]
    buffer = model.buffers[view.buffer]
    data = model.binary_blob() if buffer.uri is None else base64.b64decode(buffer.uri.partition(",")[2])
    kind, width = np.dtype(KINDS[accessor.componentType]), WIDTHS[accessor.type]
    stride = view.byteStride or kind.itemsize * width
    start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
    rows = [np.frombuffer(data, kind, width, start + stride * row) for row in range(accessor.count)]
    return np.array(rows, float)


def world_matrices(model: pygltflib.GLTF2, animation: int | None, times: Array) -> Array:
    """(n, N, 4, 4) of all nodes at these times; at rest without an animation."""
    moved: dict[tuple[int, str], Array] = {}
    for channel in model.animations[animation].channels if animation is not None else []:
        sampler = model.animations[animation].samplers[channel.sampler]
        keys, values = read_numbers(model, sampler.input)[:, 0], read_numbers(model, sampler.output)
        at = np.clip(times, keys[0], keys[-1])
        if channel.target.path == "rotation" and len(keys) > 1:
            moved[channel.target.node, "rotation"] = Slerp(keys, Rotation.from_quat(values))(at).as_quat()
        elif channel.target.path in ("translation", "scale", "rotation"):
            moved[channel.target.node, channel.target.path] = np.stack(
                [np.interp(at, keys, column) for column in values.T], axis=1
            )
    local = np.tile(np.eye(4), (len(times), len(model.nodes), 1, 1))
    for index, node in enumerate(model.nodes):
        if node.matrix and not any(key[0] == index for key in moved):
            local[:, index] = np.reshape(node.matrix, (4, 4)).T
            continue
        turns = moved.get((index, "rotation"), np.tile(node.rotation or [0, 0, 0, 1], (len(times), 1)))
        sizes = moved.get((index, "scale"), np.tile(node.scale or [1, 1, 1], (len(times), 1)))
        local[:, index, :3, :3] = Rotation.from_quat(turns).as_matrix() * np.asarray(sizes, float)[:, None, :]
        local[:, index, :3, 3] = moved.get((index, "translation"), np.asarray(node.translation or [0, 0, 0]))
    parents = {child: index for index, node in enumerate(model.nodes) for child in node.children or []}

    def place(index: int) -> Array:
        return place(parents[index]) @ local[:, index] if index in parents else local[:, index]

    return np.stack([place(index) for index in range(len(model.nodes))], axis=1)


def skinned_vertices(model: pygltflib.GLTF2, animation: int | None, times: Array) -> Array:
    """(n, V, 3) where the specification puts all vertices of skinned meshes (section 3.7.3)."""
    world = world_matrices(model, animation, times)
    found = []
    for node in model.nodes:
        if node.mesh is None or node.skin is None:
            continue
        skin = model.skins[node.skin]
        back = read_numbers(model, skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
        moves = world[:, skin.joints] @ back
        for primitive in model.meshes[node.mesh].primitives:
            points = read_numbers(model, primitive.attributes.POSITION)
            joints = read_numbers(model, primitive.attributes.JOINTS_0).astype(int)
            weights = read_numbers(model, primitive.attributes.WEIGHTS_0)
            # As viewers do for files whose weights do not add up.
            weights = weights / weights.sum(axis=1, keepdims=True)
            rows = np.column_stack([points, np.ones(len(points))])
            blended = np.einsum("vs,nvsij->nvij", weights, moves[:, joints])
            found.append(np.einsum("nvij,vj->nvi", blended, rows)[..., :3])
    return np.concatenate(found, axis=1)
