"""Documents that hold too little, too much or nothing of a body, as files: one of each kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random

from tests.builders import bvh, c3d_file, mcml_of
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


def odd_document(chance: Random) -> dict[str, bytes]:
    """Return the file of an odd document that chance makes: other shapes, names, gaps, numbers and frame ids than those
    above."""
    return chance.choice((_odd_person, _odd_chain, _odd_markers, _odd_points, _odd_mcml))(chance)


_ODD_NUMBERS = (0.0, -0.0, 1e-12, 1e6, -1e9, 1e30, 1e300, 5e-324, 360.0, 89.999999)
_ODD_NAMES = (
    "left_hand", "LeftHand", "Head", "Root", "Hips", "hips", "End", "a b", "손", "x" * 300, "l_foot", "left foot", "1",
    "_", "LFHD", "RFHD", "toes", "left_hand ",
)  # fmt: skip


def _frame_count(chance: Random) -> int:
    return chance.choice((0, 1, 2, 3, 7, 30, 61, 200))


def _odd_row(chance: Random) -> Callable[[list[float]], list[float]]:
    """Return a change of rows: some columns are constant, odd or swapped."""
    places = [chance.random() for _ in range(200)]
    number, share, swap = chance.choice(_ODD_NUMBERS), chance.choice((0.02, 0.3, 1.0)), chance.random() < 0.3

    def change(row: list[float]) -> list[float]:
        new = [number if places[place % 200] < share else value for place, value in enumerate(row)]
        return new[::-1] if swap else new

    return change


def _odd_person(chance: Random) -> dict[str, bytes]:
    frame_time = chance.choice((1e-6, 1 / 60, 1.0, 1e5))
    scale = chance.choice((0.0, 1e-9, 0.01, 1.0, 25.4, 1e9))
    content = person(chance.randrange(1000), _frame_count(chance), frame_time, scale)
    if chance.random() < 0.6:
        content = changed(content, _odd_row(chance))
    for _ in range(chance.choice((0, 0, 1, 4))):
        old = chance.choice(LABELS).encode()
        content = content.replace(b" " + old + b"\n", b" " + chance.choice(_ODD_NAMES).encode() + b"\n")
    return {"odd.bvh": content}


def _odd_chain(chance: Random) -> dict[str, bytes]:
    names = chance.sample(_ODD_NAMES, chance.randint(1, 12))
    return {"odd.bvh": changed(bvh(_frame_count(chance), chance.randrange(99), names), _odd_row(chance))}


def _odd_markers(chance: Random) -> dict[str, bytes]:
    labels = [chance.choice((*LABELS, *_ODD_NAMES)) for _ in range(chance.choice((0, 1, 2, 20, 300)))]
    missing, number = chance.choice((0.0, 0.1, 0.9, 1.0)), chance.choice(_ODD_NUMBERS)
    rows = [
        [None if chance.random() < missing else chance.choice((number, chance.gauss(0, 900))) for _ in labels * 3]
        for _ in range(_frame_count(chance))
    ]
    return {"odd.trc": trc(labels, rows, chance.choice((1, 25, 60, 100_000)))}


def _odd_points(chance: Random) -> dict[str, bytes]:
    points = chance.choice((1, 3, 40))
    first = chance.choice((1, 11, 30_000))
    return {"odd.c3d": c3d_file(max(1, _frame_count(chance)), points, chance.choice((1.0, 120.0)), first)}


def _odd_mcml(chance: Random) -> dict[str, bytes]:
    count = _frame_count(chance)
    ids = sorted(chance.sample(range(1, 10 * count + 10), count))
    content = mcml_of(ids).decode()
    for old, new in (
        ('Rx="1"', ""), ('Rx="2"', 'Rx="1e300"'), ("left_up_leg", "손목"), ("<frametime>0.0333</frametime>", ""),
        ("0.0333", "1e-9"), ("<dof>rx ry rz</dof>", "<dof>rx</dof>"), ('name="Root" order', 'name="Head" order'),
        ("<frame id", "<frame  id"),
    ):  # fmt: skip
        if chance.random() < 0.2:
            content = content.replace(old, new)
    return {"odd.mcml": content.encode()}
