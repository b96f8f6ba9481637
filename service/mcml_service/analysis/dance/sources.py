"""Clips made ready: upright, with speed, beats and bars; and several of them on one skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array, Convention, numbers
from mcml_service.analysis.dance.bars import Bars, EntryFrom, Source, Tolerance, bars_of, find_bars
from mcml_service.analysis.dance.figure import Figure, carry_by_roots, check_finite, figure_of, scale_motion, upright
from mcml_service.analysis.dance.motion_beats import (
    Candidates,
    Difference,
    Period,
    locate,
    periods,
    refine,
    speed_signal,
    window_of,
)
from mcml_service.analysis.dance.tempo import Tempo, TempoRule, body_channels, tempo_of
from mcml_service.analysis.interface import AnalysisError, Motion

LOWEST_RATE = 10.0
BONES_DIFFER = 0.02


@dataclass(frozen=True)
class Search:
    """How beats and bars are looked for. docs/analyses/dance.md describes the fields.

    locate: whether beats move from the minimum to the middle of the rest. source_bpm: the tempo the dancer heard, None
    if unknown. own_beats: seconds, set by a person: nothing is looked for. tempo: of the motion (robust), or of its
    beats (paper).
    """

    smooth: float = 0.04
    difference: Difference = "central"
    k2: float = 2 / 15
    k3: float = 1.0
    locate: bool = True
    source_bpm: float | None = None
    beats: Source = "auto"
    interval_tolerance: Tolerance = 0.2
    stride: int = 4
    lead_in: EntryFrom = "beat"
    own_beats: tuple[float, ...] | None = None
    tempo: TempoRule = "robust"


@dataclass(frozen=True)
class Clip:
    """A clip with its beats.

    motion: Y up. speed: (F,), units a second. detected: (n,) beats after refinement, frames or between them.

    period: seconds of a beat, used for the bars, None where unknown. peaks: its candidates, the likeliest first. tempo:
    the tempo of the motion itself; None if the beats or a person decided it.
    """

    motion: Motion
    figure: Figure
    speed: Array
    candidates: Candidates
    detected: Array
    peaks: tuple[Period, ...]
    period: float | None
    bars: Bars
    tempo: Tempo | None

    @property
    def fps(self) -> float:
        return self.motion.fps


def upright_clip(motion: Motion) -> Motion:
    """The motion with Y up, carried by its roots. Raises AnalysisError where it cannot have beats."""
    fps, frames = motion.fps, len(motion)
    if not fps >= LOWEST_RATE:
        raise AnalysisError(
            "frame-rate-too-low",
            f"{motion.name} has {fps:g} frames a second; a beat cannot be seen below {LOWEST_RATE:g}.",
            remedy="Use a clip recorded at 10 frames a second or more.",
            document=motion.document,
        )
    shortest = 2 * window_of(fps) + 1
    if frames < shortest:
        raise AnalysisError(
            "clip-too-short",
            f"{motion.name} has {frames} frames; beats need at least {shortest} at its frame rate.",
            remedy=f"Use clips of at least {shortest / fps:.2f} s.",
            document=motion.document,
            shortest=shortest,
        )
    check_finite(motion)
    return carry_by_roots(upright(motion))


def channels_of(motion: Motion) -> Array:
    """Return the signals for the tempo of a clip, (3, n), for a motion with Y up."""
    figure = figure_of(motion.skeleton, motion.translations)
    return body_channels(figure, motion.translations, motion.rotations, motion.fps)


def read_clip(motion: Motion, search: Search, shared: Tempo | None = None) -> Clip:
    """A clip with its speed, beats, period and bars. shared: the tempo, where it is that of several clips.

    Raises AnalysisError where it cannot have any.
    """
    motion = upright_clip(motion)
    fps, frames = motion.fps, len(motion)
    figure = figure_of(motion.skeleton, motion.translations)
    speed = speed_signal(figure, motion.translations, motion.rotations, fps, search.smooth, search.difference)
    candidates = refine(speed, fps, search.k2, search.k3)
    detected = locate(speed, candidates.beats, fps) if search.locate else candidates.beats.astype(float)
    if search.own_beats is not None:
        detected = _own(search.own_beats, fps, frames)
    tempo, peaks = _tempo(motion, search, detected, shared)
    period = 60.0 / search.source_bpm if search.source_bpm else peaks[0].seconds if peaks else None
    options = (search.interval_tolerance, search.stride, search.lead_in)
    if search.own_beats is not None:
        sure, step = np.ones(len(detected), dtype=bool), None if period is None else period * fps
        bars = bars_of(detected, sure, "detected", step, window_of(fps), *options)
    else:
        usable = candidates.frames[candidates.verdicts != 1]
        bars = find_bars(speed, fps, usable, detected, period, search.beats, search.k2, *options, search.locate)
    return Clip(motion, figure, speed, candidates, detected, peaks, period, bars, tempo)


def _tempo(
    motion: Motion, search: Search, detected: Array, shared: Tempo | None
) -> tuple[Tempo | None, tuple[Period, ...]]:
    """Return the tempo of the motion, and its possible periods."""
    if search.own_beats is not None or search.tempo == "paper":
        return None, tuple(periods(detected, len(motion), motion.fps))
    if search.source_bpm:
        return None, ()
    tempo = shared or tempo_of([channels_of(motion)])
    return tempo, () if tempo is None else tuple(Period(60.0 / peak.bpm, peak.strength) for peak in tempo.peaks[:3])


def _own(beats: Sequence[float], fps: float, frames: int) -> Array:
    beat_frames: Array = np.unique(np.asarray(beats, dtype=float) * fps)
    return beat_frames[beat_frames <= frames - 1]


def on_one_skeleton(clips: Sequence[Clip]) -> tuple[list[Clip], list[str]]:
    """The clips with their joints in the order of the first one's and in its unit, and warnings.

    Raises AnalysisError `skeletons-differ` with the first joint that does, and `no-skeleton` for markers.
    """
    first = clips[0]
    warnings: list[str] = []
    fitted = []
    for clip in clips:
        if any(joint.convention is Convention.MARKER for joint in clip.motion.skeleton.joints):
            raise AnalysisError(
                "no-skeleton",
                f"{clip.motion.name} has markers only; a new dance needs joints.",
                remedy="Use clips with a skeleton.",
                document=clip.motion.document,
            )
        fitted.append(clip if clip is first else _fit(first, clip, warnings))
    return fitted, warnings


def _fit(first: Clip, clip: Clip, warnings: list[str]) -> Clip:
    order = _order(first.motion, clip.motion)
    motion = clip.motion
    if (order != np.arange(len(order))).any():
        joints = tuple(
            replace(motion.skeleton.joints[place], parent=first.motion.skeleton.joints[index].parent)
            for index, place in enumerate(order)
        )
        motion = replace(
            motion,
            skeleton=replace(motion.skeleton, joints=joints, declared=()),
            rotations=motion.rotations[:, order],
            translations=motion.translations[:, order],
        )
    ours, theirs = first.motion.metres, motion.metres
    if ours and theirs and ours != theirs:
        motion = scale_motion(motion, theirs / ours)
    _compare_bones(first, motion, warnings)
    return replace(clip, motion=motion, figure=figure_of(motion.skeleton, motion.translations[:1]))


def _order(first: Motion, other: Motion) -> NDArray[np.intp]:
    """Return (J,) the index of each joint of the first skeleton in the other.

    Raises AnalysisError `skeletons-differ`.
    """
    place = {name: index for index, name in enumerate(other.skeleton.names)}
    order = []
    for joint in first.skeleton.joints:
        parent = first.skeleton.joints[joint.parent].name if joint.parent >= 0 else None
        index = place.get(joint.name)
        if index is None:
            raise _differs(first, other, joint.name, "is missing there")
        above = other.skeleton.joints[index].parent
        if (other.skeleton.joints[above].name if above >= 0 else None) != parent:
            raise _differs(first, other, joint.name, "hangs on another joint there")
        order.append(index)
    known = set(first.skeleton.names)
    for name in other.skeleton.names:
        if name not in known:
            raise _differs(first, other, name, "is only there")
    return np.array(order, dtype=np.intp)


def _differs(first: Motion, other: Motion, joint: str, how: str) -> AnalysisError:
    return AnalysisError(
        "skeletons-differ",
        f"{other.name} has another skeleton than {first.name}: the joint {joint} {how}.",
        remedy="Bring all clips onto one skeleton (skeleton= and the id of a document), or leave it out.",
        document=other.document,
        joint=joint,
    )


def _compare_bones(first: Clip, motion: Motion, warnings: list[str]) -> None:
    ours = np.array([numbers(joint.offset) for joint in first.motion.skeleton.joints])[~first.figure.moved]
    theirs = np.array([numbers(joint.offset) for joint in motion.skeleton.joints])[~first.figure.moved]
    size = first.figure.size or 1.0
    lengths = np.abs(np.linalg.norm(ours, axis=1) - np.linalg.norm(theirs, axis=1)).sum() / size
    turned = np.linalg.norm(ours - theirs, axis=1).sum() / size - lengths
    if lengths > BONES_DIFFER:
        warnings.append(
            f"{motion.name}: its bones differ from those of {first.motion.name} by {100 * lengths:.0f} % of the body "
            "size in sum; feet may float or sink."
        )
    if turned > 10 * BONES_DIFFER:
        warnings.append(
            f"{motion.name}: its rest pose differs from that of {first.motion.name}; limbs may point elsewhere. "
            "Bring all clips onto one skeleton (skeleton=)."
        )
