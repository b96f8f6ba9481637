"""A path of bars made into one motion: warped to the grid, placed on the floor, blended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.motion.feet.legs import legs_of
from mcml.motion.feet.locking import Contacts, foot_contacts, lock_feet
from mcml.motion.hub import walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.blend import (
    Blend,
    Placement,
    blend_rotations,
    facing,
    join_transforms,
    place_roots,
    weight,
)
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.dance.time_warp import Segment, sample, source_frames

_UP = np.array([0.0, 1.0, 0.0])
STEP = 0.25
"""Leg lengths: a foot that is planted further away after a jump steps there."""
_SAME_TIME = 1e-9
"""Seconds: a frame this near to the start of a segment still shows the one before."""


@dataclass(frozen=True)
class Transition:
    """A jump between segments. start, end: seconds of the window of the blend. position: of the bar it leads to."""

    position: int
    start: float
    end: float


@dataclass(frozen=True)
class Dance:
    """translations: (F, J, 3), rotations: (F, J, 4), Y up, in the first clip's axes and unit. rate: (F,) source seconds
    a second. transitions: its jumps. worlds: (S, 3) transforms of the segments. owners, shown: (F,) the clip and its
    frame that a frame shows, in a blend the one with the greater weight."""

    translations: Array
    rotations: Array
    rate: Array
    transitions: tuple[Transition, ...]
    worlds: Array
    owners: NDArray[np.intp]
    shown: Array


def assemble(
    clips: Sequence[Clip],
    owners: Sequence[int],
    runs: Sequence[Segment],
    jumps: Array,
    frames: int,
    fps: float,
    blend: Blend = "hold",
    blend_beats: float = 1.0,
    placement: Placement = "cloud",
) -> Dance:
    """The motion of segments.

    clips: on one skeleton. owners: (S,) the clip of each segment. jumps: (S - 1, 3) transforms between segments, see
    `motion_graph.Edges`. With blend "classic" the segments must play on (`time_warp.segments`). O(F J).
    """
    time = np.arange(frames) / fps
    starts = np.array([run.start for run in runs])
    holds = [clips[owner] for owner in owners]
    worlds = [np.zeros(3)]
    for place in range(1, len(runs)):
        jump = jumps[place - 1]
        if placement == "facing":
            jump = _facing(holds[place - 1], runs[place - 1], holds[place], runs[place])
        worlds.append(join_transforms(worlds[-1], jump))
    where = np.searchsorted(starts[1:] + _SAME_TIME, time, side="left")
    joints = len(clips[0].motion.skeleton)
    translations, rotations, rate = np.empty((frames, joints, 3)), np.empty((frames, joints, 4)), np.zeros(frames)
    sources, shown = np.array(owners, dtype=np.intp)[where], np.zeros(frames)
    for place, run in enumerate(runs):
        inside = where == place
        source = source_frames(run, time[inside])
        shown[inside] = source
        translations[inside], rotations[inside] = _pose(clips[0], holds[place], source, worlds[place])
        rate[inside] = np.gradient(source, time[inside]) / holds[place].fps if len(source) > 1 else 0.0
    transitions = []
    for place in range(1, len(runs)):
        start = runs[place].start
        window_length = (runs[place].beat - start) * blend_beats
        transitions.append(Transition(runs[place].first, start, start + window_length))
        if blend != "none":
            window = (time > start + _SAME_TIME) & (time < start + window_length - _SAME_TIME)
            alpha = weight((time[window] - start) / window_length)
            at = np.full(int(window.sum()), start) if blend == "hold" else time[window]
            before = source_frames(runs[place - 1], at)
            moved, turned = _pose(clips[0], holds[place - 1], before, worlds[place - 1])
            first = np.flatnonzero(window)[alpha > 0.5]
            sources[first], shown[first] = owners[place - 1], before[alpha > 0.5]
            part = alpha[:, None, None]
            translations[window] = part * moved + (1 - part) * translations[window]
            rotations[window] = blend_rotations(turned, rotations[window], alpha)
    return Dance(translations, rotations, rate, tuple(transitions), np.array(worlds), sources, shown)


def cut_dance(dance: Dance, frames: int) -> Dance:
    """The first frames of a dance, with all its transitions."""
    if frames >= len(dance.rate):
        return dance
    return replace(
        dance,
        translations=dance.translations[:frames],
        rotations=dance.rotations[:frames],
        rate=dance.rate[:frames],
        owners=dance.owners[:frames],
        shown=dance.shown[:frames],
    )


def lock_feet_of(clips: Sequence[Clip], dance: Dance, fps: float) -> Dance:
    """The dance with feet locked where they are planted in the clips; as it is for bodies without legs by name.

    A foot that is planted before and after a jump, at places that differ by more than a tenth of the leg, steps over
    instead. O(F J).
    """
    skeleton = clips[0].motion.skeleton
    legs = legs_of(skeleton)
    if not legs or not len(dance.shown):
        return dance
    contacts = [np.zeros((len(legs), 2, len(clip.motion)), dtype=bool) for clip in clips]
    for clip, flags in zip(clips, contacts, strict=True):
        motion = clip.motion
        places, _ = walked(motion.skeleton, motion.translations, motion.rotations)
        for index, leg in enumerate(legs):
            stands = foot_contacts(places, leg.toe, leg.ankle, motion.frame_time, leg.length(places), _UP)
            flags[index] = stands.toe, stands.ankle
    places, _ = walked(skeleton, dance.translations, dance.rotations)
    planted = np.zeros((len(legs), 2, len(dance.shown)), dtype=bool)
    for owner, flags in enumerate(contacts):
        own = dance.owners == owner
        planted[:, :, own] = flags[
            :, :, np.clip(np.floor(dance.shown[own] + 0.5).astype(np.intp), 0, flags.shape[-1] - 1)
        ]
    time, lengths = np.arange(len(dance.shown)) / fps, [leg.length(places) for leg in legs]
    for transition in dance.transitions:
        window = np.arange(*np.searchsorted(time, [transition.start, transition.end + _SAME_TIME]))
        for index, leg in enumerate(legs):
            for part, joint in enumerate((leg.toe, leg.ankle)):
                way = places[window[-1], joint] - places[window[0], joint] if len(window) else np.zeros(3)
                if np.hypot(way[0], way[2]) > STEP * lengths[index]:
                    planted[index, part, window] = False
    locked = lock_feet(
        skeleton,
        legs,
        [Contacts(toe, ankle) for toe, ankle in planted],
        dance.translations,
        dance.rotations,
        1 / fps,
        _UP,
        HubWriter(skeleton),
    )
    return replace(dance, translations=locked.translations, rotations=locked.rotations)


def _pose(first: Clip, clip: Clip, frames: Array, world: Array) -> tuple[Array, Array]:
    """Poses of a clip at source frames (n,), on the first clip's bones, with the roots placed in the world."""
    translations, rotations = sample(clip.motion.translations, clip.motion.rotations, frames)
    still = ~first.figure.moved
    translations[:, still] = first.motion.translations[0, still]
    roots = _roots(first)
    transforms = np.broadcast_to(world, (len(frames), 3))
    translations[:, roots], rotations[:, roots] = place_roots(transforms, translations[:, roots], rotations[:, roots])
    return translations, rotations


def _roots(clip: Clip) -> NDArray[np.intp]:
    return np.array(clip.motion.skeleton.roots, dtype=np.intp)


def _facing(before: Clip, run: Segment, after: Clip, following: Segment) -> Array:
    root = before.motion.skeleton.roots[0]
    end = source_frames(run, np.array([following.start]))
    start = source_frames(following, np.array([following.start]))
    place, turned = sample(before.motion.translations[:, [root]], before.motion.rotations[:, [root]], end)
    place_after, turned_after = sample(after.motion.translations[:, [root]], after.motion.rotations[:, [root]], start)
    return facing(turned[0, 0], place[0, 0], turned_after[0, 0], place_after[0, 0])
