"""The body of a stored document in space: where its joints are in every frame, and what is known of the clip."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.clips.read_clip import Skeletons, read_clip
from service.errors import ConversionError
from service.motion.bodies.calibration import Calibration, calibrate, calibration_frames
from service.motion.bodies.positions import clip_positions, filled, rounded
from service.motion.bodies.stretch import Stretch
from service.motion.bodies.turned_angles import reference_stance, turned_angle
from service.motion.clip import ClipHead, FrameBlock
from service.motion.figures import axis_of
from service.motion.hub import rest_of
from service.motion.kinematics import Walker
from service.motion.skeleton import Array
from service.motion.units import Reading, reading_of
from service.storage.bodies import StoredBody
from service.storage.columns import Listed
from service.storage.documents import StoredDocument
from service.storage.steps import pack, unpack
from service.storage.transaction import Transaction

FRAMES_TOGETHER = 8192
"""Frames of documents whose joints are placed together."""
MADE = 1
"""Counts on when positions or calibrations come to be made in another way: what was kept before is derived again."""


@dataclass(frozen=True, eq=False)
class Body:
    """names: of the joints, MCML's where they are known. frame_time: seconds, None where unknown. blocks: rounded
    positions in the document's order of frames, as `steps.pack` makes them."""

    names: tuple[str, ...]
    frames: int
    calibration: Calibration
    frame_time: float | None
    blocks: tuple[bytes, ...]

    @property
    def nbytes(self) -> int:
        return sum(map(len, self.blocks)) + 2000

    def stretch(self, joints: Collection[str], first: int = 0, end: int | None = None) -> Stretch:
        """The frames from `first` (from 0) to before `end`, by default all, with the joints of these names that it
        has."""
        frames = range(self.frames)[first:end]
        own = [place for place, name in enumerate(self.names) if name in joints]
        steps = unpack(self.blocks, own)
        places = {self.names[place]: found[first:end] for place, found in zip(own, steps, strict=True)}
        return Stretch(places, len(frames), self.frame_time, self.calibration, first=first)

    def facts(self) -> dict[str, Any]:
        """All but the positions, as plain values for JSON."""
        known = self.calibration.to_json()
        told = {"names": self.names, "frames": self.frames, "calibration": known, "frame_time": self.frame_time}
        return {**told, "blocks": len(self.blocks), "made": MADE}

    @classmethod
    def restored(cls, stored: StoredBody) -> Body | None:
        """What was kept; None where it was made in another way."""
        facts = stored.facts
        if facts["made"] != MADE:
            return None
        calibration = Calibration.from_json(facts["calibration"])
        return cls(tuple(facts["names"]), facts["frames"], calibration, facts["frame_time"], stored.blocks)


def derive_bodies(tx: Transaction, documents: Sequence[Listed], skeletons: Skeletons) -> Iterator[Body]:
    """The body of each document, worked out from its frames. skeletons: as `read_clip` takes them."""
    first = 0
    while first < len(documents):
        # Kinematics of short clips takes as long for one as for ten.
        last, frames = first + 1, documents[first].frames
        while last < len(documents) and frames + documents[last].frames <= FRAMES_TOGETHER:
            frames += documents[last].frames
            last += 1
        yield from _derived(tx, documents[first:last], skeletons)
        first = last


def _derived(tx: Transaction, documents: Sequence[Listed], skeletons: Skeletons) -> list[Body]:
    clips = [read_clip(tx, listed, bare=True, skeletons=skeletons) for listed in documents]
    same: dict[tuple[int, Reading], list[int]] = {}
    for place, clip in enumerate(clips):
        same.setdefault((id(clip.clip.head.skeleton), reading_of(clip.clip.head)), []).append(place)
    found: dict[int, Body] = {}
    for (_, reading), places in same.items():
        skeleton = clips[places[0]].clip.head.skeleton
        frames = [filled(skeleton, clips[place].clip.blocks()) for place in places]
        for place, positions in zip(places, clip_positions(skeleton, frames, reading), strict=True):
            found[place] = body_at(clips[place].clip.head, positions)
    return [found[place] for place in range(len(clips))]


def body_of(head: ClipHead, blocks: Iterable[FrameBlock]) -> Body:
    """The body of a clip that need not be stored. blocks: from the first frame on."""
    skeleton = head.skeleton
    (positions,) = clip_positions(skeleton, [filled(skeleton, blocks)], reading_of(head))
    return body_at(head, positions)


def body_at(head: ClipHead, positions: Array) -> Body:
    """The body of a clip whose joints are at positions (n, J, 3), in source units, NaN where unknown."""
    frames = calibration_frames(len(positions))
    sample = positions if len(frames) == len(positions) else positions[frames]
    calibration = calibrate(head, sample, frames=frames)
    blocks = pack(rounded(positions, calibration.step))
    return Body(head.skeleton.names, len(positions), calibration, head.seconds_per_frame(), tuple(blocks))


def read_bodies(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Body]:
    """By the keys of documents: what is kept of them, else worked out now."""
    restored = {key: Body.restored(stored) for key, stored in tx.bodies.of(documents).items()}
    found = {key: body for key, body in restored.items() if body is not None}
    missing = [listed for listed in documents if listed.key not in found]
    made = zip(missing, derive_bodies(tx, missing, {}), strict=True)
    return found | {listed.key: body for listed, body in made}


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
