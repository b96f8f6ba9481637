"""Force plates: from channels to force, centre of pressure and free moment in the laboratory.

Source: The C3D File Format User Guide (c3d.org), "The FORCE_PLATFORM Group", types 1 to 4. Lengths are metres, forces
newtons, moments newton metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

LEAST_FORCE: Final = 20.0
"""Newtons of vertical force below which a centre of pressure and a free moment mean nothing: both divide by it."""

CHANNEL_COUNTS: Final = {1: 6, 2: 6, 3: 8, 4: 6}
"""Channels of each type of plate that is read."""

_LEAST_AREA: Final = 1e-4
_QUIET_SECONDS: Final = 0.2
_QUIET: Final = 3.0
_LEAST_OFFSET: Final = 5.0
_UNLOADED_SHARE: Final = 0.1


@dataclass(frozen=True, eq=False)
class Plate:
    """A force plate.

    type: 1 to 4 are read. corners: (4, 3) in the laboratory, in metres, at (+x +y), (-x +y), (-x -y), (+x -y) of the
    plate. origin: (3,) metres from the origin of the moments to the centre of the surface, in the plate's axes.
    channels: places of its channels in the file, from 0. factors: newtons, newton metres or metres of a unit of each
    channel; of type 4, of a unit of each product of calibration and channels. calibration: (6, 6) of type 4. reasons:
    why its forces cannot be computed. assumptions: about facts that the file does not state. baseline: of each channel,
    in its own unit, to be subtracted; () for none. has_surface: False where the corners only surround the points of
    the forces.
    """

    type: int
    corners: Array
    origin: Array
    channels: tuple[int, ...]
    factors: tuple[float, ...]
    calibration: Array | None = None
    reasons: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    baseline: tuple[float, ...] = ()
    has_surface: bool = True

    @cached_property
    def problems(self) -> tuple[str, ...]:
        """Why forces cannot be computed: the reasons, and faults of the numbers themselves."""
        count = CHANNEL_COUNTS.get(self.type)
        if count is None:
            return self.reasons or (f"force plate type {self.type} is not read",)
        problems = list(self.reasons)
        area = np.linalg.norm(np.cross(self.corners[0] - self.corners[1], self.corners[0] - self.corners[3]))
        if not np.isfinite(self.corners).all():
            problems.append("its corners are unknown")
        elif not area > _LEAST_AREA:
            problems.append("its corners enclose no area")
        if not self.reasons and not len(self.channels) == len(self.factors) == count:
            problems.append(f"it has {len(self.channels)} channels, type {self.type} needs {count}")
        if self.type != 1 and not np.isfinite(self.origin).all():
            problems.append("its origin is unknown")
        if self.type == 4 and (self.calibration is None or not np.isfinite(self.calibration).all()):
            problems.append("type 4 needs a calibration matrix, and it has none")
        return tuple(problems)

    @cached_property
    def axes(self) -> Array:
        """(3, 3) x, y and z of the plate in the laboratory, as columns; z is down as a rule. NaN without an area."""
        x, y = self.corners[0] - self.corners[1], self.corners[0] - self.corners[3]
        with np.errstate(invalid="ignore", divide="ignore"):
            x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
            z = np.cross(x, y)
            z = z / np.linalg.norm(z)
        return np.stack([x, np.cross(z, x), z], axis=1)

    @cached_property
    def centre(self) -> Array:
        """(3,) the centre of its surface in the laboratory."""
        centre: Array = self.corners.mean(axis=0)
        return centre

    def has_inside(self, points: Array) -> NDArray[np.bool_]:
        """Tell which points (n, 3) are over its surface; False where unknown."""
        half = np.array([np.linalg.norm(self.corners[0] - self.corners[place]) / 2 for place in (1, 3)])
        away = np.abs((points - self.centre) @ self.axes[:, :2])
        return np.asarray((away <= half).all(axis=1), bool)

    @cached_property
    def vertical(self) -> Array:
        """(3,) the unit normal of its surface that points along the positive side of the nearest axis of the
        laboratory: up, where that axis points up.
        """
        normal: Array = self.axes[:, 2]
        return normal if normal[np.argmax(np.abs(normal))] > 0 else -normal


@dataclass(frozen=True, eq=False)
class PlateForces:
    """The reaction of the ground, in the axes of the laboratory.

    force: (n, 3) newtons. centre_of_pressure: (n, 3) metres, on the surface. free_moment: (n,) newton metres about
    `vertical`, (3,). The latter two are NaN below LEAST_FORCE. is_turned: whether the plate measures the force on the
    ground, so that force and moment were multiplied by -1. offset: mean vertical force without load, NaN if it is small
    or the plate is never without load; it is not subtracted. problems: why all numbers are NaN.
    """

    force: Array
    centre_of_pressure: Array
    free_moment: Array
    vertical: Array
    is_turned: bool
    offset: float
    problems: tuple[str, ...]


def plate_forces(plate: Plate, samples: Array, rate: float = np.nan, *, is_turned: bool | None = None) -> PlateForces:
    """Compute force, centre of pressure and free moment.

    samples: (n, channels of the plate) in the units of the file, of the whole recording: its largest vertical force
    decides the sign, unless `is_turned` does. rate: samples a second; without it no offset is sought. A plate with
    problems has NaN.
    """
    if plate.problems:
        gone = np.full((len(samples), 3), np.nan)
        return PlateForces(gone, gone, gone[:, 0], plate.vertical, False, np.nan, plate.problems)
    force, moment = _at_surface(plate, samples)
    sign = np.sign(plate.axes[:, 2] @ plate.vertical)
    upward = force[:, 2] * sign
    if is_turned is None:
        is_turned = bool(_value_of_largest(upward) <= -LEAST_FORCE)
    if is_turned:
        force, moment, upward = -force, -moment, -upward
    loaded = upward >= LEAST_FORCE
    vertical = np.where(loaded, force[:, 2], np.nan)
    x, y = -moment[:, 1] / vertical, moment[:, 0] / vertical
    free = moment[:, 2] - x * force[:, 1] + y * force[:, 0]
    pressure = np.stack([x, y, np.where(loaded, 0.0, np.nan)], axis=1)
    return PlateForces(
        force @ plate.axes.T,
        pressure @ plate.axes.T + plate.centre,
        free * sign,
        plate.vertical,
        is_turned,
        _find_offset(upward, rate),
        (),
    )


def _at_surface(plate: Plate, samples: Array) -> tuple[Array, Array]:
    """Return force and moment (n, 3) about the centre of the surface, in the plate's axes."""
    if plate.baseline:
        samples = samples - np.array(plate.baseline)
    if plate.type == 4 and plate.calibration is not None:
        samples = samples @ plate.calibration.T
    values = samples * np.array(plate.factors)
    if plate.type == 1:
        force, (x, y, free) = values[:, :3], values[:, 3:].T
        zero = np.zeros(len(values))
        return force, np.cross(np.stack([x, y, zero], axis=1), force) + np.stack([zero, zero, free], axis=1)
    if plate.type == 3:
        return _of_eight(values, plate.origin)
    # The origin of the moments is below the surface, and z points down: files write its z with either sign.
    origin = -plate.origin if plate.origin[2] > 0 else plate.origin
    return values[:, :3], values[:, 3:] + np.cross(values[:, :3], origin)


def _of_eight(values: Array, origin: Array) -> tuple[Array, Array]:
    """Force and moment from eight channels: x of 1 and 2, x of 3 and 4, y of 1 and 4, y of 2 and 3, z of 1 to 4."""
    x12, x34, y14, y23, z1, z2, z3, z4 = values.T
    a, b, depth = np.abs(origin)
    force = np.stack([x12 + x34, y14 + y23, z1 + z2 + z3 + z4], axis=1)
    moment = np.stack(
        [b * (z1 + z2 - z3 - z4), a * (-z1 + z2 + z3 - z4), b * (x34 - x12) + a * (y14 - y23)],
        axis=1,
    )
    return force, moment + np.cross(force, np.array([0.0, 0.0, -depth]))


def _value_of_largest(values: Array) -> float:
    """The value of largest size; 0 of none."""
    sizes = np.nan_to_num(np.abs(values), nan=0.0)
    return float(values[np.argmax(sizes)]) if sizes.any() else 0.0


def _find_offset(upward: Array, rate: float) -> float:
    """Mean (n,) vertical force while the plate is not loaded, from stretches of 0.2 s without change.

    NaN if it is at most 5 N, or so large that it may be a load: over 20 N and a tenth of the largest force.
    """
    width = max(2, round(_QUIET_SECONDS * rate)) if np.isfinite(rate) and rate > 0 else 0
    finite = np.isfinite(upward)
    if not width or len(upward) < width or not finite.any():
        return np.nan
    # Differences from the mean: sums of squares of the values themselves would lose digits.
    middle = float(upward[finite].mean())
    steps = np.where(finite, upward - middle, 0.0)
    means, squares, whole = (_sums(values, width) / width for values in (steps, steps**2, finite.astype(np.float64)))
    quiet = means[(squares - means**2 < _QUIET**2) & (whole > 1 - 0.5 / width)] + middle
    if not len(quiet):
        return np.nan
    # A stretch that ends in the beginning of a step is nearer to 0 than the others of a negative offset.
    offset = float(np.median(quiet[np.abs(quiet) <= np.abs(quiet).min() + _QUIET]))
    most = max(LEAST_FORCE, _UNLOADED_SHARE * float(np.abs(upward[finite]).max()))
    return offset if _LEAST_OFFSET < abs(offset) < most else np.nan


def _sums(values: Array, width: int) -> Array:
    """(n - width + 1,) sums of each `width` consecutive values."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    sums: Array = total[width:] - total[:-width]
    return sums
