"""Bodies that are made for tests, in files of every format, and their frames as questions see them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mcml.formats import FORMATS
from mcml.motion.anatomy.axes import Stance
from mcml.motion.bodies.bone_axes import line_steps
from mcml.motion.bodies.calibration import Calibration, calibrate
from mcml.motion.bodies.positions import clip_positions, filled, rounded
from mcml.motion.bodies.reference import stance_of
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.clip import ClipStream, Reference, ReferencePose
from mcml.motion.conventions.convert import convert
from mcml.motion.landmarks.centres import body_names, centres_of, with_centres
from mcml.motion.landmarks.sizes import sizes_of
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading, reading_of
from mcml.testing import read, written
from tests.builders import assign

PARTS: dict[str, tuple[str, tuple[float, float, float]]] = {
    "Root": ("", (0, 0, 0)),
    "waist": ("Root", (0, 10, -1)),
    "torso7": ("waist", (0, 20, 1)),
    "neck1": ("torso7", (0, 18, 0)),
    "Head": ("neck1", (0, 10, 2)),
    **{
        f"{side}_{part}": (above if above in ("Root", "torso7") else f"{side}_{above}", (x * sign, y, z))
        for side, sign in (("left", 1.0), ("right", -1.0))
        for part, above, (x, y, z) in (
            ("shoulder", "torso7", (4, 14, 1)),
            ("up_arm", "shoulder", (14, 0, 0)),
            ("low_arm", "up_arm", (2, -28, 0)),
            ("hand", "low_arm", (0, -25, 3)),
            ("up_leg", "Root", (9, -4, 0)),
            ("low_leg", "up_leg", (0, -42, 1)),
            ("foot", "low_leg", (0, -41, -1)),
            ("toes", "foot", (0, -7, 13)),
        )
    },
}
"""A person in centimetres: X to the left, Y up, Z on. Joint: the one above, and where it stands in that."""

FORMAT_OF = {Convention.LISTED: "bvh", Convention.FIXED: "asf-amc", Convention.BASE: "htr"}


def person(seed: int, frames: int = 40, frame_time: float = 1 / 60, scale: float = 1.0) -> bytes:
    """A BVH of someone who goes, turns round more than once, and swings all limbs."""
    rng = np.random.default_rng(seed)
    lines = ["HIERARCHY"]

    def add(name: str, depth: int) -> None:
        above, offset = PARTS[name]
        pad = "\t" * depth
        lines.append(f"{pad}{'JOINT' if above else 'ROOT'} {name}\n{pad}{{")
        lines.append(f"{pad}\tOFFSET {' '.join(f'{value * scale:.5f}' for value in offset)}")
        channels = "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
        lines.append(f"{pad}\tCHANNELS {'3 Zrotation Xrotation Yrotation' if above else channels}")
        children = [child for child, (parent, _) in PARTS.items() if parent == name]
        for child in children:
            add(child, depth + 1)
        if not children:
            lines.append(f"{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\tOFFSET 0 {-3 * scale:.5f} {2 * scale:.5f}\n{pad}\t}}")
        lines.append(pad + "}")

    add("Root", 0)
    time = np.arange(frames)[:, None] * frame_time
    columns = 3 + 3 * len(PARTS)
    values = np.zeros((frames, columns))
    for _ in range(3):
        size, speed, start = rng.uniform(0, 14, columns), rng.uniform(0.5, 9, columns), rng.uniform(0, 6.3, columns)
        values += size * np.sin(speed * time + start)
    values[:, :3] = scale * (values[:, :3] + [0, 95, 0] + time * rng.uniform(-150, 150, 3) * [1, 0, 1])
    values[:, 3:6] *= 0.4
    values[:, 5] += rng.uniform(-180, 180) + time[:, 0] * rng.uniform(-900, 900)
    lines += ["MOTION", f"Frames: {frames}", f"Frame Time: {frame_time:.8f}"]
    lines += [" ".join(f"{value:.5f}" for value in row) for row in values]
    return ("\n".join(lines) + "\n").encode()


def clip_of(content: bytes, convention: Convention = Convention.LISTED) -> ClipStream:
    """The clip of a BVH, written in a format and read again, with MCML's names."""
    clip = named(read(FORMATS["bvh"], {"bvh": content}))
    if convention is Convention.LISTED:
        return clip
    format = FORMATS[FORMAT_OF[convention]]
    frame_time = clip.head.frame_time
    turned = named(read(format, written(format, convert(clip, convention))))
    return turned.with_head(replace(turned.head, frame_time=frame_time))


def named(clip: ClipStream) -> ClipStream:
    return clip.with_head(replace(clip.head, skeleton=assign(clip.head.skeleton)))


def positions_of(clip: ClipStream) -> np.ndarray:
    """(n, J, 3), NaN where a sample is missing."""
    skeleton = clip.head.skeleton
    (found,) = clip_positions(skeleton, [filled(skeleton, clip.blocks())], reading_of(clip.head))
    return found


def stretch_of(clip: ClipStream, calibration: Calibration | None = None) -> Stretch:
    """The whole clip, with lines to the left of bones."""
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    positions, values = positions_of(clip), filled(skeleton, clip.blocks()).values
    calibration = calibration or calibrate(clip.head, positions)
    points = with_centres(centres_of(skeleton), positions, sizes_of(clip.head, calibration.metres))
    steps = rounded(points, calibration.step)
    places = {name: steps[:, index] for index, name in enumerate(body_names(skeleton))}
    lines, sides = line_steps(skeleton, calibration.bones, points, values, reading)
    places |= {line: sides[:, index] for index, line in enumerate(lines)}
    return Stretch(places, len(steps), clip.head.seconds_per_frame(), calibration)


def stance(
    skeleton: Skeleton, pose: tuple[Array, Array] | None = None, reading: Reading = DEGREES, up: str = "Y"
) -> Stance:
    """The reference pose: positions (J, 3) and rotations (J, 4) of a frame, by default the rest pose."""
    kept = None if pose is None else ReferencePose(*(tuple(map(tuple, part.tolist())) for part in pose))
    found = stance_of(Reference(up, kept), skeleton, reading)
    assert found is not None
    return found


def part_of(stretch: Stretch, first: int, end: int, joints: Sequence[str] | None = None) -> Stretch:
    """Some of its frames, and only some joints."""
    names = stretch.places if joints is None else joints
    places = {name: stretch.places[name][first:end].copy() for name in names if name in stretch.places}
    return replace(stretch, places=places, frames=end - first, first=stretch.first + first)
