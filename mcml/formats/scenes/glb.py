"""glTF 2.0 binary: one node for each joint with the source's numbers, an animation, and a visible body as a skin.

Unit and up axis are in the node above all joints, so the joints keep the numbers of the document. Each track is
contiguous, but frames are read one after the other: long clips are read several times, so that at most `_AT_ONCE` bytes
of tracks are in memory.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError, UnsupportedError
from mcml.formats.colours import to_linear
from mcml.formats.format import FileKind, note
from mcml.formats.scenes.body import Body, body_of
from mcml.formats.scenes.scene import TIPS
from mcml.formats.scenes.stage import Stage, look_through, turn_to_y
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.blend_shapes import joints_of
from mcml.motion.frames import in_columns
from mcml.motion.rotations import inverse, to_matrix
from mcml.motion.skeleton import CHANNEL_INDEX

if TYPE_CHECKING:
    from pygltflib import GLTF2

_AT_ONCE = 64 << 20
_LONGEST = (1 << 32) - 1
"""Limit of a file in bytes: its header has 32 bits for it."""
_FLOAT, _SHORT, _INT = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
_COLOUR = [0.36, 0.55, 0.78, 1.0]
_UNIT = "glTF takes them as metres"
_TINY = 1e-6
"""Metres."""


class Glb:
    """The format `glb`; see `mcml.formats.format.Writer`."""

    name = "glb"
    title = "glTF 2.0 binary"
    parts = (FileKind("glb", (".glb",), "Skeleton, motion and a simple body"),)
    convention = None
    media_type = "model/gltf-binary"
    label = "glTF"
    bodies, markers = True, True
    needs = frozenset({"frame_time"})
    assumes = "m"

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_library()
        if not clip.head.skeleton.blend_shapes:
            return write_stage(look_through(clip, "glTF", _UNIT))
        stage = look_through(joints_of(clip), "glTF", _UNIT)
        columns = [(shape, CHANNEL_INDEX["weight"]) for shape in clip.head.skeleton.blend_shapes]
        missing = sum(int(np.isnan(in_columns(block, columns)).sum()) for block in clip.blocks())
        if missing:
            note(clip.notices, "warning", f"{missing} weights of blend shapes are missing; the last value is written")
        return write_stage(replace(stage, faces=clip))


def need_library() -> None:
    """Raises UnsupportedError where the library for glTF is not installed."""
    try:
        import pygltflib  # noqa: F401  # asks whether it is installed
    except ImportError:
        raise UnsupportedError(
            "glTF needs a library that is not installed.",
            remedy="Install the extra: pip install 'mcml-repository[gltf]'.",
        ) from None


@dataclass(frozen=True)
class _Track:
    """The rotation or the translation of a joint, or the weights of all blend shapes, in every frame.

    node: number of the node of the joint, or of the mesh with the shapes. width: how many numbers a frame has.
    """

    node: int
    path: str
    width: int


@dataclass(frozen=True, eq=False)
class _Piece:
    """Frames `first` to `end` of a track, (end - first, 4 or 3) of them."""

    track: _Track
    first: int
    end: int
    values: NDArray[np.float32]


def write_stage(stage: Stage, extensions: dict[str, Any] | None = None) -> Iterator[bytes]:
    """Write a scene as GLB.

    extensions: of the file, by their names; a file with extensions describes a motion alone and has no visible body.
    Raises ConversionError for files of more than 4 GiB.
    """
    import pygltflib as gltf

    tracks = [_Track(joint, "rotation", 4) for joint in np.flatnonzero(stage.turning).tolist()]
    tracks += [_Track(joint, "translation", 3) for joint in np.flatnonzero(stage.moving).tolist()]
    content = _Content()
    model = _model(stage, content, extensions)
    if stage.shapes:
        tracks.append(_Track(_add_shapes(model, stage, content), "weights", len(stage.shapes)))
    if not stage.frames:
        tracks = []
    if tracks:
        _add_animation(model, stage, tracks, content)
    if content.length:
        model.buffers = [gltf.Buffer(byteLength=content.length)]
    length = content.length
    text = model.to_json(separators=(",", ":")).encode("utf-8", "replace")
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + (8 + length if length else 0)
    if total > _LONGEST:
        raise ConversionError(
            f"a glTF file of {stage.frames} frames would have {total} bytes, and no more than {_LONGEST} can be said",
            remedy="Export a part: `first` and `last`.",
        )
    yield struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A) + text
    if length:
        yield struct.pack("<II", length, 0x004E4942) + b"".join(content.arrays)
    if tracks:
        yield from _times(stage)
        yield from _tracks(stage, tracks)


class _Content:
    """The binary part: small arrays first, then arrays computed from the frames."""

    def __init__(self) -> None:
        self.arrays: list[bytes] = []
        self.length = 0

    def add(self, values: NDArray[Any]) -> tuple[int, int]:
        """Add an array that is written unchanged; return (offset, length)."""
        data = values.tobytes()
        self.arrays.append(data + b"\0" * (-len(data) % 4))
        return self.reserve(len(data))

    def reserve(self, length: int) -> tuple[int, int]:
        offset = self.length
        self.length += length + -length % 4
        return offset, length


def _model(stage: Stage, content: _Content, extensions: dict[str, Any] | None) -> GLTF2:
    """Return the JSON part without its animation, with references to the binary part."""
    import pygltflib as gltf

    skeleton = stage.skeleton
    root = len(skeleton)
    tips: dict[int, list[list[float]]] = {}
    for joint, tip in stage.tips:
        tips.setdefault(joint, []).append(tip.tolist())
    nodes = [
        gltf.Node(
            name=_text(joint.source_name),
            translation=stage.rest[index].tolist(),
            children=list(skeleton.children(index)) or None,
            extras={TIPS: tips[index]} if index in tips and extensions is None else {},
        )
        for index, joint in enumerate(skeleton.joints)
    ]
    nodes.append(gltf.Node(name=_text(stage.title), children=list(skeleton.roots) or None))
    if stage.metres is not None and stage.metres != 1.0:
        nodes[root].scale = [stage.metres] * 3
    if stage.up not in (None, "Y"):
        nodes[root].rotation = turn_to_y(stage.up).tolist()
    model = gltf.GLTF2(
        asset=gltf.Asset(generator="MCML Repository", version="2.0"),
        scene=0,
        scenes=[gltf.Scene(name=_text(stage.title), nodes=[root])],
        nodes=nodes,
    )
    if extensions:
        model.extensions, model.extensionsUsed = extensions, list(extensions)
    elif len(skeleton):
        _add_body(model, stage, body_of(stage), content)
    return model


def _add_body(model: GLTF2, stage: Stage, body: Body, content: _Content) -> None:
    """The mesh in metres, Y up, as the joints carry it in its pose, and the matrices that take it to each."""
    import pygltflib as gltf

    skeleton = stage.skeleton
    # From the source's unit and axes to the scene's.
    turn = to_matrix(turn_to_y(stage.up))
    to_scene = turn * (stage.metres or 1.0)
    width = body.joints.shape[1]
    joints, weights = np.zeros((len(body.joints), 4)), np.zeros((len(body.joints), 4))
    # The specification wants joints without weight to be 0.
    joints[:, :width] = np.where(body.weights > 0, body.joints, 0)
    weights[:, :width] = body.weights
    back = np.tile(np.eye(4), (len(skeleton), 1, 1))
    unturned = to_matrix(inverse(body.turns))
    back[:, :3, :3] = unturned @ np.linalg.inv(to_scene)
    back[:, :3, 3] = -np.einsum("jab,jb->ja", unturned, body.places)
    points = (body.points @ to_scene.T).astype(np.float32)
    indices = _add_array(model, content, body.faces.reshape(-1), _INT, "SCALAR", _INDICES)
    places = _add_array(model, content, points, _FLOAT, "VEC3", _VERTICES)
    accessor = model.accessors[places]
    accessor.min, accessor.max = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    attributes = gltf.Attributes(
        POSITION=places,
        JOINTS_0=_add_array(model, content, joints, _SHORT, "VEC4", _VERTICES),
        WEIGHTS_0=_add_array(model, content, weights, _FLOAT, "VEC4", _VERTICES),
    )
    if body.normals is not None:
        attributes.NORMAL = _add_array(model, content, body.normals @ turn.T, _FLOAT, "VEC3", _VERTICES)
    if body.colours is not None:
        attributes.COLOR_0 = _add_array(model, content, to_linear(body.colours), _FLOAT, "VEC3", _VERTICES)
    colour = _COLOUR if body.colours is None else [1.0, 1.0, 1.0, 1.0]
    # Columns one after the other.
    matrices = _add_array(model, content, back.transpose(0, 2, 1).reshape(-1, 16), _FLOAT, "MAT4", None)
    shine = gltf.PbrMetallicRoughness(baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=0.7)
    model.materials = [gltf.Material(name="body", pbrMetallicRoughness=shine)]
    model.meshes = [
        gltf.Mesh(name="body", primitives=[gltf.Primitive(attributes=attributes, indices=indices, material=0)])
    ]
    root = len(skeleton)
    model.skins = [gltf.Skin(inverseBindMatrices=matrices, skeleton=root, joints=list(range(root)))]
    model.nodes.append(gltf.Node(name="body", mesh=0, skin=0))
    model.scenes[0].nodes.append(root + 1)


def _add_shapes(model: GLTF2, stage: Stage, content: _Content) -> int:
    """Add a mesh that carries the weights, and return its node: a clip has the names of its blend shapes alone, so the
    mesh is a triangle too small to be seen, which they do not move.
    """
    import pygltflib as gltf

    points = np.array([[0, 0, 0], [_TINY, 0, 0], [0, _TINY, 0]], np.float32)
    places = _add_array(model, content, points, _FLOAT, "VEC3", _VERTICES)
    moves = _add_array(model, content, np.zeros((3, 3)), _FLOAT, "VEC3", _VERTICES)
    for accessor, values in ((places, points), (moves, np.zeros((1, 3)))):
        model.accessors[accessor].min = values.min(axis=0).tolist()
        model.accessors[accessor].max = values.max(axis=0).tolist()
    primitive = gltf.Primitive(
        attributes=gltf.Attributes(POSITION=places), targets=[gltf.Attributes(POSITION=moves) for _ in stage.shapes]
    )
    model.meshes.append(
        gltf.Mesh(
            name="blend shapes",
            primitives=[primitive],
            weights=[0.0] * len(stage.shapes),
            extras={"targetNames": [_text(name) for name in stage.shapes]},
        )
    )
    model.nodes.append(gltf.Node(name="blend shapes", mesh=len(model.meshes) - 1))
    model.scenes[0].nodes.append(len(model.nodes) - 1)
    return len(model.nodes) - 1


def _add_array(model: GLTF2, content: _Content, values: NDArray[Any], kind: int, type: str, target: int | None) -> int:
    """Add an array that is written unchanged; return its accessor."""
    import pygltflib as gltf

    dtype = {_FLOAT: "<f4", _SHORT: "<u2", _INT: "<u4"}[kind]
    offset, length = content.add(values.astype(dtype))
    model.bufferViews.append(gltf.BufferView(buffer=0, byteOffset=offset, byteLength=length, target=target))
    view = len(model.bufferViews) - 1
    model.accessors.append(gltf.Accessor(bufferView=view, componentType=kind, count=len(values), type=type))
    return len(model.accessors) - 1


def _add_animation(model: GLTF2, stage: Stage, tracks: list[_Track], content: _Content) -> None:
    """Times and tracks in one view, in the order in which they are written."""
    import pygltflib as gltf

    last = float(np.float32((stage.frames - 1) * stage.seconds))
    if stage.frames > 1 and not np.float32((stage.frames - 2) * stage.seconds) < last:
        raise ConversionError(
            f"single precision cannot tell the times of {stage.frames} frames apart, at {stage.seconds:g} seconds each",
            remedy="Export a part: `first` and `last`.",
        )
    view, start = len(model.bufferViews), content.length
    animation = gltf.Animation(name=_text(stage.title), channels=[], samplers=[])
    times = len(model.accessors)
    for track in (None, *tracks):
        width = 1 if track is None else track.width
        offset, _ = content.reserve(4 * width * stage.frames)
        is_plain = track is None or track.path == "weights"
        model.accessors.append(
            gltf.Accessor(
                bufferView=view,
                byteOffset=offset - start,
                componentType=_FLOAT,
                count=stage.frames * (width if is_plain else 1),
                type="SCALAR" if is_plain else f"VEC{width}",
            )
        )
    model.accessors[times].min, model.accessors[times].max = [0.0], [last]
    for number, track in enumerate(tracks):
        animation.samplers.append(gltf.AnimationSampler(input=times, output=times + 1 + number, interpolation="LINEAR"))
        target = gltf.AnimationChannelTarget(node=track.node, path=track.path)
        animation.channels.append(gltf.AnimationChannel(sampler=number, target=target))
    model.bufferViews.append(gltf.BufferView(buffer=0, byteOffset=start, byteLength=content.length - start))
    model.animations = [animation]


def _text(name: str) -> str:
    """Return a name for JSON: unpaired surrogates cannot be encoded in UTF-8."""
    return name.encode("utf-8", "replace").decode()


def _times(stage: Stage) -> Iterator[bytes]:
    for first in range(0, stage.frames, 1 << 16):
        numbers = np.arange(first, min(first + (1 << 16), stage.frames), dtype=np.float64)
        yield (numbers * stage.seconds).astype("<f4").tobytes()


def _tracks(stage: Stage, tracks: list[_Track]) -> Iterator[bytes]:
    """All tracks one after the other, each time as many of them as may be held."""
    for pieces in _groups(tracks, stage.frames):
        at = 0
        last = max(piece.end for piece in pieces)
        for translations, rotations, weights in stage.blocks_with_weights():
            end = at + len(translations)
            for piece in pieces:
                first, behind = max(piece.first, at), min(piece.end, end)
                if first < behind:
                    rows, node = slice(first - at, behind - at), piece.track.node
                    found = {"rotation": rotations, "translation": translations}.get(piece.track.path)
                    values = weights[rows] if found is None else found[rows, node]
                    piece.values[first - piece.first : behind - piece.first] = values
            at = end
            if at >= last:
                break
        for piece in pieces:
            yield piece.values.tobytes()


def _groups(tracks: list[_Track], frames: int) -> Iterator[list[_Piece]]:
    """Pieces in the order in which they are written, as many at a time as may be held."""
    group: list[_Piece] = []
    room = _AT_ONCE
    for track in tracks:
        width = track.width
        first = 0
        while first < frames:
            count = min(frames - first, room // (4 * width))
            if count:
                values = np.empty((count, width), dtype="<f4")
                group.append(_Piece(track, first, first + count, values))
                room -= values.nbytes
                first += count
            if first < frames:
                yield group
                group, room = [], _AT_ONCE
    if group:
        yield group
