"""FBX files as text: bones with curves, as small as ufbx reads them."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

_SECOND = 46_186_158_000
"""Ticks of FBX' clock."""


@dataclass(frozen=True)
class Skin:
    """A mesh with a skin.

    points: of the mesh. faces: vertices of each. weights: of the first bone at each vertex; the second has the rest.
    uv: of each vertex, or none. colour: of its material. picture: bytes of a PNG in the place of the colour.
    """

    points: Sequence[tuple[float, float, float]]
    faces: Sequence[Sequence[int]]
    weights: Sequence[float]
    uv: Sequence[tuple[float, float]] = ()
    colour: tuple[float, float, float] = (1.0, 0.0, 0.0)
    picture: bytes | None = None


def fbx_text(
    takes: Sequence[str] = ("Take 001",),
    frames: int = 11,
    rate: int = 30,
    *,
    unit: float = 1.0,
    up: int = 1,
    shapes: Mapping[str, Sequence[float]] | None = None,
    skin: Skin | None = None,
) -> bytes:
    """Two bones, the second 10 above the first, which turns about z by 9 degrees a frame and moves along x by 1.

    unit: centimetres of a unit. up: 0, 1 or 2. shapes: percent of blend shapes of a mesh in each frame of all takes.
    skin: a mesh that follows the bones.
    """
    shapes = shapes or {}
    mode = {24: 11, 25: 10, 30: 6, 60: 3, 120: 1}[rate]
    objects = [_bone(1, "Hips", (0, 100, 0)), _bone(2, "Spine", (0, 10, 0))]
    links = ['C: "OO",1,0', 'C: "OO",2,1', 'C: "OO",11,1', 'C: "OO",12,2']
    if shapes:
        objects.append(_MESH)
        links += ['C: "OO",3,0', 'C: "OO",50,3', 'C: "OO",60,50']
    if skin is not None:
        objects.append(_skin(skin))
        links += [f'C: "OO",{one},{other}' for one, other in _SKIN_LINKS]
        if skin.picture is not None:
            objects.append(_texture(skin.picture))
            links += ['C: "OP",95,94, "DiffuseColor"', 'C: "OO",96,95']
    for place, name in enumerate(shapes):
        objects.append(_shape(61 + place, 71 + place, name))
        links += [f'C: "OO",{61 + place},60', f'C: "OO",{71 + place},{61 + place}']
    for number, take in enumerate(takes):
        base = 100 * (number + 1)
        end = _SECOND * (frames - 1) // rate
        objects.append(
            f'AnimationStack: {base}, "AnimStack::{take}", "" {{\nProperties70: {{\n'
            'P: "LocalStart", "KTime", "Time", "",0\nP: "ReferenceStart", "KTime", "Time", "",0\n'
            f'P: "LocalStop", "KTime", "Time", "",{end}\nP: "ReferenceStop", "KTime", "Time", "",{end}\n}}\n}}'
        )
        objects.append(f'AnimationLayer: {base + 1}, "AnimLayer::Base", "" {{ }}')
        links.append(f'C: "OO",{base + 1},{base}')
        for place, (name, path, slope, start) in enumerate(
            (
                ("T", "Lcl Translation", (1, 0, 0), (0, 100, 0)),
                ("R", "Lcl Rotation", (0, 0, 9 * (number + 1)), (0, 0, 0)),
            )
        ):
            node = base + 10 + 10 * place
            objects.append(f'AnimationCurveNode: {node}, "AnimCurveNode::{name}", "" {{ Properties70: {{ }} }}')
            links += [f'C: "OO",{node},{base + 1}', f'C: "OP",{node},1, "{path}"']
            for axis, letter in enumerate("XYZ"):
                values = [start[axis] + slope[axis] * frame for frame in range(frames)]
                objects.append(_curve(node + 1 + axis, values, rate))
                links.append(f'C: "OP",{node + 1 + axis},{node}, "d|{letter}"')
        for place, percents in enumerate(shapes.values()):
            node, curve = base + 40 + place, base + 60 + place
            objects.append(f'AnimationCurveNode: {node}, "AnimCurveNode::DeformPercent", "" {{ Properties70: {{ }} }}')
            objects.append(_curve(curve, list(percents), rate))
            links += [f'C: "OO",{node},{base + 1}', f'C: "OP",{node},{61 + place}, "DeformPercent"']
            links.append(f'C: "OP",{curve},{node}, "d|DeformPercent"')
    newline = "\n"
    return f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{
    FBXHeaderVersion: 1003
    FBXVersion: 7400
}}
GlobalSettings:  {{
    Version: 1000
    Properties70:  {{
        P: "UpAxis", "int", "Integer", "",{up}
        P: "UpAxisSign", "int", "Integer", "",1
        P: "FrontAxis", "int", "Integer", "",{2 if up == 1 else 1}
        P: "FrontAxisSign", "int", "Integer", "",{1 if up == 1 else -1}
        P: "CoordAxis", "int", "Integer", "",0
        P: "CoordAxisSign", "int", "Integer", "",1
        P: "UnitScaleFactor", "double", "Number", "",{unit}
        P: "TimeMode", "enum", "", "",{mode}
    }}
}}
Objects:  {{
{newline.join(objects)}
}}
Connections:  {{
{newline.join(links)}
}}
""".encode()


_MESH = """Model: 3, "Model::Face", "Mesh" { Version: 232 }
Geometry: 50, "Geometry::Face", "Mesh" {
 Vertices: *9 {
 a: 0,0,0,1,0,0,0,1,0
 }
 PolygonVertexIndex: *3 {
 a: 0,1,-3
 }
}
Deformer: 60, "Deformer::Morpher", "BlendShape" { Version: 100 }"""


def _shape(channel: int, geometry: int, name: str) -> str:
    return (
        f'Deformer: {channel}, "SubDeformer::{name}", "BlendShapeChannel" {{ Version: 100\n DeformPercent: 0\n'
        " FullWeights: *1 {\n a: 100\n }\n}\n"
        f'Geometry: {geometry}, "Geometry::{name}", "Shape" {{ Version: 100\n Indexes: *1 {{\n a: 0\n }}\n'
        " Vertices: *3 {\n a: 0,0,1\n }\n}"
    )


def _bone(number: int, name: str, place: tuple[float, float, float]) -> str:
    x, y, z = place
    return (
        f'NodeAttribute: {number + 10}, "NodeAttribute::{name}", "LimbNode" {{ TypeFlags: "Skeleton" }}\n'
        f'Model: {number}, "Model::{name}", "LimbNode" {{\nVersion: 232\nProperties70: {{\n'
        f'P: "Lcl Translation", "Lcl Translation", "", "A",{x},{y},{z}\n}}\n}}'
    )


def _curve(number: int, values: list[float], rate: int) -> str:
    count = len(values)
    times = ",".join(str(_SECOND * frame // rate) for frame in range(count))
    numbers = ",".join(str(value) for value in values)
    return (
        f'AnimationCurve: {number}, "AnimCurve::", "" {{ Default: 0\n KeyVer: 4008\n'
        f" KeyTime: *{count} {{\n a: {times}\n }}\n KeyValueFloat: *{count} {{\n a: {numbers}\n }}\n"
        " KeyAttrFlags: *1 {\n a: 4\n }\n KeyAttrDataFloat: *4 {\n a: 0,0,0,0\n }\n"
        f" KeyAttrRefCount: *1 {{\n a: {count}\n }}\n}}"
    )


_SKIN_LINKS = ((80, 0), (81, 80), (94, 80), (90, 81), (91, 90), (92, 90), (1, 91), (2, 92))


def _skin(skin: Skin) -> str:
    numbers = [number for point in skin.points for number in point]
    corners = [vertex if at + 1 < len(face) else -1 - vertex for face in skin.faces for at, vertex in enumerate(face)]
    uv = _uv(skin) if skin.uv else ""
    material = 'LayerElementMaterial: 0 {\n MappingInformationType: "AllSame"\n Materials: *1 {\n a: 0\n }\n}'
    red, green, blue = skin.colour
    colour = f'P: "DiffuseColor", "Color", "", "A",{red},{green},{blue}'
    bones = [
        _cluster(91, skin.weights, (0, 100, 0)),
        _cluster(92, [1 - weight for weight in skin.weights], (0, 110, 0)),
    ]
    return "\n".join(
        (
            'Model: 80, "Model::Body", "Mesh" { Version: 232 }',
            'Geometry: 81, "Geometry::Body", "Mesh" {',
            _list("Vertices", numbers),
            _list("PolygonVertexIndex", corners),
            uv,
            material,
            "}",
            f'Material: 94, "Material::Red", "" {{ Properties70: {{ {colour} }} }}',
            'Deformer: 90, "Deformer::Skin", "Skin" { Version: 101 }',
            *bones,
        )
    )


def _uv(skin: Skin) -> str:
    numbers = [number for place in skin.uv for number in place]
    indices = [vertex for face in skin.faces for vertex in face]
    return (
        'LayerElementUV: 0 {\n MappingInformationType: "ByPolygonVertex"\n ReferenceInformationType: "IndexToDirect"\n'
        f"{_list('UV', numbers)}\n{_list('UVIndex', indices)}\n}}"
    )


def _cluster(number: int, weights: Sequence[float], place: tuple[float, float, float]) -> str:
    """place: of the bone as it was bound, in the world, where the mesh is at its origin."""
    chosen = [vertex for vertex, weight in enumerate(weights) if weight > 0]
    x, y, z = place
    return "\n".join(
        (
            f'Deformer: {number}, "SubDeformer::Cluster", "Cluster" {{ Version: 100',
            _list("Indexes", chosen),
            _list("Weights", [weights[vertex] for vertex in chosen]),
            _list("Transform", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1]),
            _list("TransformLink", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1]),
            "}",
        )
    )


def _texture(picture: bytes) -> str:
    content = base64.b64encode(picture).decode()
    return (
        'Texture: 95, "Texture::Cloth", "" { RelativeFilename: "cloth.png" }\n'
        f'Video: 96, "Video::Cloth", "Clip" {{ RelativeFilename: "cloth.png"\n Content: , "{content}"\n}}'
    )


def _list(name: str, numbers: Sequence[float]) -> str:
    return f" {name}: *{len(numbers)} {{\n a: {','.join(map(str, numbers))}\n }}"
