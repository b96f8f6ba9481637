"""C3D files of a walker whose joint angles are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcml.motion.skeleton import Array
from tests.c3d_writer import Value, c3d_bytes, texts
from tests.laboratory.gait_bodies import LegPose, make_body, turn

FRAMES = 30
POSES = {"L": LegPose(), "R": LegPose(hip=(-5.0, 1.0, 2.0), knee=(40.0, 1.0, 3.0))}


def walk(frames: int = FRAMES, way: float = 40.0, poses: Mapping[str, LegPose] = POSES) -> dict[str, Array]:
    """Markers (n, 3) of a stiff body that travels along x. way: millimetres a frame."""
    markers, _, _ = make_body(poses, turn("y", 10.0))
    travel = np.outer(np.arange(frames), [way, 0.0, 0.0])
    return {name: place + travel for name, place in markers.items()}


def measures_of(poses: Mapping[str, LegPose] = POSES) -> dict[str, float]:
    """Measures by the names of Plug-in Gait."""
    return dict(make_body(poses)[1].values)


def gait_file(
    markers: Mapping[str, Array],
    measures: Mapping[str, float],
    *,
    group: str = "PROCESSING",
    prefix: str = "",
    subjects: Sequence[str] = (),
    unit: str = "mm",
    first: int = 1,
    more: Mapping[str, Value] | None = None,
) -> bytes:
    """A C3D of markers, NaN where missing, with measures in a group. prefix: of labels, such as "Anna:"."""
    names = list(markers)
    points = np.stack([markers[name] for name in names], axis=1)
    gone = ~np.isfinite(points).all(axis=2)
    parameters: dict[str, Value | None] = {
        "POINT:LABELS": texts(*(prefix + name for name in names)),
        "POINT:UNITS": texts(unit),
        **{f"{group}:{name}": (4, (), [value]) for name, value in measures.items()},
        **(more or {}),
    }
    if subjects:
        parameters["SUBJECTS:NAMES"] = texts(*subjects)
    return c3d_bytes(
        np.where(gone[:, :, None], 0.0, points).astype(np.float32),
        np.where(gone, -1.0, 0.0),
        labels=[prefix + name for name in names],
        parameters=parameters,
        first=first,
    )


def two_people() -> dict[str, tuple[dict[str, Array], dict[str, float]]]:
    """Markers and measures of two people beside each other, who differ in both."""
    poses = {side: LegPose(knee=(30.0, 0.0, 0.0)) for side in "LR"}
    aside = {name: place + np.array([0.0, 900.0, 0.0]) for name, place in walk(poses=poses).items()}
    wide = measures_of(poses) | {"LKneeWidth": 150.0}
    return {"Anna": (walk(), measures_of()), "Bert": (aside, wide)}
