"""Bodies whose legs are made with known clinical angles, on rigs with any axes at rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from mcml.formats import FORMATS
from mcml.motion.clip import ClipStream
from mcml.motion.skeleton import Array
from mcml.testing import read
from tests.formats.scenes.reading import stating
from tests.motion.bodies.made import named

OFFSETS: dict[str, tuple[str, tuple[float, float, float]]] = {
    "Root": ("", (0, 0, 0)),
    "waist": ("Root", (0, 10, 0)),
    "neck1": ("waist", (0, 40, 0)),
    "Head": ("neck1", (0, 15, 0)),
    **{
        f"{side}_{part}": (above if above == "Root" else f"{side}_{above}", (x * sign, y, z))
        for side, sign in (("left", 1.0), ("right", -1.0))
        for part, above, (x, y, z) in (
            ("up_leg", "Root", (9, -5, 0)),
            ("low_leg", "up_leg", (0, -42, 0)),
            ("foot", "low_leg", (0, -41, 0)),
            ("toes", "foot", (0, -5, 13)),
        )
    },
}
"""X to the left, Y up, Z on, in centimetres: a body that stands upright."""
ON_LEFT_UP = Rotation.from_matrix([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
"""From clinical axes (on, left, up) to those."""


def write_rig(turns: Mapping[str, Rotation] | None = None, rest: Mapping[str, Rotation] | None = None) -> bytes:
    """A BVH of a body. turns: of joints in the world, from standing, in every frame. rest: how bones are turned at
    rest, which changes nothing about where they are in the motion."""
    turns, rest = turns or {}, rest or {}
    still = Rotation.identity()
    count = next((len(turn) for turn in turns.values()), 1)
    lines: list[str] = ["HIERARCHY"]
    order: list[str] = []

    def add(name: str, depth: int) -> None:
        above, offset = OFFSETS[name]
        pad = "\t" * depth
        order.append(name)
        lines.append(f"{pad}{'JOINT' if above else 'ROOT'} {name}\n{pad}{{")
        turned = rest.get(above, still).apply(np.array(offset, dtype=float))
        lines.append(f"{pad}\tOFFSET {' '.join(f'{value:.12f}' for value in turned)}")
        places = "6 Xposition Yposition Zposition" if not above else "3"
        lines.append(f"{pad}\tCHANNELS {places} Zrotation Xrotation Yrotation")
        children = [child for child, (parent, _) in OFFSETS.items() if parent == name]
        for child in children:
            add(child, depth + 1)
        if not children:
            lines.append(f"{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\tOFFSET 0 0 3\n{pad}\t}}")
        lines.append(pad + "}")

    add("Root", 0)
    world = {name: turns[name] if name in turns else Rotation.identity(count) for name in order}
    from_rest = {name: world[name] * rest.get(name, still).inv() for name in order}
    columns = [np.tile([0.0, 95.0, 0.0], (count, 1))]
    for name in order:
        above = OFFSETS[name][0]
        local = from_rest[above].inv() * from_rest[name] if above else from_rest[name]
        columns.append(local.as_euler("ZXY", degrees=True))
    rows = np.concatenate(columns, axis=1)
    lines += ["MOTION", f"Frames: {count}", "Frame Time: 0.01"]
    lines += [" ".join(f"{value:.12f}" for value in row) for row in rows]
    return ("\n".join(lines) + "\n").encode()


def cardan(flexion: Array, adduction: Array, internal: Array, side: str, *, knee: bool = False) -> Rotation:
    """The rotation of a joint with clinical angles, in the axes of the rig."""
    k = -1.0 if side == "right" else 1.0
    degrees = np.stack([flexion if knee else -flexion, -k * adduction, -k * internal], axis=1)
    return ON_LEFT_UP * Rotation.from_euler("YXZ", degrees, degrees=True) * ON_LEFT_UP.inv()


def turns_of(angles: Mapping[str, Array], facing: Rotation) -> dict[str, Rotation]:
    """The rotations of the joints of a body with clinical angles, in the world, from standing."""
    turns = {"Root": facing, "waist": facing, "neck1": facing, "Head": facing}
    for side in ("left", "right"):
        hip = cardan(*(angles[f"{side}-hip-{name}"] for name in ("flexion", "adduction", "internal-rotation")), side)
        knee = (angles[f"{side}-knee-{name}"] for name in ("flexion", "varus", "internal-rotation"))
        turns[f"{side}_up_leg"] = facing * hip
        turns[f"{side}_low_leg"] = turns[f"{side}_up_leg"] * cardan(*knee, side, knee=True)
        turns[f"{side}_foot"] = turns[f"{side}_toes"] = turns[f"{side}_low_leg"]
    return turns


def made_clip(angles: Mapping[str, Array], facing: Rotation, rest: Mapping[str, Rotation] | None = None) -> ClipStream:
    turns = turns_of(angles, facing)
    return stating(named(read(FORMATS["bvh"], {"bvh": write_rig(turns, rest)})), global_axis_of_gravity="Y")


RANGES = {
    "hip-flexion": (-30, 120), "hip-adduction": (-40, 30), "hip-internal-rotation": (-45, 45),
    "knee-flexion": (-15, 140), "knee-varus": (-10, 10), "knee-internal-rotation": (-20, 20),
}  # fmt: skip


def random_angles(rng: np.random.Generator, frames: int, *, hinge: bool = False) -> dict[str, Array]:
    found = {
        f"{side}-{name}": rng.uniform(low, high, frames)
        for side in ("left", "right")
        for name, (low, high) in RANGES.items()
    }
    if hinge:
        found |= {name: np.zeros(frames) for name in found if name.endswith(("knee-varus", "knee-internal-rotation"))}
    return found
