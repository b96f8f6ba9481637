"""Feet that stand in the examples, and stay in place in a made motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.motion.feet.legs import Leg, legs_of
from mcml.motion.feet.locking import Contacts, FootReport, foot_contacts, lock_feet, move_feet
from mcml.motion.hub import walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.skeleton import Array, Skeleton
from mcml_service.analysis.interface import MadeClip
from mcml_service.analysis.reach_blending.motion_spaces import Track

STANDS = 0.5
"""Share of the examples, weighted as the motion, from which a foot stands."""


@dataclass(frozen=True)
class Feet:
    """Legs of a made clip and their contacts. up: (3,) unit vector. contacts: of each leg."""

    legs: tuple[Leg, ...]
    contacts: tuple[Contacts, ...]
    up: Array

    def hold(self, clip: MadeClip) -> tuple[MadeClip, tuple[FootReport, ...]]:
        """Lock the feet during their contacts."""
        writer = HubWriter(clip.skeleton)
        motion = clip.translations, clip.rotations
        locked = lock_feet(clip.skeleton, self.legs, self.contacts, *motion, clip.frame_time, self.up, writer)
        return replace(clip, translations=locked.translations, rotations=locked.rotations), locked.reports

    def measure(self, clip: MadeClip) -> tuple[float, ...]:
        """Measure how far each foot slides during its contacts, in the clip's unit."""
        writer = HubWriter(clip.skeleton)
        motion = clip.translations, clip.rotations
        locked = lock_feet(
            clip.skeleton, self.legs, self.contacts, *motion, clip.frame_time, self.up, writer, lock=False
        )
        return tuple(report.before for report in locked.reports)

    def bring_back(self, clip: MadeClip, moved: Array) -> MadeClip:
        """Put the feet back where they were before the pelvis moved by (F, 3)."""
        writer = HubWriter(clip.skeleton)
        motion = clip.translations, clip.rotations
        moves = [-moved] * len(self.legs)
        translations, rotations, _ = move_feet(
            clip.skeleton, self.legs, moves, *motion, clip.frame_time, self.up, writer
        )
        return replace(clip, translations=translations, rotations=rotations)


def learn_contacts(
    skeleton: Skeleton, tracks: Iterable[Track], offsets: Array, frame_times: Sequence[float], up: str | None
) -> Array | None:
    """Learn when feet of clips stand: (N, legs, 2, F0), 1 in samples in which the toe (0) or the ankle (1) stands.

    offsets: (N, J, 3) of the clips' bodies. frame_times: seconds. None without legs or an axis that points up.
    """
    legs = legs_of(skeleton)
    if not legs or up is None:
        return None
    rows = []
    for track, bones, frame_time in zip(tracks, offsets, frame_times, strict=True):
        translations = np.broadcast_to(bones, (len(track.root), *bones.shape)).copy()
        translations[:, 0] = track.root
        places = walked(skeleton, translations, track.rotations)[0]
        at = np.rint(track.at).astype(np.intp)
        feet = [foot_contacts(places, leg.toe, leg.ankle, frame_time, leg.length(places), axis_of(up)) for leg in legs]
        rows.append([[stands.toe[at], stands.ankle[at]] for stands in feet])
    return np.array(rows, dtype=np.float64)


def find_feet(clip: MadeClip, contacts: Array, weights: Array, up: str, at: Array) -> Feet:
    """Find the contacts of a blended clip: the foot stands in the examples, and is low and slow in the blend.

    Where examples walk at different times, feet of the blend swing while half of the examples stand. contacts:
    (n, legs, 2, F0) of the examples, weights: (n,) their shares in the motion. at: (F,) samples of frames.
    """
    shares = np.einsum("n,nlps->lps", weights, contacts)[:, :, np.rint(at).astype(np.intp)]
    places = walked(clip.skeleton, clip.translations, clip.rotations)[0]
    legs, axis = legs_of(clip.skeleton), axis_of(up)
    stands = []
    for leg, (toe, ankle) in zip(legs, shares > STANDS, strict=True):
        own = foot_contacts(places, leg.toe, leg.ankle, clip.frame_time, leg.length(places), axis)
        stands.append(Contacts(toe & own.toe, ankle & own.ankle))
    return Feet(legs, tuple(stands), axis)


def axis_of(up: str) -> Array:
    """Unit vector (3,) of "X", "Y" or "Z"."""
    return np.asarray(np.eye(3)["XYZ".index(up)])
