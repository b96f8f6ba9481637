"""Where bars lead on the floor: the root's way through each bar, the moves of jumps, the direction a dancer faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.hub import walked
from mcml.motion.sides import sagittal
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.assembly import Dance
from mcml_service.analysis.dance.bar_graph import AllBars
from mcml_service.analysis.dance.beam import Floor
from mcml_service.analysis.dance.motion_beats import half_up
from mcml_service.analysis.dance.motion_graph import Edges
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.dance.stage import Points, Stage, bend_motion, find_shares, fit_turns, spread_turns
from mcml_service.analysis.interface import AnalysisError

BODY = 2.2
"""Metres of an adult's body size, for clips without a unit."""
_PARTS = 3
"""Points of a bar's way to a beat."""
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Company:
    """Dancers that are placed already. ways: (N, F) their roots. fps: frames a second. paths: (N, M) their bars."""

    ways: Points
    fps: float
    paths: Array

    def find_tracks(self, grid: Array) -> Points:
        """(N, M, 13) places of the roots through each bar, at the points of `find_tracks`.

        grid: (4 M + 1,) motion beats, seconds.
        """
        bars = len(grid) // 4
        beats = np.concatenate([[2 * grid[0] - grid[1]], grid])
        knots = np.stack([beats[4 * bar : 4 * bar + 5] for bar in range(bars)])
        part = np.arange(4 * _PARTS + 1) / _PARTS
        times = np.array([np.interp(part, np.arange(5), row) for row in knots])
        frames = np.arange(self.ways.shape[1]) / self.fps
        places = [np.interp(times, frames, way.real) + 1j * np.interp(times, frames, way.imag) for way in self.ways]
        return np.array(places, dtype=np.complex128)

    def uses(self, bars: int) -> Array:
        """(M, B) how many of them dance a bar at a position."""
        counts = np.zeros((self.paths.shape[1], bars))
        for path in self.paths:
            counts[np.arange(len(path)), path] += 1
        return counts


def metres_of(clip: Clip) -> float:
    """Metres in the unit of a clip: as stated, else such that its body has the size of an adult's."""
    return clip.motion.metres or BODY / (clip.figure.size or BODY)


def find_tracks(clips: Sequence[Clip], bars: AllBars, metres: float) -> Points:
    """(B, 13) the root's way through each bar, from its lead-in to its last beat, metres."""
    knots = np.column_stack([bars.entries, bars.frames])
    frames = np.array([np.interp(np.arange(4 * _PARTS + 1) / _PARTS, np.arange(5), row) for row in knots])
    tracks: Points = np.empty(frames.shape, dtype=np.complex128)
    for owner, clip in enumerate(clips):
        own = bars.owners == owner
        root = clip.motion.translations[:, clip.motion.skeleton.roots[0]]
        across, along = (np.interp(frames[own], np.arange(len(root)), root[:, axis]) for axis in (0, 2))
        tracks[own] = (across + 1j * along) * metres
    return tracks


def make_floor(
    clips: Sequence[Clip],
    bars: AllBars,
    edges: Edges,
    stage: Stage,
    most: float,
    start: Array | None,
    place: complex = 0.0,
    others: Points | None = None,
) -> Floor:
    """Return the places that bars and jumps lead to. most: radians that a bar is turned. start: (B,) turns of the first
    bar. place, others: see `Floor`."""
    metres = metres_of(clips[0])
    tracks = find_tracks(clips, bars, metres)
    spins = _spin(edges.transforms[:, 0])
    moves = spins * (tracks[edges.second, -1] - tracks[edges.second, 0])
    ways = np.maximum(np.bincount(edges.first, minlength=len(bars)), 1)
    across, along = (np.bincount(edges.first, part, len(bars)) / ways for part in (moves.real, moves.imag))
    ahead = np.asarray(across + 1j * along, dtype=np.complex128)
    shifts = np.asarray((edges.transforms[:, 1] + 1j * edges.transforms[:, 2]) * metres, dtype=np.complex128)
    turned = _spin(np.zeros(len(bars)) if start is None else start)
    return Floor(stage, most, tracks, _PARTS, spins, shifts, ahead, turned, place, others)


def _spin(turns: Array) -> Points:
    spins: Points = np.exp(-1j * turns).astype(np.complex128)
    return spins


def turn_to_face(clips: Sequence[Clip], bars: AllBars, facing: float) -> Array:
    """(B,) turns about Y, radians, after which the body faces a direction at the first beat of a bar.

    facing: radians to the left of +Z. Raises AnalysisError `sides-unknown` if no joints tell left from right.
    """
    turns = np.empty(len(bars))
    for bar in range(len(bars)):
        motion = clips[bars.owners[bar]].motion
        frame = min(max(half_up(bars.frames[bar, 0]), 0), len(motion) - 1)
        positions, _ = walked(motion.skeleton, motion.translations[[frame]], motion.rotations[[frame]])
        try:
            ahead = np.cross(sagittal(motion.skeleton, positions[0], _UP).normal, _UP)
        except ConversionError as error:
            raise AnalysisError(
                "sides-unknown",
                f"{motion.name}: no joints tell left from right, so the direction that the body faces is unknown.",
                remedy="Leave facing out, or name joints of both sides.",
                document=motion.document,
            ) from error
        turns[bar] = facing - np.arctan2(ahead[0], ahead[2])
    return turns


def fit_to_stage(
    dance: Dance,
    clip: Clip,
    grid: Array,
    fps: float,
    stage: Stage,
    turns: Array,
    start: float,
    most: float,
    place: complex = 0.0,
    others: Points | None = None,
) -> Array:
    """Turns (M,) of each bar that keep the assembled dance on the stage. turns: those that the path was chosen with.
    place: where it starts. others: (N, F) roots to keep away from, metres."""
    root = dance.translations[:, clip.motion.skeleton.roots[0]]
    track = (root[:, 0] + 1j * root[:, 2]) * metres_of(clip)
    shares = find_shares(grid, len(track), fps)
    return fit_turns(place + (track - track[0]) * np.exp(-1j * start), shares, stage, turns, most, others)


def place_dance(
    dance: Dance, clip: Clip, grid: Array, fps: float, turns: Array, start: float, place: complex | None
) -> Dance:
    """The dance turned by `start` in all and by turns (M,) over its bars.

    place: where it starts, metres; None: where it started before.
    """
    roots = np.array(clip.motion.skeleton.roots, dtype=np.intp)
    angles = start + spread_turns(turns, find_shares(grid, len(dance.rotations), fps))
    first = dance.translations[0, roots[0]]
    at = complex(first[0], first[2]) if place is None else place / metres_of(clip)
    moved, turned = bend_motion(dance.translations, dance.rotations, roots, angles, at)
    return replace(dance, translations=moved, rotations=turned)


def measure_way(translations: Array, clip: Clip) -> Points:
    """(F,) the first root's places on the floor from its first, metres. translations: (F, J, 3), Y up."""
    root = translations[:, clip.motion.skeleton.roots[0]]
    way: Points = (root[:, 0] - root[0, 0] + 1j * (root[:, 2] - root[0, 2])) * metres_of(clip)
    return way
