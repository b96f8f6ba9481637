"""FBX files as text: bones with curves, as small as ufbx reads them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

_SECOND = 46_186_158_000
"""Ticks of FBX' clock."""


def fbx_text(
    takes: Sequence[str] = ("Take 001",),
    frames: int = 11,
    rate: int = 30,
    *,
    unit: float = 1.0,
    up: int = 1,
    shapes: Mapping[str, Sequence[float]] | None = None,
) -> bytes:
    """Two bones, the second 10 above the first, which turns about z by 9 degrees a frame and moves along x by 1.

    unit: centimetres of a unit. up: 0, 1 or 2. shapes: percent of blend shapes of a mesh in each frame of all takes.
    """
    shapes = shapes or {}
    mode = {24: 11, 25: 10, 30: 6, 60: 3, 120: 1}[rate]
    objects = [_bone(1, "Hips", (0, 100, 0)), _bone(2, "Spine", (0, 10, 0))]
    links = ['C: "OO",1,0', 'C: "OO",2,1', 'C: "OO",11,1', 'C: "OO",12,2']
    if shapes:
        objects.append(_MESH)
        links += ['C: "OO",3,0', 'C: "OO",50,3', 'C: "OO",60,50']
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
