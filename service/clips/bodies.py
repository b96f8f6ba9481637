"""The body of a stored document in space: where its joints are in every frame, and what is known of the clip."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from service.clips.read_clip import Skeletons, read_clip
from service.errors import ConversionError
from service.motion.bodies.calibration import Calibration, Shared, calibrate, calibration_frames
from service.motion.bodies.positions import clip_positions, filled, rounded
from service.motion.bodies.reference import pose_in, stance_of
from service.motion.bodies.stretch import Stretch
from service.motion.bodies.turned_angles import turned_angle
from service.motion.clip import ClipHead, FrameBlock, Reference, ReferencePose
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
MOST_LOOKED_AT = 8
"""Clips of a skeleton, where a reference pose is looked for."""
MADE = 2
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
    references = References(tx)
    found: dict[int, Body] = {}
    for (_, reading), places in same.items():
        skeleton = clips[places[0]].clip.head.skeleton
        frames = [filled(skeleton, clips[place].clip.blocks()) for place in places]
        for place, own, positions in zip(places, frames, clip_positions(skeleton, frames, reading), strict=True):
            shared = partial(references.of, documents[place])
            found[place] = body_at(clips[place].clip.head, positions, own.values, shared)
    return [found[place] for place in range(len(clips))]


def body_of(head: ClipHead, blocks: Iterable[FrameBlock]) -> Body:
    """The body of a clip that need not be stored. blocks: from the first frame on."""
    skeleton = head.skeleton
    frames = filled(skeleton, blocks)
    (positions,) = clip_positions(skeleton, [frames], reading_of(head))
    return body_at(head, positions, frames.values)


def body_at(head: ClipHead, positions: Array, values: Array | None = None, shared: Shared | None = None) -> Body:
    """The body of a clip whose joints are at positions (n, J, 3), in source units, NaN where unknown.

    values: (n, D) of the skeleton's columns, as far as the clip has more than positions. shared: as `calibrate` takes
    it.
    """
    frames = calibration_frames(len(positions))
    sample = positions if len(frames) == len(positions) else positions[frames]
    pose_at = None if values is None else partial(_pose_at, head, values)
    calibration = calibrate(head, sample, frames=frames, pose_at=pose_at, shared=shared)
    blocks = pack(rounded(positions, calibration.step))
    return Body(head.skeleton.names, len(positions), calibration, head.seconds_per_frame(), tuple(blocks))


def _pose_at(head: ClipHead, values: Array, frame: int) -> ReferencePose:
    return pose_in(head.skeleton, reading_of(head), values[frame])


class References:
    """The reference poses of skeletons, found once each."""

    def __init__(self, tx: Transaction) -> None:
        self._tx = tx
        self._found: dict[tuple[int, str | None], Reference | None] = {}

    def of(self, listed: Listed | StoredDocument, stated: str | None) -> Reference | None:
        """The reference of the skeleton of a document: the one that is kept with the body of a clip of it, else that of
        its first clip that shows one, as that clip was at first. stated: the up axis, None for a guess."""
        key = listed.skeleton, stated
        if key not in self._found:
            self._found[key] = self._kept(*key) or self._first(*key)
        return self._found[key]

    def _kept(self, skeleton: int, stated: str | None) -> Reference | None:
        for facts in self._tx.bodies.facts_of_skeleton(skeleton, MOST_LOOKED_AT):
            known = facts["calibration"] if facts["made"] == MADE else None
            if known is not None and known["origins"]["reference"][0] == "measured" and known["start"]["of"]:
                reference = Reference.from_json(known["start"])
                if reference.stated == stated:
                    return reference
        return None

    def _first(self, skeleton: int, stated: str | None) -> Reference | None:
        for commit, listed in self._tx.heads.clips_of_skeleton(skeleton, MOST_LOOKED_AT):
            clip = read_clip(self._tx.at_commit(commit), listed, bare=True).clip
            head, frames = clip.head, filled(clip.head.skeleton, clip.blocks())
            (positions,) = clip_positions(head.skeleton, [frames], reading_of(head))
            rows = calibration_frames(len(positions))
            found = calibrate(
                head,
                positions[rows],
                {} if stated is None else {"up": stated},
                rows,
                pose_at=partial(_pose_at, head, frames.values),
            )
            if found.origins["reference"].kind == "measured" and found.start.stated == stated:
                return replace(found.start, of=listed.name if found.start.frame is not None else "")
        return None


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
    degrees = np.full(stored.frames, np.nan)
    # Where nothing tells left from right there are no such angles.
    with suppress(ConversionError):
        stance = stance_of(body.calibration.start, skeleton, reading)
        if stance is not None and stored.frames:
            frames = filled(skeleton, clip.blocks())
            _, rotations = Walker(skeleton, reading).poses_at(frames.values)
            rest = rest_of(skeleton, reading)
            degrees = turned_angle(name, skeleton, rest, stance, rotations, frames.unseen)
    degrees[: body.calibration.skipped] = np.nan
    return degrees
