"""Walkers that are made for tests: paths of feet and pelvis with known strikes and offs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from mcml.laboratory.gait_events import SIDES, GaitEvent, Side, WalkerPaths
from mcml.motion.pictures.figures import axis_of
from mcml.motion.skeleton import Array
from tests.c3d_writer import Value, c3d_bytes


@dataclass(frozen=True)
class Gait:
    """How somebody walks. heading, turn: degrees, and degrees a second. duty: part of a stride on the ground. late: by
    how much of a stride the left foot is behind the right one. width: metres between the tracks of the feet."""

    rate: float = 100.0
    seconds: float = 6.0
    speed: float = 1.2
    stride_time: float = 1.1
    duty: float = 0.62
    late: float = 0.5
    width: float = 0.16
    heading: float = 0.0
    turn: float = 0.0
    on_belt: bool = False
    up: str = "Z"


WALKS = st.builds(
    Gait,
    rate=st.sampled_from([60.0, 100.0, 120.0, 250.0]),
    speed=st.floats(0.7, 1.7),
    stride_time=st.floats(0.9, 1.35),
    duty=st.floats(0.57, 0.68),
    late=st.floats(0.46, 0.54),
    width=st.floats(0.06, 0.25),
    heading=st.floats(-180, 180),
    turn=st.sampled_from([0.0, 0.0, 15.0, -25.0]),
    on_belt=st.booleans(),
    up=st.sampled_from(["X", "Y", "Z", "-Y", "-Z"]),
).map(lambda gait: gait if not gait.on_belt else Gait(**{**vars(gait), "turn": 0.0}))


def true_events(gait: Gait) -> dict[tuple[Side, str], list[float]]:
    """Seconds of strikes and offs, also just before and after the frames."""
    count = int(gait.seconds / gait.stride_time) + 4
    times: dict[tuple[Side, str], list[float]] = {}
    for side, part in zip(SIDES, (gait.late, 0.0), strict=True):
        strikes = [(place + part - 1.5) * gait.stride_time for place in range(count)]
        times[side, "strike"] = strikes
        times[side, "off"] = [at + gait.duty * gait.stride_time for at in strikes]
    return times


def events_of(gait: Gait) -> list[GaitEvent]:
    """The true events within the frames, as labels would give them."""
    return [
        GaitEvent(at, side, kind, "label")  # type: ignore[arg-type]
        for (side, kind), times in true_events(gait).items()
        for at in times
        if 0 <= at <= gait.seconds - 1 / gait.rate
    ]


def _place(gait: Gait, seconds: Array) -> tuple[Array, Array]:
    """(n, 2) places on the ground, and (n, 2) directions."""
    angle = np.radians(gait.heading) + np.radians(gait.turn) * seconds
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    fine = np.linspace(-4.0, gait.seconds + 4.0, 20_000)
    fine_angle = np.radians(gait.heading) + np.radians(gait.turn) * fine
    steps = gait.speed * (fine[1] - fine[0])
    way = np.stack([np.cumsum(np.cos(fine_angle)) * steps, np.cumsum(np.sin(fine_angle)) * steps], axis=1)
    place = np.stack([np.interp(seconds, fine, way[:, axis]) for axis in range(2)], axis=1)
    return place, direction


def _foot(gait: Gait, side: Side, seconds: Array, ahead: float) -> Array:
    """(n, 3) of a point of a foot: it stays in stances, and leaps to the next place in swings, slower before it lands,
    as feet do: heels are farthest in front of the pelvis some 0.03 s before they strike."""
    times = true_events(gait)
    strikes = np.array(times[side, "strike"])
    middle = strikes + gait.duty * gait.stride_time / 2
    place, direction = _place(gait, middle)
    left = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    spots = place + ahead * direction + left * (gait.width / 2) * (1 if side == "left" else -1)
    found = np.empty((len(seconds), 3))
    for number, (begin, end) in enumerate(pairwise(strikes)):
        rows = (seconds >= begin) & (seconds < end)
        swing = (seconds[rows] - begin) / gait.stride_time - gait.duty
        part = np.clip(swing / (1 - gait.duty), 0, 1)
        found[rows, :2] = spots[number] + (1 - (1 - part[:, None]) ** 1.5) * (spots[number + 1] - spots[number])
        found[rows, 2] = 0.03 + 0.12 * np.sin(np.pi * part)
    return found


def make_walker(gait: Gait) -> WalkerPaths:
    """The paths of a walker, in metres, in the axes that the gait asks for."""
    seconds = np.arange(int(gait.seconds * gait.rate)) / gait.rate
    place, direction = _place(gait, seconds)
    left = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    pelvis = np.concatenate([place, np.full((len(seconds), 1), 0.95)], axis=1)
    across = np.concatenate([0.25 * left, np.zeros((len(seconds), 1))], axis=1)
    back = np.zeros((len(seconds), 3))
    if gait.on_belt:
        back[:, :2] = seconds[:, None] * gait.speed * direction
    to = _axes(gait.up)
    feet = {
        name: {side: (_foot(gait, side, seconds, ahead) - back) @ to for side in SIDES}
        for name, ahead in (("heels", -0.1), ("toes", 0.1))
    }
    up = axis_of(gait.up)
    return WalkerPaths(feet["heels"], feet["toes"], (pelvis - back) @ to, across @ to, up, gait.rate)


def _axes(up: str) -> Array:
    """(3, 3) rows: where x, y and z of a walker with z up go."""
    third = axis_of(up)
    first = np.roll(np.abs(third), 1)
    return np.stack([first, np.cross(third, first), third])


_MARKERS = ("ASI", "PSI", "KNE", "ANK", "HEE", "TOE")


@dataclass(frozen=True)
class Step:
    """A foot on a plate of its own. times: (n,) seconds of its samples. force, centre_of_pressure: (n, 3) of the ground
    in the axes of the gait, newtons and metres; 0 and NaN where the foot is in the air. turning: newton metres about
    the vertical."""

    side: Side
    times: Array
    force: Array
    centre_of_pressure: Array
    turning: float


SAMPLES = 4
"""Samples of a plate in a frame."""


def make_steps(gait: Gait, events: Sequence[tuple[Side, float]]) -> list[Step]:
    """The first whole stances of feet that begin at these times, with the forces of an even walk."""
    walker = make_walker(gait)
    times = np.arange(len(walker) * SAMPLES) / (gait.rate * SAMPLES)
    steps = []
    for side, strike in events:
        share = (times - strike) / (gait.duty * gait.stride_time)
        down = (share > 0) & (share < 1)
        frame = round((strike + 0.3 * gait.stride_time) * gait.rate)
        heel, toe = walker.heels[side][frame], walker.toes[side][frame]
        heel, toe = (place - (place @ walker.up) * walker.up for place in (heel, toe))
        ahead = (toe - heel) / np.linalg.norm(toe - heel)
        force = 800 * np.sin(np.pi * share)[:, None] * walker.up - 90 * np.cos(np.pi * share)[:, None] * ahead
        pressure = heel + share[:, None] * (toe - heel)
        steps.append(
            Step(side, times, np.where(down[:, None], force, 0.0), np.where(down[:, None], pressure, np.nan), 3.0)
        )
    return steps


def make_plates(gait: Gait, steps: Sequence[Step]) -> tuple[dict[str, Value | None], Array]:
    """(parameters, (frames, samples × channels)) of a plate of type 2 under each step, in millimetres with z down."""
    up = axis_of(gait.up)
    corners, channels = [], []
    for step in steps:
        centre = np.nanmean(step.centre_of_pressure, axis=0)
        x = np.roll(np.abs(up), 1)
        y = np.cross(-up, x)
        axes = np.stack([x, y, -up])
        half = 0.25 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) @ axes[:2]
        corners.append(1000 * (centre + half))
        force = step.force
        moment = np.cross(np.nan_to_num(step.centre_of_pressure - centre), force)
        moment += np.where((force @ up > 0)[:, None], step.turning * up, 0.0)
        channels += [force @ axes.T, 1000 * moment @ axes.T]
    count = len(steps)
    analog = np.concatenate(channels, axis=1)
    names = [f"{name}{number + 1}" for number in range(count) for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    parameters: dict[str, Value | None] = {
        "ANALOG:USED": (2, (), [6 * count]),
        "ANALOG:RATE": (4, (), [gait.rate * SAMPLES]),
        "ANALOG:LABELS": (-1, (4, 6 * count), "".join(name.ljust(4) for name in names).encode()),
        "ANALOG:UNITS": (-1, (3, 6 * count), count * b"N  N  N  NmmNmmNmm"),
        "FORCE_PLATFORM:USED": (2, (), [count]),
        "FORCE_PLATFORM:TYPE": (2, (count,), [2] * count),
        "FORCE_PLATFORM:CORNERS": (4, (3, 4, count), np.array(corners).reshape(-1).tolist()),
        "FORCE_PLATFORM:ORIGIN": (4, (3, count), [0] * 3 * count),
        "FORCE_PLATFORM:CHANNEL": (2, (6, count), list(range(1, 6 * count + 1))),
    }
    return parameters, analog.reshape(-1, SAMPLES * 6 * count)


def make_c3d(
    gait: Gait,
    events: Sequence[GaitEvent] = (),
    *,
    unit: str = "mm",
    first: int = 1,
    people: Sequence[str] = ("",),
    steps: Sequence[Step] = (),
) -> bytes:
    """A C3D file of a walker with markers of Plug-in Gait, up as the gait has it. events: with exact times. first:
    number of the first frame of the file. people: prefixes of the markers of each; all walk alike, and the events are
    those of the first. steps: on plates."""
    walker = make_walker(gait)
    half = walker.across / 2
    back = 0.15 * np.cross(walker.up, walker.across) / 0.25
    places: dict[str, Array] = {}
    for side, letter, sign in (("left", "L", 1), ("right", "R", -1)):
        hip, heel, toe = walker.pelvis + sign * half, walker.heels[side], walker.toes[side]
        ankle = 0.7 * heel + 0.3 * toe + 0.05 * walker.up
        own = (hip, hip - back, (hip + ankle) / 2, ankle, heel, toe)
        places |= {letter + name: place for name, place in zip(_MARKERS, own, strict=True)}
    parameters: dict[str, Value | None] = {"POINT:UNITS": (-1, (2,), unit.ljust(2).encode()) if unit else None}
    if gait.up[-1] != "X":
        parameters["POINT:Y_SCREEN"] = (-1, (2,), f"+{gait.up[-1]}".encode())
    if events:
        starts = (first - 1) / gait.rate
        contexts = "".join(event.side.capitalize().ljust(5) for event in events)
        labels = "".join(f"Foot {event.kind.capitalize()}".ljust(11) for event in events)
        times = [value for event in events for value in (0.0, event.seconds + starts)]
        parameters |= {
            "EVENT:USED": (2, (), [len(events)]),
            "EVENT:CONTEXTS": (-1, (5, len(events)), contexts.encode()),
            "EVENT:LABELS": (-1, (11, len(events)), labels.encode()),
            "EVENT:TIMES": (4, (2, len(events)), times),
        }
    points = 1000 * np.stack([places[name] for _ in people for name in places], axis=1)
    names = [prefix + name for prefix in people for name in places]
    plates, analog = make_plates(gait, steps) if steps else ({}, None)
    return c3d_bytes(
        points, labels=names, rate=gait.rate, first=first, parameters=parameters | plates, analog=analog,
        samples=SAMPLES if steps else 1,
    )  # fmt: skip
