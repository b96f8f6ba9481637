"""Documents that hold too little, too much or nothing of a body, as files: one of each kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tests.builders import bvh
from tests.motion.bodies.made import PARTS, person

LABELS = tuple(PARTS)
FRAMES = 60


def trc(labels: Sequence[str], rows: Sequence[Sequence[float | None]], rate: int = 60) -> bytes:
    """Markers of these labels in millimetres; None is a sample that is missing."""
    head = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"
    values = f"{rate}\t{rate}\t{len(rows)}\t{len(labels)}\tmm\t{rate}\t1\t{len(rows)}"
    axes = "\t".join(f"{axis}{number}" for number in range(1, len(labels) + 1) for axis in "XYZ")
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        head,
        values,
        "Frame#\tTime\t" + "\t\t\t".join(labels),
        f"\t\t{axes}",
        "",
    ]
    for number, row in enumerate(rows):
        cells = ["" if value is None else f"{value:g}" for value in row]
        lines.append("\t".join([str(number + 1), f"{number / rate:.4f}", *cells]))
    return ("\n".join(lines) + "\n").encode()


def changed(content: bytes, change: Callable[[list[float]], list[float]]) -> bytes:
    """A BVH with other values in each frame."""
    head, _, tail = content.decode().partition("Frame Time:")
    time, *rows = tail.splitlines()
    made = [" ".join(f"{value:.9g}" for value in change([float(cell) for cell in row.split()])) for row in rows]
    return "\n".join([f"{head}Frame Time:{time}", *made, ""]).encode()


def fan(joints: int) -> bytes:
    """A BVH of a root with so many joints on it."""
    end = "\t\tEnd Site\n\t\t{{\n\t\t\tOFFSET 0 1 0\n\t\t}}\n\t}}"
    joint = "\tJOINT j{0}\n\t{{\n\t\tOFFSET {0} 1 0\n\t\tCHANNELS 1 Xrotation\n" + end
    lines = ["HIERARCHY", "ROOT Hips", "{", "\tOFFSET 0 0 0", "\tCHANNELS 3 Xposition Yposition Zposition"]
    lines += [joint.format(number) for number in range(1, joints)]
    row = " ".join(["1"] * (joints + 2))
    return ("\n".join([*lines, "}", "MOTION", "Frames: 3", "Frame Time: 0.02", row, row, row]) + "\n").encode()


def _empty_mcml(skeleton: str) -> bytes:
    frames = '<frames>2</frames><frametime>0.1</frametime><frame id="1"/><frame id="2"/>'
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE mcml SYSTEM "mcml.dtd">\n<mcml version="1.0">'
        f"<header><filename>a.mcml</filename></header>{skeleton}<motion>{frames}</motion></mcml>"
    ).encode()


_NOTHING: list[float | None] = [None] * (3 * len(LABELS))
_SEEN: list[float | None] = [float(number) for number in range(len(_NOTHING))]
_AWAY = [1e8, -1e8, 1e8]
_ROOT = '<root name="Root" order="Tx Ty Tz Rx Ry Rz" axis="XYZ" position="0 0 0" orientation="0 0 0"/>'
_BONE = '<bone id="1"><name>left_up_leg</name><dof>rx ry rz</dof></bone>'

ODD: dict[str, dict[str, bytes]] = {
    "no labels": {"odd.trc": trc([], [[] for _ in range(FRAMES)])},
    "no labels, no rows": {"odd.trc": trc([], [])},
    "no bones": {"odd.mcml": _empty_mcml("<skeleton/>")},
    "a root alone": {"odd.mcml": _empty_mcml('<root name="Root"/><skeleton/>')},
    "no samples": {"odd.mcml": _empty_mcml(f"{_ROOT}<skeleton>{_BONE}</skeleton>")},
    "no frames": {"odd.bvh": person(1, 0)},
    "one frame": {"odd.bvh": person(1, 1)},
    "two frames": {"odd.bvh": person(1, 2)},
    "zero offsets": {"odd.bvh": person(1, FRAMES, scale=0.0)},
    "far away": {"odd.bvh": changed(person(1, FRAMES), lambda row: [*_AWAY, *row[3:]])},
    "out of reach": {"odd.bvh": changed(person(1, FRAMES), lambda row: [1e300, -1e300, 1e300, *row[3:]])},
    "a giant": {"odd.bvh": person(1, FRAMES, scale=1e300)},
    "an ant": {"odd.bvh": person(1, FRAMES, scale=1e-4)},
    "one joint": {"odd.bvh": bvh(FRAMES, names=["Hips"])},
    "one joint, one frame": {"odd.bvh": bvh(1, names=["Root"])},
    "many joints": {"odd.bvh": fan(2000)},
    "many markers": {"odd.trc": trc([f"m{n}" for n in range(2000)], [[float(n) for n in range(6000)]] * 3)},
    "never seen": {"odd.trc": trc(LABELS, [_NOTHING] * FRAMES)},
    "in one point": {"odd.trc": trc(LABELS, [[5.0] * len(_NOTHING)] * FRAMES)},
    "seen by turns": {"odd.trc": trc(LABELS, [_NOTHING if n % 2 else _SEEN for n in range(FRAMES)])},
    "seen late": {"odd.trc": trc(LABELS, [_NOTHING if n < 40 else _SEEN for n in range(FRAMES)])},
}
