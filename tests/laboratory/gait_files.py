"""C3D files of a walker whose joint angles are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcml.laboratory.gait_model.measures import ANGLES
from mcml.motion.skeleton import Array
from tests.c3d_writer import Value, c3d_bytes, texts
from tests.laboratory.gait_bodies import LegPose, make_body, turn

FRAMES = 30
POSES = {"L": LegPose(), "R": LegPose(hip=(-5.0, 1.0, 2.0), knee=(40.0, 1.0, 3.0))}

TURNS = {"ThighRotation": 0.12, "ShankRotation": -0.2, "TibialTorsion": -0.3, "AnkleAbAdd": 0.08}
OTHER_TURNS = {"ThighRotation": -0.07, "ShankRotation": 0.1, "TibialTorsion": -0.15, "AnkleAbAdd": 0.02}
STANDING = {
    "L": LegPose(hip=(2.0, 1.0, 0.0), knee=(1.0, 0.0, 0.0), turns=TURNS),
    "R": LegPose(hip=(3.0, -1.0, 2.0), knee=(4.0, 1.0, 0.0), turns=OTHER_TURNS),
}
WALKING = {
    "L": LegPose(hip=(25.0, 3.0, 5.0), knee=(35.0, 2.0, -4.0), turns=TURNS),
    "R": LegPose(hip=(-8.0, 2.0, 1.0), knee=(12.0, 1.0, 3.0), turns=OTHER_TURNS),
}
"""Poses of a person who stands, and walks with the same wands."""


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


def stand(frames: int = 25) -> dict[str, Array]:
    """Markers (n, 3) of a standing person, with medial ones of knees and ankles."""
    markers, _, centres = make_body(STANDING)
    for side in "LR":
        markers[f"{side}KNM"] = 2 * centres[f"{side}KJC"] - markers[f"{side}KNE"]
        markers[f"{side}MED"] = 2 * centres[f"{side}AJC"] - markers[f"{side}ANK"]
    return {name: np.repeat(place, frames, axis=0) for name, place in markers.items()}


def without_angles(measures: Mapping[str, float], *more: str) -> dict[str, float]:
    """Measures without offsets, and without further ones, by the ends of their names."""
    return {name: value for name, value in measures.items() if not name.endswith((*ANGLES, *more))}


LENGTHS = without_angles(measures_of(STANDING))
"""Measures of the person that a ruler tells."""
