"""The rig of a glTF file, its takes, and where its nodes are.

Sources: glTF 2.0 specification, Khronos Group 2021; VRM 0.x, VRM 1.0 and VRM Animation 1.0 specifications, VRM
Consortium. docs/formats/glb.md describes the reading.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from mcml.errors import FormatError, Notice
from mcml.formats.format import ReadOptions
from mcml.formats.gltf.document import DAMAGED, Document, as_number, as_numbers
from mcml.formats.gltf.morphs import read_morphs
from mcml.formats.gltf.tracks import DEFAULT_RATE, Track, find_rate, frame_times, read_tracks
from mcml.formats.scenes.scene import (
    TIPS,
    Rig,
    Scene,
    Take,
    check_joints,
    check_takes,
    read_tips,
)
from mcml.motion.nodes import choose_joints, parents_among, sort_by_tree
from mcml.motion.rotations import to_matrix
from mcml.motion.skeleton import Array


class SceneReading:
    """One file being read. joints: nodes in the order of the rig. ways: the nodes above each joint that are none."""

    def __init__(self, document: Document, options: ReadOptions) -> None:
        self.document = document
        self.options = options
        self.nodes = document.items("nodes")
        self.parents = _parents_of(self.nodes)
        self.order = sort_by_tree(self.parents, options.limits.depth)
        self.notices: list[str] = []
        self.morphs = read_morphs(document)
        bones, self.human = self._find_bones()
        joints = set(choose_joints(self.parents, bones))
        self.joints = [node for node in self.order if node in joints]
        names = [self._name(node) for node in self.joints]
        check_joints(names, len(self.nodes), options.limits, "glTF")
        # The nodes that place a joint: itself, its joints above, and nodes between the root and these.
        self.placing = self._placing()
        place = {node: index for index, node in enumerate(self.placing)}
        self.above = [place.get(self.parents[node], -1) for node in self.placing]
        self.places = [place[node] for node in self.joints]
        self.rest = [_rest_of(self.nodes[node], node) for node in self.placing]
        parents = np.array(parents_among(self.joints, self.parents), np.intp)
        self.morphed = self._morphed_nodes()
        shapes = tuple(name for node in self.morphed for name in self.morphs[node].names)
        for name in shapes:
            options.limits.check_name(name)
        extras = [self.nodes[node].get("extras") for node in self.joints]
        tips = [each.get(TIPS) if isinstance(each, dict) else None for each in extras]
        ends = tuple((joint, tip) for joint, found in enumerate(tips) for tip in read_tips(found))
        self.rig = Rig(tuple(names), parents, self._world({}, np.zeros(1))[0], shapes, ends)

    @cached_property
    def animations(self) -> list[tuple[list[Track], list[str]]]:
        """Tracks and notices of each animation."""
        targets = {node: len(morphs.names) for node, morphs in self.morphs.items()}
        return [
            read_tracks(self.document, each, len(self.nodes), targets) for each in self.document.items("animations")
        ]

    def scene(self) -> Scene:
        chosen = set(self.placing)
        takes = []
        moving = 0
        for number, (tracks, notices) in enumerate(self.animations):
            tracks = [track for track in tracks if track.path == "weights" or track.node in chosen]
            if tracks:
                takes.append(self._take(number, tracks, notices))
                moving += takes[-1].frames
        if not takes and has_skinned_mesh(self.document):
            takes.append(self._rest_take())
        check_takes(takes, len(self.joints))
        self.options.limits.check_size(moving, 6 * len(self.joints) + len(self.rig.shapes))
        return Scene(tuple(takes), "m", "Y", tuple(Notice("note", what) for what in self.notices))

    def _rest_take(self) -> Take:
        """The rest pose, of a character that has no animation."""

        def poses(first: int, end: int) -> Array:
            return np.repeat(self.rig.rest[None], end - first, axis=0)

        note = Notice("note", "the file has a character and no animation: the only frame is its rest pose")
        return Take("", self.rig, 1, DEFAULT_RATE, poses, (note,))

    def _take(self, number: int, tracks: list[Track], notices: list[str]) -> Take:
        rate, shown = find_rate(tracks)
        if self.options.rate is not None:
            rate, shown = self.options.rate, False
        elif not shown:
            notices = [*notices, f"the keys show no rate: they are sampled {rate:g} times a second; `rate` changes it"]
        span = max(float(track.times[-1]) for track in tracks) - min(float(track.times[0]) for track in tracks)
        self.options.limits.check_size(int(min(span * rate, 1e15)) + 1, 6 * len(self.joints))
        times = frame_times(tracks, rate, shown)
        by_node: dict[int, dict[str, Track]] = {}
        for track in tracks:
            by_node.setdefault(track.node, {})[track.path] = track
        name = self.document.items("animations")[number].get("name")
        name = name if isinstance(name, str) and name.strip() else f"animation_{number}"
        self.options.limits.check_name(name)

        def poses(first: int, end: int) -> Array:
            return self._world(by_node, times[first:end])

        def weights(first: int, end: int) -> Array:
            return self._weights(by_node, times[first:end])

        told = tuple(Notice("note", what) for what in notices)
        return Take(name, self.rig, len(times), rate, poses, told, weights=weights)

    def _morphed_nodes(self) -> list[int]:
        """Nodes whose morph targets an animation of the file moves."""
        moved = {track.node for tracks, _ in self.animations for track in tracks if track.path == "weights"}
        return [node for node in self.order if node in moved]

    def _weights(self, tracks: Mapping[int, Mapping[str, Track]], times: Array) -> Array:
        """(n, S) of the morph targets at times (n,)."""
        parts = [np.empty((len(times), 0))]
        for node in self.morphed:
            track = tracks.get(node, {}).get("weights")
            still = self.morphs[node].weights
            parts.append(np.tile(still, (len(times), 1)) if track is None else track.sample(times))
        return np.concatenate(parts, axis=1)

    def _world(self, tracks: Mapping[int, Mapping[str, Track]], times: Array) -> Array:
        """(n, J, 3, 4) of the joints in the world at times (n,)."""
        count = len(times)
        world: list[Array] = []
        for node, above, rest in zip(self.placing, self.above, self.rest, strict=True):
            moved = tracks.get(node, {})
            values = [
                moved[path].sample(times) if path in moved else np.broadcast_to(still, (count, len(still)))
                for path, still in zip(("translation", "rotation", "scale"), rest[:3], strict=True)
            ]
            local = np.empty((count, 3, 4))
            local[..., :3] = to_matrix(values[1]) * values[2][:, None, :]
            local[..., 3] = values[0]
            if rest[3] is not None and not moved:
                local[:] = rest[3]
            world.append(local if above < 0 else _product(world[above], local))
        return np.stack([world[place] for place in self.places], axis=1)

    def _placing(self) -> list[int]:
        """Joints and all nodes above them, parents first."""
        wanted: set[int] = set()
        for joint in self.joints:
            node = joint
            while node >= 0 and node not in wanted:
                wanted.add(node)
                node = self.parents[node]
        return [node for node in self.order if node in wanted]

    def _find_bones(self) -> tuple[set[int], dict[int, str]]:
        """The nodes that are bones, and those of a humanoid with the names that VRM gives them."""
        human = self._humanoid()
        bones: set[int] = set()
        for skin in self.document.items("skins"):
            joints = skin.get("joints", [])
            bones |= {as_number(node, "joint") for node in joints} if isinstance(joints, list) else set()
        bones = bones or set(human)
        if not bones:
            meshes = {node for node, facts in enumerate(self.nodes) if "mesh" in facts}
            moving = {(track.node, track.path) for tracks, _ in self.animations for track in tracks}
            bones = {node for node, path in moving if path != "weights"} - meshes
            if bones:
                self.notices.append("the file has no skin and no humanoid: nodes that move are taken as joints")
            elif bones := {node for node, path in moving if path == "weights"}:
                self.notices.append("the file has no skeleton: nodes whose blend shapes move are taken as joints")
        if bones and max(bones) >= len(self.nodes):
            raise FormatError(f"a skin names node {max(bones)}, which there is not", remedy=DAMAGED)
        return bones, human

    def _humanoid(self) -> dict[int, str]:
        """Nodes with the names of the VRM specifications."""
        found: dict[int, str] = {}
        for name in ("VRMC_vrm", "VRMC_vrm_animation", "VRM"):
            facts = (self.document.extension(name) or {}).get("humanoid")
            bones: Any = facts.get("humanBones") if isinstance(facts, dict) else None
            if isinstance(bones, dict):
                pairs = [(bone, each.get("node")) for bone, each in bones.items() if isinstance(each, dict)]
            elif isinstance(bones, list):
                pairs = [(each.get("bone"), each.get("node")) for each in bones if isinstance(each, dict)]
            else:
                continue
            for bone, node in pairs:
                if isinstance(bone, str) and isinstance(node, int) and 0 <= node < len(self.nodes):
                    found[node] = bone
            if name == "VRM":
                self.notices.append("VRM 0.x looks along -Z, not +Z: nothing is turned")
            break
        return found

    def _name(self, node: int) -> str:
        name = self.nodes[node].get("name")
        return name if isinstance(name, str) and name.strip() else self.human.get(node) or f"node_{node}"


def has_skinned_mesh(document: Document) -> bool:
    """Whether a node of the file has both a mesh and a skin."""
    return any("mesh" in node and "skin" in node for node in document.items("nodes"))


def _product(first: Array, second: Array) -> Array:
    """The product of affine transforms (n, 3, 4)."""
    made = first[..., :3] @ second
    made[..., 3] += first[..., 3]
    return made


def _parents_of(nodes: list[dict[str, Any]]) -> list[int]:
    parents = [-1] * len(nodes)
    for number, node in enumerate(nodes):
        children = node.get("children", [])
        if not isinstance(children, list):
            raise FormatError(f"the children of node {number} are no list", remedy=DAMAGED)
        for child in children:
            place = as_number(child, "child")
            if place >= len(nodes):
                raise FormatError(f"node {number} has the child {place}, which there is not", remedy=DAMAGED)
            if parents[place] >= 0:
                raise FormatError(f"node {place} has two parents, {parents[place]} and {number}", remedy=DAMAGED)
            parents[place] = number
    return parents


def _rest_of(node: dict[str, Any], number: int) -> tuple[Array, Array, Array, Array | None]:
    """Translation, rotation, scale, and the transform (3, 4) where the node has a matrix instead."""
    if "matrix" in node:
        matrix = as_numbers(node["matrix"], 16, f"the matrix of node {number}").reshape(4, 4).T
        return np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), np.ones(3), matrix[:3]
    translation = as_numbers(node.get("translation", [0, 0, 0]), 3, f"the translation of node {number}")
    rotation = as_numbers(node.get("rotation", [0, 0, 0, 1]), 4, f"the rotation of node {number}")
    scale = as_numbers(node.get("scale", [1, 1, 1]), 3, f"the scale of node {number}")
    length = float(np.linalg.norm(rotation))
    return translation, rotation / length if length > 0 else np.array([0.0, 0.0, 0.0, 1.0]), scale, None


def rest_matrix(node: dict[str, Any], number: int) -> Array:
    """(3, 4) the transform of a node to its parent, as the file has it at rest. FormatError."""
    translation, rotation, scale, matrix = _rest_of(node, number)
    if matrix is not None:
        return matrix
    return np.column_stack([to_matrix(rotation) * scale, translation])
