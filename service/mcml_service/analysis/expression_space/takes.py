"""Takes as frames of one face: common markers in millimetres, head motion removed, gaps filled, smoothed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array, Convention
from mcml.numerics.runs import find_starts
from mcml_service.analysis.expression_space.options import FEWEST_MARKERS, Options
from mcml_service.analysis.expression_space.rigid_motion import align
from mcml_service.analysis.interface import AnalysisError, Motion

MILLIMETRES = 1000.0
FACE_MM = 70.0
"""Mean distance of two markers of an adult's face, for guessing an unknown unit."""
FEWEST_FRAMES = 12


@dataclass(frozen=True)
class Take:
    """A take of a space. fps: frames a second. frames: of the take; kept: those in the space."""

    document: str
    revision: int
    name: str
    fps: float
    frames: int
    kept: int


@dataclass(frozen=True)
class Frames:
    """All usable frames of all takes, end to end.

    positions: (n, M, 3) mm, NaN where missing, every frame laid on `neutral`, the number of a frame. take, frame: (n,)
    which take and which of its frames, 0-based. markers: M names. dropped: (marker, why). excluded: (take, frame, why).
    """

    positions: Array
    take: NDArray[np.int32]
    frame: NDArray[np.int32]
    neutral: int
    takes: tuple[Take, ...]
    markers: tuple[str, ...]
    dropped: tuple[tuple[str, str], ...]
    excluded: tuple[tuple[int, int, str], ...]
    up: str | None
    warnings: tuple[tuple[str, str], ...]


def frames_of(motions: Sequence[Motion], options: Options) -> Frames:
    """The frames of takes.

    Raises AnalysisError `no-markers`, `marker-sets-disjoint`, `collinear-markers`, `not-finite`, `too-few-frames`.
    """
    motions = sorted(motions, key=lambda motion: motion.document)
    names, dropped = _common(motions, options.markers)
    factors, warnings = _millimetres(motions, names)
    raw = [_marker_track(motion, names, factor) for motion, factor in zip(motions, factors, strict=True)]
    total = sum(len(track) for track in raw)
    missing = np.sum([np.isnan(track[..., 0]).sum(axis=0) for track in raw], axis=0)
    few = missing > 0.5 * total
    if few.any():
        dropped += [(name, "missing in over half of the frames") for name, bad in zip(names, few, strict=True) if bad]
        names = [name for name, bad in zip(names, few, strict=True) if not bad]
        raw = [track[:, ~few] for track in raw]
    _enough(names, dropped)
    reference = _reference(raw)
    tracks, kept, excluded = _usable(raw, reference, [motion.fps for motion in motions], options)
    take = np.repeat(np.arange(len(motions)), [len(places) for places in kept]).astype(np.int32)
    if len(take) < FEWEST_FRAMES:
        raise AnalysisError(
            "too-few-frames",
            f"{len(take)} usable frames are no space of expressions.",
            remedy=f"Give takes with {FEWEST_FRAMES} frames or more in which at most 30 % of the markers are missing.",
        )
    if options.normalise_scale:
        tracks = _scale(tracks)
    positions = np.concatenate(tracks)
    del tracks, raw
    _spread(positions)
    neutral = _neutral(positions, take)
    return Frames(
        positions=align(positions, positions[neutral]),
        take=take,
        frame=np.concatenate(kept).astype(np.int32),
        neutral=neutral,
        takes=tuple(
            Take(motion.document, motion.revision, motion.name, motion.fps, len(motion), len(places))
            for motion, places in zip(motions, kept, strict=True)
        ),
        markers=tuple(names),
        dropped=tuple(dropped),
        excluded=tuple(excluded),
        up=motions[0].up,
        warnings=tuple(warnings),
    )


def more_frames(
    motions: Sequence[Motion], markers: Sequence[str], neutral: Array, options: Options
) -> tuple[Array, list[NDArray[np.intp]], list[tuple[int, int, str]]]:
    """Usable frames (q, M, 3) of further takes, aligned to the neutral frame (M, 3) of a space; their indices in
    each take; and the excluded ones. Raises AnalysisError `marker-sets-disjoint`, `not-finite`.
    """
    for motion in motions:
        lacking = [name for name in markers if name not in motion.skeleton.names]
        if lacking:
            raise AnalysisError(
                "marker-sets-disjoint",
                f"{motion.name} ({motion.document}) lacks {len(lacking)} markers of the space, such as {lacking[0]}.",
                remedy="Add takes of the same marker set, or build a space of all takes.",
            )
    factors, _ = _millimetres(motions, markers)
    raw = [_marker_track(motion, markers, factor) for motion, factor in zip(motions, factors, strict=True)]
    tracks, kept, excluded = _usable(raw, neutral, [motion.fps for motion in motions], options)
    return align(np.concatenate(tracks), neutral), kept, excluded


def _usable(
    raw: list[Array], reference: Array, rates: Sequence[float], options: Options
) -> tuple[list[Array], list[NDArray[np.intp]], list[tuple[int, int, str]]]:
    """Takes prepared, without frames that lack over 30 % of the markers; the remaining frames; the excluded ones.

    `raw` is emptied, because large spaces do not fit in memory twice.
    """
    tracks, kept, excluded = [], [], []
    for number, fps in enumerate(rates):
        prepared = prepare(raw[number], reference, fps, options)
        raw[number] = prepared[:0]
        usable = np.isnan(prepared[..., 0]).mean(axis=1) <= 0.3 + 1e-12
        excluded += [(number, int(place), "over 30 % of the markers are missing") for place in np.flatnonzero(~usable)]
        tracks.append(prepared if usable.all() else prepared[usable])
        kept.append(np.flatnonzero(usable))
    return tracks, kept, excluded


def part_of(frames: Frames, kept: NDArray[np.bool_]) -> Frames:
    """Some of the frames, laid on the neutral one among these."""
    positions, take = frames.positions[kept], frames.take[kept]
    neutral = int(kept[: frames.neutral].sum()) if kept[frames.neutral] else _neutral(positions, take)
    counts = np.bincount(take, minlength=len(frames.takes))
    return replace(
        frames,
        positions=align(positions, positions[neutral]),
        take=take,
        frame=frames.frame[kept],
        neutral=neutral,
        takes=tuple(replace(kept_take, kept=int(count)) for kept_take, count in zip(frames.takes, counts, strict=True)),
    )


def prepare(track: Array, reference: Array, fps: float, options: Options) -> Array:
    """A take (F, M, 3) laid on a reference (M, 3), short gaps filled, smoothed: motion of the head changes nothing."""
    laid = fill_gaps(align(track, reference), round(options.gap_s * fps))
    return smooth(laid, options.smooth_s * fps)


def fill_gaps(track: Array, longest: int) -> Array:
    """Gaps of at most `longest` frames inside a take filled by the cubic through two samples on either side,
    linearly if these are missing. track: (F, M, 3), NaN where missing. Returns a copy.
    """
    filled = track.copy()
    missing = np.isnan(track[..., 0])
    for marker in np.flatnonzero(missing.any(axis=0) & ~missing.all(axis=0)):
        gone = missing[:, marker]
        seen = np.flatnonzero(~gone)
        for place in np.flatnonzero(np.diff(seen) > 1):
            first, last = seen[place], seen[place + 1]
            if last - first - 1 > longest:
                continue
            support = seen[place - 1 : place + 3] if 1 <= place < len(seen) - 2 else seen[place : place + 2]
            inside = np.arange(first + 1, last)
            filled[inside, marker] = lagrange(support, inside) @ track[support, marker]
    return filled


def lagrange(support: NDArray[np.intp], at: NDArray[np.intp]) -> Array:
    """(A, S) weights of S samples in the polynomial through them at A places."""
    weights = np.ones((len(at), len(support)))
    for row, own in enumerate(support):
        for other in np.delete(support, row):
            weights[:, row] *= (at - other) / (own - other)
    return weights


def smooth(track: Array, deviation: float) -> Array:
    """Gaussian mean in time over the existing samples.

    track: (F, M, 3), NaN where missing and after that too. deviation: frames; 0 changes nothing.
    """
    if deviation <= 0 or len(track) < 2:
        return track
    here = ~np.isnan(track[..., :1])
    weight = scipy.ndimage.gaussian_filter1d(here.astype(float), deviation, axis=0, mode="constant")
    mean: Array = scipy.ndimage.gaussian_filter1d(np.where(here, track, 0.0), deviation, axis=0, mode="constant")
    mean /= np.maximum(weight, 1e-300)
    mean[~here[..., 0]] = np.nan
    return mean


def smooth_takes(frames: Frames, seconds: float) -> Array:
    """(n, M, 3) positions smoothed in time, each take separately."""
    parts = [
        smooth(frames.positions[frames.take == number], seconds * take.fps) for number, take in enumerate(frames.takes)
    ]
    return np.concatenate(parts)


def _common(motions: Sequence[Motion], wanted: Sequence[str]) -> tuple[list[str], list[tuple[str, str]]]:
    for motion in motions:
        if not motion.skeleton.joints or any(j.convention is not Convention.MARKER for j in motion.skeleton.joints):
            others = " Leave it out, or give" if len(motions) > 1 else " Give"
            raise AnalysisError(
                "no-markers",
                f"{motion.name} ({motion.document}) {'is a skeleton' if motion.skeleton.joints else 'has no markers'}; "
                "a space is made of labelled points.",
                remedy=f"{others} takes of markers, such as C3D or TRC.".strip(),
                document=motion.document,
            )
    sets = [set(motion.skeleton.names) for motion in motions]
    common = set.intersection(*sets)
    order = list(dict.fromkeys(name for motion in motions for name in motion.skeleton.names))
    dropped = [(name, "not in every take") for name in order if name not in common]
    if wanted:
        dropped += [(name, "not wanted") for name in order if name in common and name not in wanted]
        dropped += [(name, "in no take") for name in dict.fromkeys(wanted) if name not in order]
    names = [name for name in order if name in common and (not wanted or name in wanted)]
    if len(common) < FEWEST_MARKERS:
        _blame(motions, sets)
    _enough(names, dropped)
    return names, dropped


def _blame(motions: Sequence[Motion], sets: Sequence[set[str]]) -> None:
    """Raises AnalysisError `marker-sets-disjoint` where one take alone has too few of the others' markers."""
    without = [
        len(set.intersection(*sets[:place], *sets[place + 1 :])) if len(sets) > 2 else 0 for place in range(len(sets))
    ]
    best = max(range(len(sets)), key=without.__getitem__)
    if without[best] >= FEWEST_MARKERS:
        motion, common = motions[best], len(set.intersection(*sets))
        raise AnalysisError(
            "marker-sets-disjoint",
            f"{motion.name} ({motion.document}) has {common or 'none'} of the {without[best]} markers that the other "
            "takes have in common.",
            remedy="Leave it out, or rename its markers.",
            document=motion.document,
        )


def _enough(names: Sequence[str], dropped: Sequence[tuple[str, str]]) -> None:
    if len(names) < FEWEST_MARKERS:
        raise AnalysisError(
            "marker-sets-disjoint",
            f"The takes have {len(names)} usable markers in common; {FEWEST_MARKERS} are needed.",
            remedy="Give takes of one marker set, or rename the markers.",
            dropped=[list(pair) for pair in dropped[:100]],
        )


def _millimetres(motions: Sequence[Motion], names: Sequence[str]) -> tuple[list[float], list[tuple[str, str]]]:
    """Return the millimetres of each take's unit; one guess for all takes without a stated unit."""
    silent = [motion for motion in motions if motion.metres is None]
    guess = 1.0
    warnings = []
    if silent:
        sizes = [_size(_marker_track(motion, names, 1.0)) for motion in silent]
        size = float(np.nanmedian(sizes)) if np.isfinite(sizes).any() else FACE_MM
        units = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
        unit = min(units, key=lambda name: abs(np.log(max(size, 1e-12) * units[name] / FACE_MM)))
        guess = units[unit]
        warnings.append(
            ("unit-guessed", f"{len(silent)} takes do not state their unit of length; {unit} is taken, by their size.")
        )
    return [guess if motion.metres is None else MILLIMETRES * motion.metres for motion in motions], warnings


def _marker_track(motion: Motion, names: Sequence[str], factor: float) -> Array:
    """Return (F, M, 3) in mm, NaN without a sample."""
    place = {name: index for index, name in enumerate(motion.skeleton.names)}
    columns = [place[name] for name in names]
    track = motion.translations[:, columns] * factor
    if np.isinf(track).any():
        raise AnalysisError(
            "not-finite",
            f"{motion.name} ({motion.document}) has an infinite coordinate.",
            remedy="Mend the file, or delete the sample.",
        )
    gone = np.isnan(track).any(axis=2) | (track == 0).all(axis=(1, 2))[:, None]
    if motion.present is not None:
        gone |= ~motion.present[:, columns]
    track[gone] = np.nan
    return track


def _size(track: Array) -> float:
    """Mean distance of two markers in the first frame that has the most."""
    frame = track[np.isnan(track[..., 0]).sum(axis=1).argmin()]
    seen = frame[~np.isnan(frame[:, 0])]
    if len(seen) < 2:
        return float("nan")
    first, second = np.triu_indices(len(seen), 1)
    return float(np.linalg.norm(seen[first] - seen[second], axis=1).mean())


def _reference(tracks: Sequence[Array]) -> Array:
    """The first of all frames that has the most markers."""
    best = min(
        (int(count), number, place)
        for number, track in enumerate(tracks)
        if len(track)
        for counts in [np.isnan(track[..., 0]).sum(axis=1)]
        for place in [int(counts.argmin())]
        for count in [counts[place]]
    )
    frame: Array = tracks[best[1]][best[2]]
    return frame


def _scale(tracks: Sequence[Array]) -> list[Array]:
    """Takes with faces of the first one's size, by the mean distance of two markers in their first frames."""
    sizes = [_size(track[:1]) if len(track) else float("nan") for track in tracks]
    reference = next((size for size in sizes if np.isfinite(size)), 1.0)
    return [
        track * (reference / size) if np.isfinite(size) and size > 0 else track
        for track, size in zip(tracks, sizes, strict=True)
    ]


def _spread(positions: Array) -> None:
    best = positions[np.isnan(positions[..., 0]).sum(axis=1).argmin()]
    seen = best[~np.isnan(best[:, 0])]
    extents = np.linalg.svd(seen - seen.mean(axis=0), compute_uv=False)
    if len(seen) < 3 or extents[1] <= 1e-6 * max(extents[0], 1e-300):
        raise AnalysisError(
            "collinear-markers", "All markers are on one line or at one point.", remedy="Give markers of a face."
        )


def _neutral(positions: Array, take: NDArray[np.int32]) -> int:
    """Of the takes' first frames, the one nearest to all others of them; takes begin neutral."""
    firsts = find_starts(take)
    first, second = np.triu_indices(positions.shape[1], 1)
    states = np.linalg.norm(positions[firsts][:, first] - positions[firsts][:, second], axis=-1)
    apart = np.sqrt(np.nanmean((states[:, None] - states[None]) ** 2, axis=2)) if len(firsts) <= 100 else None
    if apart is None:
        middle = np.nanmedian(states, axis=0)
        return int(firsts[np.nanmean((states - middle) ** 2, axis=1).argmin()])
    return int(firsts[np.nan_to_num(apart, nan=np.inf).sum(axis=1).argmin()])
