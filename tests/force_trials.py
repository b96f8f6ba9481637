"""Made trials of markers with forces of the ground in a table beside them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mcml.motion.skeleton import Array

UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}
AXES = "xyz"
USUAL = ("{}_ground_force_v", "{}_ground_force_p", "{}_ground_torque_")


@dataclass(frozen=True)
class Trial:
    """A made trial. times: (n,) of the rows. force, point, torque: (n, plates, 3). rate, samples: of frames."""

    times: Array
    force: Array
    point: Array
    torque: Array
    rate: float
    samples: int
    first: int
    frames: int
    unit: str

    def write(self, folder: Path, names: tuple[str, str, str] = USUAL) -> list[Path]:
        """Write walk.trc and walk_grf.mot. names: of forces, points and torques, without the axis."""
        trc, mot = folder / "walk.trc", folder / "walk_grf.mot"
        start = self.times[0]
        lines = [
            "PathFileType\t4\t(X/Y/Z)\twalk.trc",
            "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
            f"{self.rate:g}\t{self.rate:g}\t{self.frames}\t1\t{self.unit}",
            "Frame#\tTime\tRHEE\t\t",
            "\t\tX1\tY1\tZ1",
            "",
        ]
        lines += [
            f"{self.first + k}\t{start + k / self.rate:.6f}\t{k + 1000}\t{2 * k + 1000}\t{1000 - k}"
            for k in range(self.frames)
        ]
        trc.write_text("\n".join(lines) + "\n")
        titles, columns = ["time"], [self.times]
        for plate in range(self.force.shape[1]):
            for name, part in zip(names, (self.force, self.point, self.torque), strict=True):
                titles += [name.format(plate + 1) + axis for axis in AXES]
                columns += list(part[:, plate].T)
        rows = ["\t".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist()]
        head = ["walk", "version=1", f"nRows={len(rows)}", f"nColumns={len(titles)}", "inDegrees=yes", "endheader"]
        mot.write_text("\n".join([*head, "\t".join(titles), *rows]) + "\n")
        return [trc, mot]

    def means(self, part: Array) -> Array:
        """(frames, plates, 3) of the samples of each frame."""
        whole: Array = (
            part[: self.frames * self.samples].reshape(self.frames, self.samples, *part.shape[1:]).mean(axis=1)
        )
        return whole


def make_trial(
    seed: int,
    *,
    up: int = 1,
    samples: int = 4,
    rate: float = 100.0,
    first: int = 1,
    start: float = 0.0,
    unit: str = "mm",
) -> Trial:
    """Two plates with steady loads, and points that wander on a floor at 3 cm."""
    rng = np.random.default_rng(seed)
    frames, plates = 12, 2
    count = frames * samples
    force = rng.normal(0, 40, (count, plates, 3))
    force[..., up] = rng.uniform(200, 900, (count, plates))
    point = rng.uniform(-0.2, 0.2, (count, plates, 3)) + np.array([0.0, 0.7])[None, :, None]
    point[..., up] = 0.03
    torque = np.zeros_like(force)
    torque[..., up] = rng.normal(0, 5, (count, plates))
    times = start + np.arange(count) / (rate * samples)
    return Trial(times, force, point, torque, rate, samples, first, frames, unit)
