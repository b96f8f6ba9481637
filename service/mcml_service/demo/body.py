"""A generated person, and the clips it performs, as BVH-like clips (rotations listed Z X Y, centimetres, Y up)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart, full_shape
from mcml.motion.skeleton import Array, Convention, EndSite, Joint, Skeleton

RATE = 60

_SIDE = (
    # name, parent, offset as part of the height, mirrored by side
    ("UpLeg", "Hips", (0.052, -0.02, 0.0)),
    ("Leg", "UpLeg", (0.0, -0.245, 0.0)),
    ("Foot", "Leg", (0.0, -0.246, 0.0)),
    ("ToeBase", "Foot", (0.0, -0.039, 0.08)),
    ("Shoulder", "Spine1", (0.018, 0.12, 0.0)),
    ("Arm", "Shoulder", (0.11, 0.0, 0.0)),
    ("ForeArm", "Arm", (0.17, 0.0, 0.0)),
    ("Hand", "ForeArm", (0.155, 0.0, 0.0)),
)
_TIPS = {"ToeBase": (0.0, 0.0, 0.04), "Hand": (0.1, 0.0, 0.0), "Head": (0.0, 0.12, 0.0)}
_CENTRE = (
    ("Hips", None, (0.0, 0.53, 0.0)),
    ("Spine", "Hips", (0.0, 0.06, 0.0)),
    ("Spine1", "Spine", (0.0, 0.12, 0.0)),
    ("Neck", "Spine1", (0.0, 0.15, 0.0)),
    ("Head", "Neck", (0.0, 0.05, 0.01)),
)

Angles = Mapping[str, Array]
"""Degrees about Z, X, Y for each joint that moves: (F, 3)."""


def _lexeme(value: float) -> str:
    return f"{value:.4f}"


def skeleton(height: float) -> Skeleton:
    """A person of that height (cm): 21 joints."""
    joints: dict[str, tuple[str | None, tuple[float, float, float]]] = {n: (p, o) for n, p, o in _CENTRE}
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        for name, parent, (x, y, z) in _SIDE:
            of = parent if parent in joints else f"{side}{parent}"
            joints[f"{side}{name}"] = (of, (sign * x, y, z))
    order = _depth_first(joints)
    place = {name: index for index, name in enumerate(order)}
    result = []
    for name in order:
        above, offset = joints[name]
        tip = next((_TIPS[end] for end in _TIPS if name.endswith(end)), None)
        if tip is not None and name.startswith("Right"):
            tip = (-tip[0], tip[1], tip[2])
        sites = () if tip is None else (EndSite(_triple(tip, height)),)
        rotations = ("Rz", "Rx", "Ry")
        result.append(
            Joint(
                name=name,
                parent=-1 if above is None else place[above],
                source_name=name,
                convention=Convention.LISTED,
                channels=("Tx", "Ty", "Tz", *rotations) if above is None else rotations,
                rotation_order="ZXY",
                offset=_triple((0.0, 0.0, 0.0) if above is None else offset, height),
                translation="absolute" if above is None else "",
                end_sites=sites,
            )
        )
    return Skeleton(tuple(result))


def _triple(offset: tuple[float, float, float], height: float) -> tuple[str, str, str]:
    x, y, z = (_lexeme(part * height) for part in offset)
    return x, y, z


def _depth_first(joints: Mapping[str, tuple[str | None, tuple[float, float, float]]]) -> list[str]:
    order: list[str] = []
    waiting = ["Hips"]
    while waiting:
        name = waiting.pop()
        order.append(name)
        waiting += reversed([child for child, (parent, _) in joints.items() if parent == name])
    return order


def clip(name: str, height: float, root: Array, angles: Angles) -> ClipStream:
    """root: (F, 3) position of the hips in cm. Numbers have four decimals, as capture systems write them."""
    body = skeleton(height)
    columns = body.columns()
    values = np.zeros((len(root), len(columns)))
    values[:, :3] = root
    place = {joint.name: index for index, joint in enumerate(body.joints)}
    for joint, degrees in angles.items():
        first = columns.index((place[joint], 5))
        values[:, first : first + 3] = degrees
    values = np.round(values, 4) + 0.0
    head = ClipHead(
        format="bvh",
        skeleton=body,
        fields={"filename": f"{name}.bvh"},
        frame_time=f"{1 / RATE:.7f}",
        number_style="fixed:4",
        sources=(SourcePart("bvh", f"{name}.bvh"),),
    )

    def blocks() -> Iterator[FrameBlock]:
        yield FrameBlock(values, columns, (full_shape(columns),), np.arange(1, len(values) + 1))

    return ClipStream(head, blocks, len(values))


def walk(height: float, seconds: float, pace: float, sway: float) -> tuple[Array, dict[str, Array]]:
    """(root, angles) of a walk forward. pace: strides a second. sway: degrees of the trunk."""
    time = np.arange(round(seconds * RATE)) / RATE
    phase = 2 * np.pi * pace * time
    zero = np.zeros_like(phase)
    speed = 0.75 * height * pace
    root = np.stack(
        [0.012 * height * np.sin(phase), 0.53 * height + 0.012 * height * np.cos(2 * phase), speed * time], axis=1
    )
    angles = {"Spine": _turn(sway * 0.3 * np.sin(phase), 3 + zero, sway * np.sin(phase))}
    for side, shift in (("Left", 0.0), ("Right", np.pi)):
        swing = np.sin(phase + shift)
        bend = np.clip(np.sin(phase + shift + 1.9), 0, None) ** 2
        angles[f"{side}UpLeg"] = _turn(zero, -26 * swing - 4, zero)
        angles[f"{side}Leg"] = _turn(zero, 6 + 52 * bend, zero)
        angles[f"{side}Foot"] = _turn(zero, 14 * np.sin(phase + shift + 0.9), zero)
        down = -78.0 if side == "Left" else 78.0
        angles[f"{side}Arm"] = _turn(down + zero, zero, (24 if side == "Left" else -24) * -swing)
        angles[f"{side}ForeArm"] = _turn(zero, zero, (-1 if side == "Left" else 1) * (16 + 8 * swing))
    return root, angles


def reach(height: float, seconds: float, elevation: float, side: str = "Right") -> tuple[Array, dict[str, Array]]:
    """(root, angles) of one reach with the right hand to a point at an elevation (degrees), and back."""
    time = np.arange(round(seconds * RATE)) / RATE
    u = np.clip(np.minimum(time / (0.45 * seconds), (seconds - time) / (0.45 * seconds)), 0, 1)
    there = u**3 * (10 - 15 * u + 6 * u**2)
    zero = np.zeros_like(time)
    root = np.stack([zero, 0.53 * height + zero, zero], axis=1)
    angles = _arms_down(zero)
    sign = 1.0 if side == "Left" else -1.0
    lift = sign * (-78 + (78 + elevation * 0.4) * there)
    angles[f"{side}Arm"] = _turn(lift, zero, -sign * 70 * there)
    angles[f"{side}ForeArm"] = _turn(zero, zero, -sign * (12 + 55 * there * (1 - there) * 4))
    angles["Spine"] = _turn(zero, 10 * there * (1 - elevation / 120), 12 * there)
    angles["Head"] = _turn(zero, -elevation * 0.2 * there, zero)
    return root, angles


def wave(height: float, seconds: float, beats: float) -> tuple[Array, dict[str, Array]]:
    """(root, angles): the left arm is abducted, waves at a number of beats a second, and is lowered."""
    time = np.arange(round(seconds * RATE)) / RATE
    u = np.clip(np.minimum(time, seconds - time) / 0.8, 0, 1)
    up = u**2 * (3 - 2 * u)
    zero = np.zeros_like(time)
    root = np.stack([zero, 0.53 * height + zero, zero], axis=1)
    angles = _arms_down(zero)
    angles["LeftArm"] = _turn(-78 + 110 * up, zero, zero)
    angles["LeftForeArm"] = _turn((50 + 24 * np.sin(2 * np.pi * beats * time)) * up, zero, zero)
    return root, angles


def dance(height: float, seconds: float, tempo: float, depth: float) -> tuple[Array, dict[str, Array]]:
    """(root, angles) of a side step to a tempo (beats a minute): weight, knees and arms turn on the beat."""
    time = np.arange(round(seconds * RATE)) / RATE
    beat = np.pi * tempo / 60 * time
    zero = np.zeros_like(time)
    root = np.stack([0.1 * height * np.sin(beat), (0.52 - 0.02 * depth * np.abs(np.cos(beat))) * height, zero], axis=1)
    angles = {
        "Spine": _turn(6 * np.sin(beat), zero, 14 * np.sin(beat)),
        "Head": _turn(-4 * np.sin(beat), zero, -8 * np.sin(beat)),
    }
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        bend = 18 * depth * np.clip(np.cos(beat + (0 if sign > 0 else np.pi)), 0, None)
        angles[f"{side}UpLeg"] = _turn(sign * 6 + 8 * np.sin(beat), -bend, zero)
        angles[f"{side}Leg"] = _turn(zero, 2 * bend, zero)
        angles[f"{side}Arm"] = _turn(sign * (-50 + 25 * np.abs(np.sin(beat))), zero, zero)
        angles[f"{side}ForeArm"] = _turn(zero, zero, -sign * (60 + 20 * np.cos(2 * beat)))
    return root, angles


def _arms_down(zero: Array) -> dict[str, Array]:
    return {
        "LeftArm": _turn(-78 + zero, zero, zero),
        "RightArm": _turn(78 + zero, zero, zero),
    }


def _turn(z: Array, x: Array, y: Array) -> Array:
    return np.stack(np.broadcast_arrays(z, x, y), axis=1)
