"""Generated facial takes as analyses get them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.motion.markers import marker_skeleton
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.space import Space, build
from mcml_service.analysis.interface import Motion
from mcml_service.demo.face_takes import FaceTake, face_takes

STILL = (0.0, 0.0, 0.0, 1.0)


def motion_of(take: FaceTake) -> Motion:
    head = take.clip.head
    block = next(iter(take.clip.blocks()))
    markers = len(head.skeleton)
    values = block.values.reshape(len(block), markers, 3)
    return Motion(
        document=take.name,
        revision=1,
        name=take.name,
        skeleton=head.skeleton,
        frame_time=head.seconds_per_frame() or 0.0,
        rotations=np.broadcast_to(STILL, (len(block), markers, 4)),
        translations=np.nan_to_num(values),
        present=None if take.present.all() else take.present,
        metres=0.001,
        up="Y",
        properties={name: (value, unit) for name, value, unit in head.properties},
    )


def motion_from(
    positions: Array, name: str = "take", fps: float = 60, metres: float | None = 0.001, labels: Sequence[str] = ()
) -> Motion:
    """A take with given markers, (F, M, 3), NaN where missing."""
    count = positions.shape[1]
    present: NDArray[np.bool_] = ~np.isnan(positions[..., 0])
    skeleton = marker_skeleton(labels or [f"m{place}" for place in range(count)])
    return Motion(
        document=name,
        revision=1,
        name=name,
        skeleton=skeleton,
        frame_time=1 / fps,
        rotations=np.broadcast_to(STILL, (len(positions), count, 4)),
        translations=np.nan_to_num(positions, nan=0.0, posinf=np.inf, neginf=-np.inf),
        present=None if present.all() else present,
        metres=metres,
        up="Y",
    )


def body_motion() -> Motion:
    joint = Joint(name="Root", parent=-1, source_name="Hips", convention=Convention.LISTED, channels=("Tx", "Ty", "Tz"))
    skeleton = Skeleton((joint,))
    return Motion("body", 1, "body", skeleton, 1 / 60, np.tile(STILL, (20, 1, 1)), np.zeros((20, 1, 3)))


@cache
def takes(seed: int = 1, fps: float = 12, every_marker: int = 4, **options: Any) -> list[FaceTake]:
    """A small set: about 500 frames of 25 markers."""
    return face_takes(seed, fps=fps, every_marker=every_marker, **options)


def motions(seed: int = 1, fps: float = 12, every_marker: int = 4, **options: Any) -> list[Motion]:
    return [motion_of(take) for take in takes(seed, fps, every_marker, **options)]


@cache
def space(method: str = "robust", noise: float = 0.1, **options: Any) -> Space:
    return build(motions(noise=noise, head=True), options_of(method, **options))  # type: ignore[arg-type]
