"""The body of a stored document in space: where its joints are in every frame, and what is known of the clip."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.clips.read_clip import Skeletons, read_clip
from service.motion.bodies.calibration import Calibration, calibrate
from service.motion.bodies.positions import Steps, rounded, world_positions
from service.motion.bodies.stretch import Stretch
from service.motion.clip import ClipHead, ClipStream
from service.motion.kinematics import unseen
from service.motion.layout import Held
from service.motion.skeleton import Array
from service.motion.units import reading_of
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.storage.documents import StoredDocument

MOST_SEEN = 4096
"""Frames that a clip is calibrated by; of longer ones, evenly spaced ones and the first few."""
BEGINNING = 16
"""Frames in which a pose before the motion shows."""


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
    head, seconds = clip.clip.head, clip.clip.head.seconds_per_frame()
    if stored.frames <= MOST_SEEN:
        positions = _joined(head, list(_positions(clip.clip)))
        calibration = calibrate(head, positions, overrides)
        return Body(clip.names, rounded(positions, calibration.step), calibration, seconds)
    step = -(-stored.frames // MOST_SEEN)
    first = read_clip(tx, stored, last=BEGINNING, labelled=False, skeletons=skeletons)
    some = read_clip(tx, stored, first=BEGINNING + 1, step=step, labelled=False, skeletons=skeletons)
    frames = np.concatenate([np.arange(BEGINNING), np.arange(BEGINNING, stored.frames, step)])
    sample = _joined(head, [*_positions(first.clip), *_positions(some.clip)])
    calibration = calibrate(head, sample, overrides, frames)
    steps = np.concatenate([rounded(found, calibration.step) for found in _positions(clip.clip)])
    return Body(clip.names, steps, calibration, seconds)


def read_bodies(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Body]:
    """By the keys of documents."""
    skeletons: Skeletons = {}
    return {listed.key: read_body(tx, listed, skeletons) for listed in documents}


def _joined(head: ClipHead, blocks: list[Array]) -> Array:
    return np.concatenate([np.empty((0, len(head.skeleton), 3)), *blocks])


def _positions(clip: ClipStream) -> Iterator[Array]:
    """(n, J, 3) of the frames of each block, NaN where a sample is missing that a joint's place hangs on."""
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    held = Held(skeleton)
    for block in clip.blocks():
        found = world_positions(skeleton, held.values(block), reading)
        if held.missing or np.isnan(block.values).any():
            found[unseen(skeleton, block)] = np.nan
        yield found
