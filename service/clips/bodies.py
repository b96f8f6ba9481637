"""The body of a stored document in space: where its joints are in every frame, and what is known of the clip."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.clips.read_clip import Skeletons, read_clip
from service.errors import ConversionError
from service.motion.bodies.calibration import Calibration, calibrate, calibration_frames
from service.motion.bodies.positions import Steps, clip_positions, rounded
from service.motion.bodies.stretch import Stretch
from service.motion.bodies.turned_angles import reference_stance, turned_angle
from service.motion.figures import axis_of
from service.motion.hub import rest_of
from service.motion.kinematics import Walker
from service.motion.skeleton import Array
from service.motion.units import reading_of
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.storage.documents import StoredDocument


@dataclass(frozen=True, eq=False)
class Body:
    """names: of the joints, MCML's where they are known. steps: (n, J, 3) rounded positions in the document's order of
    frames. frame_time: seconds, None where unknown."""

    names: tuple[str, ...]
    steps: Steps
    calibration: Calibration
    frame_time: float | None

    @property
    def nbytes(self) -> int:
        return self.steps.nbytes + 2000

    def stretch(self, joints: Collection[str]) -> Stretch:
        """All of it, with the joints of these names that it has."""
        places = {name: self.steps[:, place] for place, name in enumerate(self.names) if name in joints}
        return Stretch(places, len(self.steps), self.frame_time, self.calibration)


def read_body(
    tx: Transaction,
    stored: StoredDocument | Listed,
    skeletons: Skeletons,
    overrides: Mapping[str, Any] | None = None,
) -> Body:
    """The body of a document, worked out from its frames. skeletons: as `read_clip` takes them. overrides: of the
    calibration, as people set them."""
    clip = read_clip(tx, stored, labelled=False, skeletons=skeletons)
    head = clip.clip.head
    positions = clip_positions(head.skeleton, clip.clip.blocks(), reading_of(head))
    frames = calibration_frames(len(positions))
    sample = positions if len(frames) == len(positions) else positions[frames]
    calibration = calibrate(head, sample, overrides, frames)
    return Body(clip.names, rounded(positions, calibration.step), calibration, head.seconds_per_frame())


def read_bodies(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Body]:
    """By the keys of documents."""
    skeletons: Skeletons = {}
    return {listed.key: read_body(tx, listed, skeletons) for listed in documents}


def read_turned(tx: Transaction, stored: StoredDocument | Listed, name: str, body: Body) -> Array:
    """(n,) degrees of an angle that takes rotations (`limb_angles.NEEDS_ROTATIONS`), NaN where unknown. body: of the
    document."""
    clip = read_clip(tx, stored, labelled=False).clip
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    walker = Walker(skeleton, reading)
    degrees = np.full(stored.frames, np.nan)
    turned = [walker.poses(block) for block in clip.blocks()]
    rotations = np.concatenate([np.empty((0, len(skeleton), 4)), *(rotations for _, rotations in turned)])
    pose = None
    if body.calibration.reference is not None and turned:
        positions = np.concatenate([positions for positions, _ in turned])
        pose = positions[body.calibration.reference], rotations[body.calibration.reference]
    # Where nothing tells left from right there are no such angles.
    with suppress(ConversionError):
        stance = reference_stance(skeleton, axis_of(body.calibration.up), pose, reading)
        degrees = turned_angle(name, skeleton, rest_of(skeleton, reading), stance, rotations)
    if body.calibration.leaps:
        degrees[:1] = np.nan
    return degrees
