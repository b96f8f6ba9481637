"""FBX files as text: bones with curves, as small as ufbx reads them."""

from __future__ import annotations

from collections.abc import Sequence

_SECOND = 46_186_158_000
"""Ticks of FBX' clock."""


def fbx_text(
    takes: Sequence[str] = ("Take 001",), frames: int = 11, rate: int = 30, *, unit: float = 1.0, up: int = 1
) -> bytes:
    """Two bones, the second 10 above the first, which turns about z by 9 degrees a frame and moves along x by 1.

    unit: centimetres of a unit. up: 0, 1 or 2.
    """
    mode = {24: 11, 25: 10, 30: 6, 60: 3, 120: 1}[rate]
    objects = [_bone(1, "Hips", (0, 100, 0)), _bone(2, "Spine", (0, 10, 0))]
    links = ['C: "OO",1,0', 'C: "OO",2,1', 'C: "OO",11,1', 'C: "OO",12,2']
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
