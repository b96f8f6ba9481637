"""The body of a stored document in space: the positions of its joints in every frame, and the calibration of the
clip.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial
from typing import Any

from mcml.motion.bodies.activities.activity import Activity
from mcml.motion.bodies.activities.recognition import recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.bodies.bone_axes import pool_hinges
from mcml.motion.bodies.calibration import Calibration
from mcml.motion.bodies.clip_body import (
    ClipBody,
    body_at,
    calibrate_clip,
    hinges_in_clip,
    lines_of,
    steps_of,
    turned_degrees,
)
from mcml.motion.bodies.positions import clip_positions, filled
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.clip import ClipHead, Reference
from mcml.motion.guesses import stated_up
from mcml.motion.landmarks.centres import body_names, doubtful_names
from mcml.motion.skeleton import Array
from mcml.motion.units import Reading, reading_of
from mcml_service.clips.read_clip import Skeletons, read_clip
from mcml_service.storage.documents.bodies import StoredBody
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.packed_positions import pack, pack_parts, unpack
from mcml_service.storage.transaction import Transaction

FRAMES_TOGETHER = 8192
"""Frames of documents whose joints are placed together."""
LONG = 65_536
"""Frames of a document from which on some of it is in memory at a time."""
MOST_LOOKED_AT = 8
"""Clips of a skeleton, where a reference pose is looked for."""
MADE = 10
"""Version of bodies: increased when the computation of positions, calibrations or activities changes, so that stored
bodies are derived again.
"""


@dataclass(frozen=True, eq=False)
class Body:
    """names: of the joints, MCML's where they are known, and of centres that markers tell. frame_time: seconds, None
    where unknown. blocks: rounded positions in the document's order of frames, then lines to the left of bones, as
    `steps.pack` makes them. doubtful: names of MCML's that are guesses. lines: names of the lines. activities: as
    `recognize_activities` finds them, None where it has not looked for them, in long documents."""

    names: tuple[str, ...]
    frames: int
    calibration: Calibration
    frame_time: float | None
    blocks: tuple[bytes, ...]
    doubtful: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()
    activities: tuple[Activity, ...] | None = None

    @property
    def nbytes(self) -> int:
        return sum(map(len, self.blocks)) + 2000 + 200 * len(self.activities or ())

    def stretch(self, joints: Collection[str], first: int = 0, end: int | None = None) -> Stretch:
        """The frames from `first` (from 0) to before `end`, by default all, with the joints, and the lines to the left,
        of these names that it has."""
        frames = range(self.frames)[first:end]
        every = (*self.names, *self.lines)
        own = [place for place, name in enumerate(every) if name in joints]
        steps = unpack(self.blocks, own)
        places = {every[place]: positions[first:end] for place, positions in zip(own, steps, strict=True)}
        stretch = Stretch(places, len(frames), self.frame_time, self.calibration, first=first)
        if self.activities is not None and len(frames) == self.frames:
            stretch.hold(recognize_activities, self.activities)
        return stretch

    def facts(self) -> dict[str, Any]:
        """Everything except the positions, as plain values for JSON."""
        known = self.calibration.to_json()
        told = {"names": self.names, "frames": self.frames, "calibration": known, "frame_time": self.frame_time}
        activities = None if self.activities is None else [astuple(activity) for activity in self.activities]
        told |= {"blocks": len(self.blocks), "doubtful": self.doubtful, "lines": self.lines, "activities": activities}
        return {**told, "made": MADE}

    @classmethod
    def pack(cls, body: ClipBody) -> Body:
        """Return the stored form of the body of a clip."""
        blocks = tuple(pack(body.steps))
        activities = recognize_activities(body.stretch(JOINTS))
        frames, seconds = len(body.steps), body.frame_time
        return cls(body.names, frames, body.calibration, seconds, blocks, body.doubtful, body.lines, activities)

    @classmethod
    def restore(cls, stored: StoredBody) -> Body | None:
        """Restore a stored body; None if it has another version."""
        facts = stored.facts
        if facts["made"] != MADE:
            return None
        calibration = Calibration.from_json(facts["calibration"])
        names, doubtful, lines = (tuple(facts[each]) for each in ("names", "doubtful", "lines"))
        seen = facts["activities"]
        activities = None if seen is None else tuple(Activity(*each) for each in seen)
        return cls(names, facts["frames"], calibration, facts["frame_time"], stored.blocks, doubtful, lines, activities)


def derive_bodies(tx: Transaction, documents: Sequence[Listed], skeletons: Skeletons) -> Iterator[Body]:
    """Compute the body of each document from its frames. skeletons: as for `read_clip`."""
    first = 0
    while first < len(documents):
        # Kinematics of short clips takes as long for one as for ten.
        last, frames = first + 1, documents[first].frames
        while last < len(documents) and frames + documents[last].frames <= FRAMES_TOGETHER:
            frames += documents[last].frames
            last += 1
        yield from _derive(tx, documents[first:last], skeletons)
        first = last


def _derive(tx: Transaction, documents: Sequence[Listed], skeletons: Skeletons) -> list[Body]:
    if documents[0].frames > LONG:
        (listed,) = documents
        return [_derive_in_parts(tx, listed, skeletons)]
    clips = [read_clip(tx, listed, bare=True, skeletons=skeletons) for listed in documents]
    same: dict[tuple[int, Reading], list[int]] = {}
    for place, clip in enumerate(clips):
        same.setdefault((id(clip.clip.head.skeleton), reading_of(clip.clip.head)), []).append(place)
    references = References(tx)
    derived: dict[int, Body] = {}
    for (_, reading), places in same.items():
        skeleton = clips[places[0]].clip.head.skeleton
        frames = [filled(skeleton, clips[place].clip.blocks()) for place in places]
        for place, own, positions in zip(places, frames, clip_positions(skeleton, frames, reading), strict=True):
            shared = partial(references.of, documents[place])
            derived[place] = Body.pack(body_at(clips[place].clip.head, positions, own.values, shared))
    return [derived[place] for place in range(len(clips))]


def _derive_in_parts(tx: Transaction, listed: Listed, skeletons: Skeletons) -> Body:
    """The same of a long document, which is read twice: for its calibration, and for its positions."""
    clip = read_clip(tx, listed, bare=True, skeletons=skeletons).clip
    calibration = calibrate_clip(clip, listed.frames, shared=partial(References(tx).of, listed))
    blocks = tuple(pack_parts(steps_of(clip, calibration)))
    skeleton, seconds = clip.head.skeleton, clip.head.seconds_per_frame()
    names, lines = body_names(skeleton), lines_of(calibration)
    return Body(names, listed.frames, calibration, seconds, blocks, doubtful_names(skeleton), lines)


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
            self._found[key] = self._read_kept(*key) or self._first(*key)
        return self._found[key]

    def _read_kept(self, skeleton: int, stated: str | None) -> Reference | None:
        for facts in self._tx.bodies.facts_of_skeleton(skeleton, MOST_LOOKED_AT):
            known = facts["calibration"] if facts["made"] == MADE else None
            if known is not None and known["origins"]["reference"][0] == "measured" and known["start"]["of"]:
                reference = Reference.from_json(known["start"])
                if reference.stated == stated:
                    return reference
        return None

    def _first(self, skeleton: int, stated: str | None) -> Reference | None:
        """The pose of the first clip that shows one, and the axes of knees in all that are looked at."""
        start: Reference | None = None
        clips = list(self._tx.heads.clips_of_skeleton(skeleton, MOST_LOOKED_AT))
        for commit, listed in clips:
            clip = read_clip(self._tx.at_commit(commit), listed, bare=True).clip
            calibration = calibrate_clip(clip, clip.frames or 0, {} if stated is None else {"up": stated})
            if calibration.origins["reference"].kind == "measured" and calibration.start.stated == stated:
                start = replace(calibration.start, of=listed.name if calibration.start.frame is not None else "")
                break
        if start is None or start.frame is None:
            return start
        read = (read_clip(self._tx.at_commit(commit), listed, bare=True).clip for commit, listed in clips)
        return replace(start, hinges=pool_hinges(hinges_in_clip(clip, clip.frames or 0) for clip in read))


def read_bodies(tx: Transaction, documents: Sequence[Listed]) -> dict[int, Body]:
    """Return bodies by the keys of documents: stored ones, others computed now."""
    restored = {key: Body.restore(stored) for key, stored in tx.bodies.of(documents).items()}
    sound = {key: body for key, body in restored.items() if body is not None}
    missing = [listed for listed in documents if listed.key not in sound]
    made = zip(missing, derive_bodies(tx, missing, {}), strict=True)
    return sound | {listed.key: body for listed, body in made}


def read_up(tx: Transaction, stored: StoredDocument, head: ClipHead) -> str:
    """The axis that points up, "X", "Y" or "Z": as the header states it, else as a body with legs shows it, else Y."""
    stated = stated_up(head)
    if stated is not None:
        return stated[-1]
    (listed,) = tx.columns.documents([stored.key])
    known = read_bodies(tx, [listed])[stored.key].calibration
    return "Y" if known.leg is None else known.up[-1]


def read_turned(tx: Transaction, stored: StoredDocument | Listed, name: str, body: Body) -> Array:
    """(n,) degrees of an angle that takes rotations (`limb_angles.turn_named`), NaN where unknown. body: of the
    document."""
    return turned_degrees(read_clip(tx, stored, labelled=False).clip, name, body.calibration)
