"""GLB files read as their specification says, with matrices and nothing of the service; and where joints should be."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mcml.motion.clip import ClipStream
from mcml.motion.kinematics import Walker
from mcml.motion.units import reading_of

_KINDS = {5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Scene:
    """model: the JSON part. binary: the other one."""

    model: dict[str, Any]
    binary: bytes

    def array(self, accessor: int) -> np.ndarray:
        said = self.model["accessors"][accessor]
        view = self.model["bufferViews"][said["bufferView"]]
        start = view.get("byteOffset", 0) + said.get("byteOffset", 0)
        width, kind = _WIDTHS[said["type"]], np.dtype(_KINDS[said["componentType"]])
        assert start % kind.itemsize == 0
        assert said.get("byteOffset", 0) + said["count"] * width * kind.itemsize <= view["byteLength"]
        values = np.frombuffer(self.binary, kind, said["count"] * width, start).reshape(said["count"], width)
        for name, extreme in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
            if name in said:
                assert [float(value) for value in extreme] == said[name]
        return values

    @property
    def joints(self) -> list[int]:
        return self.model["skins"][0]["joints"]

    def times(self) -> np.ndarray:
        (animation,) = self.model["animations"]
        (source,) = {sampler["input"] for sampler in animation["samplers"]}
        times = self.array(source)[:, 0]
        assert (np.diff(times) > 0).all()
        return times

    def matrices(self) -> np.ndarray:
        """(n, N, 4, 4) of every node in the scene, in every frame; one frame where nothing moves."""
        nodes = self.model["nodes"]
        moved: dict[tuple[int, str], np.ndarray] = {}
        for animation in self.model.get("animations") or []:
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                assert sampler["interpolation"] == "LINEAR"
                moved[channel["target"]["node"], channel["target"]["path"]] = self.array(sampler["output"])
        frames = len(self.times()) if moved else 1
        assert all(len(values) == frames for values in moved.values())
        local = np.tile(np.eye(4), (frames, len(nodes), 1, 1))
        for index, node in enumerate(nodes):
            assert "matrix" not in node
            turn = moved.get((index, "rotation"), np.array([node.get("rotation") or [0, 0, 0, 1]]))
            local[:, index, :3, :3] = _matrix(turn.astype(float)) * np.array(node.get("scale") or [1, 1, 1])
            local[:, index, :3, 3] = moved.get((index, "translation"), np.array([node.get("translation") or [0, 0, 0]]))
        world = np.full_like(local, np.nan)

        def place(index: int, above: np.ndarray) -> None:
            assert np.isnan(world[:, index]).all(), "a node has one parent"
            world[:, index] = above @ local[:, index]
            for child in nodes[index].get("children") or []:
                place(child, world[:, index])

        for root in self.model["scenes"][self.model["scene"]]["nodes"]:
            place(root, np.tile(np.eye(4), (frames, 1, 1)))
        return world

    def positions(self) -> np.ndarray:
        """(n, J, 3) of the joints of the skin."""
        return self.matrices()[:, self.joints][:, :, :3, 3]

    def body(self) -> np.ndarray:
        """(n, V, 3) corners of the mesh on its skin."""
        (primitive,) = self.model["meshes"][0]["primitives"]
        names = primitive["attributes"]
        points, carriers = self.array(names["POSITION"]), self.array(names["JOINTS_0"])
        weights = self.array(names["WEIGHTS_0"])
        assert (weights >= 0).all()
        assert np.abs(weights.sum(axis=1) - 1).max() < 1e-6
        assert (carriers[weights == 0] == 0).all()
        assert self.array(primitive["indices"]).max() == len(points) - 1
        back = self.array(self.model["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        moved = self.matrices()[:, self.joints] @ back
        rows = np.column_stack([points, np.ones(len(points))])
        return sum(
            weights[:, [slot]] * np.einsum("nvij,vj->nvi", moved[:, carriers[:, slot]], rows)[:, :, :3]
            for slot in range(4)
            if weights[:, slot].any()
        )


def _matrix(turn: np.ndarray) -> np.ndarray:
    np.testing.assert_allclose(np.linalg.norm(turn, axis=1), 1, atol=1e-6)
    x, y, z, w = turn.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def read_glb(content: bytes) -> Scene:
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    chunks, at = [], 12
    while at < len(content):
        size, kind = struct.unpack_from("<II", content, at)
        assert size % 4 == 0
        chunks.append((kind, content[at + 8 : at + 8 + size]))
        at += 8 + size
    assert at == len(content)
    assert [kind for kind, _ in chunks] in ([0x4E4F534A], [0x4E4F534A, 0x004E4942])
    model = json.loads(chunks[0][1])
    binary = chunks[1][1] if len(chunks) > 1 else b""
    assert sum(buffer["byteLength"] for buffer in model.get("buffers") or []) == len(binary)
    return Scene(model, binary)


_TO_Y = {
    "Y": np.eye(3),
    "Z": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "X": np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "-Y": np.diag([1, -1, -1]),
}
"""By the axis that is up, what turns it to Y."""


def expected(clip: ClipStream, metres: float = 1.0, up: str = "Y") -> np.ndarray:
    """(n, J, 3) where the joints are, by the service's own kinematics, in metres with Y up."""
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    found = [walker.poses(block)[0] for block in clip.blocks() if len(block)]
    return np.concatenate(found) @ (_TO_Y[up] * metres).T


def size_of(scene: Scene, clip: ClipStream) -> float:
    """Metres of one of the clip's units in the scene: what its header states, or what the writer guessed."""
    root = scene.model["nodes"][len(clip.head.skeleton)]
    return float((root.get("scale") or [1.0])[0])


def height(positions: np.ndarray) -> float:
    """The largest extent of the body in the first frame."""
    return float(np.ptp(positions[0], axis=0).max()) or 1.0


def stating(clip: ClipStream, **fields: str) -> ClipStream:
    """The clip whose header has these fields too."""
    return clip.with_head(replace(clip.head, fields=clip.head.fields | fields))
