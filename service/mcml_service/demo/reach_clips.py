"""Labelled reach clips in the shape of the founding paper's set: drivers who reach for the seat belt.

The law that makes them is written in docs/analyses/reach.md, with every constant. Centimetres, Y up, X to the left, Z
ahead; angles in degrees in the clips, channels X Y Z at every joint.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart, full_shape
from mcml.motion.hub import walked
from mcml.motion.rotations import from_euler, inverse, multiply, rotate, shortest_arc, to_euler
from mcml.motion.skeleton import Array, Convention, EndSite, Joint, Skeleton

RATE = 30
BELT = np.array([26.0, 80.0, 0.0])
SEAT = 30.0
YOUNG, OLD = (5,) * 10 + (4,) * 12, (5,) * 11 + (4,) * 8
"""Trials of each person."""

_JOINTS: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    # name, parent, offset as part of the height; "L" and "R" are Biped's sides
    ("", "", (0.0, 0.0, 0.0)),
    ("Pelvis", "", (0.0, 0.0, 0.0)),
    ("Spine", "Pelvis", (0.0, 0.045, 0.0)),
    ("Spine1", "Spine", (0.0, 0.08, 0.0)),
    ("Spine2", "Spine1", (0.0, 0.09, 0.0)),
    ("Neck", "Spine2", (0.0, 0.1, 0.0)),
    ("Head", "Neck", (0.0, 0.05, 0.01)),
    *(
        row
        for side, sign in (("L", 1.0), ("R", -1.0))
        for row in (
            (f"{side} Clavicle", "Spine2", (sign * 0.015, 0.075, 0.0)),
            (f"{side} UpperArm", f"{side} Clavicle", (sign * 0.1, 0.0, 0.0)),
            (f"{side} Forearm", f"{side} UpperArm", (sign * 0.165, 0.0, 0.0)),
            (f"{side} Hand", f"{side} Forearm", (sign * 0.15, 0.0, 0.0)),
        )
    ),
    *(
        row
        for side, sign in (("L", 1.0), ("R", -1.0))
        for row in (
            (f"{side} Thigh", "Pelvis", (sign * 0.05, -0.02, 0.0)),
            (f"{side} Calf", f"{side} Thigh", (0.0, -0.245, 0.0)),
            (f"{side} Foot", f"{side} Calf", (0.0, -0.245, 0.0)),
            (f"{side} Toe0", f"{side} Foot", (0.0, -0.04, 0.08)),
        )
    ),
)
_TIPS = {"Head": (0.0, 0.12, 0.0), "L Hand": (0.1, 0.0, 0.0), "R Hand": (-0.1, 0.0, 0.0), "Toe0": (0.0, 0.0, 0.04)}
_PLACE = {name: index for index, (name, _, _) in enumerate(_JOINTS)}
_TRUNK = {"": 0.2, "Spine": 0.2, "Spine1": 0.3, "Spine2": 0.3}
"""Shares of the trunk's rotation."""

_BEFORE: dict[str, tuple[float, float, float]] = {
    # degrees about X, Y, Z before the reach
    "": (-8.0, 0.0, 0.0),
    "Spine": (-6.0, 0.0, 0.0),
    "Spine1": (-3.0, 0.0, 0.0),
    "Neck": (6.0, 0.0, 0.0),
    "Head": (8.0, 0.0, 0.0),
    "L UpperArm": (-35.0, 0.0, -60.0),
    "L Forearm": (0.0, -50.0, 0.0),
    "R UpperArm": (-40.0, 0.0, 72.0),
    "R Forearm": (0.0, 60.0, 0.0),
    "L Thigh": (-75.0, 0.0, 6.0),
    "R Thigh": (-75.0, 0.0, -6.0),
    "L Calf": (60.0, 0.0, 0.0),
    "R Calf": (60.0, 0.0, 0.0),
    "L Foot": (12.0, 0.0, 0.0),
    "R Foot": (12.0, 0.0, 0.0),
}


@dataclass(frozen=True)
class ReachClip:
    """A generated clip and the truth about it.

    times: t1, t2 and the end in frames since the first frame. age in years, height in cm, hbp in mm.
    """

    clip: ClipStream
    name: str
    subject: str
    age: int
    height: float
    hbp: int
    times: tuple[float, float, float]


@dataclass(frozen=True)
class _Drawn:
    """One number a trial, (N,), and tables of them, (N, …), from which everything else follows."""

    subject: NDArray[np.intp]
    age: Array
    height: Array
    hbp: Array
    turn: Array
    side: Array
    elbow: Array
    head: Array
    posture: Array
    sway: Array
    belt: Array
    prepare: Array
    reach: Array
    length: Array
    counter: Array
    sinking: Array


@dataclass(frozen=True)
class _Postures:
    """Degrees about X, Y, Z before the reach and at the belt, (N, J, 3); and need, (N,): distance over arm's length.

    upper: (N, 2, 4) the right upper arm's rotation before and at the belt.
    """

    before: Array
    at_belt: Array
    upper: Array
    need: Array


def reach_clips(
    seed: int = 1,
    *,
    fps: float = RATE,
    young: Sequence[int] = YOUNG,
    old: Sequence[int] = OLD,
    noise: bool = True,
    deviations: float = 1.0,
) -> list[ReachClip]:
    """Generate 185 clips of 41 people, or of people with the numbers of trials in `young` and `old`.

    fps: frames a second; the same seed gives the same movements at any rate. noise: of the measurement.
    deviations: of people and trials from the values for their attributes, as a factor; 0: no deviations.
    """
    rng = np.random.default_rng(seed)
    drawn = _draw(rng, young, old, deviations)
    postures = _postures(drawn)
    times = _times(drawn, postures.need)
    clips = []
    for trial in range(len(drawn.age)):
        frames = round(times[trial, 2] * fps) + 1
        values = _frames(drawn, postures, times[trial], trial, np.arange(frames) / fps)
        if noise:
            values += rng.normal(0.0, 0.05, values.shape)
        name = f"reach_{drawn.subject[trial] + 1:02d}_{trial + 1:03d}"
        properties = (
            ("age", str(int(drawn.age[trial])), "year"),
            ("height", f"{drawn.height[trial]:.1f}", "cm"),
            ("hbp", str(int(drawn.hbp[trial])), "mm"),
            ("subject", f"S{drawn.subject[trial] + 1:02d}", ""),
        )
        clips.append(
            ReachClip(
                clip=_clip(name, float(drawn.height[trial]), np.round(values, 4) + 0.0, fps, properties),
                name=name,
                subject=properties[3][1],
                age=int(drawn.age[trial]),
                height=float(drawn.height[trial]),
                hbp=int(drawn.hbp[trial]),
                times=(times[trial, 0] * fps, times[trial, 1] * fps, float(frames - 1)),
            )
        )
    return clips


def _draw(rng: np.random.Generator, young: Sequence[int], old: Sequence[int], deviations: float) -> _Drawn:
    people = len(young) + len(old)
    is_old = np.arange(people) >= len(young)
    age = np.where(is_old, rng.integers(60, 80, people), rng.integers(20, 30, people)).astype(float)
    height = np.clip(rng.normal(np.where(is_old, 163.0, 170.0), 7.0), 148.0, 190.0).round(1)
    person = deviations * rng.normal(size=(people, 6))
    posture = deviations * rng.normal(0.0, 3.0, (people, len(_JOINTS), 3))
    subject = np.repeat(np.arange(people), [*young, *old])
    count = len(subject)
    hbp = np.clip(265 + 2 * (height[subject] - 168) + rng.normal(0.0, 40.0, count), 150.0, 420.0).round()
    trial = deviations * rng.normal(size=(count, 9))
    return _Drawn(
        subject=subject,
        age=age[subject],
        height=height[subject],
        hbp=hbp,
        turn=3.0 * person[subject, 0] + 1.2 * trial[:, 0],
        side=1.5 * person[subject, 1] + 0.8 * trial[:, 1],
        elbow=5.0 * person[subject, 2] + 2.0 * trial[:, 2],
        head=4.0 * person[subject, 3] + 2.0 * trial[:, 3],
        posture=posture[subject] + deviations * rng.normal(0.0, 1.0, (count, len(_JOINTS), 3)),
        sway=deviations * rng.normal(0.0, 0.3, (count, len(_JOINTS), 3, 2)),
        belt=BELT + deviations * rng.normal(0.0, 0.8, (count, 3)),
        prepare=np.exp(0.06 * person[subject, 4] + 0.12 * trial[:, 4]),
        reach=np.exp(0.06 * person[subject, 5] + 0.04 * trial[:, 5]),
        length=0.12 * trial[:, 6],
        counter=np.clip(0.05 * np.exp(0.5 * trial[:, 7]), 0.01, 0.15),
        sinking=-0.02 + 0.01 * trial[:, 8],
    )


def _older(drawn: _Drawn) -> Array:
    older: Array = 1.0 / (1.0 + np.exp(-(drawn.age - 50.0) / 6.0))
    return older


def _postures(drawn: _Drawn) -> _Postures:
    g, h, b = _older(drawn), (drawn.height - 168.0) / 8.0, (drawn.hbp - 265.0) / 45.0
    before = np.zeros((len(g), len(_JOINTS), 3))
    for name, degrees in _BEFORE.items():
        before[:, _PLACE[name]] = degrees
    before[:, [_PLACE["L Calf"], _PLACE["R Calf"]], 0] += (-6.0 * b + 3.0 * h)[:, None]
    before += drawn.posture
    before[:, _PLACE["Pelvis"]] = 0.0

    arm = 0.315 * drawn.height
    shoulder, _ = _shoulder(drawn, before)
    need = np.linalg.norm(drawn.belt - shoulder, axis=1) / arm
    e = 0.05 * np.log1p(np.exp((need - 0.86) / 0.05))
    zero = np.zeros_like(g)
    change = np.zeros_like(before)
    trunk = np.stack(
        [
            4 + 30 * e * (1 + g),
            10 + 80 * e - 5 * g + 3 * np.sin(1.6 * b) + drawn.turn,
            -(3 + 70 * e + 2 * g * b + drawn.side),
        ],
        axis=1,
    )
    for name, share in _TRUNK.items():
        change[:, _PLACE[name]] = share * trunk
    head = np.stack([zero - 2, (30 - 8 * g - 5 * b + drawn.head) / 2, zero], axis=1)
    change[:, [_PLACE["Neck"], _PLACE["Head"]]] = head[:, None]
    change[:, _PLACE["R Clavicle"]] = np.stack([zero, 12 - 4 * g + 6 * np.tanh(b), zero - 6], axis=1)
    change[:, _PLACE["R Hand"], 2] = -15 + 5 * np.tanh(b)

    at_belt = before + change
    elevation = np.radians(38 - 16 * g + 10 * np.sin(1.5 * b) + 4 * h + drawn.elbow)
    upper, bend = _arm(drawn, at_belt, elevation)
    at_belt[:, _PLACE["R Forearm"]] = np.stack([zero, np.degrees(bend), zero], axis=1)
    start = from_euler(np.radians(before[:, _PLACE["R UpperArm"]]), "XYZ")
    return _Postures(before, at_belt, np.stack([start, upper], axis=1), need)


def _shoulder(drawn: _Drawn, degrees: Array) -> tuple[Array, Array]:
    """Where the right upper arm begins (N, 3), and its parent's rotation (N, 4), in the world."""
    offsets = np.array([offset for _, _, offset in _JOINTS]) * drawn.height[:, None, None]
    offsets[:, 0] = np.stack([0 * drawn.hbp, SEAT + 0 * drawn.hbp, drawn.hbp / 10], axis=1)
    positions, turned = walked(skeleton(170.0), offsets, from_euler(np.radians(degrees), "XYZ"))
    return positions[:, _PLACE["R UpperArm"]], turned[:, _PLACE["R Clavicle"]]


def _arm(drawn: _Drawn, degrees: Array, elevation: Array) -> tuple[Array, Array]:
    """The upper arm's rotation (N, 4) and the elbow's bend (N,), radians, with the wrist in the belt's point."""
    shoulder, parent = _shoulder(drawn, degrees)
    first, second = 0.165 * drawn.height, 0.15 * drawn.height
    way = rotate(inverse(parent), drawn.belt - shoulder)
    distance = np.linalg.norm(way, axis=1)
    along = way / distance[:, None]
    distance = np.minimum(distance, 0.985 * (first + second))
    bend = np.arccos(np.clip((distance**2 - first**2 - second**2) / (2 * first * second), -1.0, 1.0))
    at_rest = np.stack([-(first + second * np.cos(bend)), 0 * bend, second * np.sin(bend)], axis=1)
    down = rotate(inverse(parent), np.array([0.0, -1.0, 0.0]))
    down -= np.sum(down * along, axis=1)[:, None] * along
    down /= np.linalg.norm(down, axis=1)[:, None]
    wanted = np.cos(elevation)[:, None] * down + np.sin(elevation)[:, None] * np.cross(down, along)
    aim = np.stack([shortest_arc(start, end) for start, end in zip(at_rest, along, strict=True)])
    elbow = rotate(aim, np.array([-1.0, 0.0, 0.0]))
    elbow -= np.sum(elbow * along, axis=1)[:, None] * along
    swivel = np.arctan2(np.sum(np.cross(elbow, wanted) * along, axis=1), np.sum(elbow * wanted, axis=1))
    half = swivel[:, None] / 2
    return multiply(np.concatenate([np.sin(half) * along, np.cos(half)], axis=1), aim), bend


def _times(drawn: _Drawn, need: Array) -> Array:
    """(N, 3) seconds of t1, t2 and the end; the end in whole frames of 1/30 s."""
    g, b = _older(drawn), (drawn.hbp - 265.0) / 45.0
    prepare = np.maximum((0.24 + 0.10 * g) * drawn.prepare, 0.1)
    reach = np.maximum((0.70 + 0.20 * g + 0.9 * (need - 0.88) + 0.04 * np.sin(1.5 * b)) * drawn.reach, 0.4)
    end = np.round(np.clip(2.15 + 0.45 * g + 0.1 * b + drawn.length, 59 / RATE, 89 / RATE) * RATE) / RATE
    return np.stack([prepare, prepare + reach, end], axis=1)


def _smooth(share: Array) -> Array:
    s = np.clip(share, 0.0, 1.0)
    smooth: Array = s**3 * (10 - 15 * s + 6 * s**2)
    return smooth


def _progress(drawn: _Drawn, times: Array, trial: int, time: Array) -> Array:
    """How far the arm is at each time (F,): 0 before, 1 at the belt."""
    t1, t2, end = times
    counter, sinking = drawn.counter[trial], drawn.sinking[trial]
    power = 0.95 - 0.12 * _older(drawn)[trial]
    share = np.clip((time - t1) / (t2 - t1), 0.0, 1.0) ** power
    progress: Array = (
        -counter * _smooth(time / t1) + (1 + counter) * _smooth(share) + sinking * _smooth((time - t2) / (end - t2))
    )
    return progress


def _frames(drawn: _Drawn, postures: _Postures, times: Array, trial: int, time: Array) -> Array:
    """(F, 3 + 3 J): the root's position in cm, then degrees about X, Y, Z of every joint."""
    arm = _progress(drawn, times, trial, time)
    lag = 0.05 * (1 + _older(drawn)[trial])
    trunk = _progress(drawn, times, trial, time - lag)
    head = _progress(drawn, times, trial, time + 0.1)
    course = np.repeat(arm[:, None], len(_JOINTS), axis=1)
    course[:, [_PLACE[name] for name in _TRUNK]] = trunk[:, None]
    course[:, [_PLACE["Neck"], _PLACE["Head"]]] = head[:, None]
    before, change = postures.before[trial], postures.at_belt[trial] - postures.before[trial]
    degrees = before + course[:, :, None] * change
    start, end = postures.upper[trial]
    degrees[:, _PLACE["R UpperArm"]] = np.degrees(to_euler(_turn(start, end, arm), "XYZ"))
    waves = np.stack([np.sin(2 * np.pi * turns * time / times[2]) for turns in (1, 2)])
    sway = np.einsum("jcw,wf->fjc", drawn.sway[trial], waves)
    sway[:, _PLACE["Pelvis"]] = 0.0
    degrees += sway
    root = np.tile([0.0, SEAT, drawn.hbp[trial] / 10], (len(time), 1))
    return np.concatenate([root, degrees.reshape(len(time), -1)], axis=1)


def _turn(start: Array, end: Array, share: Array) -> Array:
    """Return (F, 4) `start` rotated towards `end` about a constant axis, by a share that may be outside 0 to 1."""
    way = multiply(inverse(start), end)
    way = way if way[3] >= 0 else -way
    size = float(np.linalg.norm(way[:3]))
    half = share[:, None] * np.arctan2(size, way[3])
    return multiply(start, np.concatenate([np.sin(half) * way[:3] / size, np.cos(half)], axis=1))


def skeleton(height: float) -> Skeleton:
    """A driver of that height (cm): 23 joints, named as Biped's."""
    joints = []
    for name, parent, offset in _JOINTS:
        tip = next((_TIPS[end] for end in _TIPS if name.endswith(end)), None)
        is_root = name == ""
        rotations = ("Rx", "Ry", "Rz")
        full = f"Bip01 {name}".strip()
        joints.append(
            Joint(
                name=full,
                parent=-1 if is_root else _PLACE[parent],
                source_name=full,
                convention=Convention.LISTED,
                channels=("Tx", "Ty", "Tz", *rotations) if is_root else rotations,
                rotation_order="XYZ",
                offset=_triple(offset, height),
                translation="absolute" if is_root else "",
                end_sites=() if tip is None else (EndSite(_triple(tip, height)),),
            )
        )
    return Skeleton(tuple(joints))


def _triple(offset: tuple[float, float, float], height: float) -> tuple[str, str, str]:
    x, y, z = (f"{part * height:.4f}" for part in offset)
    return x, y, z


def _clip(
    name: str, height: float, values: Array, fps: float, properties: tuple[tuple[str, str, str], ...]
) -> ClipStream:
    body = skeleton(height)
    columns = body.columns()
    head = ClipHead(
        format="bvh",
        skeleton=body,
        fields={"filename": f"{name}.bvh", "calibration_unit": "cm", "global_axis_of_gravity": "Y"},
        frame_time=f"{1 / fps:.7f}",
        number_style="fixed:4",
        sources=(SourcePart("bvh", f"{name}.bvh"),),
        properties=properties,
    )

    def blocks() -> Iterator[FrameBlock]:
        yield FrameBlock(values, columns, (full_shape(columns),), np.arange(1, len(values) + 1))

    return ClipStream(head, blocks, len(values))
