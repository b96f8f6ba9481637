"""Moments and powers of ankle, knee and hip by inverse dynamics, from the foot upwards.

Newton's and Euler's equations of rigid segments in the axes of the laboratory, in metres, seconds, newtons and
kilograms. Masses and centres of segments are those of Winter ("Biomechanics and Motor Control of Human Movement"). The
radii of gyration, 0.69, 0.528 and 0.54 of the length, reproduce the moments that Plug-in Gait writes better than
Winter's 0.475, 0.302 and 0.323. Moments are internal: of muscles and ligaments of a joint on the segment below it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.laboratory.gait_events import smooth
from mcml.laboratory.gait_model.lower_body import SIGNS, Leg
from mcml.laboratory.gait_model.segment_frames import transpose
from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, dot, length, unit

JOINTS: Final = ("Ankle", "Knee", "Hip")

_GRAVITY: Final = 9.81
_CORNER: Final = 15.0
"""Hz up to which velocities and accelerations are taken from positions."""


@dataclass(frozen=True)
class _Share:
    """Of the body's mass, of the length from the proximal end to the centre of mass, and the radius of gyration."""

    mass: float
    centre: float
    gyration: float


_SHARES: Final[Mapping[str, _Share]] = {
    "Ankle": _Share(0.0145, 0.5, 0.69),
    "Knee": _Share(0.0465, 0.433, 0.528),
    "Hip": _Share(0.1, 0.433, 0.54),
}
"""Of the segment below each joint: foot, shank, thigh."""


@dataclass(frozen=True, eq=False)
class Ground:
    """The reaction of the ground on one foot, NaN where it is unknown.

    force, centre: (n, 3) newtons, and metres of the centre of pressure. moment: (n, 3) free moment in newton metres.
    """

    force: Array
    centre: Array
    moment: Array


@dataclass(frozen=True, eq=False)
class Load:
    """Of a joint, per kilogram of the body: moment (n, 3) newton millimetres in the signs of Plug-in Gait, power (n,)
    watts. Axes are those of the segment below the joint."""

    moment: Array
    power: Array


def joint_loads(
    side: str, leg: Leg, pelvis: Array, toe: Array, ground: Ground, mass: float, rate: float, up: Array
) -> dict[str, Load]:
    """Return the loads of ankle, knee and hip by their names.

    leg, toe: in millimetres; toe: (n, 3) its marker, the end of the foot. pelvis: its frames. mass: of the body.
    rate: frames a second. up: (3,). NaN where the ground's reaction is unknown.
    """
    metres = {name: getattr(leg, name) / 1000.0 for name in ("hip", "knee", "ankle")} | {"toe": toe / 1000.0}
    ends = {"Ankle": ("ankle", "toe"), "Knee": ("knee", "ankle"), "Hip": ("hip", "knee")}
    frames = {"Ankle": leg.foot, "Knee": leg.shank, "Hip": leg.thigh}
    spins = {name: spin_of(frame, rate) for name, frame in (*frames.items(), ("pelvis", pelvis))}
    above = {"Ankle": "Knee", "Knee": "Hip", "Hip": "pelvis"}
    at, force, moment = ground.centre, ground.force, ground.moment
    loads = {}
    for joint in JOINTS:
        begin, end = (metres[name] for name in ends[joint])
        force, moment = _balance(joint, begin, end, spins[joint], at, force, moment, mass, rate, up)
        power = dot(moment, spins[joint] - spins[above[joint]]) / mass
        x, y, z = (transpose(frames[joint]) @ moment[:, :, None])[:, :, 0].T * 1000.0 / mass
        k = SIGNS[side]
        about = np.stack([-y if joint == "Knee" else y, k * x, k * z], axis=1)
        loads[joint] = Load(about, power)
        at, force, moment = begin, -force, -moment
    return loads


def _balance(
    joint: str,
    begin: Array,
    end: Array,
    spin: Array,
    at: Array,
    load: Array,
    turning: Array,
    mass: float,
    rate: float,
    up: Array,
) -> tuple[Array, Array]:
    """(force, moment) at the proximal end of a segment that carries a load and a moment at a point."""
    share = _SHARES[joint]
    own = share.mass * mass
    centre = begin + share.centre * (end - begin)
    acceleration = derive(derive(centre, rate), rate)
    force = own * (acceleration + _GRAVITY * up) - load
    size = length(end - begin)
    axis = unit(end - begin)
    inertia = own * (share.gyration * float(np.nanmedian(size) if np.isfinite(size).any() else np.nan)) ** 2
    momentum = inertia * (spin - dot(spin, axis)[:, None] * axis)
    moment = derive(momentum, rate) - cross(begin - centre, force) - cross(at - centre, load) - turning
    return force, moment


def derive(values: Array, rate: float) -> Array:
    """(n, 3) the change a second of values (n, 3), without what is faster than 15 Hz; NaN beside gaps."""
    if len(values) < 2:
        return np.full(values.shape, np.nan)
    change: Array = np.gradient(smooth(values, rate, _CORNER), 1.0 / rate, axis=0)
    return change


def spin_of(frame: Array, rate: float) -> Array:
    """(n, 3) radians a second of turning frames (n, 3, 3), in the laboratory."""
    if len(frame) < 2:
        return np.full((len(frame), 3), np.nan)
    change = np.gradient(frame, 1.0 / rate, axis=0)
    turn = change @ transpose(frame)
    spin = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], 1)
    return smooth(spin / 2.0, rate, _CORNER)
